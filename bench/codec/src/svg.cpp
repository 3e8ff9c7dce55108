#include "carat/bench/svg.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace carat::bench {
namespace {

constexpr double kWidth = 430, kHeight = 360, kLeft = 58, kTop = 34, kRight = 118, kBottom = 44;
constexpr double kInnerWidth = kWidth - kLeft - kRight, kInnerHeight = kHeight - kTop - kBottom;
constexpr const char* kColours[] = {"#c0392b", "#d35400", "#8e44ad", "#2471a3", "#1e8449", "#7d6608",
                                    "#117a65", "#5d6d7e", "#a93226", "#2e4053", "#b7950b", "#6c3483"};

// Text of any file or codec name inside markup.
std::string escaped(const std::string& text) {
    std::string out;
    for (const char c : text)
        out += c == '<' ? "&lt;" : c == '>' ? "&gt;" : c == '&' ? "&amp;" : std::string(1, c);
    return out;
}

struct LogAxis {
    double low, high;

    double place(double v) const {
        return (std::log10(v) - std::log10(low)) / (std::log10(high) - std::log10(low));
    }
    // 1, 2, 5 times powers of ten inside.
    std::vector<double> ticks() const {
        std::vector<double> out;
        for (double decade = std::pow(10, std::floor(std::log10(low))); decade <= high; decade *= 10)
            for (const double k : {1.0, 2.0, 5.0})
                if (k * decade >= low * 0.999 && k * decade <= high * 1.001) out.push_back(k * decade);
        return out;
    }
};

LogAxis axis_of(const Plot& plot, std::vector<double> PlotSeries::*values) {
    double low = std::numeric_limits<double>::infinity(), high = 0;
    for (const PlotSeries& s : plot.series)
        for (const double v : s.*values)
            if (v > 0) {
                low = std::min(low, v);
                high = std::max(high, v);
            }
    if (!(high > 0)) return {1, 10};
    return {low / 1.15, high * 1.15};
}

std::string text(double x, double y, const std::string& anchor, const std::string& words,
                 const char* extra = "") {
    return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\"{}>{}</text>\n", x, y, anchor,
                       extra, escaped(words));
}

std::string grid(const LogAxis& x, const LogAxis& y) {
    std::string out;
    for (const double t : x.ticks()) {
        const double at = kLeft + x.place(t) * kInnerWidth;
        out += fmt::format("<path d=\"M{:.1f} {:.1f}V{:.1f}\" stroke=\"#ddd\"/>\n", at, kTop,
                           kTop + kInnerHeight);
        out += text(at, kTop + kInnerHeight + 15, "middle", fmt::format("{:g}", t));
    }
    for (const double t : y.ticks()) {
        const double at = kTop + (1 - y.place(t)) * kInnerHeight;
        out += fmt::format("<path d=\"M{:.1f} {:.1f}H{:.1f}\" stroke=\"#ddd\"/>\n", kLeft, at,
                           kLeft + kInnerWidth);
        out += text(kLeft - 5, at + 4, "end", fmt::format("{:g}", t));
    }
    return out;
}

std::string curve(const PlotSeries& s, const LogAxis& x, const LogAxis& y, const char* colour) {
    std::string path, dots;
    for (std::size_t k = 0; k < s.x.size(); ++k) {
        if (!(s.x[k] > 0) || !(s.y[k] > 0)) continue;
        const double px = kLeft + x.place(s.x[k]) * kInnerWidth,
                     py = kTop + (1 - y.place(s.y[k])) * kInnerHeight;
        path += fmt::format("{}{:.1f} {:.1f}", path.empty() ? "M" : "L", px, py);
        dots += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{}\"/>", px, py, s.strong ? 3.5 : 2.2);
    }
    return fmt::format(
        "<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{}\"/>\n<g fill=\"{}\">{}</g>\n", path,
        colour, s.strong ? 2.6 : 1.2, colour, dots);
}

std::string plot_markup(const Plot& plot) {
    const LogAxis x = axis_of(plot, &PlotSeries::x), y = axis_of(plot, &PlotSeries::y);
    std::string out = grid(x, y);
    out += fmt::format("<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"none\" stroke=\"#555\"/>\n",
                       kLeft, kTop, kInnerWidth, kInnerHeight);
    double legend = kTop + 8;
    for (std::size_t k = 0; k < plot.series.size(); ++k) {
        const PlotSeries& s = plot.series[k];
        const char* colour = kColours[k % std::size(kColours)];
        out += curve(s, x, y, colour);
        out += fmt::format("<path d=\"M{:.0f} {:.0f}h14\" stroke=\"{}\" stroke-width=\"{}\"/>\n",
                           kWidth - kRight + 6, legend - 4, colour, s.strong ? 2.6 : 1.2);
        out += text(kWidth - kRight + 24, legend, "start", s.name, s.strong ? " font-weight=\"bold\"" : "");
        legend += 16;
    }
    out += text(kLeft, 20, "start", plot.title, " font-weight=\"bold\"");
    out += text(kLeft + kInnerWidth / 2, kHeight - 10, "middle", plot.x_label);
    out += fmt::format("<g transform=\"translate(14 {:.1f}) rotate(-90)\">{}</g>\n", kTop + kInnerHeight / 2,
                       text(0, 0, "middle", plot.y_label));
    return out;
}

}  // namespace

std::string svg_of(const std::vector<Plot>& plots) {
    const double width = kWidth * static_cast<double>(plots.size());
    std::string out = fmt::format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0:.0f} {1:.0f}\" width=\"{0:.0f}\" "
        "height=\"{1:.0f}\" "
        "font-family=\"sans-serif\" font-size=\"11\">\n<rect width=\"100%\" height=\"100%\" "
        "fill=\"white\"/>\n",
        width, kHeight);
    for (std::size_t k = 0; k < plots.size(); ++k)
        out += fmt::format("<g transform=\"translate({:.0f} 0)\">\n{}</g>\n", kWidth * static_cast<double>(k),
                           plot_markup(plots[k]));
    return out + "</svg>\n";
}

}  // namespace carat::bench
