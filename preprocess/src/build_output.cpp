#include "build_output.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <stdexcept>

#include "carat/preprocess/provenance.hpp"
#include "measure_blocks.hpp"

namespace carat {
namespace {

std::vector<LayerShare> shares_of(const SourceStack& sources, std::span<const DiamondEntry> diamonds) {
    const std::size_t layers = sources.layers().size();
    std::vector<std::int8_t> layer(diamonds.size());
    tbb::parallel_for(std::size_t{0}, diamonds.size(), [&](std::size_t k) {
        layer[k] = static_cast<std::int8_t>(sources.layer_near(direction(diamonds[k].id.centre())));
    });
    std::vector<LayerShare> out(layers + 1);
    for (std::size_t k = 0; k < diamonds.size(); ++k) {
        LayerShare& s = out[layer[k] == kBaseLayer ? layers : static_cast<std::size_t>(layer[k])];
        ++s.refined;
        if (diamonds[k].blob_bytes == 0) ++s.zero;
        s.residual_bytes += diamonds[k].blob_bytes;
    }
    return out;
}

// Compares the file, complete but for this, with the sources.
ErrorSummary measure_file(const OutputJob& job, const BuildPlan& plan,
                          const std::optional<Certification>& certification, RepositoryWriter& writer) {
    std::uint64_t samples = 0;
    for (const LayerInfo& layer : plan.layers) samples += layer.samples;
    const FileSurface surface(Repository::open(writer.complete()), job.cache_bytes);
    job.progress.begin(BuildStage::measuring, samples);
    ErrorSummary errors =
        measure_blocks(job.sources, surface, kRecordedPlaces, [&](std::uint64_t n) { job.progress.step(n); });
    if (certification && certification->reached() && errors.all.max > certification->bound)
        throw std::logic_error("the certified bound does not hold");
    writer.replace_provenance(provenance_json(job.options, plan, &errors, certification));
    return errors;
}

WriterSetup writer_setup(const OutputJob& job, const BuildPlan& plan) {
    WriterSetup setup;
    setup.log2_cells = job.options.log2_cells;
    setup.quantum = job.quantum;
    setup.tolerance = job.options.tolerance;
    setup.body = job.options.body;
    setup.vertical_datum = job.options.vertical_datum;
    setup.provenance = provenance_json(job.options, plan);
    if (job.options.measures()) setup.provenance.resize(measured_room(setup.provenance, plan), ' ');
    setup.coding = job.options.coding;
    setup.rms_tolerance = std::min(job.options.rms.value_or(0), job.options.tolerance);
    setup.radii.assign(plan.refined_by_level.size() + 1, job.radius);
    return setup;
}

}  // namespace

BuildPlan describe_plan(const SourceStack& sources, const RefinedLevels& levels, int cells) {
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

std::uint64_t write_output(const OutputJob& job, BuildPlan& plan,
                           const std::optional<Certification>& certification, const EncodedRoots& roots,
                           std::span<const DiamondEntry> diamonds, const BlobSource& blobs,
                           std::optional<ErrorSummary>& errors, const OldPages& old) {
    if (plan.shares.empty()) plan.shares = shares_of(job.sources, diamonds);
    WriterSetup setup = writer_setup(job, plan);
    constexpr std::uint64_t kIndexBytes = 10;  // of a diamond, about
    setup.expected_bytes = kIndexBytes * diamonds.size() + setup.provenance.size();
    for (const DiamondEntry& d : diamonds) setup.expected_bytes += d.blob_bytes;
    RepositoryWriter writer(job.options.output, std::move(setup), roots);
    writer.write(
        diamonds,
        [&](std::size_t k, std::vector<std::byte>& out) {
            blobs(k, out);
            job.progress.step();
        },
        old);
    if (job.options.measures()) errors = measure_file(job, plan, certification, writer);
    return writer.finish();
}

}  // namespace carat
