// What is refused, and how.
#include <cmath>

#include "carat/globe/error.hpp"
#include "planet.hpp"

namespace carat::test {

namespace {

class Limits : public RendererTest {
  protected:
    const Ellipsoid body = Ellipsoid::moon();
    DrawRequest request;
    void SetUp() override { request.camera = look_down(body, {0, 0}, 3 * body.a(), 64, 48, 40); }
};

template <class Action>
void expect_error(ErrorCode code, const char* words, const Action& action) {
    try {
        action();
        ADD_FAILURE() << "no error";
    } catch (const Error& e) {
        EXPECT_EQ(e.code(), code) << e.what();
        EXPECT_NE(std::string(e.what()).find(words), std::string::npos) << e.what();
    }
}

TEST_F(Limits, APictureLargerThanTheDeviceDraws) {
    request.camera.width = 1 << 20;
    expect_error(ErrorCode::limit, "1048576x48", [&] { renderer(body, 16).draw(request, {}); });
}

TEST_F(Limits, BadRequestsAreNamed) {
    Renderer& gpu = renderer(body, 16);
    const auto refused = [&](const char* words, auto change) {
        DrawRequest bad = request;
        change(bad);
        expect_error(ErrorCode::usage, words, [&] { gpu.draw(bad, {}); });
    };
    refused("no pixels", [](DrawRequest& r) { r.camera.height = 0; });
    refused("field of view", [](DrawRequest& r) { r.camera.vertical_fov = 3.2; });
    refused("unit vectors", [](DrawRequest& r) { r.camera.up = {0, 0, 0}; });
    refused("perpendicular", [](DrawRequest& r) { r.camera.up = r.camera.right; });
    refused("light", [](DrawRequest& r) { r.light.direction = {1, 1, 1}; });
    refused("ambient", [](DrawRequest& r) { r.light.ambient = 1.5; });
    refused("exposure", [](DrawRequest& r) { r.light.exposure = NAN; });
    refused("samples", [](DrawRequest& r) { r.samples = 0; });
    refused("near plane", [](DrawRequest& r) { r.near_plane = -1; });
    EXPECT_NO_THROW(gpu.draw(request, {}));  // still usable
}

TEST_F(Limits, BadOptionsAreNamed) {
    const auto refused = [&](const char* words, auto change) {
        RendererOptions options;
        change(options);
        expect_error(ErrorCode::usage, words, [&] { Renderer(body, length_unit(body), options); });
    };
    refused("cells", [](RendererOptions& o) { o.cells = 65; });
    refused("cells", [](RendererOptions& o) { o.cells = 256; });
    refused("capacity", [](RendererOptions& o) { o.capacity = 0; });
    refused("no device 'no such device'", [](RendererOptions& o) { o.device = "no such device"; });
    refused("no device '99'", [](RendererOptions& o) { o.device = "99"; });
}

TEST_F(Limits, MeshesOfOtherCellsAreRefused) {
    const Patches patches = make_meshes(body, level_halves(0), 16, [](const Vec3&) { return 0.0; });
    expect_error(ErrorCode::usage, "vertices instead of", [&] { renderer(body, 32).draw(request, patches); });
}

TEST_F(Limits, DevicesAreChosenByIndexAndByPartOfTheName) {
    const auto names = vulkan_devices();
    ASSERT_FALSE(names.empty());
    RendererOptions options;
    options.device = std::to_string(names.size() - 1);
    EXPECT_EQ(Renderer(body, length_unit(body), options).device_name(), names.back());
    options.device = names.back().substr(1, 4);
    EXPECT_NO_THROW(Renderer(body, length_unit(body), options));
}

}  // namespace

}  // namespace carat::test
