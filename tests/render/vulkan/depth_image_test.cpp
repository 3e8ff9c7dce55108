// Surfaces one close above the other, through the whole pipeline: the nearer wins in every pixel.
#include <cmath>
#include <numbers>

#include "carat/globe/globe.hpp"
#include "planet.hpp"

namespace carat::test {
namespace {

constexpr int kCells = 64, kWidth = 160, kHeight = 120;
constexpr double kGround = 800;  // metres

// Surfaces this far apart, metres, measured across, are told apart at a distance (docs/accuracy.md): a device
// may round each vertex to 1/256 pixel both ways, which shifts a slanted surface by up to sqrt(2)/512 pixel;
// depth is a float, from floats, to 1e-6; vertices are rounded to whole units. Each for both surfaces.
double resolution(const Camera& camera, double unit, double distance) {
    return distance * (std::numbers::sqrt2 / (256 * camera.focal_pixels()) + 1e-6) + 2 * unit;
}

struct Found {
    std::uint64_t compared = 0, swapped = 0;
};

class DepthImage : public RendererTest {
  protected:
    const Ellipsoid body = Ellipsoid::earth();
    const double unit = length_unit(body);

    // A half of about that size (metres along its legs) and the place amid it.
    Half half_near(const Geodetic& place, double size) const {
        const double level = 2 * std::log2(body.a() * std::numbers::pi / 2 / size);
        return locate(lattice_position(direction(place)), std::clamp(static_cast<int>(level), 0, 40)).half;
    }
    Geodetic middle(const Half& half) const {
        const HalfFrame frame = half_frame(half, 4);
        return geodetic(direction(half.side == 0 ? frame.vertex(3, 1) : frame.vertex(1, 3)));
    }
    // Under another name, so that it can lie in the same batch.
    std::shared_ptr<const PatchMesh> sheet(const Half& half, double height, bool renamed) const {
        auto mesh =
            std::make_shared<PatchMesh>(*make_mesh(body, half, kCells, [&](const Vec3&) { return height; }));
        if (renamed) mesh->half.diamond = root_diamond((face_of(half.diamond.centre()) + 1) % kFaces);
        return mesh;
    }
    DrawRequest request_from(const Geodetic& place, double above, double tilt) const {
        DrawRequest request;
        request.camera = look_down(body, place, body.a(), kWidth, kHeight, 40, tilt, 17);
        request.camera.eye = to_units(body.position(direction(place), kGround + above), unit);
        request.aovs.patch = request.aovs.position = true;
        return request;
    }
    // Of the pixels that show either sheet where it is alone: how often the lower is drawn when both are, in
    // either order. `resolved`: only where the gap is to be told apart.
    Found compare(Renderer& gpu, const DrawRequest& request, const Half& half, double gap,
                  bool resolved = true) {
        const auto upper = sheet(half, kGround, false), lower = sheet(half, kGround - gap, true);
        const Frame above = gpu.draw(request, Patches{upper}), beneath = gpu.draw(request, Patches{lower});
        Found found;
        for (const Patches& order : {Patches{upper, lower}, Patches{lower, upper}}) {
            const Frame both = gpu.draw(request, order);
            EXPECT_EQ(both.counters.batches, 1);
            for (std::size_t k = 0; k < both.patch.size(); ++k) {
                if (above.patch[k] == kNoPatch || beneath.patch[k] == kNoPatch) continue;
                const float* const p = &above.position.values[3 * k];
                const double distance = std::hypot(p[0], p[1], p[2]);
                if (resolved && gap < resolution(request.camera, unit, distance)) continue;
                ++found.compared;
                found.swapped += both.patch[k] != above.patch[k];
            }
        }
        return found;
    }
};

const Geodetic kPlaces[] = {{46.5, 8}, {90, 0}, {-27.5, 180}};

// From 10 m above, straight down to grazing, as far as a centimetre is to be told apart (280 m with this
// camera): with triangles of 15 cm, and with such that reach from the eye to beyond the horizon.
TEST_F(DepthImage, ACentimetreAtTenMetres) {
    Renderer& gpu = renderer(body, kCells);
    std::uint64_t compared = 0;
    for (const Geodetic& somewhere : kPlaces)
        for (const double size : {10.0, 100.0, 1e4, 1e6}) {
            const Half half = half_near(somewhere, size);
            for (const double tilt : {0, 45, 80, 88}) {
                SCOPED_TRACE(testing::Message() << size << " m, " << tilt << " degrees");
                const DrawRequest request = request_from(middle(half), 10, tilt);
                ASSERT_LT(resolution(request.camera, unit, 10), 0.0005);
                const Found found = compare(gpu, request, half, 0.01);
                EXPECT_EQ(found.swapped, 0u);
                if (size >= 100) {
                    EXPECT_GT(found.compared, 5000u);
                }
                compared += found.compared;
            }
        }
    std::printf("%llu pixels\n", static_cast<unsigned long long>(compared));
    EXPECT_GT(compared, 800'000u);
}

// From 1 m to 10,000 km. Prints the least gap, of a sequence of quarters, at which no pixel swapped.
TEST_F(DepthImage, TheStatedResolutionAtEveryDistance) {
    Renderer& gpu = renderer(body, kCells);
    for (const double above : {1.0, 10.0, 100.0, 1e3, 1e4, 1e5, 1e6, 1e7}) {
        std::uint64_t compared = 0;
        double least = 0, stated = 0;
        for (const double cell : {above / 32, above})
            for (const double tilt : {0, 60}) {
                SCOPED_TRACE(testing::Message() << above << " m, " << tilt << " degrees");
                const Half half = half_near(kPlaces[0], kCells * cell);
                const DrawRequest request = request_from(middle(half), above, tilt);
                stated = resolution(request.camera, unit, above);
                // Twice as far at the middle of the picture if tilted, more above it.
                const Found found = compare(gpu, request, half, (tilt > 0 ? 4 : 1.1) * stated);
                EXPECT_EQ(found.swapped, 0u);
                compared += found.compared;
                double gap = stated;
                while (gap > stated / 2000 && compare(gpu, request, half, gap, false).swapped == 0) gap /= 4;
                least = std::max(least, 4 * gap);
            }
        std::printf("%g m: stated %.2g m, no swap down to %.2g m (%.2g of the distance)\n", above, stated,
                    least, least / above);
        EXPECT_GT(compared, 20'000u);
        EXPECT_LE(least, stated);
    }
}

}  // namespace
}  // namespace carat::test
