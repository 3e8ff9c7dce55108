#include "frame_images.hpp"

#include <cstring>

#include "pixels.hpp"

namespace carat {

namespace {

constexpr std::size_t kDepthChannel = 3, kHeightChannel = 3;  // w of positions and of normals

// A pixel of kPatchFormat.
struct PatchPixel {
    std::uint64_t half;
    std::uint32_t triangle, unused;
};

class Reads {
  public:
    Reads(int width, int height) : width_(width), height_(height) {}

    // One band: pixels are counted from the top left.
    template <class Take>
    void add(const vk::Image& image, std::size_t pixel_bytes, Take take) {
        const auto width = static_cast<std::size_t>(width_);
        list_.push_back({&image, image.extent, pixel_bytes,
                         [width, take](std::uint32_t row, std::uint32_t rows, const std::byte* pixels) {
                             take(std::size_t{row} * width, std::size_t{rows} * width, pixels);
                         }});
    }
    void add_floats(const vk::Image& image, Picture* vector, Picture* scalar, std::size_t channel) {
        add(image, 4 * sizeof(float), [=](std::size_t first, std::size_t count, const std::byte* pixels) {
            if (vector != nullptr) take_float4(*vector, first, count, pixels, 0);
            if (scalar != nullptr) take_float4(*scalar, first, count, pixels, channel);
        });
    }
    Picture* make(Picture& picture, bool wanted, std::vector<std::string> channels) const {
        if (!wanted) return nullptr;
        picture = empty_picture(width_, height_, std::move(channels));
        return &picture;
    }
    std::vector<vk::ImageRead> list() { return std::move(list_); }

  private:
    int width_, height_;
    std::vector<vk::ImageRead> list_;
};

}  // namespace

std::vector<vk::ImageRead> frame_images(const DrawRequest& request, const vk::Targets& targets,
                                        Frame& frame) {
    const Aovs& want = request.aovs;
    Reads reads(request.camera.width, request.camera.height);
    reads.make(frame.colour, true, {"R", "G", "B", "A"});
    reads.add(targets.colour(), 8, [&frame](std::size_t first, std::size_t count, const std::byte* pixels) {
        take_half4(frame.colour, first, count, pixels);
    });
    Picture* const position = reads.make(frame.position, want.position, {"X", "Y", "Z"});
    Picture* const depth = reads.make(frame.depth, want.depth, {"Z"});
    if (position != nullptr || depth != nullptr)
        reads.add_floats(targets.position(), position, depth, kDepthChannel);
    Picture* const normal = reads.make(frame.normal, want.normal, {"X", "Y", "Z"});
    Picture* const height = reads.make(frame.height, want.height, {"Y"});
    if (normal != nullptr || height != nullptr)
        reads.add_floats(targets.normal(), normal, height, kHeightChannel);
    if (want.patch) {
        frame.patch.resize(frame.colour.values.size() / frame.colour.channels.size());
        frame.triangle.resize(frame.patch.size());
        reads.add(targets.patch(), sizeof(PatchPixel),
                  [&frame](std::size_t first, std::size_t count, const std::byte* pixels) {
                      for (std::size_t k = 0; k < count; ++k) {
                          PatchPixel pixel;
                          std::memcpy(&pixel, pixels + k * sizeof(pixel), sizeof(pixel));
                          frame.patch[first + k] = pixel.half;
                          frame.triangle[first + k] = pixel.triangle;
                      }
                  });
    }
    return reads.list();
}

}  // namespace carat
