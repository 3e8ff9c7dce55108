// Help, versions, exit codes and messages that all subcommands share.
#include "program.hpp"

namespace carat::test {
namespace {

const std::vector<std::string> kCommands{"synth",  "build", "update", "info",
                                         "verify", "query", "render", "fly"};

using CommandLine = Program;

TEST_F(CommandLine, WithoutArgumentsItPrintsHelp) {
    const Outcome r = carat("");
    EXPECT_EQ(r.exit, 0);
    EXPECT_EQ(r.out, carat("--help").out);
    for (const std::string& command : kCommands)
        EXPECT_TRUE(contains(r.out, "  " + command + " ")) << command;
}

TEST_F(CommandLine, EverySubcommandHasHelpWithExamples) {
    for (const std::string& command : kCommands) {
        const Outcome r = carat(command + " --help");
        EXPECT_EQ(r.exit, 0) << command;
        EXPECT_TRUE(contains(r.out, "Usage:")) << command;
        EXPECT_TRUE(contains(r.out, "Examples:\n  carat " + command + " ")) << command;
        EXPECT_EQ(r.err, "") << command;
    }
}

TEST_F(CommandLine, VersionIsThatOfTheProject) {
    const Outcome r = carat("--version");
    EXPECT_EQ(r.exit, 0);
    EXPECT_EQ(r.out, "carat " CARAT_VERSION "\n");
}

TEST_F(CommandLine, WrongUsageIsExitCode2) {
    for (const char* wrong :
         {"fly-me", "info", "info a.carat b.carat", "info --jsn a.carat", "build -o a.carat",
          "render a.carat -o a.png", "render a.carat --eye 1,2 -o a.png",
          "render a.carat --eye 1,2,x -o a.png", "render a.carat --eye 1,2,3 --size 12 -o a.png",
          "query a.carat --memory 12Q 1 2", "query a.carat 1"}) {
        const Outcome r = carat(wrong);
        EXPECT_EQ(r.exit, 2) << wrong;
        EXPECT_TRUE(contains(r.err, "carat: error (usage): ")) << wrong << ": " << r.err;
        EXPECT_EQ(r.out, "") << wrong;
    }
}

TEST_F(CommandLine, AMessageAboutAValueNamesTheOption) {
    EXPECT_TRUE(contains(carat("render a.carat --eye 1,2,3 --size 12 -o a.png").err, "--size"));
    EXPECT_TRUE(contains(carat("render a.carat --eye 1,2 -o a.png").err, "--eye"));
}

TEST_F(CommandLine, AMissingFileIsExitCode1AndNamed) {
    for (const char* command :
         {"info none.carat", "verify none.carat", "query none.carat 1 2",
          "render none.carat --eye 1,2,3 -o a.png", "build --layer none.tif --tolerance 1 -o a.carat"}) {
        const Outcome r = carat(command);
        EXPECT_EQ(r.exit, 1) << command;
        EXPECT_TRUE(contains(r.err, "carat: error (io): ")) << command << ": " << r.err;
        EXPECT_TRUE(contains(r.err, "none.")) << command << ": " << r.err;
    }
}

TEST_F(CommandLine, AFileOfAnotherKindIsRefused) {
    std::ofstream(path("a.carat")) << std::string(4096, 'x');
    for (const char* command : {"info a.carat", "query a.carat 1 2"}) {
        const Outcome r = carat(command);
        EXPECT_EQ(r.exit, 1) << command;
        EXPECT_TRUE(contains(r.err, "carat: error (corrupt): a.carat")) << command << ": " << r.err;
    }
}

}  // namespace
}  // namespace carat::test
