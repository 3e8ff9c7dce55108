// How far numbers hold: what the vertex shader computes against the exact place in long double, over eyes,
// places, levels, tolerances, reliefs and bodies. No GPU.
//
//   reference   vertex_position.hpp's formula and the camera in long double (64 bits of mantissa), with the
//               C library's tangent; the test compares it with GeographicLib
//   error       of the position relative to the eye, metres; the eye is what the camera holds
//   bound       position_bound(): rounding to length units, and 2^-24 a float operation
//   pixels      the error seen from its distance with 1000 pixels a radian (1080 rows and 57 degrees)
#pragma once

#include <string>
#include <vector>

#include "carat/globe/ellipsoid.hpp"
#include "carat/globe/lattice.hpp"
#include "carat/render/patch_mesh.hpp"

namespace carat::bench {

using LongVec3 = std::array<long double, 3>;

// Metres, body frame. height above the ellipsoid along the geodetic normal.
LongVec3 reference_position(const Ellipsoid& body, const LatticePoint& p, long double height);

// Metres: greatest error of a vertex at this distance from the eye.
double position_bound(double unit, double distance);

struct StabilityOptions {
    int vertices = 8;  // for each combination
    unsigned seed = 1;
    bool small = false;  // a few values of each dimension, for tests
};

struct StabilityRow {
    std::string body, place;
    double relief = 0, tolerance = 0, altitude = 0;  // metres
    int level = 0;
    double near_error = 0;  // metres: worst within 10 m of the eye; 0 if no vertex was
    double error = 0;       // metres: worst
    double pixels = 0;      // worst
    double share = 0;       // worst, of position_bound()
};
// Relief is limited to a tenth of the body's radius, and levels to those that can be refined.
std::vector<StabilityRow> measure_stability(const StabilityOptions& options = {});

// An eye one metre above the ground that moves sideways in steps of 0.1 mm, and the vertices within 10 m of
// it; micrometres.
struct JitterRow {
    std::string body, place;
    double unit = 0;
    double offset = 0;  // worst distance of the shader's vertex from where the exact eye sees it
    double step = 0;    // worst change of that from one step to the next: how uneven 0.1 mm steps are
    double bound = 0;   // of step: jitter_bound() at 10 m
    double pixels = 0;  // of step, seen from 10 m
};
std::vector<JitterRow> measure_jitter(const StabilityOptions& options = {});
// Metres, for a vertex at this distance: the eye is rounded to whole units and the shader to floats, before
// the step and after.
double jitter_bound(double unit, double distance);

// Pairs of points one behind the other.
struct DepthRow {
    double distance = 0;    // metres along the view axis
    double separation = 0;  // metres: least that was always resolved, of a halving sequence; 0: none was
    std::uint64_t pairs = 0, swapped = 0;  // swapped: the further one stored as the nearer
};
std::vector<DepthRow> measure_depth(const StabilityOptions& options = {});

}  // namespace carat::bench
