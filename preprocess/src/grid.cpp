#include "grid.hpp"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <mutex>
#include <numbers>

#include "carat/globe/error.hpp"

namespace carat {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kTileUnit = 64;                // tile sides are multiples, so that cells never straddle tiles
constexpr std::int64_t kMaxCells = 1 << 24;  // beyond it, cells grow
constexpr int kMaxCellBits = 6;

std::int64_t divide_up(std::int64_t a, std::int64_t b) { return (a + b - 1) / b; }

int rounded_to_unit(std::int64_t x) { return static_cast<int>(divide_up(x, kTileUnit) * kTileUnit); }

PixelWindow intersection(const PixelWindow& a, const PixelWindow& b) {
    PixelWindow w{std::max(a.x, b.x), std::max(a.y, b.y), 0, 0};
    w.width = static_cast<int>(std::max<std::int64_t>(0, std::min(a.x + a.width, b.x + b.width) - w.x));
    w.height = static_cast<int>(std::max<std::int64_t>(0, std::min(a.y + a.height, b.y + b.height) - w.y));
    return w;
}

PixelWindow window_of_part(const GridPart& part) {
    const RasterHeader& h = part.file->header();
    return {part.x, part.y, h.width, h.height};
}

std::size_t area(const PixelWindow& w) {
    return static_cast<std::size_t>(w.width) * static_cast<std::size_t>(w.height);
}

template <class T>
std::optional<double> mean_of_row(const Grid& grid, std::int64_t row, std::int64_t columns) {
    double sum = 0;
    std::int64_t count = 0;
    TilePtr tile;
    for (std::int64_t x = 0; x < columns; ++x) {
        if (!tile || x >= tile->x + tile->width) tile = grid.tile_at(x, row);
        const auto i = static_cast<std::size_t>((row - tile->y) * tile->width + (x - tile->x));
        if (tile->samples.empty() || (!tile->valid.empty() && tile->valid[i] == 0)) continue;
        sum += static_cast<double>(reinterpret_cast<const T*>(tile->samples.data())[i]);
        ++count;
    }
    if (count == 0) return std::nullopt;
    return sum / static_cast<double>(count);
}

std::optional<double> mean_at_pole(const Grid& grid, const PoleEnd& pole) {
    if (!pole.reached) return std::nullopt;
    const std::int64_t columns = grid.frame().period();
    switch (grid.type()) {
        case SampleType::int16:
            return mean_of_row<std::int16_t>(grid, pole.mean_row, columns);
        case SampleType::int32:
            return mean_of_row<std::int32_t>(grid, pole.mean_row, columns);
        case SampleType::float32:
            return mean_of_row<float>(grid, pole.mean_row, columns);
        case SampleType::float64:
            break;
    }
    return mean_of_row<double>(grid, pole.mean_row, columns);
}

}  // namespace

Grid::Grid(Frame frame, std::vector<GridPart> parts, const Ellipsoid& body, const Feather& feather,
           TileCache& cache, std::uint64_t key, bool lazy)
    : frame_(std::move(frame)), parts_(std::move(parts)), feather_(feather), cache_(cache), key_(key) {
    choose_tiles();
    index_parts();
    find_cap();
    find_spacings(body);
    scan(lazy);
    if (lazy) return;
    top_mean();  // files that cannot be read are found now
    bottom_mean();
}

const std::optional<double>& Grid::PoleMean::of(const Grid& grid, const PoleEnd& pole) const {
    std::call_once(once_, [&] { mean_ = mean_at_pole(grid, pole); });
    return mean_;
}

