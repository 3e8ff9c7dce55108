// carat bench refine, deadline and scaling: the runtime without a GPU.
#include <fmt/core.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "bench.hpp"
#include "carat/bench/deadline.hpp"
#include "carat/bench/throughput.hpp"
#include "carat/globe/error.hpp"
#include "interrupt.hpp"
#include "progress.hpp"
#include "text.hpp"
#include "values.hpp"

namespace carat::cli {
namespace {

using Json = nlohmann::ordered_json;

struct RefineOptions {
    std::string file, csv;
    bool json = false;
    bench::ThroughputOptions bench;
};

int run_refine(const RefineOptions& o) {
    const bench::Throughput t = bench::measure_throughput(Repository::open(o.file), o.bench);
    const double copied = t.copy_bytes_per_second / 1e9;
    std::string csv =
        "threads,diamonds_per_s,samples_per_s,samples_per_core_s,vertices_per_s,GB_per_core_s,copy_GB_per_"
        "s\n";
    Json rows = Json::array();
    if (!o.json) {
        fmt::print(
            "{} diamonds a round, {:.0f} bytes of heights and vertices each; memory copy {:.1f} GB/s a "
            "core\n",
            t.diamonds, t.bytes_a_diamond, copied);
        fmt::print("{:>7} {:>11} {:>9} {:>14} {:>12} {:>10} {:>8} {:>7}\n", "threads", "diamonds/s", "MS/s",
                   "MS/s per core", "Mvertices/s", "GB/s core", "decode", "build");
    }
    for (const bench::ThroughputRow& r : t.rows) {
        const double a_sample = t.bytes_a_diamond * r.diamonds_per_second / r.samples_per_second;
        const double bytes = r.samples_per_core_second * a_sample / 1e9;
        csv += fmt::format("{},{:.0f},{:.0f},{:.0f},{:.0f},{:.3f},{:.3f}\n", r.threads, r.diamonds_per_second,
                           r.samples_per_second, r.samples_per_core_second, r.vertices_per_second, bytes,
                           copied);
        if (o.json)
            rows.push_back({{"threads", r.threads},
                            {"diamonds_per_second", r.diamonds_per_second},
                            {"samples_per_second", r.samples_per_second},
                            {"samples_per_core_second", r.samples_per_core_second},
                            {"vertices_per_second", r.vertices_per_second},
                            {"decode_share", r.decode_share},
                            {"build_share", r.build_share}});
        else
            fmt::print("{:>7} {:>11.0f} {:>9.1f} {:>14.1f} {:>12.1f} {:>10.2f} {:>7.0f}% {:>6.0f}%\n",
                       r.threads, r.diamonds_per_second, r.samples_per_second / 1e6,
                       r.samples_per_core_second / 1e6, r.vertices_per_second / 1e6, bytes,
                       100 * r.decode_share, 100 * r.build_share);
    }
    if (o.json)
        fmt::print("{}\n", Json{{"diamonds", t.diamonds},
                                {"bytes_a_diamond", t.bytes_a_diamond},
                                {"copy_bytes_per_second", t.copy_bytes_per_second},
                                {"rows", rows}}
                               .dump(2));
    write_text(o.csv, csv);
    return kSuccess;
}

struct FlightOptions {
    std::vector<std::string> files;
    std::optional<Geodetic> place;
    std::array<int, 2> size{1280, 720};
    std::string csv;
    bool json = false;
    bench::DeadlineOptions bench;
};

void use(FlightOptions& o) {
    o.bench.width = o.size[0];
    o.bench.height = o.size[1];
}

std::size_t by_us(const bench::DeadlineRow& row) {
    return static_cast<std::size_t>(std::count_if(row.late_frames.begin(), row.late_frames.end(),
                                                  [](const bench::LateFrame& l) { return l.by_us; }));
}

void print_late_frames(const std::vector<bench::DeadlineRow>& rows) {
    const bool any = std::any_of(rows.begin(), rows.end(),
                                 [](const bench::DeadlineRow& r) { return !r.late_frames.empty(); });
    if (any)
        fmt::print("\n{:<17} {:>6} {:>6} {:>8} {:>9} {:>8} {:>9} {:>8} {:>6} {:>9} {:>7}\n", "late frames",
                   "budget", "frame", "over ms", "processor", "ready", "overslept", "gone", "sleeps",
                   "preempted", "faults");
    for (const bench::DeadlineRow& r : rows)
        for (const bench::LateFrame& l : r.late_frames)
            fmt::print(
                "{:<17} {:>6} {:>6} {:>8.2f} {:>9.2f} {:>8.2f} {:>9.2f} {:>8.2f} {:>6} {:>9} {:>7}{}\n",
                r.flight, r.budget_ms, l.frame, l.overrun_ms, l.processor_ms, l.ready_ms, l.overslept_ms,
                l.gone_ms, l.other_sleeps, l.preempted, l.faults, l.by_us ? "  by us" : "");
}

int run_deadline(FlightOptions o, const Globals& globals) {
    catch_interrupts();
    use(o);
    Progress progress("flights", globals.quiet);
    o.bench.progress = [&](const std::string& what, std::size_t done, std::size_t total) {
        return progress.update(what, done, total);
    };
    const auto open = [&] { return Repository::open(o.files.at(0)); };
    const auto flights = bench::shipped_flights(open(), o.place);
    const auto rows = bench::measure_deadlines(open, flights, o.bench);
    progress.finish();
    if (rows.size() < flights.size() * o.bench.budgets_ms.size()) return kInterrupted;
    std::string csv =
        "flight,budget_ms,frames,over_median_ms,over_p99_ms,over_p999_ms,over_worst_ms,late_frames,late_by_"
        "us,own_"
        "p999_ms,own_worst_ms,other_sleeps,late_p999_ms,late_worst_ms,wait_p999_ms,wait_worst_"
        "ms,"
        "within_share,converged_share,median_error_px,greatest_triangles,forced_coarse,decoded_a_frame,"
        "uploads_a_frame,pages,longest_over_s,jump_s\n";
    Json all = Json::array();
    if (!o.json)
        fmt::print(
            "{:<17} {:>6} {:>6} {:>32} {:>14} {:>16} {:>6} {:>16} {:>7} {:>9} {:>8} {:>8} {:>7} {:>7} "
            "{:>7}\n",
            "flight", "budget", "frames", "over: median/p99/p99.9/worst ms", "over 1 ms: us",
            "own: p99.9/worst", "sleeps", "plain wait p99.9", "within", "median px", "Mtri max", "decoded",
            "upload", "over s", "jump s");
    for (const bench::DeadlineRow& r : rows) {
        csv += fmt::format(
            "{},{},{},{:.4f},{:.4f},{:.4f},{:.4f},{},{},{:.4f},{:.4f},{},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f},"
            "{:.4f},{:.4f},{},{},{:.2f},{:.2f},{},{:.3f},{:.3f}\n",
            r.flight, r.budget_ms, r.frames, r.overrun.median, r.overrun.p99, r.overrun.p999, r.overrun.worst,
            r.late_frames.size(), by_us(r), r.own.p999, r.own.worst, r.other_sleeps, r.late.p999,
            r.late.worst, r.wait_overrun.p999, r.wait_overrun.worst, r.within_share, r.converged_share,
            r.median_error, r.greatest_triangles, r.forced_coarse, r.decoded, r.uploads, r.pages,
            r.longest_over_seconds, r.jump_seconds);
        if (o.json)
            all.push_back({{"flight", r.flight},
                           {"budget_ms", r.budget_ms},
                           {"frames", r.frames},
                           {"overrun_p999_ms", r.overrun.p999},
                           {"overrun_worst_ms", r.overrun.worst},
                           {"late_frames", r.late_frames.size()},
                           {"late_by_us", by_us(r)},
                           {"own_p999_ms", r.own.p999},
                           {"other_sleeps", r.other_sleeps},
                           {"late_p999_ms", r.late.p999},
                           {"wait_p999_ms", r.wait_overrun.p999},
                           {"within_share", r.within_share},
                           {"converged_share", r.converged_share},
                           {"pages", r.pages},
                           {"longest_over_seconds", r.longest_over_seconds},
                           {"jump_seconds", r.jump_seconds}});
        else
            fmt::print(
                "{:<17} {:>6} {:>6} {:>8.2f}{:>8.2f}{:>8.2f}{:>8.2f} {:>9} {:>4} {:>8.2f}{:>8.2f} "
                "{:>6} "
                "{:>16.2f} {:>6.0f}% {:>9.2f} {:>8.2f} {:>8.1f} {:>7.1f} {:>7.2f} {:>7.2f}\n",
                r.flight, r.budget_ms, r.frames, r.overrun.median, r.overrun.p99, r.overrun.p999,
                r.overrun.worst, r.late_frames.size(), by_us(r), r.own.p999, r.own.worst, r.other_sleeps,
                r.wait_overrun.p999, 100 * r.within_share, r.median_error,
                static_cast<double>(r.greatest_triangles) / 1e6, r.decoded, r.uploads, r.longest_over_seconds,
                r.jump_seconds);
    }
    if (o.json) fmt::print("{}\n", all.dump(2));
    if (!o.json) print_late_frames(rows);
    write_text(o.csv, csv);
    return kSuccess;
}

int run_scaling(FlightOptions o) {
    use(o);
    Json all = Json::array();
    std::string csv =
        "file,bytes,diamonds,frame_ms,selection_ms,work_ms,triangles,bytes_read,pages,decoded\n";
    if (!o.json)
        fmt::print("{:<24} {:>12} {:>10} {:>9} {:>10} {:>8} {:>10} {:>10} {:>7} {:>8}\n", "file", "bytes",
                   "diamonds", "frame ms", "select ms", "work ms", "triangles", "read", "pages", "decoded");
    for (const std::string& file : o.files) {
        const auto repository = Repository::open(file);
        const FlightPath flight = bench::flight_over(repository, "orbit-to-ground", o.place);
        const bench::ScalingRow r = bench::measure_flight(repository, flight, o.bench);
        csv += fmt::format("{},{},{},{:.4f},{:.4f},{:.4f},{:.0f},{:.0f},{:.3f},{:.3f}\n", file, r.file_bytes,
                           r.diamonds, r.frame_ms, r.selection_ms, r.work_ms, r.triangles, r.bytes_read,
                           r.pages, r.decoded);
        if (o.json)
            all.push_back({{"file", file},
                           {"bytes", r.file_bytes},
                           {"diamonds", r.diamonds},
                           {"frame_ms", r.frame_ms},
                           {"selection_ms", r.selection_ms},
                           {"work_ms", r.work_ms},
                           {"triangles", r.triangles},
                           {"bytes_read", r.bytes_read},
                           {"pages", r.pages},
                           {"decoded", r.decoded}});
        else
            fmt::print(
                "{:<24} {:>12} {:>10} {:>9.3f} {:>10.3f} {:>8.3f} {:>10.0f} {:>10.0f} {:>7.2f} {:>8.2f}\n",
                file, grouped(r.file_bytes), grouped(r.diamonds), r.frame_ms, r.selection_ms, r.work_ms,
                r.triangles, r.bytes_read, r.pages, r.decoded);
    }
    if (o.json) fmt::print("{}\n", all.dump(2));
    write_text(o.csv, csv);
    return kSuccess;
}

constexpr const char* kRefineFooter = R"(
Refines diamonds of the file over and over: residuals decoded, heights handed to the children, and the four child
patches built with positions and normals. A sample is a height that the parent's patch does not show. "Per core" counts
the processor time of the threads, so that other programs do not disturb; the memory copy moves as many bytes.

Example:
  carat bench refine california.carat --threads 1,2,4)";

constexpr const char* kDeadlineFooter = R"(
Flies the paths that come with Carat (see carat fly --help) with a budget of refinement a frame, and prints by
how much frames exceeded it, beside the same number of plain timed waits of that length in the same run: what the
machine itself is late by. A frame more than 1 ms over is listed with what the system did with its thread: the time
on a processor; the time it was ready while other threads had the processors; by how much it overslept, woken later
than it had asked to be; the time it was gone, nothing of these nor waiting for results; and how often it slept other
than for results, which would be for a lock or for memory. Gone without such a sleep, another guest of the host had the
processor. "own" is the overrun without what the machine took so; a frame is late by us if that, or what its processor
time says (late in the CSV), is above 1 ms. No GPU is used. Each row opens the file
anew. "over s" is the longest time in which every frame had a patch above the threshold, "jump s" that to the converged
picture at the flight's end, starting from the coarsest cut and an empty cache. On a busy machine run it as root
under chrt -R -f 1: that puts the frame's thread, and none of the workers, before other programs.

Examples:
  carat bench deadline california.carat --at 36.58,-118.29 --csv deadline.csv
  sudo chrt -R -f 1 carat bench deadline california.carat)";

