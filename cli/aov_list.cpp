#include "aov_list.hpp"

#include <algorithm>
#include <filesystem>
#include <sstream>

#include "carat/globe/error.hpp"

namespace carat::cli {
namespace {

// Appends the channels of a picture of the same size, their names behind a prefix.
void append(Picture& out, const Picture& part, const std::string& prefix) {
    const std::size_t pixels = static_cast<std::size_t>(part.width) * static_cast<std::size_t>(part.height);
    const std::size_t old = out.channels.size(), extra = part.channels.size();
    std::vector<float> values(pixels * (old + extra));
    for (std::size_t k = 0; k < pixels; ++k) {
        const auto at = values.begin() + static_cast<std::ptrdiff_t>(k * (old + extra));
        std::copy_n(out.values.begin() + static_cast<std::ptrdiff_t>(k * old), old, at);
        std::copy_n(part.values.begin() + static_cast<std::ptrdiff_t>(k * extra), extra,
                    at + static_cast<std::ptrdiff_t>(old));
    }
    out.width = part.width;
    out.height = part.height;
    for (const std::string& name : part.channels) out.channels.push_back(prefix + name);
    out.values = std::move(values);
}

// Level of the diamond drawn at each pixel, -1 for the background.
Picture levels(const Frame& frame) {
    Picture out{frame.colour.width, frame.colour.height, {"Y"}, {}};
    out.values.reserve(frame.patch.size());
    for (const std::uint64_t entry : frame.patch)
        out.values.push_back(entry == kNoPatch ? -1.0f
                                               : static_cast<float>(half_of_pixel(entry).diamond.level()));
    return out;
}

// R, G, B: the background is opaque in pictures for the eye.
Picture without_coverage(const Picture& colour) {
    constexpr std::size_t kColours = 3;
    Picture out{colour.width, colour.height, {"R", "G", "B"}, {}};
    const std::size_t channels = colour.channels.size();
    out.values.reserve(colour.values.size() / channels * kColours);
    for (std::size_t k = 0; k < colour.values.size(); ++k)
        if (k % channels < kColours) out.values.push_back(colour.values[k]);
    return out;
}

}  // namespace

bool is_exr(const std::string& path) { return std::filesystem::path(path).extension() == ".exr"; }

AovList AovList::parse(const std::string& text) {
    AovList list;
    list.colour_ = false;
    std::istringstream in(text);
    for (std::string name; std::getline(in, name, ',');) {
        bool* const wanted = name == "color"      ? &list.colour_
                             : name == "depth"    ? &list.depth_
                             : name == "normal"   ? &list.normal_
                             : name == "position" ? &list.position_
                             : name == "height"   ? &list.height_
                             : name == "level"    ? &list.level_
                                                  : nullptr;
        if (wanted == nullptr)
            throw Error(ErrorCode::usage,
                        "\"" + name + "\" is none of color, depth, normal, position, height, level");
        *wanted = true;
    }
    if (!list.colour_ && !list.wanted().any()) throw Error(ErrorCode::usage, "names no picture");
    return list;
}

void AovList::check_output(const std::string& path) const {
    if (wanted().any() && !is_exr(path))
        throw Error(ErrorCode::usage, path + ": --aov other than color needs an .exr file");
}

Aovs AovList::wanted() const { return {depth_, position_, normal_, height_, level_}; }

Picture AovList::assemble(const Frame& frame, const std::string& path) const {
    Picture out;
    if (colour_) append(out, is_exr(path) ? frame.colour : without_coverage(frame.colour), "");
    if (depth_) append(out, frame.depth, "");
    if (normal_) append(out, frame.normal, "normal.");
    if (position_) append(out, frame.position, "position.");
    if (height_) append(out, frame.height, "height.");
    if (level_) append(out, levels(frame), "level.");
    return out;
}

}  // namespace carat::cli
