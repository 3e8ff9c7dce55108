#include "build_workspace.hpp"

#include <sys/resource.h>
#include <unistd.h>
#include <xxhash.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>

#include "carat/codec/quantize.hpp"
#include "carat/globe/error.hpp"
#include "content_hash.hpp"

namespace carat {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* kInputsName = "inputs.json";
constexpr int kLayout = 2;  // of the temporary files
// Program, libraries and the two steps at work.
constexpr std::size_t kOwnMemory = std::size_t{150} << 20;
// More than a few steps of heights is seldom asked for again; reading them costs less than fresh memory does.
constexpr std::size_t kMostHeights = std::size_t{256} << 20;
// Lists, summaries, pages: bytes a refined diamond.
constexpr std::uint64_t kDiamondMemory = 160;

std::string hexadecimal(std::uint64_t x) {
    char text[17];
    std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(x));
    return text;
}

std::string gigabytes(std::uint64_t bytes) {
    char text[32];
    std::snprintf(text, sizeof text, "%.2f GiB", static_cast<double>(bytes) / (1 << 30));
    return text;
}

Json layer_inputs(const LayerOptions& o, const LayerInfo& info) {
    Json files = Json::array();
    for (const FileInfo& f : info.files)
        files.push_back({{"name", fs::path(f.path).filename().string()},
                         {"bytes", f.bytes},
                         {"content", hexadecimal(f.hash)}});
    Json out{{"files", files},
             {"resampling", to_string(o.resampling)},
             {"band", o.band},
             {"latitude", static_cast<int>(o.latitude)}};
    if (o.colour_component) out["colour_component"] = *o.colour_component;
    if (o.nodata) out["nodata"] = std::to_string(*o.nodata);
    if (o.valid_range) out["valid_range"] = *o.valid_range;
    if (o.bounds) out["bounds"] = *o.bounds;
    if (o.feather) out["feather"] = *o.feather;
    if (o.feather_edges) out["feather_edges"] = *o.feather_edges;
    if (!o.geoid.empty()) out["geoid"] = hexadecimal(content_hash({o.geoid}).hash);
    return out;
}

// The names of the inputs that differ, "/layers/0/files/0/content" and so on.
std::string differences(const std::string& before, const std::string& now) {
    std::string out;
    const Json old = Json::parse(before, nullptr, false);
    if (old.is_discarded()) return "its list of inputs is damaged";
    for (const Json& change : Json::diff(old, Json::parse(now)))
        out += (out.empty() ? "" : ", ") + change.at("path").get<std::string>().substr(1);
    return out + " differ";
}

std::string read_text(const fs::path& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

void write_text(const fs::path& path, const std::string& text) {
    std::ofstream out(path, std::ios::binary | std::ios::trunc);
    out << text;
    out.close();
    if (!out) throw Error(ErrorCode::io, path.string() + ": cannot write");
}

void check_room(const fs::path& folder, std::uint64_t usual, std::uint64_t there) {
    std::error_code failed;
    const fs::space_info space = fs::space(folder, failed);
    if (failed || space.available + there >= usual) return;
    throw Error(ErrorCode::io, folder.string() + ": the temporary data of this build need about " +
                                   gigabytes(usual) + ", only " + gigabytes(space.available) +
                                   " are free; make room or name another disk with --temp");
}

}  // namespace

std::optional<tbb::global_control> limit_threads(int threads) {
    if (threads <= 0) return std::nullopt;
    return std::optional<tbb::global_control>(std::in_place, tbb::global_control::max_allowed_parallelism,
                                              static_cast<std::size_t>(threads));
}

std::size_t memory_limit(const BuildOptions& options) {
    if (options.memory_bytes == 0) {
        const auto ram = static_cast<std::size_t>(sysconf(_SC_PHYS_PAGES)) *
                         static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
        return std::max(kLeastMemory, ram / 4);
    }
    if (options.memory_bytes < kLeastMemory)
        throw Error(ErrorCode::usage, "a build needs at least 256M of memory");
    return options.memory_bytes;
}

MemoryShares share_memory(std::size_t limit) {
    const std::size_t rest = limit - kOwnMemory;
    return {rest / 2, std::min(rest / 4, kMostHeights), rest / 5};
}

void check_diamonds(std::uint64_t refined, std::size_t limit) {
    if (refined * kDiamondMemory <= share_memory(limit).diamonds) return;
    throw Error(ErrorCode::limit, "this build has " + std::to_string(refined) +
                                      " diamonds, whose lists need a --memory of at least " +
                                      gigabytes(refined * kDiamondMemory * 5 + kOwnMemory));
}

