// carat info: the numbers add up.
#include "program.hpp"
#include "rasters.hpp"

namespace carat::test {
namespace {

class Info : public Program {
  protected:
    void SetUp() override {
        Program::SetUp();
        write_raster(path("hills.tif"), hills());
        write_raster(path("flat.tif"), flat(40));
        ASSERT_EQ(carat("build -q --layer hills.tif --tolerance 2 -o hills.carat").exit, 0);
        ASSERT_EQ(
            carat("build -q --layer flat.tif --tolerance 2 --vertical-datum ellipsoid -o flat.carat").exit,
            0);
    }
};

void check_sums(const nlohmann::json& info, std::uintmax_t file_bytes) {
    const auto& bytes = info.at("bytes");
    EXPECT_EQ(bytes.at("file"), file_bytes);
    EXPECT_EQ(bytes.at("header").get<std::uint64_t>() + bytes.at("roots").get<std::uint64_t>() +
                  bytes.at("pages").get<std::uint64_t>() + bytes.at("directory").get<std::uint64_t>(),
              file_bytes);
    std::uint64_t refined = 0, zero = 0, residuals = 0;
    for (const auto& level : info.at("levels")) {
        refined += level.at("refined").get<std::uint64_t>();
        zero += level.at("zero").get<std::uint64_t>();
        residuals += level.at("residual_bytes").get<std::uint64_t>();
    }
    EXPECT_EQ(refined, info.at("refined_diamonds"));
    EXPECT_EQ(zero, info.at("zero_diamonds"));
    EXPECT_EQ(residuals, bytes.at("residuals"));
    std::uint64_t coded = 0;
    for (const auto& mode : info.at("modes")) coded += mode.get<std::uint64_t>();
    EXPECT_EQ(coded, refined - zero);
}

TEST_F(Info, SumsAgreeWithTheFile) {
    for (const char* name : {"hills.carat", "flat.carat"})
        check_sums(carat(std::string("info --json ") + name).json(), fs::file_size(path(name)));
}

TEST_F(Info, LayersAddUpToTheWhole) {
    write_raster(path("patch.tif"), {200, 200, {10, 10, 20, 20}, [](double lat, double lon) {
                                         return 300 * std::sin(30 * lat) * std::cos(20 * lon);
                                     }});
    ASSERT_EQ(carat("build -q --layer patch.tif --layer hills.tif --tolerance 2 -o two.carat").exit, 0);
    const auto info = carat("info --json two.carat").json();
    const auto& shares = info.at("provenance").at("shares");
    ASSERT_EQ(shares.size(), 3u) << "two layers and the base height";
    for (const char* key : {"refined", "zero", "residual_bytes"}) {
        std::uint64_t by_layer = 0, by_level = 0;
        for (const auto& s : shares) by_layer += s.at(key).get<std::uint64_t>();
        for (const auto& l : info.at("levels")) by_level += l.at(key).get<std::uint64_t>();
        EXPECT_EQ(by_layer, by_level) << key;
    }
    EXPECT_GT(shares[0].at("refined"), 10);
    EXPECT_GT(shares[1].at("refined"), 100);
    EXPECT_EQ(shares[2].at("refined"), 0) << "the hills lie everywhere";
    const std::string text = carat("info two.carat").out;
    for (const char* word : {"layer at a diamond's centre", "patch.tif  ", "base height"})
        EXPECT_TRUE(contains(text, word)) << word;
}

TEST_F(Info, AFlatPlanetIsAllZero) {
    const auto info = carat("info --json flat.carat").json();
    EXPECT_GT(info.at("refined_diamonds"), 0);
    EXPECT_EQ(info.at("zero_diamonds"), info.at("refined_diamonds"));
    EXPECT_EQ(info.at("bytes").at("residuals"), 0);
}

TEST_F(Info, BitsASampleAreThoseOfTheWholeFile) {
    const auto info = carat("info --json hills.carat").json();
    EXPECT_EQ(info.at("source_samples"), 1024 * 512);
    EXPECT_DOUBLE_EQ(info.at("bits_per_source_sample").get<double>(),
                     8.0 * static_cast<double>(fs::file_size(path("hills.carat"))) / (1024 * 512));
}

TEST_F(Info, HeaderOnlyReadsNoPages) {
    const auto info = carat("info --json --header hills.carat").json();
    EXPECT_FALSE(info.contains("levels"));
    EXPECT_EQ(info.at("tolerance_m"), 2);
}

TEST_F(Info, AnUnstatedDatumIsSaidPlainly) {
    EXPECT_TRUE(contains(carat("info hills.carat").out, "vertical datum   unstated: nobody said"));
    EXPECT_TRUE(contains(carat("info flat.carat").out, "vertical datum   ellipsoid\n"));
}

TEST_F(Info, TextShowsWhatJsonShows) {
    const std::string text = carat("info hills.carat").out;
    for (const char* word : {"tolerance", "quantum", "coder", "range", "level", "residual bytes",
                             "provenance", "hills.tif", "earth", "bits a source sample"})
        EXPECT_TRUE(contains(text, word)) << word;
}

}  // namespace
}  // namespace carat::test
