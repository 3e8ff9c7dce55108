#include "error_report.hpp"

#include <fmt/core.h>

#include <algorithm>

#include "text.hpp"

namespace carat::cli {
namespace {

void print_row(const std::string& name, const ErrorStats& s) {
    if (s.count == 0) return;
    fmt::print("  {:<28} {:>13} {:>10.4g} {:>10.4g} {:>10.3g} {:>9.4g} {:>9.4g} {:>9.4g} {:>9.4g}\n", name,
               grouped(s.count), s.max, s.rms, s.mean, s.p50, s.p90, s.p99, s.p999);
}

}  // namespace

void print_errors(const ErrorSummary& errors, std::size_t places) {
    fmt::print("error at source samples, metres (surface - source; it contains what resampling costs)\n");
    fmt::print("  {:<28} {:>13} {:>10} {:>10} {:>10} {:>9} {:>9} {:>9} {:>9}\n", "layer", "samples",
               "greatest", "RMS", "mean", "50 %", "90 %", "99 %", "99.9 %");
    for (const LayerErrors& l : errors.layers) {
        print_row(l.name, l.compared);
        print_row("  in blended zones", l.blended);
        if (l.hidden > 0) fmt::print("  {:<28} {:>13}\n", "  hidden by other layers", grouped(l.hidden));
    }
    if (errors.layers.size() > 1) print_row("all", errors.all);
    for (const LayerErrors& l : errors.layers)
        for (std::size_t k = 0; k < std::min(places, l.worst.size()); ++k) {
            const WorstPlace& w = l.worst[k];
            fmt::print("  {} {}: {:.7f} {:.7f}: source {:.3f}, surface {:.3f}, {:+.3f}\n",
                       k == 0 ? "worst in" : "        ", k == 0 ? l.name : std::string(l.name.size(), ' '),
                       w.latitude, w.longitude, w.source, w.surface, w.surface - w.source);
        }
}

nlohmann::ordered_json errors_json(const ErrorSummary& errors) {
    return nlohmann::ordered_json::parse(to_json(errors));
}

}  // namespace carat::cli
