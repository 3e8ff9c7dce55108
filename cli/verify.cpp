// carat verify: is a file sound, and how far is it from its sources?
#include "carat/codec/verify.hpp"

#include <fmt/core.h>
#include <spdlog/spdlog.h>

#include <chrono>
#include <memory>
#include <nlohmann/json.hpp>

#include "against.hpp"
#include "carat/globe/error.hpp"
#include "carat/preprocess/measure.hpp"
#include "colour_files.hpp"
#include "commands.hpp"
#include "error_report.hpp"
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
    LayerArguments against{"--against"};
};

// What the comparison with the sources found.
struct Comparison {
    ErrorSummary errors;
    std::vector<std::string> remarks;
    std::optional<double> certificate;  // metres, as the file says
    double seconds = 0;

    bool holds() const { return !certificate || errors.all.max <= *certificate; }
};

constexpr const char* kFooter = R"(
Reads and decodes the whole file and checks that
  - every checksum fits and every page parses;
  - both parents of every refined diamond are refined, and the header's counts are true;
  - every diamond decodes, and the heights that two parents give to a common edge are equal;
  - all heights lie within the summaries (least and greatest height) of every half that contains them.

Prints "ok", or one line for each damage. Exit status: 0 sound, 1 damaged, unreadable, or a certificate that the sources
refute, 2 wrong usage.

--against compares the surface with the sources at every sample of theirs that alone gives the height at its place, and
prints the errors by layer and where they are greatest; samples in feathered zones are compared with what the layers blend
to. Name the layers as for `carat build`, with their options where they differ from those that the file records; or name
the one folder where the recorded sources lie. The tolerance bounds the error at the file's own samples; what lies in
between contains the cost of resampling as well.

Examples:
  carat verify earth.carat
  carat verify earth.carat --against rasters/
  carat verify earth.carat --against alps.tif --against world.tif
  carat verify --json earth.carat | jq .ok)";

void print_promise(const RepositoryHeader& h) {
    fmt::print("guaranteed at the file's own samples: {} m\n", number(h.tolerance));
    if (h.rms_tolerance > 0) fmt::print("guaranteed root mean square there: {} m\n", number(h.rms_tolerance));
}

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
    if (r.zero_skipped > 0)
        fmt::print("{} diamonds without residuals were not decoded: of each page of such, {} were\n",
                   grouped(r.zero_skipped), grouped(VerifyOptions{}.zero_page_limit));
    print_promise(Repository::open(o.file)->header());
}

void print_text(const VerifyReport& r, const Comparison& c) {
    for (const std::string& remark : c.remarks) fmt::print("remark: {}\n", remark);
    print_errors(c.errors, 5);
    if (c.certificate)
        fmt::print("certificate: every compared source sample within {} m: {}\n", number(*c.certificate),
                   c.holds() ? "confirmed" : "FALSE");
    const double rate = static_cast<double>(c.errors.all.count) / std::max(c.seconds, 1e-9);
    fmt::print("compared in {}, {} samples/s{}\n", duration(c.seconds),
               grouped(static_cast<std::uint64_t>(rate)), r.ok() ? "" : "; the file is damaged");
}

void print_json(const Options& o, const VerifyReport& r, const std::optional<Comparison>& c) {
    Json json = {{"file", o.file},
                 {"ok", r.ok()},
                 {"damage", r.damage},
                 {"damage_count", r.damage_count},
                 {"remarks", r.remarks},
                 {"file_bytes", r.census.file_bytes},
                 {"pages", r.census.pages},
                 {"diamonds", r.census.refined},
                 {"decoded", r.decoded},
                 {"unreachable", r.unreachable},
                 {"zero_not_decoded", r.zero_skipped},
                 {"heights_checked", r.heights},
                 {"shared_heights_checked", r.shared_heights},
                 {"seconds", r.seconds}};
    if (r.ok()) {
        const RepositoryHeader h = Repository::open(o.file)->header();
        json["guaranteed_at_lattice_m"] = h.tolerance;
        json["guaranteed_rms_at_lattice_m"] = h.rms_tolerance > 0 ? Json(h.rms_tolerance) : Json(nullptr);
    }
    if (c) {
        json["source_errors"] = errors_json(c->errors);
        if (c->certificate) json["certificate"] = {{"bound_m", *c->certificate}, {"confirmed", c->holds()}};
        json["source_remarks"] = c->remarks;
        json["source_seconds"] = c->seconds;
    }
    fmt::print("{}\n", json.dump(2));
}