// Reference heights are written fine to coarse and dropped as they are coded; reconstructed heights are kept
// for six levels, those of the deepest not at all.
TemporaryBytes temporary_bytes(const RefinedLevels& levels, int n, Mode mode) {
    const auto vertices = static_cast<std::uint64_t>(n * n),
               cells = static_cast<std::uint64_t>((n - 1) * (n - 1));
    const bool filtered = mode != Mode::interpolating;
    const std::uint64_t up = vertices, reference = cells + (filtered ? vertices : 0);
    const std::uint64_t heights = vertices + cells + (filtered ? vertices : 0);
    constexpr std::uint64_t kFacts = 512, kCode = 2048;  // bytes
    std::uint64_t peak = 0, now = 0, small = 0;
    const auto count = [&](std::size_t level) { return static_cast<std::uint64_t>(levels[level].size()); };
    for (std::size_t level = levels.size(); level-- > 0;) {
        now += count(level) * (reference + up);
        peak = std::max(peak, now);
        if (level + 1 < levels.size()) now -= count(level + 1) * up;
    }
    for (std::size_t level = 0; level < levels.size(); ++level) {
        if (level + 1 < levels.size()) now += count(level) * heights;
        small += count(level) * (kFacts + kCode);
        peak = std::max(peak, now);
        now -= count(level) * reference;
        if (level >= 5) now -= count(level - 5) * heights;
    }
    return {4 * peak + small + (std::uint64_t{1} << 20), 2 * peak + small};
}

fs::path temporary_folder(const BuildOptions& options) {
    const std::string name = options.output.filename().string();
    if (options.temp.empty()) return options.output.parent_path() / (name + ".build");
    const std::string whole = fs::absolute(options.output).lexically_normal().string();
    return options.temp / (name + "-" + hexadecimal(XXH3_64bits(whole.data(), whole.size())) + ".build");
}

std::string inputs_of(const BuildOptions& o, const SourceStack& sources) {
    Json layers = Json::array();
    for (std::size_t k = 0; k < o.layers.size(); ++k)
        layers.push_back(layer_inputs(o.layers[k], sources.layers()[k]));
    return Json{{"layout", kLayout},
                {"version", CARAT_VERSION},
                {"layers", layers},
                {"tolerance", o.tolerance},
                {"quantum", o.quantum.value_or(default_quantum(o.tolerance))},
                {"body", {o.body.name(), o.body.a(), o.body.b()}},
                {"base_height", o.base_height},
                {"vertical_datum", o.vertical_datum},
                {"mode", static_cast<int>(o.mode)},
                {"coder", to_string(o.coding.coder)},
                {"orders", o.coding.orders},
                {"rms", o.rms ? Json(*o.rms) : Json(nullptr)},
                {"fit_tables", o.fit_tables},
                {"depth_bias", o.depth_bias},
                {"max_level", o.max_level},
                {"certify", o.certify ? Json(*o.certify) : Json(nullptr)},
                {"measure", o.measures()},
                {"log2_cells", o.log2_cells}}
        .dump(1);
}

std::optional<double> tolerance_in_workspace(const BuildOptions& options) {
    const fs::path path = temporary_folder(options) / kInputsName;
    if (!options.resume || !options.rms || !fs::exists(path)) return std::nullopt;
    const Json before = Json::parse(read_text(path), nullptr, false);
    if (!before.is_object() || before.value("rms", Json()) != Json(*options.rms)) return std::nullopt;
    const Json tolerance = before.value("tolerance", Json());
    return tolerance.is_number() ? std::optional<double>(tolerance.get<double>()) : std::nullopt;
}

std::unique_ptr<StepStore> open_workspace(const BuildOptions& options, const SourceStack& sources,
                                          const TemporaryBytes& bytes) {
    const fs::path folder = temporary_folder(options);
    const std::string inputs = inputs_of(options, sources);
    bool resume = options.resume;
    if (resume && fs::exists(folder / kInputsName)) {
        const std::string before = read_text(folder / kInputsName);
        if (before != inputs)
            throw Error(ErrorCode::usage, folder.string() +
                                              ": cannot resume this build: " + differences(before, inputs) +
                                              "; without --resume it starts anew");
    } else {
        resume = false;
    }
    auto store =
        std::make_unique<StepStore>(folder, XXH3_64bits(inputs.data(), inputs.size()), resume, bytes.usual);
    check_room(folder, bytes.usual, store->bytes());
    if (!resume) write_text(folder / kInputsName, inputs);
    return store;
}

std::uint64_t peak_memory_bytes() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
}

}  // namespace carat
