// The subcommands of `carat`: one function and one file each.
//
// add_x(app, globals) declares the subcommand, its options and its help, and sets what it does with on_run().
// Pattern:
//
//   void add_x(CLI::App& app, Globals& globals) {
//       struct Options { ... };
//       const auto o = std::make_shared<Options>();
//       CLI::App& sub = *app.add_subcommand("x", "What it does");
//       sub.add_option("-o,--output", o->output, "...")->required();
//       on_run(sub, globals, [o, &globals] { return run(*o, globals); });
//   }
//
// The action runs after the whole command line has been parsed, and returns the exit code. It reports failure
// by throwing carat::Error: main() prints "carat: error (corrupt): message" and returns 2 for usage, 1 for
// all others.
#pragma once

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <functional>

namespace carat::cli {

enum ExitCode : int { kSuccess = 0, kFailure = 1, kUsage = 2, kNoCertificate = 3, kInterrupted = 130 };

// Options of every subcommand, and the action of the one that was named.
struct Globals {
    bool quiet = false;    // -q: no progress, no summary, no warnings; results and errors remain
    bool verbose = false;  // -v: more numbers, on stderr
    std::function<int()> action;
};

// Adds -q and -v and sets the action of a subcommand.
void on_run(CLI::App& subcommand, Globals& globals, std::function<int()> action);

void add_synth(CLI::App& app, Globals& globals);
void add_build(CLI::App& app, Globals& globals);
void add_update(CLI::App& app, Globals& globals);
void add_info(CLI::App& app, Globals& globals);
void add_verify(CLI::App& app, Globals& globals);
void add_query(CLI::App& app, Globals& globals);
void add_render(CLI::App& app, Globals& globals);
void add_fly(CLI::App& app, Globals& globals);
void add_bench(CLI::App& app, Globals& globals);

}  // namespace carat::cli
