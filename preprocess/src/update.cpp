#include "carat/preprocess/update.hpp"

#include <chrono>

#include "build_certify.hpp"
#include "build_plan.hpp"
#include "build_workspace.hpp"
#include "carat/globe/error.hpp"
#include "carat/preprocess/provenance.hpp"
#include "content_hash.hpp"
#include "update_closure.hpp"

namespace carat {
namespace {

namespace fs = std::filesystem;

// The old sources: where they lie, and whether they are what they were.
class OldSources {
  public:
    OldSources(const UpdateOptions& options, const Provenance& recorded)
        : file_(options.file.string()), folders_(options.sources), recorded_(recorded) {
        folders_.push_back(options.file.parent_path().empty() ? "." : options.file.parent_path());
        folders_.emplace_back(".");
    }

    std::vector<LayerOptions> layers() const {
        std::vector<LayerOptions> out;
        for (const RecordedLayer& layer : recorded_.layers) {
            LayerOptions o = layer.options;
            for (std::string& name : o.files) name = find(name);
            if (!o.geoid.empty()) {
                o.geoid = find(o.geoid);
                if (content_hash({o.geoid}).hash != layer.geoid_hash) refuse(o.geoid);
            }
            out.push_back(std::move(o));
        }
        return out;
    }

    // infos: of the recorded layers, as they were opened. Puts in hashes that were not asked for.
    void check(std::vector<LayerInfo>& infos) const {
        for (std::size_t k = 0; k < infos.size(); ++k)
            for (std::size_t f = 0; f < infos[k].files.size(); ++f) {
                FileInfo& now = infos[k].files[f];
                const RecordedFile& then = recorded_.layers[k].files[f];
                const bool hashed = now.hash != 0;  // else only sizes are asked for
                if (now.bytes != then.bytes || (hashed && now.hash != then.hash)) refuse(now.path);
                now.hash = then.hash;
            }
    }

  private:
    std::string find(const std::string& name) const {
        std::string where;
        for (const fs::path& folder : folders_) {
            if (fs::exists(folder / name)) return (folder / name).string();
            where += (where.empty() ? "" : ", ") + folder.string();
        }
        throw Error(ErrorCode::usage, file_ + ": its source " + name + " is missing: it is not in " + where +
                                          "; name its folder with --sources");
    }
    [[noreturn]] void refuse(const std::string& path) const {
        throw Error(ErrorCode::usage, path + ": has changed since " + file_ +
                                          " was built from it; put the old one back, or build the file anew");
    }

