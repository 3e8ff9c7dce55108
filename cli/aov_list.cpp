#include "aov_list.hpp"

#include <fmt/core.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <sstream>

#include "carat/globe/error.hpp"

namespace carat::cli {
namespace {

// Pictures of one size, one after the other in the channels of one.
class Layers {
  public:
    void add(const Picture& part, const std::string& prefix) {
        parts_.push_back(&part);
        for (const std::string& name : part.channels) names_.push_back(prefix + name);
    }

    Picture interleaved() const {
        Picture out{parts_.at(0)->width, parts_[0]->height, names_, {}, {}};
        const auto rows = static_cast<std::size_t>(out.height), width = static_cast<std::size_t>(out.width);
        out.values.resize(rows * width * names_.size());
        tbb::parallel_for(std::size_t{0}, rows, [&](std::size_t y) {
            float* to = out.values.data() + y * width * names_.size();
            for (std::size_t x = 0; x < width; ++x)
                for (const Picture* part : parts_)
                    to = std::copy_n(part->at(static_cast<int>(x), static_cast<int>(y)),
                                     part->channels.size(), to);
        });
        return out;
    }

  private:
    std::vector<const Picture*> parts_;
    std::vector<std::string> names_;
};

// R, G, B: the background is opaque in pictures for the eye.
Picture without_coverage(const Picture& colour) {
    constexpr std::size_t kColours = 3;
    Picture out{colour.width, colour.height, {"R", "G", "B"}, {}, {}};
    const std::size_t channels = colour.channels.size();
    out.values.reserve(colour.values.size() / channels * kColours);
    for (std::size_t k = 0; k < colour.values.size(); ++k)
        if (k % channels < kColours) out.values.push_back(colour.values[k]);
    return out;
}

// A picture made of each pixel's number alone: value(pixel, out) fills the channels.
template <class Value>
Picture by_pixel(const Frame& frame, std::vector<std::string> channels, const Value& value) {
    Picture out{frame.colour.width, frame.colour.height, std::move(channels), {}, {}};
    const std::size_t count = out.channels.size(), width = static_cast<std::size_t>(out.width);
    out.values.resize(width * static_cast<std::size_t>(out.height) * count);
    tbb::parallel_for(std::size_t{0}, static_cast<std::size_t>(out.height), [&](std::size_t y) {
        for (std::size_t k = y * width; k < (y + 1) * width; ++k) value(k, &out.values[k * count]);
    });
    return out;
}

// The facts of the patch drawn at a pixel; null for the background.
class FactsOfPixels {
  public:
    FactsOfPixels(const Frame& frame, const DrawList& list) : frame_(frame), list_(list) {}

    const PatchFacts* operator()(std::size_t pixel) const {
        if (frame_.patch[pixel] == kNoPatch) return nullptr;
        const Half half = half_of_pixel(frame_.patch[pixel]);
        const auto at = std::lower_bound(list_.meshes.begin(), list_.meshes.end(), half,
                                         [](const auto& mesh, const Half& h) { return mesh->half < h; });
        return &list_.facts[static_cast<std::size_t>(at - list_.meshes.begin())];
    }

