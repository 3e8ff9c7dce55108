// carat bench look: what each feature of a picture costs.
#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <limits>
#include <nlohmann/json.hpp>

#include "bench.hpp"
#include "carat/globe/error.hpp"
#include "carat/render/draw_list.hpp"
#include "carat/render/shadows.hpp"
#include "carat/vulkan/renderer.hpp"
#include "interrupt.hpp"
#include "look.hpp"
#include "progress.hpp"
#include "values.hpp"

namespace carat::cli {
namespace {

using Json = nlohmann::ordered_json;

struct Options {
    std::string file;
    std::array<double, 3> eye{36.4, -118.0, 5500};
    ViewRequest view;
    RendererOptions renderer;
    int rounds = 5;
    bool json = false;
};

struct Row {
    std::string name;
    DrawRequest request;
    const DrawList* list;
    Renderer* renderer;
    Tone tone = Tone::none;
    double device_ms = std::numeric_limits<double>::infinity();  // least
    double tone_ms = std::numeric_limits<double>::infinity();
};

constexpr const char* kFooter = R"(
Draws one view, refined once, with one feature after the other, round by round, and prints the least time that the
device took for each: drawing and shading, without uploads and reading back. Tone mapping is the host's. Detail is drawn with the
patches that it asks for besides. Casting shadows is the host's, measured once.

Example:
  carat bench look earth.carat --eye 36.4,-118,5500 --heading 280 --pitch -8 --size 1280x720)";

// What rows are drawn from.
struct Scenes {
    DrawList plain, detailed, shadowed;
    Renderer renderer, for_shadows;
};

std::vector<Row> rows_of(const DrawRequest& plain, Scenes& scenes, bool sea) {
    std::vector<Row> rows;
    const auto add = [&](const char* name, auto change) {
        Row row{name, plain, &scenes.plain, &scenes.renderer};
        change(row);
        rows.push_back(std::move(row));
    };
    add("light and colours", [](Row&) {});
    add("4 samples", [](Row& r) { r.request.samples = 4; });
    if (sea) add("water", [](Row& r) { r.request.water = true; });
    add("sky", [](Row& r) { r.request.sky = true; });
    if (sea) add("sky, water", [](Row& r) { r.request.sky = r.request.water = true; });
    add("sky, 4 samples", [](Row& r) { r.request.sky = true, r.request.samples = 4; });
    add("AOVs", [](Row& r) { r.request.aovs = {true, true, true, true, true}; });
    add("detail", [&](Row& r) { r.list = &scenes.detailed; });
    add("shadows", [&](Row& r) {
        r.list = &scenes.shadowed;
        r.renderer = &scenes.for_shadows;
        r.request.shadows = true;
    });
    add("tone mapping", [](Row& r) { r.tone = Tone::aces; });
    return rows;
}

int run(Options o, const Globals& globals) {
    catch_interrupts();
    o.view.eye = {o.eye[0], o.eye[1]};
    o.view.height = o.eye[2];
    const auto file = Repository::open(o.file);
    const Ellipsoid body = file->header().ellipsoid();
    const View view(body, o.view);
    o.renderer.cells = file->header().cells();
    RendererOptions shadowed = o.renderer;
    shadowed.shadowed = true;
    const Detail detail(file->header(), DetailOptions{});
    Scenes scenes{converged_cut(*file, view, 1, 1.5), converged_cut(*file, view, 1, 1.5, nullptr, &detail),
                  converged_cut(*file, view, 1, 1.5), Renderer(body, view.unit(), o.renderer),
                  Renderer(body, view.unit(), shadowed)};
    Look look;
    look.samples = 1;
    const DrawRequest request = draw_request(look, o.view, view, body);
    const ShadowCounters shadows = cast_shadows(scenes.shadowed, *file, view, request.light.direction);
    std::vector<Row> rows = rows_of(request, scenes, colours_of(body.name()).sea_level.has_value());
    double table_ms = 0;
    Progress progress("rounds", globals.quiet);
    for (int round = 0; round < o.rounds; ++round) {
        for (Row& row : rows) {
            Frame frame = row.renderer->draw(row.request, row.list->meshes);
            row.device_ms = std::min(row.device_ms, frame.counters.gpu_ms);
            table_ms += frame.counters.table_ms;
            const auto begin = std::chrono::steady_clock::now();
            tone_map(frame.colour, row.tone);
            row.tone_ms = std::min(
                row.tone_ms,
                std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count());
        }
        if (!progress.update("drawing", static_cast<std::uint64_t>(round) + 1,
                             static_cast<std::uint64_t>(o.rounds)))
            return kInterrupted;
    }
    progress.finish();
    const double base = rows[0].device_ms;
    Json json = {{"device", scenes.renderer.device_name()},
                 {"width", o.view.width},
                 {"height", o.view.image_height},
                 {"patches", scenes.plain.meshes.size()},
                 {"patches_with_detail", scenes.detailed.meshes.size()},
                 {"sky_tables_ms", table_ms},
                 {"shadows",
                  {{"ms", shadows.milliseconds}, {"views", shadows.views}, {"triangles", shadows.triangles}}},
                 {"features", Json::array()}};
    if (!o.json)
        fmt::print("{}, {}x{}, {} patches, {} with detail\n{:<18} {:>10} {:>8}\n",
                   scenes.renderer.device_name(), o.view.width, o.view.image_height,
                   scenes.plain.meshes.size(), scenes.detailed.meshes.size(), "", "ms", "more");
    for (const Row& row : rows) {
        const double ms = row.device_ms + (row.tone == Tone::none ? 0 : row.tone_ms);
        json["features"].push_back({{"name", row.name}, {"ms", ms}, {"more_ms", ms - base}});
        if (!o.json) fmt::print("{:<18} {:>10.1f} {:>8.1f}\n", row.name, ms, ms - base);
    }
    if (o.json)
        fmt::print("{}\n", json.dump(2));
    else
        fmt::print(
            "tables of the sky, once: {:.0f} ms\ncasting shadows: {:.0f} ms, {} views of the sun, {} "
            "triangles\n",
            table_ms, shadows.milliseconds, shadows.views, shadows.triangles);
    return kSuccess;
}

}  // namespace

void add_bench_look(CLI::App& bench, Globals& globals) {
    const auto o = std::make_shared<Options>();
    o->view.heading = 280;
    o->view.pitch = -8;
    CLI::App& sub = *bench.add_subcommand("look", "What light, sky, water and samples cost");
    sub.footer(kFooter);
    sub.add_option("FILE", o->file, "A .carat file")->required();
    add_numbers(sub, "--eye", o->eye, "LAT,LON,HEIGHT_M", "Place of the eye (default 36.4,-118,5500)");
    add_bench_direction(sub, o->view);
    sub.add_option("--rounds", o->rounds, "Of all features (default 5)")->check(CLI::Range(1, 1000));
    sub.add_option("--device", o->renderer.device, "Vulkan device: part of its name, or its number");
    sub.add_flag("--json", o->json, "Print JSON");
    on_run(sub, globals, [o, &globals] { return run(*o, globals); });
}

}  // namespace carat::cli