    std::string file_;
    std::vector<fs::path> folders_;
    const Provenance& recorded_;
};

// What the file was built with, and the new layer.
BuildOptions options_of(const UpdateOptions& update, const FileContents& file, const Provenance& recorded,
                        std::vector<LayerOptions> layers) {
    const RepositoryHeader& h = file.header();
    BuildOptions o;
    o.layers = std::move(layers);
    o.layers.insert(o.layers.begin() + (update.at - 1), update.layer);
    o.tolerance = h.tolerance;
    o.quantum = h.quantum;
    o.body = h.ellipsoid();
    o.vertical_datum = h.vertical_datum;
    o.base_height = recorded.base_height;
    o.mode = recorded.mode;
    o.coding = file.coding();
    o.coding.orders = recorded.orders;
    o.depth_bias = recorded.depth_bias;
    o.max_level = recorded.max_level;
    o.log2_cells = h.log2_cells;
    o.certify = recorded.certify;
    o.measure = update.measure;
    o.threads = update.threads;
    o.memory_bytes = update.memory_bytes;
    o.temp = update.temp;
    o.output = update.output.empty() ? update.file : update.output;
    o.overwrite = update.overwrite || update.output.empty();
    return o;
}

void check(const UpdateOptions& o, const Provenance& recorded, const BuildOptions& build, double file_rms) {
    if (!build.overwrite && fs::exists(build.output))
        throw Error(ErrorCode::usage, build.output.string() + ": exists already; --overwrite replaces it");
    if (!o.layer.geoid.empty() && build.vertical_datum != "ellipsoid" && build.vertical_datum != "unstated")
        throw Error(ErrorCode::usage, "heights that a geoid is added to are above the ellipsoid, not above " +
                                          build.vertical_datum + "; a geoid must not be applied twice");
    if (file_rms > 0)
        throw Error(ErrorCode::usage, o.file.string() +
                                          ": promises an RMS error, whose step hangs on all of the "
                                          "data; build it anew");
    if (recorded.layers.empty())
        throw Error(ErrorCode::usage, o.file.string() + ": records no sources; build it anew");
}

RefinedLevels levels_of(const FileContents& file) {
    RefinedLevels levels;
    for (const DiamondEntry& d : file.diamonds()) {
        const auto level = static_cast<std::size_t>(d.id.level());
        if (levels.size() <= level) levels.resize(level + 1);
        levels[level].push_back(d.id);
    }
    return levels;
}

std::uint64_t total(const RefinedLevels& levels) {
    std::uint64_t n = 0;
    for (const auto& level : levels) n += level.size();
    return n;
}

std::string geoid_beneath(const std::vector<LayerOptions>& layers) {
    return layers.empty() ? std::string() : layers.back().geoid;
}

void count(std::vector<LayerShare>& shares, const DiamondEntry& d, int layer, std::uint64_t times) {
    LayerShare& s = layer == kBaseLayer ? shares.back() : shares[static_cast<std::size_t>(layer)];
    s.refined += times;
    s.zero += d.blob_bytes == 0 ? times : 0;
    s.residual_bytes += times * d.blob_bytes;
}

// Shares of the layers: those of before, but for diamonds that are new, gone, changed or under the new layer.
std::vector<LayerShare> shares_now(std::vector<LayerShare> shares, std::size_t layer,
                                   const UpdateState& state, const UpdateClosure& closure,
                                   const SourceStack& sources) {
    constexpr std::uint64_t kOnce = 1, kLess = ~std::uint64_t{0};  // mod 2^64
    shares.insert(shares.begin() + static_cast<std::ptrdiff_t>(layer), LayerShare{});
    for (const std::size_t k : closure.looked_at()) {
        const DiamondEntry& now = closure.diamonds()[k];
        const DiamondEntry* before = closure.before(k);
        const Vec3 middle = direction(now.id.centre());
        const bool same = before != nullptr && before->blob_bytes == now.blob_bytes;
        if (same && !sources.is_near(layer, middle)) continue;
        if (before != nullptr) count(shares, *before, sources.layer_near(middle, layer), kLess);
        count(shares, now, sources.layer_near(middle), kOnce);
    }
    for (std::size_t level = 0; level < state.plan.removed.size(); ++level)
        for (const DiamondId id : state.plan.removed[level]) {
            const DiamondEntry& d = closure.entry_before(id, level);
            count(shares, d, sources.layer_near(direction(id.centre()), layer), kLess);
        }
    return shares;
}

class Update {
  public:
    Update(const UpdateOptions& options, const ProgressFunction& callback)
        : update_(options),
          callback_(callback),
          progress_(callback),
          file_(Repository::open(options.file)),
          recorded_(parse_provenance(file_->header().provenance)) {}

    UpdateReport run() {
        const auto layers = static_cast<int>(recorded_.layers.size());
        if (update_.at < 1 || update_.at > layers + 1)
            throw Error(ErrorCode::usage, "--at " + std::to_string(update_.at) + ": the file has " +
                                              std::to_string(layers) + " layers; 1 to " +
                                              std::to_string(layers + 1) + " are possible");
        BuildOptions probe;
        probe.memory_bytes = update_.memory_bytes;
        memory_ = memory_limit(probe);
        check_diamonds(file_->header().refined_diamonds, memory_);
        const FileContents contents(update_.file);
        const OldSources old(update_, recorded_);
        const std::vector<LayerOptions> layers_before = old.layers();
        const BuildOptions build = options_of(update_, contents, recorded_, layers_before);
        check(update_, recorded_, build, file_->header().rms_tolerance);
        everywhere_ = geoid_beneath(build.layers) != geoid_beneath(layers_before);
        local_ = build.mode == Mode::interpolating && !everywhere_ && !build.certify && !build.measure &&
                 recorded_.source_samples > 0 && recorded_.shares.size() == recorded_.layers.size() + 1;
        const SourceStack sources(
            build.layers, build.body, build.base_height, share_memory(memory_).sources,
            {local_ ? std::optional(new_layer()) : std::nullopt, !update_.trust_sources});
        layers_ = sources.layers();
        const LayerInfo added = layers_[new_layer()];
        layers_.erase(layers_.begin() + (update_.at - 1));
        old.check(layers_);
        layers_.insert(layers_.begin() + (update_.at - 1), added);
        if (build.mode != Mode::interpolating) return build_anew(build);
        try {
            return from_closure(build, sources, contents);
        } catch (const ClosureTooLarge&) {
            return build_anew(build);
        }
    }

