// The sizes that Carat's codec reaches on synthetic relief are a table in the tree, codec_sizes.csv: a change
// of the ratio shows in review. After a wanted change write the table anew:
//
//   CARAT_WRITE_TABLES=1 build/release/tests/bench/bench_codec_sizes_golden_test
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <sstream>

#include "carat/bench/codec_bench.hpp"
#include "carat/synth/synth.hpp"

namespace carat::bench {
namespace {

constexpr const char* kFile = CARAT_SOURCE_DIR "/tests/bench/codec_sizes.csv";
constexpr int kSide = 513;

// `spacing`: between samples, in radii of the body, around (1, y, z). The formulas give the same bits
// everywhere.
Raster patch(const synth::Height& height, double y, double z, double spacing, bool integer) {
    Raster r;
    r.width = r.height = kSide;
    r.integer = integer;
    for (int row = 0; row < kSide; ++row)
        for (int column = 0; column < kSide; ++column) {
            const double a = y + column * spacing, b = z + row * spacing,
                         length = std::sqrt(1 + a * a + b * b);
            const double h = height({1 / length, a / length, b / length});
            if (integer)
                r.whole.push_back(static_cast<std::int16_t>(std::floor(h + 0.5)));
            else
                r.real.push_back(static_cast<float>(h));
        }
    return r;
}

std::string table() {
    const synth::Height earth = synth::earthlike(1, 200), moon = synth::moonlike(1, 400);
    struct Case {
        const char* name;
        Raster raster;
    };
    const Case cases[] = {{"earth 90 m int16", patch(earth, 0.3, 0.1, 1.4e-5, true)},
                          {"earth 9 km int16", patch(earth, -0.4, -0.4, 1.4e-3, true)},
                          {"moon 200 m float32", patch(moon, 0.2, 0.3, 1.15e-4, false)}};
    CodecBenchOptions options;
    options.codecs = {"carat"};
    options.repeats = 1;
    std::ostringstream out;
    out << "raster,codec,tolerance_m,bytes,bits_per_sample\n";
    for (const Case& c : cases)
        for (const CodecRow& row : bench_codecs(c.raster, options).rows) {
            EXPECT_TRUE(row.within) << c.name << " " << row.codec << row.failure;
            out << c.name << ',' << row.codec << ',' << row.tolerance << ',' << row.bytes << ',';
            out.setf(std::ios::fixed);
            out.precision(4);
            out << row.bits_per_sample << '\n';
            out.unsetf(std::ios::fixed);
            out.precision(6);
        }
    return out.str();
}

TEST(CodecSizes, AreThoseOfTheTable) {
    const std::string found = table();
    if (std::getenv("CARAT_WRITE_TABLES") != nullptr) std::ofstream(kFile, std::ios::binary) << found;
    std::ifstream in(kFile, std::ios::binary);
    const std::string pinned{std::istreambuf_iterator<char>(in), {}};
    EXPECT_EQ(found, pinned) << "a change of the ratio: see the head of this test for how to accept it";
}

}  // namespace
}  // namespace carat::bench
