// carat update: what it prints, where it looks for sources, and how it fails.
#include "program.hpp"
#include "rasters.hpp"

namespace carat::test {
namespace {

class UpdateProgram : public Program {
  protected:
    void SetUp() override {
        Program::SetUp();
        write_raster(path("hills.tif"), hills());
        write_raster(path("patch.tif"), {100, 100, {10, 10, 14, 14}, [](double lat, double lon) {
                                             return 400 + 300 * std::sin(9 * lat) * std::cos(7 * lon);
                                         }});
        ASSERT_EQ(carat("build -q --no-measure --layer hills.tif --tolerance 2 -o a.carat").exit, 0);
        ASSERT_EQ(carat("build -q --no-measure --layer patch.tif --feather 0 --layer hills.tif --tolerance 2 "
                        "-o b.carat")
                      .exit,
                  0);
    }
};

TEST_F(UpdateProgram, TheBytesOfAFullBuildAndTheSizeOfTheClosure) {
    const Outcome text = carat("update a.carat --layer patch.tif --feather 0 -o c.carat");
    ASSERT_EQ(text.exit, 0) << text.err;
    EXPECT_TRUE(contents(path("c.carat")) == contents(path("b.carat")));
    for (const char* part : {"closure  ", "coded anew", "copied", "c.carat: ", "time "})
        EXPECT_TRUE(contains(text.out, part)) << part << '\n' << text.out;
    const auto json = carat("update a.carat --layer patch.tif --feather 0 --json").json();
    EXPECT_TRUE(contents(path("a.carat")) == contents(path("b.carat"))) << "in place";
    EXPECT_FALSE(json.at("built_anew"));
    EXPECT_GT(json.at("closure_diamonds"), 0);
    EXPECT_LT(json.at("closure_diamonds"), json.at("refined_diamonds"));
    EXPECT_EQ(json.at("copied_diamonds").get<int>() + json.at("changed_diamonds").get<int>(),
              json.at("refined_diamonds"));
    EXPECT_EQ(json.at("file_bytes"), fs::file_size(path("a.carat")));
    EXPECT_EQ(carat("verify a.carat").exit, 0);
}

TEST_F(UpdateProgram, SourcesAreLookedForAndCompared) {
    fs::create_directory(path("dem"));
    fs::rename(path("hills.tif"), path("dem/hills.tif"));
    const std::string before = contents(path("a.carat"));
    const Outcome missing = carat("update a.carat --layer patch.tif");
    EXPECT_EQ(missing.exit, 2);
    EXPECT_TRUE(contains(missing.err, "its source hills.tif is missing")) << missing.err;
    EXPECT_EQ(carat("update a.carat --layer patch.tif --sources dem -o c.carat").exit, 0);
    write_raster(path("dem/hills.tif"), flat(3));
    const Outcome changed = carat("update a.carat --layer patch.tif --sources dem");
    EXPECT_EQ(changed.exit, 2);
    EXPECT_TRUE(contains(changed.err, "hills.tif: has changed since a.carat was built")) << changed.err;
    EXPECT_TRUE(contents(path("a.carat")) == before);
    EXPECT_FALSE(fs::exists(path("a.carat.partial")));
}

TEST_F(UpdateProgram, WrongUsageIsExitCode2) {
    for (const char* rest : {"--layer patch.tif --at 3", "--layer patch.tif --layer patch.tif",
                             "--layer patch.tif -o b.carat", ""})
        EXPECT_EQ(carat(std::string("update a.carat ") + rest).exit, 2) << rest;
}

}  // namespace
}  // namespace carat::test
