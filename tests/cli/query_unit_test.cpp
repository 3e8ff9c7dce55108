// carat query: CSV in, CSV out.
#include <algorithm>
#include <random>

#include "program.hpp"
#include "rasters.hpp"

namespace carat::test {
namespace {

constexpr const char* kHeading = "lat,lon,height_m,spacing_m,bound_m,measured\n";

std::vector<std::string> split(const std::string& text, char separator) {
    std::vector<std::string> out;
    std::istringstream in(text);
    for (std::string part; std::getline(in, part, separator);) out.push_back(part);
    return out;
}

class Query : public Program {
  protected:
    void SetUp() override {
        Program::SetUp();
        // A plane in latitude: bilinear interpolation and S agree with it but for curvature and tolerance.
        write_raster(path("tilted.tif"),
                     {720, 360, {-180, -90, 180, 90}, [](double lat, double) { return 100 * lat; }});
        ASSERT_EQ(carat("build -q --layer tilted.tif --tolerance 0.5 -o a.carat").exit, 0);
    }
};

TEST_F(Query, OnePlaceFromArguments) {
    const Outcome r = carat("query a.carat -33.5 -70.25");
    ASSERT_EQ(r.exit, 0) << r.err;
    ASSERT_EQ(r.out.rfind(kHeading, 0), 0u) << r.out;
    const auto row = split(split(r.out, '\n').at(1), ',');
    ASSERT_EQ(row.size(), 6u);
    EXPECT_EQ(row[0], "-33.5");
    EXPECT_EQ(row[1], "-70.25");
    EXPECT_NEAR(std::stod(row[2]), -3350, 2);
    EXPECT_EQ(row[5], "measured");
}

TEST_F(Query, NegativePlacesAreNotOptions) {
    EXPECT_TRUE(contains(carat("query --no-header a.carat -.5 -.25").out, "-0.5,-0.25,-"));
    EXPECT_TRUE(contains(carat("query --no-header a.carat -1e1 -7").out, "-1e1,-7,-1000") ||
                contains(carat("query --no-header a.carat -1e1 -7").out, "-1e1,-7,-999"));
}

TEST_F(Query, BoundIsTheToleranceAtASampleAndEmptyElsewhere) {
    // The middle of a face is a sample; a place with no short binary fraction is none.
    EXPECT_EQ(split(split(carat("query a.carat 0 0").out, '\n').at(1), ',').at(4), "0.5");
    EXPECT_EQ(split(split(carat("query a.carat 12.345 67.891").out, '\n').at(1), ',').at(4), "");
    EXPECT_TRUE(
        carat("query --json a.carat 12.345 67.891").json().at("points").at(0).at("bound_m").is_null());
}

TEST_F(Query, LinesComeBackInOrderAndVerbatim) {
    std::mt19937 random(7);
    std::string input;
    for (int k = 0; k < 3000; ++k)
        input += std::to_string(std::uniform_real_distribution(-90.0, 90.0)(random)) + "," +
                 std::to_string(std::uniform_real_distribution(-180.0, 360.0)(random)) + "\n";
    const Outcome r = carat("query --no-header a.carat --points -", input);
    ASSERT_EQ(r.exit, 0) << r.err;
    const auto in = split(input, '\n'), out = split(r.out, '\n');
    ASSERT_EQ(out.size(), in.size());
    for (std::size_t k = 0; k < in.size(); ++k) {
        ASSERT_EQ(out[k].rfind(in[k] + ",", 0), 0u) << "line " << k + 1;
        const auto row = split(out[k], ',');
        EXPECT_NEAR(std::stod(row[2]), 100 * std::stod(row[0]), 60)
            << out[k];  // at poles the raster ends at 89.75
    }
}

TEST_F(Query, APieceOfManyLinesIsLikeManyPieces) {
    std::string input;
    for (int k = 0; k < 530000; ++k) input += std::to_string(k % 90) + "," + std::to_string(k % 180) + "\n";
    const Outcome r = carat("query --no-header a.carat --points -", input);
    const auto out = split(r.out, '\n');
    ASSERT_EQ(out.size(), 530000u);
    for (std::size_t k = 0; k + 180 < out.size(); k += 997) EXPECT_EQ(out[k], out[k + 180]);
}

TEST_F(Query, PointsFromAFileSkipBlanksAndComments) {
    std::ofstream(path("points.csv")) << "lat,lon\n\n# home\n 1.5 , 2.5 \r\n-1.5,-2.5";
    const Outcome r = carat("query a.carat --points points.csv");
    ASSERT_EQ(r.exit, 0) << r.err;
    const auto lines = split(r.out, '\n');
    ASSERT_EQ(lines.size(), 3u);
    EXPECT_EQ(lines[1].rfind("1.5,2.5,", 0), 0u);
    EXPECT_EQ(lines[2].rfind("-1.5,-2.5,", 0), 0u);
}

TEST_F(Query, AMalformedLineIsNamed) {
    for (const char* bad : {"1", "1,2,3", "a,b", "91,0", "1,", "nan,1", "1,2x"}) {
        const Outcome r = carat("query a.carat --points -", std::string("1,2\n3,4\n") + bad + "\n5,6\n");
        EXPECT_EQ(r.exit, 2) << bad;
        EXPECT_TRUE(contains(r.err, "stdin: line 3: ")) << bad << ": " << r.err;
    }
}

TEST_F(Query, JsonHasPointsAndASummary) {
    const auto json = carat("query --json a.carat --points -", "0.5,1.5\n10,20\n").json();
    ASSERT_EQ(json.at("points").size(), 2u);
    EXPECT_EQ(json.at("points").at(1).at("lat"), 10);
    EXPECT_NEAR(json.at("points").at(1).at("height_m").get<double>(), 1000, 2);
    EXPECT_GT(json.at("points").at(1).at("spacing_m"), 0);
    EXPECT_EQ(json.at("summary").at("count"), 2);
    EXPECT_GT(json.at("summary").at("queries_per_second"), 0);
    EXPECT_EQ(carat("query --json a.carat --points -", "").json().at("points").size(), 0u);
}

TEST_F(Query, APlaceAndPointsExcludeEachOther) {
    EXPECT_EQ(carat("query a.carat 1 2 --points -").exit, 2);
    EXPECT_EQ(carat("query a.carat").exit, 2);
}

TEST_F(Query, PolesAndTheAntimeridianAreOrdinaryPlaces) {
    const auto height = [&](const std::string& place) {
        return carat("query --json a.carat " + place).json().at("points").at(0).at("height_m").get<double>();
    };
    EXPECT_EQ(height("45 180"), height("45 -180"));
    EXPECT_EQ(height("90 0"), height("90 77"));
    EXPECT_NEAR(height("-90 0"), -8975, 1);  // the southernmost samples, at 89.75
}

}  // namespace
}  // namespace carat::test
