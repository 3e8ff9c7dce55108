// carat verify: is a file sound?
#include "carat/codec/verify.hpp"

#include <fmt/core.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "commands.hpp"
#include "interrupt.hpp"
#include "progress.hpp"
#include "text.hpp"
#include "values.hpp"

namespace carat::cli {
namespace {

using Json = nlohmann::ordered_json;

struct Options {
    std::string file;
    bool json = false;
    VerifyOptions verify;
};

constexpr const char* kFooter = R"(
Reads and decodes the whole file and checks that
  - every checksum fits and every page parses;
  - both parents of every refined diamond are refined, and the header's counts are true;
  - every diamond decodes, and the heights that two parents give to a common edge are equal;
  - all heights lie within the summaries (least and greatest height) of every half that contains them.

Prints "ok", or one line for each damage. Exit status: 0 sound, 1 damaged or unreadable, 2 wrong usage.

Examples:
  carat verify earth.carat
  carat verify --json earth.carat | jq .ok)";

void print_text(const Options& o, const VerifyReport& r) {
    for (const std::string& remark : r.remarks) fmt::print("remark: {}\n", remark);
    for (const std::string& damage : r.damage) fmt::print("{}\n", damage);
    if (r.damage_count > r.damage.size())
        fmt::print("and {} more\n", grouped(r.damage_count - r.damage.size()));
    if (!r.ok()) {
        fmt::print("{}: damaged: {} findings, {} diamonds could not be decoded\n", o.file,
                   grouped(r.damage_count), grouped(r.unreachable));
        return;
    }
    fmt::print(
        "{}: ok: {} bytes, {} pages, {} diamonds decoded, {} heights within their summaries, {} shared "
        "heights "
        "equal ({})\n",
        o.file, grouped(r.census.file_bytes), grouped(r.census.pages), grouped(r.decoded), grouped(r.heights),
        grouped(r.shared_heights), duration(r.seconds));
}

void print_json(const Options& o, const VerifyReport& r) {
    const Json json = {{"file", o.file},
                       {"ok", r.ok()},
                       {"damage", r.damage},
                       {"damage_count", r.damage_count},
                       {"remarks", r.remarks},
                       {"file_bytes", r.census.file_bytes},
                       {"pages", r.census.pages},
                       {"diamonds", r.census.refined},
                       {"decoded", r.decoded},
                       {"unreachable", r.unreachable},
                       {"heights_checked", r.heights},
                       {"shared_heights_checked", r.shared_heights},
                       {"seconds", r.seconds}};
    fmt::print("{}\n", json.dump(2));
}

int run(const Options& o, const Globals& globals) {
    catch_interrupts();
    Progress progress("diamonds", globals.quiet);
    VerifyOptions options = o.verify;
    options.progress = [&](std::uint64_t done, std::uint64_t total) {
        return progress.update("verifying", done, total);
    };
    const VerifyReport report = verify_file(o.file, options);
    progress.finish();
    if (o.json)
        print_json(o, report);
    else
        print_text(o, report);
    return report.ok() ? kSuccess : kFailure;
}

}  // namespace

void add_verify(CLI::App& app, Globals& globals) {
    const auto o = std::make_shared<Options>();
    CLI::App& sub = *app.add_subcommand("verify", "Check that a .carat file is sound");
    sub.footer(kFooter);
    sub.add_option("FILE", o->file, "A .carat file")->required()->type_name(" ");
    sub.add_flag("--json", o->json, "Print JSON");
    sub.add_option("--threads", o->verify.threads, "Threads (default: all)")
        ->type_name("N")
        ->check(between(1, 256));
    add_value(sub, "--memory", "SIZE", "For decoded diamonds (default 256M)",
              [o](const std::string& text) { o->verify.memory_bytes = parse_size(text); });
    on_run(sub, globals, [o, &globals] { return run(*o, globals); });
}

}  // namespace carat::cli