Provenance recorded_in(const Repository& file) {
    try {
        return parse_provenance(file.header().provenance);
    } catch (const Error&) {
        return {};  // made by another program: everything must be given
    }
}

Comparison compare(const Options& o, Progress& progress) {
    const auto begin = std::chrono::steady_clock::now();
    const auto file = Repository::open(o.file);
    const Provenance recorded = recorded_in(*file);
    const SourceStack sources(layers_against(o.against, recorded), file->header().ellipsoid(),
                              recorded.base_height, o.verify.memory_bytes);
    for (const std::string& warning : sources.warnings()) spdlog::warn("{}", warning);
    MeasureOptions options;
    options.threads = o.verify.threads;
    options.memory_bytes = o.verify.memory_bytes;
    options.progress = [&](std::uint64_t done, std::uint64_t total) {
        return progress.update("comparing", done, total);
    };
    Comparison out;
    out.errors = measure_errors(sources, file, options);
    out.certificate = recorded.certificate;
    out.remarks = differences(sources, recorded);
    out.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    return out;
}

VerifyReport verify(const Options& o, Progress& progress) {
    VerifyOptions options = o.verify;
    options.progress = [&](std::uint64_t done, std::uint64_t total) {
        return progress.update("verifying", done, total);
    };
    return verify_file(o.file, options);
}

int run(const Options& o, bool against, const Globals& globals) {
    catch_interrupts();
    if (is_colour_file(o.file)) {
        if (against) throw Error(ErrorCode::usage, o.file + ": --against is for relief");
        return verify_colour(o.file, o.verify, o.json) ? kSuccess : kFailure;
    }
    Progress diamonds("diamonds", globals.quiet);
    const VerifyReport report = verify(o, diamonds);
    diamonds.finish();
    std::optional<Comparison> comparison;
    if (against && report.ok()) {
        Progress samples("samples", globals.quiet);
        comparison = compare(o, samples);
        samples.finish();
    }
    if (o.json)
        print_json(o, report, comparison);
    else
        print_text(o, report);
    if (!o.json && comparison) print_text(report, *comparison);
    return report.ok() && (!comparison || comparison->holds()) ? kSuccess : kFailure;
}

}  // namespace

void add_verify(CLI::App& app, Globals& globals) {
    const auto o = std::make_shared<Options>();
    CLI::App& sub = *app.add_subcommand(
        "verify", "Check that a .carat file is sound, and measure its error against the sources");
    sub.footer(kFooter);
    sub.add_option("FILE", o->file, "A .carat file")->required()->type_name(" ");
    sub.add_flag("--json", o->json, "Print JSON");
    sub.add_option("--threads", o->verify.threads, "Threads (default: all)")
        ->type_name("N")
        ->check(between(1, 256));
    add_value(sub, "--memory", "SIZE", "For decoded diamonds (default 256M)",
              [o](const std::string& text) { o->verify.memory_bytes = parse_size(text); });
    const char* group = "Comparing with the sources (options after an --against apply to it)";
    const CLI::Option* against =
        o->against.add_lead(sub, "A layer of sources, as for build; or one folder", group);
    o->against.add_options(sub, group);
    on_run(sub, globals, [o, against, &globals] { return run(*o, against->count() > 0, globals); });
}

}  // namespace carat::cli
