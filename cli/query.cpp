// carat query: heights at places.
#include <fmt/core.h>
#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <numeric>

#include "carat/codec/surface.hpp"
#include "carat/globe/error.hpp"
#include "carat/globe/locate.hpp"
#include "carat/render/detail_surface.hpp"
#include "colour_files.hpp"
#include "commands.hpp"
#include "look.hpp"
#include "points.hpp"
#include "text.hpp"
#include "values.hpp"

namespace carat::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kPiece = 1u << 19;  // points in memory at a time
constexpr std::size_t kGrain = 512;       // points a task

struct Options {
    std::string file, latitude, longitude, points;
    bool json = false, no_header = false;
    std::optional<DetailOptions> detail;
    std::size_t memory_bytes = 256u << 20;
};

constexpr const char* kFooter = R"(
Latitude is geodetic, in degrees, north positive; longitude in degrees, east positive. The height is that of the
surface that is drawn: metres above the file's vertical datum (`carat info` names it), linear in between samples.

Input  lines "lat,lon"; blank lines, lines that begin with # and a first line "lat,lon" are skipped.
Output one line for each place, in the order of the input, after a first line with the names of the columns:
  lat,lon    as given
  height_m   height
  spacing_m  distance between samples there
  bound_m    greatest possible |height - source|: the tolerance if the place is a sample, otherwise empty
  measured   "measured": the height comes from the file's data; "synthesised": with --detail, in between samples

--detail asks the surface that render and fly draw with the same --detail, where they refine to the end. Samples of the
file keep their heights.

Of a colour file the lines are "lat,lon,red,green,blue,spacing_m,bound,measured", channels 0 to 255, and bound is the greatest
error of a channel if the place is a sample.

Examples:
  carat query earth.carat 27.9881 86.9250
  carat query earth.carat --points places.csv > heights.csv
  carat query earth.carat 36.5785 -118.2923 --detail seed=7,to=0.1
  printf '46.5475,7.9854\n-32.65,-70.01\n' | carat query earth.carat --points - --json)";

// Heights of pieces of the input, several threads at once.
class Asking {
  public:
    Asking(std::shared_ptr<const Repository> file, std::size_t memory,
           const std::optional<DetailOptions>& detail) {
        if (detail)
            detailed_.emplace(file, std::make_shared<const Detail>(file->header(), *detail), memory);
        else
            surface_.emplace(file, memory);
    }

    // In the order of the points. Works in the order of places, so that neighbours share decoded diamonds.
    std::vector<DetailSurface::Sample> operator()(const Points& points) const {
        std::vector<RealLattice> places(points.size());
        std::vector<std::uint64_t> keys(points.size());
        parallel(points.size(), [&](std::size_t k) {
            places[k] = lattice_position(direction(points.places[k]));
            keys[k] = locate(places[k], kKeyLevel).half.diamond.bits();
        });
        std::vector<std::uint32_t> order(points.size());
        std::iota(order.begin(), order.end(), 0u);
        std::sort(order.begin(), order.end(), [&](auto a, auto b) { return keys[a] < keys[b]; });
        std::vector<DetailSurface::Sample> out(points.size());
        parallel(points.size(), [&](std::size_t k) { out[order[k]] = sample(places[order[k]]); });
        return out;
    }

  private:
    static constexpr int kKeyLevel = 24;

    template <class Work>
    static void parallel(std::size_t count, const Work& work) {
        tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, kGrain), [&](const auto& range) {
            for (std::size_t k = range.begin(); k < range.end(); ++k) work(k);
        });
    }

    DetailSurface::Sample sample(const RealLattice& place) const {
        if (detailed_) return detailed_->sample(place);
        const Surface::Sample s = surface_->sample(place);
        return {s.height, s.spacing, s.at_lattice, false};
    }

    std::optional<Surface> surface_;  // one of the two
    std::optional<DetailSurface> detailed_;
};

std::string bound_text(const RepositoryHeader& h, const DetailSurface::Sample& s) {
    return s.at_lattice ? number(h.tolerance) : "";
}

void print_csv(const RepositoryHeader& h, const Points& points,
               const std::vector<DetailSurface::Sample>& samples) {
    fmt::memory_buffer out;
    for (std::size_t k = 0; k < points.size(); ++k)
        fmt::format_to(std::back_inserter(out), "{},{:.4f},{:.6g},{},{}\n", points.written(k),
                       samples[k].height, samples[k].spacing, bound_text(h, samples[k]),
                       samples[k].synthesised ? "synthesised" : "measured");
    std::fwrite(out.data(), 1, out.size(), stdout);
}

void print_json(const RepositoryHeader& h, const Points& points,
                const std::vector<DetailSurface::Sample>& samples, bool first) {
    for (std::size_t k = 0; k < points.size(); ++k) {
        const DetailSurface::Sample& s = samples[k];
        const Json point = {{"lat", points.places[k].latitude},
                            {"lon", points.places[k].longitude},
                            {"height_m", s.height},
                            {"spacing_m", s.spacing},
                            {"bound_m", s.at_lattice ? Json(h.tolerance) : Json(nullptr)},
                            {"measured", !s.synthesised}};
        fmt::print("{}\n    {}", first && k == 0 ? "" : ",", point.dump());
    }
}

