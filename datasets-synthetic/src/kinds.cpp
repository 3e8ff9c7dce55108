#include "kinds.hpp"

#include "carat/globe/error.hpp"

namespace carat::synth {
namespace {

constexpr std::array kTable{
    KindInfo{Kind::earth, "earth",
             "Earth-like world: global raster, 3\" inset with voids, 0.5\" coast, 10 m inset in UTM"},
    KindInfo{Kind::moon, "moon",
             "cratered sphere of the Moon's radius: global raster, inset of 128 px/degree"},
    KindInfo{Kind::spikes, "spikes", "8 km spikes on both poles and along the antimeridian"},
    KindInfo{Kind::cliff, "cliff", "cliffs of at least 10 km along all edges of the equi-angular cube"},
    KindInfo{Kind::checkerboard, "checkerboard", "+-1000 m alternating from pixel to pixel"},
    KindInfo{Kind::constant, "constant", "one height everywhere"},
    KindInfo{Kind::nodata, "nodata", "nothing but NODATA"},
    KindInfo{Kind::nonfinite, "nonfinite", "NaN and both infinities sprinkled in, no NODATA value declared"},
    KindInfo{Kind::int16, "int16", "-32768 and 32767 as real heights, no NODATA value declared"},
    KindInfo{Kind::onepixel, "onepixel", "a raster of one pixel"},
    KindInfo{Kind::overlap, "overlap", "three overlapping layers of equal resolution that disagree by 100 m"},
    KindInfo{Kind::antimeridian, "antimeridian", "rasters across 180 degrees, in degrees and in UTM"},
    KindInfo{Kind::polar, "polar", "rasters that hold a pole, in polar stereographic projection"},
    KindInfo{Kind::rotated, "rotated", "a raster whose geotransform is rotated by 30 degrees"},
    KindInfo{Kind::empty, "empty", "a file of 0 bytes"},
    KindInfo{Kind::truncated, "truncated", "GeoTIFFs cut in the header and in the data"},
    KindInfo{Kind::hostile, "hostile", "all of the above from spikes on, in one directory"},
};

}  // namespace

std::span<const KindInfo> kinds() { return kTable; }

const KindInfo& info_of(Kind kind) { return kTable[static_cast<std::size_t>(kind)]; }

Kind kind_of(const std::string& name) {
    std::string known;
    for (const KindInfo& k : kTable) {
        if (name == k.name) return k.kind;
        known += known.empty() ? k.name : std::string(", ") + k.name;
    }
    throw Error(ErrorCode::usage, "unknown kind '" + name + "'; known are " + known);
}

Ellipsoid body_of(Kind kind) { return kind == Kind::moon ? Ellipsoid::moon() : Ellipsoid::earth(); }

}  // namespace carat::synth
