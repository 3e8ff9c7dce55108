#include "carat/preprocess/build.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>

#include "build_certify.hpp"
#include "build_choice.hpp"
#include "build_estimate.hpp"
#include "build_finished.hpp"
#include "build_output.hpp"
#include "build_passes.hpp"
#include "build_plan.hpp"
#include "build_workspace.hpp"
#include "carat/globe/error.hpp"

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
    if (o.rms && !(*o.rms > 0 && std::isfinite(*o.rms)))
        throw Error(ErrorCode::usage, "an RMS error must be positive, in metres");
    if (o.rms && o.certify)
        throw Error(ErrorCode::usage, "a bound is certified for a given tolerance, not for an RMS error");
    if (o.fit_tables && o.coding.coder == CoderId::gamma)
        throw Error(ErrorCode::usage, "the gamma coder has no tables to fit");
    if (o.log2_cells < 4 || o.log2_cells > 7)
        throw Error(ErrorCode::usage, "patches have 16 to 128 cells a side");
    if (o.max_level < 0 || o.max_level >= kDeepestId)
        throw Error(ErrorCode::usage, "the deepest level is below " + std::to_string(kDeepestId));
}

double rms_of(const ErrorSum& errors) {
    return errors.count == 0 ? 0 : std::sqrt(errors.squares / static_cast<double>(errors.count));
}

ErrorSum root_errors(const BuildContext& context, const FaceHeights& source, const EncodedRoots& coded) {
    ErrorSum sum;
    for (std::size_t face = 0; face < kFaces; ++face)
        for (std::size_t k = 0; k < source[face].size(); ++k) {
            const std::int64_t e = std::abs(std::int64_t{source[face][k]} - coded.heights[face][k]);
            sum.add(e, static_cast<double>(e) * static_cast<double>(e), 1, context.quantum);
        }
    return sum;
}

bool has_step(const BuildContext& c, int level, std::size_t step) {
    return c.store.has({StepKind::heights, level, step}) && c.store.has({StepKind::code, level, step}) &&
           c.store.has({StepKind::facts, level, step});
}

// False if a file that is needed is missing, for instance because it was found damaged: then nothing of use
// is left.
bool can_go_on(const BuildContext& c) {
    const int depth = c.depth();
    int next = 0;  // the level to be coded
    while (next < depth && c.has_level(StepKind::facts, next)) ++next;
    for (int level = 0; level < next; ++level) {
        if (!c.has_level(StepKind::code, level)) return false;
        if (level >= next - 5 && next < depth && !c.has_level(StepKind::heights, level)) return false;
    }
    if (next == depth) return true;
    bool coding = next > 0;
    for (std::size_t step = 0; step < c.steps(next); ++step) coding = coding || has_step(c, next, step);
    if (coding) {
        for (std::size_t step = 0; step < c.steps(next); ++step)
            if (!has_step(c, next, step) && !c.store.has({StepKind::reference, next, step})) return false;
        for (int level = next + 1; level < depth; ++level)
            if (!c.has_level(StepKind::reference, level)) return false;
        return true;
    }
    int level = depth;  // from here on the reference is complete
    while (level > 0 && c.has_level(StepKind::reference, level - 1)) --level;
    return level == 0 || level == depth || c.has_level(StepKind::vertices, level);
}

// The blobs that lie in the store, by their place among all diamonds.
class StoredBlobs {
  public:
    explicit StoredBlobs(const BuildContext& context) : context_(context) {
        for (const auto& level : context.levels) first_.push_back(first_.back() + level.size());
    }
    void read(std::size_t k, std::vector<std::byte>& out) const {
        const auto level = std::upper_bound(first_.begin(), first_.end(), k) - first_.begin() - 1;
        const std::size_t position = k - first_[static_cast<std::size_t>(level)];
        context_.store.read({StepKind::code, static_cast<int>(level), position / kStepDiamonds},
                            position % kStepDiamonds, out);
        out.erase(out.begin());  // the BlobInfo
    }