  private:
    std::size_t new_layer() const { return static_cast<std::size_t>(update_.at - 1); }

    UpdateReport from_closure(const BuildOptions& build, const SourceStack& sources,
                              const FileContents& contents) {
        progress_.begin(BuildStage::planning, 0);
        RefinedLevels before = levels_of(contents);
        UpdateReport report;
        const UpdatePlan plan = plan_of(build, sources, before, report);
        report.plan = describe_plan(sources, plan.levels, 1 << build.log2_cells);
        report.plan.layers = layers_;
        if (local_)
            report.plan.source_samples =
                recorded_.source_samples + report.plan.layers[new_layer()].valid_samples;
        check_diamonds(report.plan.refined, memory_);
        UpdateState state{contents, *file_, std::move(before), plan, {}, {}};
        report.added = total(plan.added);
        report.removed = total(plan.removed);
        const double quantum = *build.quantum;
        const std::int32_t radius = quantizer_radius(build.tolerance, quantum);
        const int n = (1 << build.log2_cells) + 1;
        FaceHeights faces;
        for (int face = 0; face < kFaces; ++face) {
            const auto f = static_cast<std::size_t>(face);
            state.roots_before[f] = file_->root(face).values;
            faces[f] = sample_face(sources, quantum, n, face);
        }
        const EncodedRoots roots = encode_roots(faces, n, radius);
        state.roots = roots.heights;
        const OutputJob job{build, sources, quantum, radius, progress_, share_memory(memory_).heights};
        const std::size_t layer = new_layer();
        UpdateClosure closure(
            job, state, [&](DiamondId d) { return everywhere_ || sources.may_touch(layer, d); },
            share_memory(memory_).heights);
        progress_.begin(BuildStage::coding, report.plan.refined);
        closure.code();
        progress_.begin(BuildStage::summarising, report.plan.refined);
        closure.summarise();
        progress_.begin(BuildStage::writing, report.plan.refined);
        report.recoded = closure.recoded();
        report.changed = closure.changed();
        report.copied = report.plan.refined - closure.changed();
        report.summaries = closure.summaries();
        if (local_) report.plan.shares = shares_now(recorded_.shares, layer, state, closure, sources);
        report.file_bytes =
            write_output(job, report.plan, report.certification, roots, closure.diamonds(),
                         [&](std::size_t k, std::vector<std::byte>& out) { closure.blob(k, out); },
                         report.errors, {&contents, [&](std::size_t k) { return closure.unchanged(k); }});
        report.source_tiles = sources.reads().tiles;
        report.tile_reads = sources.reads().reads;
        report.stage_seconds = progress_.stage_seconds();
        return report;
    }

    UpdatePlan plan_of(const BuildOptions& build, const SourceStack& sources, const RefinedLevels& before,
                       UpdateReport& report) {
        if (local_) return plan_update(build, sources, new_layer(), before, progress_);
        RefinedLevels levels = plan_depth(build, sources, progress_);
        if (build.certify) report.certification = certify_depth(build, sources, levels, progress_);
        return whole_update(std::move(levels), before);
    }

    UpdateReport build_anew(const BuildOptions& build) const {
        const BuildReport built = build_repository(build, callback_);
        UpdateReport report;
        report.plan = built.plan;
        report.full = true;
        report.recoded = report.changed = built.plan.refined;
        report.summaries = 2 * built.plan.refined;
        report.file_bytes = built.file_bytes;
        report.certification = built.certification;
        report.errors = built.errors;
        report.stage_seconds = built.stage_seconds;
        return report;
    }

    const UpdateOptions& update_;
    const ProgressFunction& callback_;
    ProgressReporter progress_;
    std::shared_ptr<const Repository> file_;
    Provenance recorded_;
    std::size_t memory_ = 0;
    std::vector<LayerInfo> layers_;
    bool everywhere_ = false;  // the base height changes
    bool local_ = false;       // old layers are looked at near the new one only
};

}  // namespace

UpdateReport update_repository(const UpdateOptions& options, const ProgressFunction& progress) {
    const auto started = std::chrono::steady_clock::now();
    const auto threads = limit_threads(options.threads);
    UpdateReport report = Update(options, progress).run();
    report.peak_memory_bytes = peak_memory_bytes();
    report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - started).count();
    return report;
}

}  // namespace carat
