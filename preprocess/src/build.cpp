#include "carat/preprocess/build.hpp"

#include <tbb/global_control.h>

#include <chrono>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "build_certify.hpp"
#include "build_passes.hpp"
#include "build_plan.hpp"
#include "carat/globe/error.hpp"
#include "carat/preprocess/provenance.hpp"
#include "measure_blocks.hpp"

namespace carat {
namespace {

void check(const BuildOptions& o) {
    if (o.layers.empty()) throw Error(ErrorCode::usage, "no layers: name at least one raster");
    if (!(o.tolerance > 0) || !std::isfinite(o.tolerance))
        throw Error(ErrorCode::usage, "tolerance must be positive, in metres");
    if (!std::isfinite(o.base_height)) throw Error(ErrorCode::usage, "base height is not finite");
    for (const LayerOptions& layer : o.layers)
        if (!layer.geoid.empty() && o.vertical_datum != "ellipsoid" && o.vertical_datum != "unstated")
            throw Error(ErrorCode::usage,
                        "heights that a geoid is added to are above the ellipsoid, not above " +
                            o.vertical_datum + "; a geoid must not be applied twice");
    if (o.certify && !(*o.certify > o.tolerance && std::isfinite(*o.certify)))
        throw Error(ErrorCode::usage, "a certified bound must be above the tolerance, which is a part of it");
    if (o.certify && o.mode != Mode::interpolating)
        throw Error(ErrorCode::usage, "a bound can be certified in mode 0 only");
    if (o.log2_cells < 4 || o.log2_cells > 7)
        throw Error(ErrorCode::usage, "patches have 16 to 128 cells a side");
    if (o.max_level < 0 || o.max_level >= kDeepestId)
        throw Error(ErrorCode::usage, "the deepest level is below " + std::to_string(kDeepestId));
}

std::optional<tbb::global_control> limit_threads(int threads) {
    if (threads <= 0) return std::nullopt;
    return std::optional<tbb::global_control>(std::in_place, tbb::global_control::max_allowed_parallelism,
                                              static_cast<std::size_t>(threads));
}

BuildPlan describe(const SourceStack& sources, const RefinedLevels& levels, int cells) {
    BuildPlan plan;
    plan.layers = sources.layers();
    plan.warnings = sources.warnings();
    for (const auto& level : levels) {
        plan.refined_by_level.push_back(level.size());
        plan.refined += level.size();
    }
    const auto side = static_cast<std::uint64_t>(cells);
    plan.leaf_samples = kFaces * side * side + 2 + plan.refined * side * side;
    for (const LayerInfo& layer : plan.layers) plan.source_samples += layer.valid_samples;
    return plan;
}

BuildTree make_tree(const RefinedLevels& levels) {
    BuildTree tree;
    for (const auto& ids : levels) {
        auto& level = tree.levels.emplace_back(ids.size());
        for (std::size_t k = 0; k < ids.size(); ++k) level[k].id = ids[k];
    }
    tree.index();
    return tree;
}

ErrorSum root_errors(const BuildContext& context, const FaceHeights& source, const EncodedRoots& coded) {
    ErrorSum sum;
    for (std::size_t face = 0; face < kFaces; ++face)
        for (std::size_t k = 0; k < source[face].size(); ++k)
            sum.add(context.quantum *
                    (std::abs(static_cast<double>(source[face][k]) - coded.heights[face][k]) + 0.5));
    return sum;
}

// Compares the file, complete but for this, with the sources.
ErrorSummary measure_file(const BuildContext& context, const BuildPlan& plan,
                          const std::optional<Certification>& certification, RepositoryWriter& writer) {
    std::uint64_t samples = 0;
    for (const LayerInfo& layer : plan.layers) samples += layer.samples;
    const FileSurface surface(Repository::open(writer.complete()), context.options.memory_bytes / 4);
    context.progress.begin(BuildStage::measuring, samples);
    ErrorSummary errors = measure_blocks(context.sources, surface, kRecordedPlaces,
                                         [&](std::uint64_t n) { context.progress.step(n); });
    if (certification && certification->reached() && errors.all.max > certification->bound)
        throw std::logic_error("the certified bound does not hold");
    writer.replace_provenance(provenance_json(context.options, plan, &errors, certification));
    return errors;
}

std::vector<DiamondRecord> take_records(BuildTree& tree) {
    std::vector<DiamondRecord> records;
    records.reserve(tree.count());
    for (auto& level : tree.levels)
        for (BuildDiamond& d : level) records.push_back({d.id, std::move(d.residuals), d.summary});
    return records;
}

WriterSetup writer_setup(const BuildContext& context, const BuildPlan& plan, int depth) {
    WriterSetup setup;
    setup.log2_cells = context.options.log2_cells;
    setup.quantum = context.quantum;
    setup.tolerance = context.options.tolerance;
    setup.body = context.options.body;
    setup.vertical_datum = context.options.vertical_datum;
    setup.provenance = provenance_json(context.options, plan);
    if (context.options.measures()) setup.provenance.resize(measured_room(setup.provenance, plan), ' ');
    setup.coding = context.options.coding;
    setup.radii.assign(static_cast<std::size_t>(depth) + 1, context.radius);
    return setup;
}

}  // namespace

BuildPlan plan_build(const BuildOptions& options, const ProgressFunction& callback) {
    check(options);
    const auto threads = limit_threads(options.threads);
    ProgressReporter progress(callback);
    const SourceStack sources(options.layers, options.body, options.base_height, options.memory_bytes);
    progress.begin(BuildStage::planning, 0);
    RefinedLevels levels = plan_depth(options, sources, progress);
    if (options.certify) certify_depth(options, sources, levels, progress);
    return describe(sources, levels, 1 << options.log2_cells);
}

BuildReport build_repository(const BuildOptions& options, const ProgressFunction& callback) {
    const auto started = std::chrono::steady_clock::now();
    check(options);
    if (!options.overwrite && std::filesystem::exists(options.output))
        throw Error(ErrorCode::usage, options.output.string() + ": exists already; --overwrite replaces it");
    const double quantum = options.quantum.value_or(default_quantum(options.tolerance));
    const std::int32_t radius = quantizer_radius(options.tolerance, quantum);
    const auto threads = limit_threads(options.threads);
    ProgressReporter progress(callback);
    const SourceStack sources(options.layers, options.body, options.base_height, options.memory_bytes);

    BuildReport report;
    progress.begin(BuildStage::planning, 0);
    RefinedLevels levels = plan_depth(options, sources, progress);
    if (options.certify) report.certification = certify_depth(options, sources, levels, progress);
    report.plan = describe(sources, levels, 1 << options.log2_cells);
    BuildTree tree = make_tree(levels);
    const BuildContext context{options, sources, quantum, radius, progress};

    progress.begin(options.mode == Mode::interpolating ? BuildStage::sampling : BuildStage::filtering,
                   tree.count());
    const FaceHeights roots =
        options.mode == Mode::interpolating ? sample_roots(context) : filter_tree(context, tree);
    const EncodedRoots coded = encode_roots(roots, context.n(), radius);
    ErrorSum errors = root_errors(context, roots, coded);

    progress.begin(BuildStage::coding, tree.count());
    errors.add(code_tree(context, coded.heights, tree));
    progress.begin(BuildStage::summarising, tree.count());
    summarise_tree(context, tree);

    progress.begin(BuildStage::writing, tree.count());
    RepositoryWriter writer(options.output, writer_setup(context, report.plan, tree.depth()), coded);
    std::vector<DiamondRecord> records = take_records(tree);
    for (const DiamondRecord& r : records)
        ++(r.residuals.blob.empty() ? report.zero_diamonds : report.coded_diamonds);
    writer.write(std::move(records));
    if (options.measures()) report.errors = measure_file(context, report.plan, report.certification, writer);
    report.file_bytes = writer.finish();
    report.max_error = errors.max;
    report.rms_error = std::sqrt(errors.squares / static_cast<double>(errors.count));
    report.stage_seconds = progress.stage_seconds();
    report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - started).count();
    return report;
}

}  // namespace carat