  private:
    const BuildContext& context_;
    std::vector<std::size_t> first_{0};
};

// The step that was chosen from a sample does not keep the RMS error that was asked for.
struct RmsMissed {
    double found;  // metres
};

// The passes, from sources to a file. Throws RmsMissed before anything is written.
BuildReport run_passes(const BuildContext& context, BuildPlan plan,
                       const std::optional<Certification>& certification) {
    BuildReport report;
    report.certification = certification;
    ProgressReporter& progress = context.progress;
    progress.begin(BuildStage::sampling, plan.refined);
    const SourceStack::Reads before = context.sources.reads();
    const FaceHeights roots = make_reference(context);
    const SourceStack::Reads sampled = context.sources.reads();
    report.source_tiles = sampled.tiles;
    report.sampling_tile_reads = sampled.reads - before.reads;
    const EncodedRoots coded = encode_roots(roots, context.n(), context.radius);
    ErrorSum errors = root_errors(context, roots, coded);
    progress.begin(BuildStage::coding, plan.refined);
    code_levels(context, coded.heights);
    progress.begin(BuildStage::summarising, plan.refined);
    const Summaries summaries = summarise_levels(context);
    if (const double found = rms_of(summaries.errors); context.options.rms && found > *context.options.rms)
        throw RmsMissed{found};
    errors.add(summaries.errors);
    progress.begin(BuildStage::writing, plan.refined);
    for (const DiamondEntry& d : summaries.diamonds)
        ++(d.blob_bytes == 0 ? report.zero_diamonds : report.coded_diamonds);
    const OutputJob job{context.options, context.sources,  context.quantum,
                        context.radius,  context.progress, context.cache_bytes};
    const StoredBlobs blobs(context);
    report.file_bytes = write_output(
        job, plan, certification, coded, summaries.diamonds,
        [&](std::size_t k, std::vector<std::byte>& out) { blobs.read(k, out); }, report.errors);
    report.measuring_tile_reads = context.sources.reads().reads - sampled.reads;
    report.plan = std::move(plan);
    report.max_error = errors.max;
    report.rms_error = rms_of(errors);
    report.tolerance = context.options.tolerance;
    return report;
}

// A failure after which the same command with --resume may do better.
bool may_resume(const Error& error, const ProgressReporter& progress) {
    return error.code() == ErrorCode::io || progress.cancelled();
}

std::string kept(const StepStore& store) {
    return "; what is done is kept in " + store.folder().string() +
           ": the same command with --resume goes on";
}

BuildPlan plan_of(const BuildOptions& options, const SourceStack& sources, const RefinedLevels& levels) {
    BuildPlan plan = describe_plan(sources, levels, 1 << options.log2_cells);
    plan.temporary_bytes = temporary_bytes(levels, (1 << options.log2_cells) + 1, options.mode).bound;
    plan.temporary_folder = temporary_folder(options);
    return plan;
}

// The temporary files are removed when the file is complete, and after failures that --resume does not mend.
BuildReport build_in_workspace(const BuildOptions& options, const SourceStack& sources,
                               const RefinedLevels& levels, ProgressReporter& progress, const BuildPlan& plan,
                               const std::optional<Certification>& certification, std::size_t memory) {
    const double quantum = options.quantum.value_or(default_quantum(options.tolerance));
    const std::int32_t radius = quantizer_radius(options.tolerance, quantum);
    const std::unique_ptr<StepStore> store = open_workspace(
        options, sources, temporary_bytes(levels, (1 << options.log2_cells) + 1, options.mode));
    const BuildContext context{options, sources,  levels, quantum,
                               radius,  progress, *store, share_memory(memory).heights};
    if (store->found() > 0 && !can_go_on(context)) store->drop_all();
    try {
        BuildReport report = run_passes(context, plan, certification);
        report.resumed_files = store->found();
        report.temporary_peak_bytes = store->peak_bytes();
        store->remove();
        return report;
    } catch (const Error& error) {
        if (may_resume(error, progress) && store->peak_bytes() > 0)
            throw Error(error.code(), error.what() + kept(*store));
        store->remove();
        throw;
    } catch (const RmsMissed&) {
        store->remove();
        throw;
    }
}

