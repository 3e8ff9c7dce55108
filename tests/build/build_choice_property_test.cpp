// What a build decides from a sample: an RMS error is kept by whole files, checked height by height against
// the sources; fitted tables change nothing but the size.
#include <gtest/gtest.h>

#include <cmath>

#include "build_choice.hpp"
#include "carat/codec/repository.hpp"
#include "carat/codec/surface.hpp"
#include "carat/globe/error.hpp"
#include "scratch.hpp"

namespace carat::test {
namespace {

struct Errors {
    double max = 0, squares = 0;
    std::size_t count = 0;

    double rms() const { return std::sqrt(squares / static_cast<double>(count)); }
};

// Of the values that residuals are coded for, at every level: in mode 0 the cell centres.
void add_errors(const Surface& surface, const SourceStack& sources, DiamondId d, Errors& sum) {
    const Repository& repository = surface.repository();
    if (!repository.refined(d)) return;
    for (const DiamondId c : children(d))
        if (*parent(c, 0) == d) add_errors(surface, sources, c, sum);
    const int n = repository.header().n();
    for (const int side : {0, 1})
        for (const Half& half : child_halves({d, side})) {
            const auto p = surface.heights(half.diamond);
            const ChildMap m = child_map(d, half, n - 1);
            const HalfFrame frame = half_frame(half, n - 1);
            for (int i = 0; i < n; ++i)
                for (int j = half.side == 0 ? 0 : i; j < (half.side == 0 ? i + 1 : n); ++j) {
                    const bool centre = ((m.p0 + i * m.pi + j * m.pj) & 1) != 0;
                    if (!centre) continue;
                    const double e = p->at(i, j) * repository.header().quantum -
                                     height_at_point(sources, frame.vertex(i, j));
                    sum.max = std::max(sum.max, std::abs(e));
                    sum.squares += e * e;
                    ++sum.count;
                }
        }
}

Errors errors_of(const BuildOptions& options) {
    const Surface surface(Repository::open(options.output));
    const SourceStack sources(options.layers, options.body, 0, std::size_t{64} << 20);
    Errors sum;
    for (int face = 0; face < kFaces; ++face) add_errors(surface, sources, root_diamond(face), sum);
    return sum;
}

TEST(BuildChoice, AnRmsErrorIsKeptByTheWholeFileAndUsedUp) {
    for (const CoderId coder : {CoderId::range, CoderId::gamma}) {
        const Scratch scratch;
        BuildOptions options = synthetic_build(synth::Kind::earth, scratch.folder, 256);
        if (coder == CoderId::gamma) options.coding = Coding::gamma();
        options.rms = 1.5;
        options.tolerance = 100;
        const BuildReport report = build_repository(options);
        const auto header = Repository::open(options.output)->header();
        EXPECT_EQ(header.rms_tolerance, 1.5);
        EXPECT_EQ(header.tolerance, report.tolerance);
        EXPECT_LE(header.tolerance, 8 * 1.5);
        const Errors found = errors_of(options);
        EXPECT_LE(found.rms(), 1.5);
        EXPECT_GT(found.rms(), 0.9 * 1.5) << "the promise is used up";
        EXPECT_LE(found.max, header.tolerance);
        EXPECT_GT(found.count, std::size_t{100000});
    }
}

TEST(BuildChoice, AnRmsErrorDoesNotLiftTheTolerance) {
    const Scratch scratch;
    BuildOptions options = synthetic_build(synth::Kind::earth, scratch.folder, 128);
    options.rms = 3;
    options.tolerance = 2;
    build_repository(options);
    EXPECT_LE(Repository::open(options.output)->header().tolerance, 2);
    EXPECT_LE(errors_of(options).max, 2);
}

TEST(BuildChoice, BytesDoNotDependOnThreads) {
    const Scratch scratch;
    BuildOptions options = synthetic_build(synth::Kind::earth, scratch.folder, 128);
    options.rms = 2;
    options.fit_tables = true;
    options.overwrite = true;
    std::string first;
    for (const int threads : {1, 2, 5}) {
        options.threads = threads;
        build_repository(options);
        const std::string bytes = bytes_of(options.output);
        if (first.empty()) first = bytes;
        EXPECT_TRUE(bytes == first) << threads;
    }
}

TEST(BuildChoice, FittedTablesAreStoredAndKeepTheBound) {
    const Scratch scratch;
    BuildOptions options = synthetic_build(synth::Kind::moon, scratch.folder, 512);
    options.overwrite = true;
    options.tolerance = 0.02;
    const std::uint64_t plain = build_repository(options).file_bytes;
    EXPECT_FALSE(Repository::open(options.output)->header().fitted_tables);
    options.fit_tables = true;
    const std::uint64_t fitted = build_repository(options).file_bytes;
    EXPECT_TRUE(Repository::open(options.output)->header().fitted_tables);
    EXPECT_LT(fitted, plain) << "this surface is unlike those that the built-in tables were made of";
    EXPECT_LE(errors_of(options).max, 0.02);
}

TEST(BuildChoice, TablesThatDoNotPayAreLeftOut) {
    const Scratch scratch;
    BuildOptions options = synthetic_build(synth::Kind::earth, scratch.folder, 64);
    options.overwrite = true;
    build_repository(options);
    const std::string plain = bytes_of(options.output);
    options.fit_tables = true;
    build_repository(options);
    EXPECT_TRUE(bytes_of(options.output) == plain);
}

// After a round that missed: steps go down by the ratio, at least by one, to the finest and no further.
TEST(BuildChoice, AMissedRmsLeadsToSmallerStepsUntilThereAreNone) {
    BuildOptions options;
    options.rms = 4;
    options.quantum = 1;
    options.tolerance = tolerance_of(100, 1);
    const BuildOptions next = with_smaller_step(options, 5);
    EXPECT_GT(next.tolerance, tolerance_of(70, 1));
    EXPECT_LT(next.tolerance, tolerance_of(80, 1)) << "0.8 of the radius, and a margin";
    options.tolerance = tolerance_of(10, 1);
    EXPECT_EQ(with_smaller_step(options, 4.0001).tolerance, tolerance_of(9, 1));
    options.tolerance = tolerance_of(1, 1);
    options = with_smaller_step(options, 4.0001);
    EXPECT_EQ(options.tolerance, tolerance_of(0, 1));
    EXPECT_THROW(with_smaller_step(options, 4.0001), Error);
}

TEST(BuildChoice, WhatCannotBeIsRefused) {
    const Scratch scratch;
    const BuildOptions good = synthetic_build(synth::Kind::earth, scratch.folder, 64);
    const auto refuses = [&](auto change) {
        BuildOptions o = good;
        change(o);
        try {
            build_repository(o);
            ADD_FAILURE() << "no error";
        } catch (const Error& e) {
            EXPECT_EQ(e.code(), ErrorCode::usage) << e.what();
        }
        EXPECT_FALSE(std::filesystem::exists(o.output));
    };
    refuses([](BuildOptions& o) { o.rms = 0; });
    refuses([](BuildOptions& o) { o.rms = std::nan(""); });
    refuses([](BuildOptions& o) { o.rms = 1, o.certify = 20; });
    refuses([](BuildOptions& o) { o.rms = 0.5, o.quantum = 1; });
    refuses([](BuildOptions& o) { o.coding = Coding::gamma(), o.fit_tables = true; });
}

}  // namespace
}  // namespace carat::test