// Tiles follow the file's own blocks, within reason; strips become wide flat tiles, so that few of them share
// a strip.
void Grid::choose_tiles() {
    const RasterHeader& h = parts_.front().file->header();
    if (h.block_width >= h.width && h.block_width > 1024) {
        tile_width_ = rounded_to_unit(std::min(h.block_width, 4096));
        tile_height_ = rounded_to_unit(std::clamp(h.block_height, 1, 128));
    } else {
        tile_width_ = rounded_to_unit(std::clamp(h.block_width, 256, 1024));
        tile_height_ = rounded_to_unit(std::clamp(h.block_height, 256, 1024));
    }
    tile_width_ = std::min(tile_width_, rounded_to_unit(frame_.width()));
    tile_height_ = std::min(tile_height_, rounded_to_unit(frame_.height()));
    tiles_x_ = divide_up(frame_.width(), tile_width_);
    tiles_y_ = divide_up(frame_.height(), tile_height_);
    const auto cells = [&](std::int64_t n) { return divide_up(n, std::int64_t{1} << cell_bits_); };
    while (cell_bits_ < kMaxCellBits && cells(frame_.width()) * cells(frame_.height()) > kMaxCells)
        ++cell_bits_;
    cells_x_ = cells(frame_.width());
    cells_y_ = cells(frame_.height());
}

void Grid::index_parts() {
    const auto visit = [&](auto&& see) {
        for (std::uint32_t p = 0; p < parts_.size(); ++p) {
            const PixelWindow w = window_of_part(parts_[p]);
            for (std::int64_t y = w.y / tile_height_; y <= (w.y + w.height - 1) / tile_height_; ++y)
                for (std::int64_t x = w.x / tile_width_; x <= (w.x + w.width - 1) / tile_width_; ++x)
                    see(static_cast<std::size_t>(y * tiles_x_ + x), p);
        }
    };
    part_start_.assign(static_cast<std::size_t>(tiles_x_ * tiles_y_) + 1, 0);
    visit([&](std::size_t tile, std::uint32_t) { ++part_start_[tile + 1]; });
    for (std::size_t t = 1; t < part_start_.size(); ++t) part_start_[t] += part_start_[t - 1];
    part_list_.resize(part_start_.back());
    std::vector<std::uint32_t> next(part_start_.begin(), part_start_.end() - 1);
    visit([&](std::size_t tile, std::uint32_t p) { part_list_[next[tile]++] = p; });
}

std::span<const std::uint32_t> Grid::parts_of(TileIndex t) const {
    const auto i = static_cast<std::size_t>(t.y * tiles_x_ + t.x);
    return {part_list_.data() + part_start_[i], part_list_.data() + part_start_[i + 1]};
}

PixelWindow Grid::window_of(TileIndex t) const {
    const std::int64_t x = t.x * tile_width_, y = t.y * tile_height_;
    return {x, y, static_cast<int>(std::min<std::int64_t>(tile_width_, frame_.width() - x)),
            static_cast<int>(std::min<std::int64_t>(tile_height_, frame_.height() - y))};
}

// --- tiles ---

TilePtr Grid::load(TileIndex t) const {
    tile_reads_.fetch_add(1, std::memory_order_relaxed);
    const PixelWindow window = window_of(t);
    const std::size_t size = size_of(type()), count = area(window);
    auto tile = std::make_shared<Tile>(Tile{window.x, window.y, window.width, window.height, {}, {}});
    std::vector<std::uint8_t> valid(count, 0);
    std::vector<std::byte> samples(count * size), part_samples;
    std::vector<std::uint8_t> part_valid;
    for (const std::uint32_t p : parts_of(t)) {
        const GridPart& part = parts_[p];
        const PixelWindow w = intersection(window, window_of_part(part));
        const PixelWindow in_file{w.x - part.x, w.y - part.y, w.width, w.height};
        if (area(w) == count && parts_of(t).front() == p) {
            part.file->read(in_file, samples.data(), valid.data());
            continue;
        }
        part_samples.resize(area(w) * size);
        part_valid.resize(area(w));
        part.file->read(in_file, part_samples.data(), part_valid.data());
        for (int row = 0; row < w.height; ++row)
            for (int column = 0; column < w.width; ++column) {
                const auto from = static_cast<std::size_t>(row) * static_cast<std::size_t>(w.width) +
                                  static_cast<std::size_t>(column);
                const auto to = static_cast<std::size_t>((w.y - window.y + row) * window.width +
                                                         (w.x - window.x + column));
                if (valid[to] != 0 || part_valid[from] == 0) continue;
                valid[to] = 1;
                std::memcpy(samples.data() + to * size, part_samples.data() + from * size, size);
            }
    }
    const auto present = static_cast<std::size_t>(std::count(valid.begin(), valid.end(), std::uint8_t{1}));
    if (present > 0) tile->samples = std::move(samples);
    if (present > 0 && present < count) tile->valid = std::move(valid);
    return tile;
}

