// Frames under way together: the same pictures as one by one, no waiting, and budgets that hold.
#include "carat/globe/error.hpp"
#include "carat/globe/globe.hpp"
#include "planet.hpp"

namespace carat::test {

namespace {

constexpr int kCells = 16;

class FramesInFlight : public RendererTest {
  protected:
    const Ellipsoid body = Ellipsoid::moon();
    const Patches patches =
        make_meshes(body, level_halves(3), kCells, [](const Vec3& n) { return 5000 * n[0] * n[1]; });

    DrawRequest request(double longitude) const {
        DrawRequest r;
        r.camera = look_down(body, {10, longitude}, 3 * body.a(), 160, 120, 50);
        r.aovs = {true, false, true, true, true};
        return r;
    }
    // Part of the patches, so that the frames of a flight differ in what they upload.
    Patches part(int k) const {
        const auto first = static_cast<std::ptrdiff_t>(k) * 7;
        return {patches.begin() + first, patches.begin() + first + 40};
    }
};

void expect_same(const Frame& a, const Frame& b) {
    EXPECT_EQ(a.colour.values, b.colour.values);
    EXPECT_EQ(a.depth.values, b.depth.values);
    EXPECT_EQ(a.normal.values, b.normal.values);
    EXPECT_EQ(a.height.values, b.height.values);
    EXPECT_EQ(a.patch, b.patch);
}

TEST_F(FramesInFlight, GiveTheSamePicturesAsOneByOne) {
    Renderer& single = renderer(body, kCells);
    // The second has too few slots: its frames are drawn in batches and push each other's patches out.
    for (Renderer* gpu : {&renderer(body, kCells), &renderer(body, kCells, 15)}) {
        constexpr int kFrames = 7;
        int collected = 0;
        const auto collect = [&] {
            SCOPED_TRACE(collected);
            expect_same(gpu->collect(), single.draw(request(20 * collected), part(collected)));
            ++collected;
        };
        for (int k = 0; k < kFrames; ++k) {
            gpu->submit(request(20 * k), part(k));
            if (gpu->frames_in_flight() == kFramesInFlight) collect();
        }
        while (gpu->frames_in_flight() > 0) collect();
        EXPECT_EQ(collected, kFrames);
    }
}

TEST_F(FramesInFlight, ThePictureMayChangeItsSize) {
    Renderer& gpu = renderer(body, kCells);
    DrawRequest small = request(0), large = request(90);
    large.camera.width = 333;
    gpu.submit(small, patches);
    gpu.submit(large, patches);
    const Frame first = gpu.collect(), second = gpu.collect();
    EXPECT_EQ(second.colour.width, 333);
    expect_same(first, renderer(body, kCells).draw(small, patches));
    expect_same(second, renderer(body, kCells).draw(large, patches));
}

TEST_F(FramesInFlight, CountersBelongToTheirFrame) {
    Renderer& gpu = renderer(body, kCells);
    gpu.submit(request(0), part(0));
    gpu.submit(request(0), part(1));
    EXPECT_EQ(gpu.collect().counters.patches_uploaded, 40u);
    const FrameCounters second = gpu.collect().counters;
    EXPECT_EQ(second.patches_uploaded, 7u);
    EXPECT_EQ(second.bytes_uploaded, 7 * gpu.patch_bytes());
    EXPECT_EQ(second.patches_drawn, 40u);
}

TEST_F(FramesInFlight, TooManyOrTooFewAreRefused) {
    Renderer& gpu = renderer(body, kCells);
    EXPECT_THROW(gpu.collect(), Error);
    for (int k = 0; k < kFramesInFlight; ++k) gpu.submit(request(0), part(0));
    EXPECT_THROW(gpu.submit(request(0), part(0)), Error);
    EXPECT_THROW(gpu.draw(request(0), part(0)), Error);
    EXPECT_EQ(gpu.frames_in_flight(), kFramesInFlight);
    for (int k = 0; k < kFramesInFlight; ++k) gpu.collect();
    EXPECT_NO_THROW(gpu.draw(request(0), part(0)));
}

TEST_F(FramesInFlight, TheHostWaitsForTheRingOnlyWhenItIsTooSmall) {
    RendererOptions options;
    options.cells = kCells;
    options.validation = true;
    Renderer roomy(body, length_unit(body), options);
    roomy.submit(request(0), part(0));
    roomy.submit(request(0), part(3));
    EXPECT_EQ(roomy.collect().counters.stall_ms, 0);
    EXPECT_EQ(roomy.collect().counters.stall_ms, 0);
    options.upload_bytes = 16384;  // less than one patch a segment
    // A host that is kept from running may come back when the device is done already: then once more.
    double stall_ms = 0;
    for (int k = 0; k < 20 && stall_ms == 0; ++k) {
        Renderer tight(body, length_unit(body), options);
        stall_ms = tight.draw(request(0), patches).counters.stall_ms;
        EXPECT_TRUE(tight.messages().empty());
    }
    EXPECT_GT(stall_ms, 0);
    EXPECT_TRUE(roomy.messages().empty());
}

}  // namespace

}  // namespace carat::test