using Instant = std::chrono::steady_clock::time_point;

BuildReport timed(BuildReport report, const ProgressReporter& progress, Instant started) {
    report.stage_seconds = progress.stage_seconds();
    report.peak_memory_bytes = peak_memory_bytes();
    report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - started).count();
    return report;
}

[[noreturn]] void refuse_to_replace(const BuildOptions& options) {
    throw Error(ErrorCode::usage, options.output.string() + ": exists already; --overwrite replaces it");
}

// With what has been done since `started`, which a build does too.
BuildEstimate expected(const BuildOptions& options, const SourceStack& sources, const RefinedLevels& levels,
                       const BuildPlan& plan, std::chrono::steady_clock::time_point started,
                       std::size_t trials) {
    const std::chrono::duration<double> before = std::chrono::steady_clock::now() - started;
    BuildEstimate out = estimate_build(options, sources, levels, plan, trials);
    out.seconds += before.count();
    return out;
}

}  // namespace

BuildPlan plan_build(const BuildOptions& options, const ProgressFunction& callback) {
    const auto started = std::chrono::steady_clock::now();
    check(options);
    const auto threads = limit_threads(options.threads);
    ProgressReporter progress(callback);
    const SourceStack sources(options.layers, options.body, options.base_height,
                              share_memory(memory_limit(options)).sources);
    progress.begin(BuildStage::planning, 0);
    RefinedLevels levels = plan_depth(options, sources, progress);
    if (options.certify) certify_depth(options, sources, levels, progress);
    progress.begin(BuildStage::sampling, 0);
    BuildPlan plan = plan_of(options, sources, levels);
    const BuildOptions chosen = chosen_options(options, sources, levels);
    plan.estimate = expected(chosen, sources, levels, plan, started, kMostTrials);
    return plan;
}

BuildReport build_repository(const BuildOptions& options, const ProgressFunction& callback,
                             const std::function<void(const BuildPlan&)>& planned) {
    const auto started = std::chrono::steady_clock::now();
    check(options);
    const bool exists = !options.overwrite && std::filesystem::exists(options.output);
    if (exists && !options.resume) refuse_to_replace(options);
    const std::size_t memory = memory_limit(options);
    const auto threads = limit_threads(options.threads);
    ProgressReporter progress(callback);
    const SourceStack sources(options.layers, options.body, options.base_height,
                              share_memory(memory).sources);

    progress.begin(BuildStage::planning, 0);
    RefinedLevels levels = plan_depth(options, sources, progress);
    std::optional<Certification> certification;
    if (options.certify) certification = certify_depth(options, sources, levels, progress);
    BuildPlan plan = plan_of(options, sources, levels);
    if (exists) {
        std::optional<BuildReport> report = finished_before(options, plan, certification);
        if (!report) refuse_to_replace(options);
        return timed(*std::move(report), progress, started);
    }
    check_diamonds(plan.refined, memory);
    if (planned) planned(plan);
    BuildOptions chosen = chosen_options(options, sources, levels);
    if (!options.resume)
        plan.estimate = expected(chosen, sources, levels, plan, started, trials_before_build(plan));
    chosen.tolerance = tolerance_in_workspace(options).value_or(chosen.tolerance);
    for (;;) try {
            return timed(build_in_workspace(chosen, sources, levels, progress, plan, certification, memory),
                         progress, started);
        } catch (const RmsMissed& missed) {
            chosen = with_smaller_step(chosen, missed.found);
            chosen.resume = false;
        }
}

}  // namespace carat