std::uint64_t Grid::tiles() const {
    std::uint64_t covered = 0;
    for (std::size_t t = 1; t < part_start_.size(); ++t)
        covered += part_start_[t] > part_start_[t - 1] ? 1 : 0;
    return covered;
}

TilePtr Grid::tile(TileIndex t) const {
    const std::uint64_t index = static_cast<std::uint64_t>(t.y * tiles_x_ + t.x);
    return cache_.get((key_ << 40) | index, [&] { return load(t); });
}

TilePtr Grid::tile_at(std::int64_t x, std::int64_t y) const {
    return tile({x / tile_width_, y / tile_height_});
}

// --- the pass over the whole grid ---

bool Grid::certainly_full(TileIndex t) const {
    const PixelWindow window = window_of(t);
    for (const std::uint32_t p : parts_of(t))
        if (!parts_[p].file->header().may_have_holes &&
            area(intersection(window, window_of_part(parts_[p]))) == area(window))
            return true;
    return false;
}

std::vector<std::uint8_t> Grid::covered_by_parts(const PixelWindow& window) const {
    std::vector<std::uint8_t> covered(area(window), 0);
    for (const std::uint32_t p : parts_of({window.x / tile_width_, window.y / tile_height_})) {
        const PixelWindow w = intersection(window, window_of_part(parts_[p]));
        for (int row = 0; row < w.height; ++row)
            std::memset(covered.data() + (w.y - window.y + row) * window.width + (w.x - window.x), 1,
                        static_cast<std::size_t>(w.width));
    }
    return covered;
}

void Grid::scan_tile(TileIndex t, std::uint64_t& samples, std::uint64_t& valid) const {
    if (parts_of(t).empty()) return;
    const PixelWindow window = window_of(t);
    std::vector<std::uint8_t> mask;
    if (certainly_full(t)) {
        mask.assign(area(window), 1);
    } else {
        bool holes = false;
        for (const std::uint32_t p : parts_of(t)) holes = holes || parts_[p].file->header().may_have_holes;
        mask = covered_by_parts(window);
        samples += static_cast<std::uint64_t>(std::count(mask.begin(), mask.end(), std::uint8_t{1}));
        if (holes) {
            const TilePtr loaded = tile(t);
            if (!loaded->valid.empty())
                mask = loaded->valid;
            else
                mask.assign(mask.size(), loaded->samples.empty() ? 0 : 1);
        }
    }
    const auto present = static_cast<std::uint64_t>(std::count(mask.begin(), mask.end(), std::uint8_t{1}));
    if (certainly_full(t)) samples += present;
    valid += present;
    const int side = 1 << cell_bits_;
    for (int y = 0; y < window.height; y += side)
        for (int x = 0; x < window.width; x += side) {
            const auto width = static_cast<std::size_t>(std::min(side, window.width - x));
            std::uint8_t some = 0, all = 1;
            for (int row = y; row < std::min(y + side, window.height); ++row) {
                const std::uint8_t* there = mask.data() + static_cast<std::ptrdiff_t>(row) * window.width + x;
                for (std::size_t i = 0; i < width; ++i) {
                    some |= there[i];
                    all &= there[i];
                }
            }
            const auto cell = static_cast<std::size_t>(((window.y + y) >> cell_bits_) * cells_x_ +
                                                       ((window.x + x) >> cell_bits_));
            cells_[cell] = static_cast<std::uint8_t>((some != 0 ? kSome : 0) | (all != 0 ? kAll : 0));
        }
}

