#include "carat/bench/codec_bench.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>

#include "carat/globe/error.hpp"
#include "cycles.hpp"

namespace carat::bench {
namespace {

// Median of up to `repeats` runs, seconds of the thread.
template <class Work>
double median_seconds(int repeats, Work work) {
    constexpr double kLongSeconds = 5;
    std::vector<double> times;
    do {
        const double begin = thread_seconds();
        work();
        times.push_back(thread_seconds() - begin);
    } while (static_cast<int>(times.size()) < repeats && times.back() < kLongSeconds);
    std::sort(times.begin(), times.end());
    return times[(times.size() - 1) / 2];
}

// Rate of the time stamp counter.
double cycles_per_second() {
    const auto begin = std::chrono::steady_clock::now();
    const std::uint64_t first = cycles_now();
    std::chrono::duration<double> passed{};
    do passed = std::chrono::steady_clock::now() - begin;
    while (passed.count() < 0.05);
    return static_cast<double>(cycles_now() - first) / passed.count();
}

bool chosen(const ContestantInfo& info, const std::vector<std::string>& names) {
    return names.empty() || std::any_of(names.begin(), names.end(),
                                        [&](const std::string& n) { return info.name.rfind(n, 0) == 0; });
}

CodecRow measure(const ContestantInfo& info, const Raster& raster, int tile, double tolerance, int repeats,
                 double cycles_per_second) {
    CodecRow row;
    row.codec = info.name;
    row.unit = tile > 0 ? std::to_string(tile) : info.unit;
    row.tolerance = tolerance;
    const auto samples = static_cast<double>(raster.size());
    try {
        const std::vector<Raster> tiles = cut_tiles(raster, tile);
        std::vector<Raster> decoded;
        for (const Raster& t : tiles) decoded.push_back(t.like());
        const auto contestant = info.make();
        contestant->prepare(tiles, tolerance);
        const double encode = median_seconds(repeats, [&] { row.bytes = contestant->encode(tiles); });
        const double decode = median_seconds(repeats, [&] { contestant->decode(decoded); });
        Raster whole = raster.like();
        join_tiles(decoded, tile, whole);
        row.bits_per_sample = 8 * static_cast<double>(row.bytes) / samples;
        row.errors = compare(raster, whole);
        row.within = row.errors.max <= (raster.integer ? std::floor(tolerance) : tolerance);
        row.encode_rate = samples / encode;
        row.decode_rate = samples / decode;
        row.decode_cycles = decode * cycles_per_second / samples;
        row.decode_bytes_per_cycle = static_cast<double>(raster.bytes()) / (decode * cycles_per_second);
        row.decode_shares = contestant->decode_shares();
    } catch (const Error& e) {
        row.failure = e.what();
    }
    return row;
}

void measure_copy(const Raster& raster, CodecTable& table) {
    const std::size_t bytes = raster.bytes();
    std::vector<std::byte> from(bytes), to(bytes);
    const double copy = median_seconds(9, [&] { std::memcpy(to.data(), from.data(), bytes); });
    table.cycles_per_second = cycles_per_second();
    table.copy_bytes_per_cycle = static_cast<double>(bytes) / (copy * table.cycles_per_second);
}

struct Job {
    const ContestantInfo* info;
    int tile;
    double tolerance;
};

std::vector<Job> jobs(const CodecBenchOptions& options) {
    std::vector<Job> out;
    for (const ContestantInfo& info : contestants()) {
        if (!chosen(info, options.codecs)) continue;
        if (info.tiled && options.tile > 0)
            for (const double t : options.tolerances) out.push_back({&info, options.tile, t});
        for (const double t : options.tolerances) out.push_back({&info, 0, t});
    }
    if (out.empty()) throw Error(ErrorCode::usage, "there is no codec of that name");
    return out;
}

}  // namespace

CodecTable bench_codecs(const Raster& raster, const CodecBenchOptions& options) {
    CodecTable table;
    const std::vector<Job> all = jobs(options);
    measure_copy(raster, table);
    for (const Job& job : all) {
        if (options.progress && !options.progress(job.info->name, table.rows.size(), all.size()))
            throw Error(ErrorCode::usage, "cancelled");
        table.rows.push_back(
            measure(*job.info, raster, job.tile, job.tolerance, options.repeats, table.cycles_per_second));
    }
    return table;
}

}  // namespace carat::bench
