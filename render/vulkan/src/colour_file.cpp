// Colour files: GDAL's colour-relief text and GMT's colour palette tables.
#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <optional>
#include <sstream>

#include "carat/globe/error.hpp"
#include "carat/vulkan/colour_table.hpp"

namespace carat {

namespace {

using Rgb = std::array<std::uint8_t, 3>;

// Of gdaldem; GMT knows these and many more.
const std::map<std::string, Rgb>& named_colours() {
    static const std::map<std::string, Rgb> colours{
        {"white", {255, 255, 255}}, {"black", {0, 0, 0}},      {"red", {255, 0, 0}},
        {"green", {0, 255, 0}},     {"blue", {0, 0, 255}},     {"yellow", {255, 255, 0}},
        {"magenta", {255, 0, 255}}, {"cyan", {0, 255, 255}},   {"aqua", {0, 191, 191}},
        {"grey", {191, 191, 191}},  {"gray", {191, 191, 191}}, {"orange", {255, 127, 0}},
        {"brown", {127, 63, 0}},    {"purple", {127, 0, 255}}, {"violet", {127, 0, 255}},
        {"indigo", {0, 0, 127}}};
    return colours;
}

std::string lower(std::string text) {
    for (char& c : text)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    return text;
}

std::optional<double> number(const std::string& word) {
    std::istringstream in(word);
    double value = 0;
    if (!(in >> value) || in.peek() != std::istringstream::traits_type::eof() || !std::isfinite(value))
        return std::nullopt;
    return value;
}

std::vector<std::string> split(std::string line, const std::string& separators) {
    for (char& c : line)
        if (separators.find(c) != std::string::npos) c = ' ';
    std::istringstream in(line);
    std::vector<std::string> words;
    for (std::string word; in >> word;) words.push_back(word);
    return words;
}

class Reader {
  public:
    explicit Reader(const std::string& path) : path_(path), in_(path) {
        if (!in_) throw Error(ErrorCode::io, path + ": cannot be opened");
    }

    ColourTable read() {
        table_.name = path_;
        std::string line;
        while (std::getline(in_, line)) {
            ++line_;
            if (!line.empty() && line.back() == '\r') line.pop_back();
            if (!line.empty() && line[0] == '#') {
                comment(line);
            } else {
                stops(line);
            }
        }
        if (in_.bad()) throw Error(ErrorCode::io, path_ + ": cannot be read");
        if (table_.land.empty()) throw Error(ErrorCode::corrupt, path_ + ": no line gives a colour");
        stretch();
        sort();
        split_at_the_shore();
        check_colours(table_);
        return std::move(table_);
    }

  private:
    [[noreturn]] void refuse(const std::string& why, ErrorCode code = ErrorCode::corrupt) const {
        throw Error(code, path_ + ", line " + std::to_string(line_) + ": " + why);
    }

    // GMT keeps its settings in comments.
    void comment(const std::string& line) {
        const std::vector<std::string> words = split(line.substr(1), "=/ \t");
        const std::string key = words.empty() ? "" : lower(words[0]);
        if (key == "color_model" && words.size() > 1 && lower(words[1]) != "rgb" && lower(words[1]) != "+rgb")
            refuse("colours of the model " + words[1] + "; only RGB is read", ErrorCode::unsupported);
        if (key == "range" && words.size() > 2) {
            const auto low = number(words[1]), high = number(words[2]);
            if (low && high) range_ = {*low, *high};
        }
        if (key == "hinge" || key == "hard_hinge" || key == "soft_hinge") hinged_ = true;
    }

    std::uint8_t component(double value) const {
        if (!(value >= 0 && value <= 255)) refuse("a colour's components are 0 to 255");
        return static_cast<std::uint8_t>(std::lround(value));
    }

    // "12/34/56", "#0c2238", a name or a grey.
    std::optional<Rgb> one_word(const std::string& word) const {
        if (const auto named = named_colours().find(lower(word)); named != named_colours().end())
            return named->second;
        if (word.size() == 7 && word[0] == '#' &&
            word.find_first_not_of("0123456789abcdefABCDEF", 1) == std::string::npos) {
            const unsigned long code = std::stoul(word.substr(1), nullptr, 16);
            return Rgb{static_cast<std::uint8_t>(code >> 16), static_cast<std::uint8_t>(code >> 8 & 255),
                       static_cast<std::uint8_t>(code & 255)};
        }
        if (word.find('/') != std::string::npos) {
            const std::vector<std::string> parts = split(word, "/");
            return parts.size() == 3 ? three(parts, 0) : std::nullopt;
        }
        if (const auto grey = number(word)) return Rgb{component(*grey), component(*grey), component(*grey)};
        return std::nullopt;
    }

    std::optional<Rgb> three(const std::vector<std::string>& words, std::size_t at) const {
        Rgb out{};
        for (std::size_t k = 0; k < 3; ++k) {
            const auto value = at + k < words.size() ? number(words[at + k]) : std::nullopt;
            if (!value) return std::nullopt;
            out[k] = component(*value);
        }
        return out;
    }

    Rgb colour(const std::vector<std::string>& words, std::size_t at, std::size_t count) const {
        const auto found = count >= 3 ? three(words, at) : one_word(words[at]);
        if (!found) refuse("\"" + words[at] + "\" is no colour that is known here");
        return *found;
    }