  private:
    const Frame& frame_;
    const DrawList& list_;
};

Picture levels(const Frame& frame) {
    return by_pixel(frame, {"Y"}, [&](std::size_t k, float* out) {
        *out = frame.patch[k] == kNoPatch ? -1.0f
                                          : static_cast<float>(half_of_pixel(frame.patch[k]).diamond.level());
    });
}

Picture errors(const Frame& frame, const FactsOfPixels& facts) {
    return by_pixel(frame, {"pixels", "metres"}, [&](std::size_t k, float* out) {
        const PatchFacts* f = facts(k);
        out[0] = f == nullptr ? 0.0f : static_cast<float>(f->error);
        out[1] = f == nullptr ? 0.0f : static_cast<float>(f->delta);
    });
}

Picture sources(const Frame& frame, const FactsOfPixels& facts) {
    return by_pixel(frame, {"Y"}, [&](std::size_t k, float* out) {
        const PatchFacts* f = facts(k);
        *out = f == nullptr ? -1.0f : f->synthesised ? 2.0f : f->is_virtual ? 1.0f : 0.0f;
    });
}

// What a float leaves of a double. In a loop g++ 12 -O3 makes 0 of it: its vectoriser takes (double)(float)x
// for x.
[[gnu::noinline]] float low_part(double x) {
    return static_cast<float>(x - static_cast<double>(static_cast<float>(x)));
}

// Geodetic degrees in two floats each, whose sum is good to 1e-12 degrees.
Picture places(const Frame& frame, const Scene& scene, const std::vector<SeenPoint>& points) {
    const Vec3 eye = to_metres(scene.camera.eye, scene.unit);
    return by_pixel(frame, {"lat", "lon", "lat_low", "lon_low"}, [&](std::size_t k, float* out) {
        if (frame.patch[k] == kNoPatch) return;
        const Vec3& p = points[k].position;
        const Geodetic g =
            geodetic(scene.body.normal_height({eye[0] + p[0], eye[1] + p[1], eye[2] + p[2]}).normal);
        const double degrees[] = {g.latitude, g.longitude};
        for (std::size_t c = 0; c < 2; ++c) {
            out[c] = static_cast<float>(degrees[c]);
            out[c + 2] = low_part(degrees[c]);
        }
    });
}

Picture depths(const Frame& frame, const Scene& scene, const std::vector<SeenPoint>& points) {
    return by_pixel(frame, {"Z"}, [&](std::size_t k, float* out) {
        double z = 0;
        for (std::size_t c = 0; c < 3; ++c) z += scene.camera.forward[c] * points[k].position[c];
        *out = static_cast<float>(z);
    });
}

Picture heights(const Frame& frame, const std::vector<SeenPoint>& points) {
    return by_pixel(frame, {"Y"},
                    [&](std::size_t k, float* out) { *out = static_cast<float>(points[k].height); });
}

// Two pictures whose sum is good to 2^-48.
Picture positions(const Frame& frame, const std::vector<SeenPoint>& points) {
    return by_pixel(frame, {"X", "Y", "Z"}, [&](std::size_t k, float* out) {
        for (std::size_t c = 0; c < 3; ++c) out[c] = static_cast<float>(points[k].position[c]);
    });
}
Picture position_rests(const Frame& frame, const std::vector<SeenPoint>& points) {
    return by_pixel(frame, {"X", "Y", "Z"}, [&](std::size_t k, float* out) {
        for (std::size_t c = 0; c < 3; ++c) out[c] = low_part(points[k].position[c]);
    });
}

using Matrix = std::array<float, 16>;

// OpenEXR's standard attributes, for row vectors. World: the body's axes, metres from the eye. Camera: x
// right, y up, z forward.
Matrix world_to_camera(const Camera& c) {
    Matrix m{};
    for (std::size_t i = 0; i < 3; ++i) {
        m[4 * i] = static_cast<float>(c.right[i]);
        m[4 * i + 1] = static_cast<float>(c.up[i]);
        m[4 * i + 2] = static_cast<float>(c.forward[i]);
    }
    m[15] = 1;
    return m;
}

// To (0, 0) at the top left corner of the picture and (1, 1) at the bottom right; z is near / depth for a
// near plane of 1 m.
Matrix world_to_ndc(const Camera& c) {
    const double vertical = 1 / std::tan(c.vertical_fov / 2), horizontal = vertical * c.height / c.width;
    Matrix m{};
    for (std::size_t i = 0; i < 3; ++i) {
        m[4 * i] = static_cast<float>(0.5 * (c.forward[i] + horizontal * c.right[i]));
        m[4 * i + 1] = static_cast<float>(0.5 * (c.forward[i] - vertical * c.up[i]));
        m[4 * i + 3] = static_cast<float>(c.forward[i]);
    }
    m[14] = 1;
    return m;
}

void describe(Picture& out, const Scene& scene) {
    const Vec3 eye = to_metres(scene.camera.eye, scene.unit);
    const auto say = [&](const char* name, Picture::Attribute value) {
        out.attributes.emplace_back(name, std::move(value));
    };
    say("worldtocamera", world_to_camera(scene.camera));
    say("worldtoscreen", world_to_ndc(scene.camera));
    say("carat:frame",
        std::string("body-fixed: x to 0 N 0 E, z to the north pole; matrices and position from "
                    "carat:origin, row vectors"));
    say("carat:origin", fmt::format("{:.9f} {:.9f} {:.9f}", eye[0], eye[1], eye[2]));
    say("carat:ellipsoid", fmt::format("{} {}", scene.body.a(), scene.body.b()));
    say("carat:verticalFieldOfView", fmt::format("{:.17g}", scene.camera.vertical_fov));
    say("carat:units",
        std::string("Z, position, height, error.metres: metres; position: the sum with position_low; latlon: "
                    "degrees, lat + lat_low; error.pixels: "
                    "pixels; level: of diamonds, -1 background; source: 0 measured, 1 interpolated, 2 "
                    "synthesised, -1 background; R G B: linear Rec. 709"));
}

}  // namespace

bool is_exr(const std::string& path) { return std::filesystem::path(path).extension() == ".exr"; }

AovList AovList::parse(const std::string& text) {
    AovList list;
    list.wanted_ = {};
    std::istringstream in(text);
    for (std::string name; std::getline(in, name, ',');) {
        const auto at = std::find(kNames.begin(), kNames.end(), name);
        if (at == kNames.end()) {
            std::string all;
            for (const char* known : kNames) all += (all.empty() ? "" : ", ") + std::string(known);
            throw Error(ErrorCode::usage, "\"" + name + "\" is none of " + all);
        }
        list.wanted_[static_cast<std::size_t>(at - kNames.begin())] = true;
    }
    if (std::find(list.wanted_.begin(), list.wanted_.end(), true) == list.wanted_.end())
        throw Error(ErrorCode::usage, "names no picture");
    return list;
}

void AovList::check_output(const std::string& path) const {
    if (wanted().any() && !is_exr(path))
        throw Error(ErrorCode::usage, path + ": --aov other than color needs an .exr file");
}

Aovs AovList::wanted() const {
    Aovs out;
    out.normal = has(normal);
    out.patch = has(level) || has(error) || has(source) || has_points();
    return out;
}

Picture AovList::assemble(const Frame& frame, const Scene& scene, const std::string& path) const {
    if (!is_exr(path)) return without_coverage(frame.colour);
    const FactsOfPixels facts(frame, scene.list);
    const Picture none;
    std::vector<SeenPoint> points;
    if (has_points()) points = seen_points(frame, scene.camera, scene.unit, scene.cells, scene.list.meshes);
    const Picture distance = has(depth) ? depths(frame, scene, points) : none;
    const Picture point = has(position) ? positions(frame, points) : none;
    const Picture point_low = has(position) ? position_rests(frame, points) : none;
    const Picture elevation = has(height) ? heights(frame, points) : none;
    const Picture place = has(latlon) ? places(frame, scene, points) : none;
    const Picture bound = has(error) ? errors(frame, facts) : none;
    const Picture depth_in_file = has(level) ? levels(frame) : none;
    const Picture origin = has(source) ? sources(frame, facts) : none;
    Layers layers;
    if (has(color)) layers.add(frame.colour, "");
    if (has(depth)) layers.add(distance, "");
    if (has(normal)) layers.add(frame.normal, "normal.");
    if (has(position)) layers.add(point, "position.");
    if (has(position)) layers.add(point_low, "position_low.");
    if (has(height)) layers.add(elevation, "height.");
    if (has(latlon)) layers.add(place, "latlon.");
    if (has(error)) layers.add(bound, "error.");
    if (has(level)) layers.add(depth_in_file, "level.");
    if (has(source)) layers.add(origin, "source.");
    Picture out = layers.interleaved();
    describe(out, scene);
    return out;
}

}  // namespace carat::cli
