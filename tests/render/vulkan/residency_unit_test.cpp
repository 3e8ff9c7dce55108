// What is uploaded when, and that it never shows in the picture.
#include "carat/globe/globe.hpp"
#include "planet.hpp"

namespace carat::test {

namespace {

constexpr int kCells = 16;

class Residency : public RendererTest {
  protected:
    const Ellipsoid body = Ellipsoid::mars();
    Patches patches =
        make_meshes(body, level_halves(3), kCells, [](const Vec3& n) { return 9000 * n[0] * n[1] * n[2]; });
    DrawRequest request;

    void SetUp() override {
        request.camera = look_down(body, {20, 30}, 3 * body.a(), 200, 150, 50);
        request.light.direction = unit({1, 1, 0.3});
        request.aovs = {true, true, true, true, true};
    }
};

void expect_same(const Frame& a, const Frame& b) {
    EXPECT_EQ(a.colour.values, b.colour.values);
    EXPECT_EQ(a.position.values, b.position.values);
    EXPECT_EQ(a.normal.values, b.normal.values);
    EXPECT_EQ(a.height.values, b.height.values);
    EXPECT_EQ(a.depth.values, b.depth.values);
    EXPECT_EQ(a.patch, b.patch);
}

TEST_F(Residency, ARepeatedFrameUploadsNothingAndIsTheSame) {
    Renderer& gpu = renderer(body, kCells);
    const Frame first = gpu.draw(request, patches);
    EXPECT_EQ(first.counters.patches_uploaded, patches.size());
    EXPECT_EQ(first.counters.patches_drawn, patches.size());
    EXPECT_EQ(first.counters.triangles, patches.size() * kCells * kCells);
    EXPECT_EQ(first.counters.bytes_uploaded, patches.size() * (half_vertex_count(kCells) + 1) * 32);
    EXPECT_EQ(first.counters.batches, 1);
    EXPECT_EQ(first.counters.passes, 1) << "colour and AOVs together";
    EXPECT_EQ(first.counters.draw_calls, 1) << "of all patches";
    const Frame second = gpu.draw(request, patches);
    EXPECT_EQ(second.counters.patches_uploaded, 0u);
    EXPECT_EQ(second.counters.patches_drawn, patches.size());
    expect_same(first, second);
}

TEST_F(Residency, AnotherRendererDrawsTheSameBytes) {
    expect_same(renderer(body, kCells).draw(request, patches), renderer(body, kCells).draw(request, patches));
}

TEST_F(Residency, OnlyNewMeshesAreUploaded) {
    Renderer& gpu = renderer(body, kCells);
    const auto half = static_cast<std::ptrdiff_t>(patches.size() / 2);
    gpu.draw(request, Patches(patches.begin(), patches.begin() + half));
    EXPECT_EQ(gpu.draw(request, patches).counters.patches_uploaded, patches.size() - patches.size() / 2);
    // A new mesh of a known half replaces the old one.
    patches[3] = make_mesh(body, patches[3]->half, kCells, [](const Vec3&) { return 4000.0; });
    const Frame changed = gpu.draw(request, patches);
    EXPECT_EQ(changed.counters.patches_uploaded, 1u);
    expect_same(changed, renderer(body, kCells).draw(request, patches));
}

TEST_F(Residency, ASmallCapacityDrawsInBatchesWithoutAnyDifference) {
    const Frame whole = renderer(body, kCells).draw(request, patches);
    for (const int capacity : {1, 7, 50, 95, 96}) {
        SCOPED_TRACE(capacity);
        Renderer& gpu = renderer(body, kCells, capacity);
        const Frame batched = gpu.draw(request, patches);
        const int slots = static_cast<int>(patches.size());
        EXPECT_EQ(batched.counters.batches, (slots + capacity - 1) / capacity);
        EXPECT_EQ(batched.counters.patches_drawn, patches.size());
        expect_same(whole, batched);
        // What is resident is drawn first, so the second frame saves as many uploads as there are slots.
        EXPECT_EQ(gpu.draw(request, patches).counters.patches_uploaded,
                  patches.size() - static_cast<std::size_t>(capacity));
    }
}

// One indirect multi-draw a pass, whatever the number of patches; AOVs beside several samples are a second
// pass.
TEST_F(Residency, OneMultiDrawAPass) {
    Renderer& gpu = renderer(body, kCells);
    for (const std::size_t count : {1, 20, 96}) {
        const auto part = Patches(patches.begin(), patches.begin() + static_cast<std::ptrdiff_t>(count));
        for (const int samples : {1, 4}) {
            request.samples = samples;
            const FrameCounters c = gpu.draw(request, part).counters;
            EXPECT_EQ(c.patches_drawn, count);
            EXPECT_EQ(c.passes, samples == 1 ? 1 : 2);
            EXPECT_EQ(c.draw_calls, c.passes);
        }
    }
    EXPECT_EQ(gpu.draw(request, {}).counters.draw_calls, 0);
}

TEST_F(Residency, BatchesKeepSeveralSamples) {
    request.samples = 4;
    const Frame whole = renderer(body, kCells).draw(request, patches),
                batched = renderer(body, kCells, 20).draw(request, patches);
    expect_same(whole, batched);
    EXPECT_EQ(batched.counters.draw_calls, 2 * batched.counters.batches);
}

// A ray that meets a back face has met a front face before. On the outline itself the two are equally deep.
TEST_F(Residency, BackFacesAddNothingOutsideTheBody) {
    Renderer& gpu = renderer(body, kCells);
    const Frame culled = gpu.draw(request, patches);
    request.cull_back_faces = false;
    const Frame all = gpu.draw(request, patches);
    int differing = 0;
    for (std::size_t i = 0; i < culled.depth.values.size(); ++i) {
        ASSERT_EQ(culled.colour.values[4 * i + 3], all.colour.values[4 * i + 3]);
        ASSERT_NEAR(culled.depth.values[i], all.depth.values[i], 1e-2 * culled.depth.values[i]);
        differing += culled.depth.values[i] != all.depth.values[i];
    }
    EXPECT_LT(differing, 10);
}

TEST_F(Residency, AnEmptyListIsBackground) {
    request.background = {0.25f, 0.5f, 0.75f};
    const Frame frame = renderer(body, kCells).draw(request, {});
    for (int x = 0; x < 200; x += 17) {
        EXPECT_EQ(frame.colour.at(x, 75)[0], 0.25f);
        EXPECT_EQ(frame.colour.at(x, 75)[2], 0.75f);
        EXPECT_EQ(frame.colour.at(x, 75)[3], 0);
    }
}

}  // namespace

}  // namespace carat::test
