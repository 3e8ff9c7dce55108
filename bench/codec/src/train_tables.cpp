// Trains the built-in tables of the range coder: counts tokens over rasters and tolerances, fits, repeats
// with the fitted tables, and writes codec/src/range_built_in.hpp to standard output.
//
// usage: carat_train_tables TOLERANCE[,TOLERANCE...] RASTER... [-- TOLERANCE... RASTER...]...
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <sstream>
#include <string>

#include "carat/bench/plane.hpp"
#include "carat/bench/raster.hpp"

namespace {

using namespace carat;

struct Job {
    std::vector<double> tolerances;
    bench::Raster raster;
};

constexpr int kRounds = 4;
constexpr std::uint64_t kEnough = 3000;  // tokens that a context must have seen to speak for itself

// A context seldom seen takes the counts of the nearest below it in activity that was, else of the nearest
// above.
RangeStatistics filled(const RangeStatistics& seen) {
    RangeStatistics out;
    const auto count = [&](std::size_t c, std::size_t t) { return seen.counts()[c * 64 + t]; };
    const auto total = [&](std::size_t c) {
        std::uint64_t n = 0;
        for (std::size_t t = 0; t < 64; ++t) n += count(c, t);
        return n;
    };
    for (std::size_t pass = 0; pass < 2; ++pass)
        for (std::size_t c = 0; c < 64; ++c) {
            const std::size_t base = 64 * pass;
            std::size_t from = c;
            while (from > 0 && total(base + from) < kEnough) --from;
            for (std::size_t up = c; total(base + from) < kEnough && up < 64; ++up) from = up;
            for (std::size_t t = 0; t < 64; ++t) out.add(base + c, t, 16 * count(base + from, t));
        }
    return out;
}

void print(const RangeTables& tables) {
    std::printf(
        "// The built-in tables of the range coder, in the form of RangeTables::bytes(). Part of the file "
        "format:\n"
        "// written by carat_train_tables (bench/codec), never to be changed while coder id 1 means them.\n"
        "#pragma once\n\n#include <cstdint>\n\nnamespace carat {\n\n// clang-format off\n"
        "inline constexpr std::uint8_t kBuiltInRangeTables[] = {");
    int k = 0;
    for (const std::byte b : tables.bytes())
        std::printf("%s%d,", k++ % 28 == 0 ? "\n    " : "", static_cast<int>(b));
    std::printf("\n};\n// clang-format on\n\n}  // namespace carat\n");
}

std::vector<double> numbers(const std::string& text) {
    std::vector<double> out;
    std::istringstream in(text);
    for (std::string word; std::getline(in, word, ',');) out.push_back(std::stod(word));
    return out;
}

void run(int argc, char** argv) {
    std::vector<Job> jobs;
    std::vector<double> tolerances;
    for (int k = 1; k < argc; ++k) {
        const std::string word = argv[k];
        if (word == "--") {
            tolerances.clear();
        } else if (tolerances.empty()) {
            tolerances = numbers(word);
        } else {
            std::size_t missing = 0;
            jobs.push_back({tolerances, bench::read_raster(word, {}, missing)});
        }
    }
    std::shared_ptr<const RangeTables> tables = RangeTables::built_in();
    for (int round = 0; round < kRounds; ++round) {
        RangeStatistics sum;
        double bits = 0, samples = 0;
        for (const Job& job : jobs)
            for (const double tolerance : job.tolerances) {
                bench::KernelChoice choice{Mode::interpolating, Coding{}};
                choice.coding.tables = tables;
                bench::PlaneCodec codec(job.raster, choice, tolerance);
                codec.count_tokens();
                bits += 8.0 * static_cast<double>(codec.encode(job.raster));
                samples += static_cast<double>(job.raster.size());
                sum.merge(codec.tokens());
            }
        std::fprintf(stderr, "round %d: %.4f bits a sample\n", round, bits / samples);
        tables = RangeTables::fit(filled(sum));
    }
    print(*tables);
}

}  // namespace

int main(int argc, char** argv) {
    try {
        run(argc, argv);
        return 0;
    } catch (const std::exception& e) {
        std::fprintf(stderr, "carat_train_tables: %s\n", e.what());
        return 1;
    }
}
