#include "build_finished.hpp"

#include <algorithm>
#include <cmath>

#include "build_workspace.hpp"
#include "carat/codec/codec.hpp"
#include "carat/codec/quantize.hpp"
#include "carat/globe/error.hpp"
#include "carat/preprocess/provenance.hpp"
#include "step_store.hpp"

namespace carat {
namespace {

namespace fs = std::filesystem;

// Null if it is no repository.
std::shared_ptr<const Repository> open_output(const fs::path& path) {
    try {
        return Repository::open(path);
    } catch (const Error&) {
        return nullptr;
    }
}

bool same_heights(const RepositoryHeader& h, const BuildOptions& o) {
    if (h.log2_cells != o.log2_cells || h.vertical_datum != o.vertical_datum || h.body_a != o.body.a() ||
        h.body_b != o.body.b())
        return false;
    if (o.rms) return h.rms_tolerance == std::min(*o.rms, h.tolerance);  // the step hangs on the data
    return h.rms_tolerance == 0 && h.tolerance == o.tolerance &&
           h.quantum == o.quantum.value_or(default_quantum(o.tolerance));
}

bool same_coding(const RepositoryHeader& h, const BuildOptions& o) {
    const bool range = o.coding.coder == CoderId::range;
    return (h.coder == "range") == range && (!h.fitted_tables || o.fit_tables);
}

}  // namespace

std::optional<BuildReport> finished_before(const BuildOptions& options, const BuildPlan& plan,
                                           const std::optional<Certification>& certification) {
    const std::shared_ptr<const Repository> file = open_output(options.output);
    if (!file) return std::nullopt;
    const RepositoryHeader& h = file->header();
    if (h.refined_diamonds != plan.refined || !same_heights(h, options) || !same_coding(h, options) ||
        !same_build(h.provenance, options, plan, certification))
        return std::nullopt;
    if (const fs::path folder = temporary_folder(options); fs::exists(folder))
        StepStore(folder, 0, false, 0).remove();
    const Provenance recorded = parse_provenance(h.provenance);
    BuildReport report;
    report.already_complete = true;
    report.plan = plan;
    report.plan.shares = recorded.shares;
    for (const LayerShare& s : recorded.shares) {
        report.zero_diamonds += s.zero;
        report.coded_diamonds += s.refined - s.zero;
    }
    report.file_bytes = fs::file_size(options.output);
    report.tolerance = h.tolerance;
    report.max_error = report.rms_error = std::nan("");
    report.certification = certification;
    report.errors = recorded.errors;
    return report;
}

}  // namespace carat
