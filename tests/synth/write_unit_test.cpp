// What write() promises about files: same bytes each time, manifest, no overwriting, nothing half-written,
// progress.
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <map>

#include "carat/globe/error.hpp"
#include "carat/synth/synth.hpp"
#include "raster_reader.hpp"

namespace carat::synth {
namespace {

namespace fs = std::filesystem;
using test::Directory;
using test::Raster;

std::map<std::string, std::string> contents(const fs::path& directory) {
    std::map<std::string, std::string> files;
    for (const auto& entry : fs::directory_iterator(directory)) {
        std::ifstream in(entry.path(), std::ios::binary);
        files[entry.path().filename().string()] = {std::istreambuf_iterator<char>(in), {}};
    }
    return files;
}

ErrorCode code_of(const std::function<void()>& action) {
    try {
        action();
    } catch (const Error& e) {
        return e.code();
    }
    ADD_FAILURE() << "no error";
    return ErrorCode::corrupt;
}

Options small() {
    Options o;
    o.size = 64;
    o.inset_size = 40;
    return o;
}

TEST(Write, SameBytesEachTime) {
    const Directory a("synth_same_a"), b("synth_same_b");
    for (const Kind kind : {Kind::earth, Kind::moon}) {
        Options o = small();
        o.overwrite = true;
        write(kind, a.path(), o);
        write(kind, b.path(), o);
        EXPECT_EQ(contents(a.path()), contents(b.path()));
    }
}

TEST(Write, SeedChangesTheBytes) {
    const Directory a("synth_seed_a"), b("synth_seed_b");
    Options o = small();
    write(Kind::moon, a.path(), o);
    o.seed = 2;
    write(Kind::moon, b.path(), o);
    EXPECT_NE(contents(a.path()).at("moon_global.tif"), contents(b.path()).at("moon_global.tif"));
}

TEST(Write, LeavesTheNamedFilesAndTheManifestOnly) {
    const Directory d("synth_names");
    std::map<std::string, std::string> expected{{"manifest.json", ""}};
    for (const Written& f : write(Kind::hostile, d.path())) expected[f.name] = "";
    std::map<std::string, std::string> found = contents(d.path());
    const std::string manifest = found.at("manifest.json");
    for (auto& [name, bytes] : found) bytes.clear();
    EXPECT_EQ(found, expected);
    for (const auto& [name, nothing] : expected)
        EXPECT_TRUE(name == "manifest.json" || manifest.find('"' + name + '"') != std::string::npos) << name;
    EXPECT_EQ(manifest.find(d.path().string()), std::string::npos);
}

TEST(Write, RefusesToOverwriteUnlessTold) {
    const Directory d("synth_overwrite");
    write(Kind::onepixel, d.path());
    const auto before = contents(d.path());
    EXPECT_EQ(code_of([&] { write(Kind::onepixel, d.path()); }), ErrorCode::usage);
    EXPECT_EQ(code_of([&] { write(Kind::constant, d.path()); }), ErrorCode::usage);  // the manifest
    EXPECT_EQ(contents(d.path()), before);
    Options o;
    o.overwrite = true;
    EXPECT_NO_THROW(write(Kind::onepixel, d.path(), o));
    EXPECT_EQ(contents(d.path()), before);
}

TEST(Write, CannotWriteIntoAFile) {
    const Directory d("synth_not_a_directory");
    fs::create_directories(d.path());
    std::ofstream(d.path() / "file") << "x";
    EXPECT_EQ(code_of([&] { write(Kind::onepixel, d.path() / "file"); }), ErrorCode::io);
}

TEST(Write, InterruptedLeavesNothingHalfWritten) {
    const Directory d("synth_interrupted");
    Options o = small();
    o.progress = [](std::uint64_t, std::uint64_t) { return false; };
    EXPECT_EQ(code_of([&] { write(Kind::moon, d.path(), o); }), ErrorCode::io);
    EXPECT_TRUE(contents(d.path()).empty());
}

TEST(Write, ProgressRisesToTheTotal) {
    const Directory d("synth_progress");
    Options o = small();
    std::uint64_t last = 0, total = 0, calls = 0;
    o.progress = [&](std::uint64_t done, std::uint64_t all) {
        EXPECT_GT(done, last);
        EXPECT_TRUE(total == 0 || total == all);
        last = done;
        total = all;
        ++calls;
        return true;
    };
    std::uint64_t samples = 0;
    for (const Written& f : write(Kind::moon, d.path(), o))
        samples += static_cast<std::uint64_t>(f.width) * static_cast<std::uint64_t>(f.height);
    EXPECT_EQ(last, samples);
    EXPECT_EQ(total, samples);
    EXPECT_GT(calls, 1U);
}

TEST(Write, EarthIsAGlobeWithFinerInsets) {
    const Directory d("synth_earth");
    Options detailed = small();
    detailed.inset_size = 500;
    const std::vector<Written> files = write(Kind::earth, d.path(), detailed);
    ASSERT_EQ(files.size(), 4U);
    const Bounds globe = files.back().bounds;
    EXPECT_EQ(globe.west, -180);
    EXPECT_EQ(globe.east, 180);
    EXPECT_EQ(globe.south, -90);
    EXPECT_EQ(globe.north, 90);
    for (std::size_t i = 1; i < files.size(); ++i) EXPECT_GT(files[i].spacing_m, files[i - 1].spacing_m);

    const auto range = test::read_raster(d.path() / "earth_range_3s.tif");
    ASSERT_TRUE(range.has_value());
    double holes = 0, highest = -1e9;
    for (const double h : range->samples) {
        holes += h == *range->nodata;
        highest = std::max(highest, h);
    }
    EXPECT_GT(holes / static_cast<double>(range->samples.size()), 0.001);
    EXPECT_LT(holes / static_cast<double>(range->samples.size()), 0.15);
    EXPECT_GT(highest, 3500);

    const auto coast = test::read_raster(d.path() / "earth_coast_0p5s.tif");
    ASSERT_TRUE(coast.has_value());
    double land = 0;
    for (const double h : coast->samples) land += h > 0;
    EXPECT_GT(land / static_cast<double>(coast->samples.size()), 0.1);
    EXPECT_LT(land / static_cast<double>(coast->samples.size()), 0.9);

    const auto summit = test::read_raster(d.path() / "earth_summit_utm10m.tif");
    ASSERT_TRUE(summit.has_value());
    EXPECT_NE(summit->crs_wkt.find("UTM"), std::string::npos);
}

TEST(Write, RefusesBadOptions) {
    const Directory d("synth_options");
    Options odd, huge, fine, thin;
    odd.size = 63;
    huge.size = 86402;
    fine.min_wavelength_m = 0.1;
    thin.inset_size = 1;
    for (const Options& o : {odd, huge, fine, thin})
        EXPECT_EQ(code_of([&] { write(Kind::moon, d.path(), o); }), ErrorCode::usage);
    EXPECT_FALSE(fs::exists(d.path()));
    EXPECT_EQ(code_of([] { planet(Kind::hostile); }), ErrorCode::usage);
}

TEST(Kinds, HaveNamesThatLeadBack) {
    for (const KindInfo& k : kinds()) {
        EXPECT_EQ(kind_of(k.name), k.kind);
        EXPECT_FALSE(std::string(k.description).empty());
        EXPECT_EQ(std::string(k.description).find('\n'), std::string::npos);
    }
    EXPECT_EQ(code_of([] { kind_of("jupiter"); }), ErrorCode::usage);
}

}  // namespace
}  // namespace carat::synth