void Grid::scan(bool lazy) {
    if (parts_.size() == 1 && !parts_.front().file->header().may_have_holes) {
        samples_ = valid_samples_ =
            static_cast<std::uint64_t>(frame_.width()) * static_cast<std::uint64_t>(frame_.height());
        return;
    }
    cells_.assign(static_cast<std::size_t>(cells_x_ * cells_y_), 0);
    if (lazy) {
        scanned_ = std::make_unique<std::once_flag[]>(static_cast<std::size_t>(tiles_x_ * tiles_y_));
        return;
    }
    std::mutex mutex;
    tbb::parallel_for(tbb::blocked_range<std::int64_t>(0, tiles_x_ * tiles_y_), [&](const auto& range) {
        std::uint64_t samples = 0, valid = 0;
        for (std::int64_t t = range.begin(); t < range.end(); ++t)
            scan_tile({t % tiles_x_, t / tiles_x_}, samples, valid);
        const std::lock_guard lock(mutex);
        samples_ += samples;
        valid_samples_ += valid;
    });
    if (valid_samples_ ==
        static_cast<std::uint64_t>(frame_.width()) * static_cast<std::uint64_t>(frame_.height()))
        cells_ = {};
}

double Grid::tile_spacing(const Ellipsoid& body, TileIndex t) const {
    const PixelWindow w = window_of(t);
    for (const auto& [fx, fy] : {std::pair{0.5, 0.5}, {0.1, 0.1}, {0.9, 0.1}, {0.1, 0.9}, {0.9, 0.9}}) {
        const auto spacing = frame_.spacing(body, static_cast<double>(w.x) + fx * w.width,
                                            static_cast<double>(w.y) + fy * w.height);
        if (spacing) return *spacing;
    }
    return kInfinity;
}

void Grid::find_spacings(const Ellipsoid& body) {
    if (frame_.rows_are_parallels()) {
        spacings_.resize(static_cast<std::size_t>(cells_y_), kInfinity);
        const double side = 1 << cell_bits_, u = static_cast<double>(frame_.width()) / 2;
        for (std::size_t y = 0; y < spacings_.size(); ++y) {
            const double v =
                std::min((static_cast<double>(y) + 0.5) * side, static_cast<double>(frame_.height()) - 0.5);
            spacings_[y] = frame_.spacing(body, u, v).value_or(kInfinity);
        }
        return;
    }
    spacings_.resize(static_cast<std::size_t>(tiles_x_ * tiles_y_));
    tbb::parallel_for(std::int64_t{0}, tiles_x_ * tiles_y_, [&](std::int64_t t) {
        spacings_[static_cast<std::size_t>(t)] = tile_spacing(body, {t % tiles_x_, t / tiles_x_});
    });
}

// From a net of places, with the net's widest mesh as margin. A place that the CRS does not have: the whole
// sphere.
void Grid::find_cap() {
    constexpr int kNet = 16;
    std::vector<Vec3> places;
    for (int j = 0; j <= kNet; ++j)
        for (int i = 0; i <= kNet; ++i) {
            const auto n = frame_.normal(static_cast<double>(frame_.width()) * i / kNet,
                                         static_cast<double>(frame_.height()) * j / kNet);
            if (!n) return;
            places.push_back(*n);
        }
    double mesh = 0;
    for (std::size_t k = 0; k + kNet + 1 < places.size(); ++k) {
        mesh = std::max(mesh, angle_between(places[k], places[k + kNet + 1]));
        if (k % (kNet + 1) != kNet) mesh = std::max(mesh, angle_between(places[k], places[k + 1]));
    }
    cap_ = cap_of(places, mesh);
}

}  // namespace carat