    void add(double height, const Rgb& srgb) { table_.land.back().stops.push_back({height, srgb}); }

    void stops(const std::string& line) {
        std::vector<std::string> words = split(line.substr(0, line.find(';')), ", \t:");
        if (words.empty()) return;
        const std::string first = lower(words[0]);
        if (first == "latitude") return new_band(words);
        if (first == "nv" || first == "b" || first == "f" || first == "n") return;  // no data, below, above
        if (first.back() == '%')
            refuse("percentages are relative to a raster, of which nothing is known here",
                   ErrorCode::unsupported);
        const auto height = number(words[0]);
        if (!height) refuse("\"" + words[0] + "\" is no height");
        if (table_.land.empty()) table_.land.push_back({0, {}});
        const std::string last = lower(words.back());
        if (words.size() > 4 && (last == "l" || last == "u" || last == "b")) words.pop_back();
        const bool numbers = std::all_of(words.begin(), words.end(), [](const auto& w) { return number(w); });
        if (words.size() == 4 && !numbers) return segment(words, 1);
        if (words.size() == 8) return segment(words, 3);
        if (words.size() == 2) return add(*height, colour(words, 1, 1));
        if (words.size() == 4 || words.size() == 5) return add(*height, colour(words, 1, 3));  // 5: opacity
        refuse("neither \"height red green blue\" nor \"height colour height colour\"");
    }

    // GMT: from one height to the next, each with a colour of `count` words.
    void segment(const std::vector<std::string>& words, std::size_t count) {
        const auto low = number(words[0]), high = number(words[count + 1]);
        if (!low || !high || !(*low < *high)) refuse("the heights of a segment must ascend");
        add(*low, colour(words, 1, count));
        add(*high, colour(words, count + 2, count));
    }

    void new_band(const std::vector<std::string>& words) {
        const auto latitude = words.size() == 2 ? number(words[1]) : std::nullopt;
        if (!latitude || !(std::abs(*latitude) <= 90)) refuse("\"latitude\" wants degrees from -90 to 90");
        table_.land.push_back({*latitude, {}});
    }

    // Heights from -1 to 1 (or 0 to 1) that a RANGE stretches; with a hinge both sides of 0 by themselves.
    void stretch() {
        if (!range_) return;
        for (const ColourBand& band : table_.land)
            for (const ColourStop& s : band.stops)
                if (std::abs(s.height) > 1) return;
        for (ColourBand& band : table_.land)
            for (ColourStop& s : band.stops) {
                const auto [low, high] = *range_;
                if (hinged_)
                    s.height *= s.height < 0 ? -low : high;
                else
                    s.height = low + (high - low) * s.height;
            }
    }

    void sort() {
        std::sort(table_.land.begin(), table_.land.end(),
                  [](const ColourBand& l, const ColourBand& r) { return l.latitude < r.latitude; });
        for (ColourBand& band : table_.land) {
            std::vector<ColourStop>& s = band.stops;
            std::stable_sort(s.begin(), s.end(),
                             [](const ColourStop& l, const ColourStop& r) { return l.height < r.height; });
            // The colour from below and the colour from above stay, whatever a file has between.
            std::vector<ColourStop> kept;
            for (std::size_t k = 0; k < s.size(); ++k) {
                const bool again = k > 0 && s[k].height == s[k - 1].height;
                if (again && s[k].srgb == kept.back().srgb) continue;
                if (again && kept.size() > 1 && kept[kept.size() - 2].height == s[k].height) kept.pop_back();
                kept.push_back(s[k]);
            }
            s = std::move(kept);
        }
    }

    // A jump of the colour at height 0 is a shore: below it begins the sea. Any other jump becomes steep.
    void split_at_the_shore() {
        const auto jumps_at_zero = [](const ColourBand& band) {
            for (std::size_t k = 1; k < band.stops.size(); ++k)
                if (band.stops[k].height == 0 && band.stops[k - 1].height == 0)
                    return k > 1 && k + 1 < band.stops.size();
            return false;
        };
        const bool shore = std::all_of(table_.land.begin(), table_.land.end(), jumps_at_zero);
        if (shore) {
            table_.sea_level = 0;
            for (ColourBand& band : table_.land) {
                const auto above = std::find_if(band.stops.begin(), band.stops.end(),
                                                [](const ColourStop& s) { return s.height >= 0; }) +
                                   1;
                table_.sea.push_back({band.latitude, {band.stops.begin(), above}});
                band.stops.erase(band.stops.begin(), above);
            }
        }
        for (auto* bands : {&table_.sea, &table_.land})
            for (ColourBand& band : *bands)
                for (std::size_t k = 1; k < band.stops.size(); ++k)
                    if (!(band.stops[k - 1].height < band.stops[k].height))
                        band.stops[k].height = std::nextafter(band.stops[k - 1].height, INFINITY);
    }

    const std::string path_;
    std::ifstream in_;
    int line_ = 0;
    ColourTable table_;
    std::optional<std::array<double, 2>> range_;
    bool hinged_ = false;
};

}  // namespace

ColourTable read_colours(const std::string& path) { return Reader(path).read(); }

}  // namespace carat