// Points from the command line, a file or stdin, a piece at a time.
class Input {
  public:
    explicit Input(const Options& o) {
        if (o.points.empty()) {
            single_.add(o.latitude, o.longitude, [] { return std::string("command line"); });
            return;
        }
        if (o.points != "-") {
            file_.open(o.points);
            if (!file_) throw Error(ErrorCode::io, o.points + ": cannot be opened");
        }
        reader_.emplace(o.points == "-" ? std::cin : file_, o.points == "-" ? "stdin" : o.points);
    }
    Points next() {
        if (reader_) return reader_->next(kPiece);
        return std::exchange(single_, {});
    }

  private:
    Points single_;
    std::ifstream file_;
    std::optional<PointReader> reader_;
};

void check(const Options& o) {
    const bool place = !o.latitude.empty() || !o.longitude.empty();
    if (place == !o.points.empty() || o.latitude.empty() != o.longitude.empty())
        throw Error(ErrorCode::usage, "query: give either LAT LON or --points");
}

// Colours instead of heights.
int run_colour(const Options& o) {
    Input input(o);
    const auto file = ColourRepository::open(o.file, o.memory_bytes);
    if (o.json)
        fmt::print("{{\n  \"file\": {},\n  \"points\": [", Json(o.file).dump());
    else if (!o.no_header)
        fmt::print("{}\n", kColourColumns);
    bool first = true;
    for (Points points = input.next(); points.size() > 0; points = input.next()) {
        print_colours(*file, points, o.json, first);
        first = false;
    }
    if (o.json) fmt::print("\n  ]\n}}\n");
    if (std::fflush(stdout) != 0) throw Error(ErrorCode::io, "stdout: cannot be written");
    return kSuccess;
}

int run(const Options& o, const Globals& globals) {
    check(o);
    if (is_colour_file(o.file)) return run_colour(o);
    Input input(o);
    const auto file = Repository::open(o.file);
    const RepositoryHeader& h = file->header();
    const Asking ask(file, o.memory_bytes, o.detail);
    if (o.json)
        fmt::print("{{\n  \"file\": {},\n  \"vertical_datum\": {},\n  \"points\": [", Json(o.file).dump(),
                   Json(h.vertical_datum).dump());
    else if (!o.no_header)
        fmt::print("lat,lon,height_m,spacing_m,bound_m,measured\n");

    const auto begin = std::chrono::steady_clock::now();
    std::uint64_t asked = 0;
    for (Points points = input.next(); points.size() > 0; points = input.next()) {
        const std::vector<DetailSurface::Sample> samples = ask(points);
        if (o.json)
            print_json(h, points, samples, asked == 0);
        else
            print_csv(h, points, samples);
        asked += points.size();
    }
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    const double rate = static_cast<double>(asked) / std::max(seconds, 1e-9);
    if (o.json)
        fmt::print("\n  ],\n  \"summary\": {}\n}}\n",
                   Json{{"count", asked}, {"seconds", seconds}, {"queries_per_second", rate}}.dump());
    if (std::fflush(stdout) != 0) throw Error(ErrorCode::io, "stdout: cannot be written");
    if (globals.verbose)
        fmt::print(stderr, "{} places in {}, {}/s; {} bytes read, {} diamonds decoded\n", grouped(asked),
                   duration(seconds), grouped(static_cast<std::uint64_t>(rate)),
                   grouped(file->counters().bytes),
                   grouped(file->counters().diamonds_decoded + file->counters().diamonds_zero));
    return kSuccess;
}

}  // namespace

void add_query(CLI::App& app, Globals& globals) {
    const auto o = std::make_shared<Options>();
    CLI::App& sub = *app.add_subcommand("query", "Heights at places, from arguments or CSV");
    sub.footer(kFooter);
    sub.add_option("FILE", o->file, "A .carat file")->required()->type_name(" ");
    sub.add_option("LAT", o->latitude, "Latitude, degrees")->type_name(" ");
    sub.add_option("LON", o->longitude, "Longitude, degrees")->type_name(" ");
    sub.add_option("--points", o->points, "CSV file with lines \"lat,lon\"; - is stdin")->type_name("CSV|-");
    sub.add_flag("--json", o->json, "Print JSON");
    sub.add_flag("--no-header", o->no_header, "CSV without the first line");
    add_value(sub, "--memory", "SIZE", "For decoded diamonds (default 256M)",
              [o](const std::string& text) { o->memory_bytes = parse_size(text); });
    add_detail_option(sub, o->detail, "Options");
    on_run(sub, globals, [o, &globals] { return run(*o, globals); });
}

}  // namespace carat::cli
