// The program `carat`: parses the command line, runs one subcommand, turns errors into messages and exit
// codes.
#include <fmt/core.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <exception>
#include <string>
#include <vector>

#include "carat/globe/error.hpp"
#include "commands.hpp"
#include "interrupt.hpp"

namespace carat::cli {
namespace {

constexpr const char* kDescription =
    "carat compresses the relief of a whole planet into one small file with a guaranteed maximum error, and "
    "draws "
    "it.\n";

constexpr const char* kFooter = R"(
Examples:
  carat synth earth -o planet                                    a planet from formulas, to try the rest on
  carat build --layer alps.tif --layer world.tif --tolerance 1 -o earth.carat
  carat info earth.carat
  carat verify earth.carat
  carat query earth.carat 46.5475 7.9854
  carat render earth.carat --eye 46.60,7.95,4500 --heading 150 --pitch -12 --size 1920x1080 --error 1 -o alps.png

`carat COMMAND --help` describes a command.

Exit status:
  0    full success
  1    failure: a message on stderr names the file and the cause
  2    wrong usage
  3    build --certify: the file is written, but its depth does not suffice for the certificate
  130  interrupted)";

// Errors and warnings go to stderr, "carat: warning: ...", never into results on stdout.
void set_up_log(const Globals& globals) {
    auto logger = spdlog::stderr_color_mt("carat");
    logger->set_pattern("%n: %^%l%$: %v");
    logger->set_level(globals.quiet     ? spdlog::level::err
                      : globals.verbose ? spdlog::level::info
                                        : spdlog::level::warn);
    spdlog::set_default_logger(std::move(logger));
}

int report(const std::string& kind, const std::string& message, int exit_code) {
    fmt::print(stderr, "carat: error ({}): {}\n", kind, message);
    return exit_code;
}

int run(const Globals& globals) {
    try {
        set_up_log(globals);
        return globals.action();
    } catch (const Error& error) {
        if (interrupted()) return report("interrupted", error.what(), kInterrupted);
        return report(to_string(error.code()), error.what(),
                      error.code() == ErrorCode::usage ? kUsage : kFailure);
    } catch (const std::bad_alloc&) {
        return report(to_string(ErrorCode::limit), "out of memory", kFailure);
    } catch (const std::exception& error) {
        return report("internal", error.what(), kFailure);
    }
}

// What the user typed, last first, as CLI11 takes it; "-.5" becomes "-0.5", which it knows for a number.
std::vector<std::string> arguments(int argc, char** argv) {
    std::vector<std::string> out;
    for (int k = argc - 1; k > 0; --k) {
        std::string text = argv[k];
        if (text.size() > 2 && text[0] == '-' && text[1] == '.') text.insert(1, 1, '0');
        out.push_back(std::move(text));
    }
    return out;
}

int main(int argc, char** argv) {
    CLI::App app(kDescription, "carat");
    app.footer(kFooter);
    app.set_version_flag("--version", "carat " CARAT_VERSION);
    app.require_subcommand(0, 1);
    app.get_formatter()->column_width(34);
    Globals globals;
    for (const auto add :
         {add_synth, add_build, add_update, add_info, add_verify, add_query, add_render, add_fly, add_bench})
        add(app, globals);

    try {
        app.parse(arguments(argc, argv));
    } catch (const CLI::ParseError& error) {
        if (error.get_exit_code() == 0) return app.exit(error);  // --help, --version
        return report(to_string(ErrorCode::usage), error.what(), kUsage);
    }
    if (!globals.action) {
        fmt::print("{}", app.help());
        return kSuccess;
    }
    return run(globals);
}

}  // namespace

void on_run(CLI::App& subcommand, Globals& globals, std::function<int()> action) {
    subcommand.add_flag("-q,--quiet", globals.quiet, "No progress, no warnings; results and errors only");
    subcommand.add_flag("-v,--verbose", globals.verbose, "More numbers, on stderr");
    subcommand.callback([&globals, action = std::move(action)] { globals.action = action; });
}

}  // namespace carat::cli

int main(int argc, char** argv) { return carat::cli::main(argc, argv); }