constexpr const char* kScalingFooter = R"(
Flies from orbit to the ground at --at over each file, every frame converged to --error, and prints the cost of a frame.

Example:
  carat bench scaling planet.carat planet8.carat planet64.carat)";

void add_flight_options(CLI::App& sub, const std::shared_ptr<FlightOptions>& o) {
    add_place(sub, "Where the flights lead (default 36.58,-118.29)",
              [o](const Geodetic& at) { o->place = at; });
    add_value(sub, "--size", "WxH", "Pixels (default 1280x720)",
              [o](const std::string& text) { o->size = parse_picture_size(text); });
    sub.add_option("--error", o->bench.goal.threshold, "Greatest error on the screen, pixels (default 1)")
        ->check(CLI::PositiveNumber);
    sub.add_option("--frames", o->bench.frames, "Of each flight (default 1000)")
        ->check(between(2, 1'000'000));
    sub.add_option("--threads", o->bench.refiner.threads, "Workers (default: one for each core)")
        ->check(between(1, 1024));
    sub.add_option("--csv", o->csv, "Also write the table here");
}

}  // namespace

void add_bench_refine(CLI::App& app, Globals& globals) {
    const auto o = std::make_shared<RefineOptions>();
    CLI::App& sub =
        *app.add_subcommand("refine", "Diamonds decoded and built a second, against a memory copy");
    sub.footer(kRefineFooter);
    sub.add_option("FILE", o->file, "A .carat file")->required();
    sub.add_option("--threads", o->bench.threads, "Numbers of threads (default 1,2)")->delimiter(',');
    sub.add_option("--diamonds", o->bench.diamonds, "A round (default 1500)")->check(between(1, 1'000'000));
    sub.add_option("--rounds", o->bench.rounds, "The best of so many counts (default 5)")
        ->check(between(1, 100'000));
    sub.add_flag("--json", o->json, "Print JSON");
    sub.add_option("--csv", o->csv, "Also write the table here");
    on_run(sub, globals, [o] { return run_refine(*o); });
}

void add_bench_deadline(CLI::App& app, Globals& globals) {
    const auto o = std::make_shared<FlightOptions>();
    CLI::App& sub =
        *app.add_subcommand("deadline", "Frames against their budget, and convergence after a jump");
    sub.footer(kDeadlineFooter);
    o->files.resize(1);
    sub.add_option("FILE", o->files[0], "A .carat file")->required();
    sub.add_option("--budget", o->bench.budgets_ms, "Milliseconds a frame (default 4,8,16)")->delimiter(',');
    add_flight_options(sub, o);
    sub.add_flag("--json", o->json, "Print JSON");
    on_run(sub, globals, [o, &globals] { return run_deadline(*o, globals); });
}

void add_bench_scaling(CLI::App& app, Globals& globals) {
    const auto o = std::make_shared<FlightOptions>();
    CLI::App& sub = *app.add_subcommand("scaling", "The cost of a frame against the size of the file");
    sub.footer(kScalingFooter);
    sub.add_option("FILE", o->files, "Files to compare")->required();
    add_flight_options(sub, o);
    sub.add_flag("--json", o->json, "Print JSON");
    on_run(sub, globals, [o] { return run_scaling(*o); });
}

}  // namespace carat::cli
