// Draws patch meshes with Vulkan 1.3, without a window: on a discrete GPU, or in software on Mesa lavapipe.
//
//   frame    body-fixed axes as in globe; positions int64 in length units, directions unit vectors
//   picture  pixel (0,0) top left; linear light; distances in metres
//   depth    float, reversed (near / z), no far plane: relative resolution 2^-24 at every distance
//   vertex   (anchor - eye + offset) is exact in 64-bit integers, then rounded to float metres with a
//            relative error of at most 2^-23; equal integers give equal clip positions in every patch
//   memory   patches live in fixed slots (capacity), least recently used first out; a longer list is drawn
//            in batches: it costs uploads, never holes
//   uploads  what a list brings that is not resident is uploaded in its frame, through a ring of staging
//            memory. The bytes a frame may bring are the list's maker's to limit: RefineBudget::upload_bytes
//            (carat fly --upload)
//   draws    one shared index buffer, and one indirect multi-draw a pass for each buffer of slots (256 MiB)
//   time     submit() and collect() keep up to kFramesInFlight frames under way, ordered on the device by one
//            timeline; the host waits in collect(), and elsewhere only if the staging ring is full (stall_ms)
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "carat/globe/ellipsoid.hpp"
#include "carat/render/patch_mesh.hpp"
#include "carat/vulkan/atmosphere.hpp"
#include "carat/vulkan/colour_table.hpp"
#include "carat/vulkan/picture.hpp"

namespace carat {

// Names of the Vulkan devices present, in the loader's order. Throws Error(unsupported) when there is no
// Vulkan loader or driver.
std::vector<std::string> vulkan_devices();

// Frames that may be under way at once.
inline constexpr int kFramesInFlight = 2;

struct RendererOptions {
    // Part of a name, or an index of vulkan_devices(); empty: discrete first, software last.
    std::string device;
    bool validation = false;  // load VK_LAYER_KHRONOS_validation; see Renderer::messages()
    int cells = 64;           // of every patch: a power of two, 2 to 128
    bool coloured = false;    // meshes bring colours (PatchMesh::colours), drawn instead of the table's
    bool shadowed = false;    // meshes bring the sun's share (cast_shadows()), for DrawRequest::shadows
    int capacity = 4096;      // patch slots at most; memory is taken in chunks as they fill
    // Staging ring, in quarters. submit() never waits for the device while the uploads of
    // kFramesInFlight + 1 frames fit in three quarters of it: staging_bytes() of what a frame uploads.
    std::size_t upload_bytes = 16u << 20;
    // Folder for compiled pipelines, made if missing; empty: none are kept. A file per device and driver;
    // what does not fit them or was damaged is ignored, and a folder that cannot be written costs nothing
    // but the time.
    std::string pipeline_cache;
};

// A ring for frames that upload so many bytes of patches each, at most: a quarter takes them with what else
// a frame brings, its constants and draw commands.
constexpr std::size_t staging_bytes(std::size_t frame_bytes) {
    return (kFramesInFlight + 2) * (frame_bytes + frame_bytes / 64 + (1u << 20));
}

struct Light {
    Vec3 direction{1, 0, 0};         // towards the light, unit, body frame
    double ambient = 0.08;           // share of the light that comes from everywhere, [0, 1]
    double exposure = 1;             // factor on the linear colour
    double relief_exaggeration = 1;  // factor on slopes for shading only
};

// Pictures besides colour. Samples at pixel centres, never averaged; background 0. Floats of the device:
// exact points and heights follow from `patch` (seen_points.hpp).
struct Aovs {
    bool depth = false;     // metres along the view axis
    bool position = false;  // relative to the eye, body axes, metres
    bool normal = false;    // shading normal, body axes, unit
    bool height = false;    // metres above the datum surface
    bool patch = false;     // which half and which of its triangles was drawn

    bool any() const { return depth || position || normal || height || patch; }
};

struct DrawRequest {
    Camera camera;
    Light light;
    std::array<float, 3> background{0, 0, 0};  // linear
    Aovs aovs;
    int samples = 1;  // a pixel, for colour: 1, 2, 4 or 8; the greatest supported number not above it is used
    double near_plane = 0;  // metres along the view axis; 0: a tenth of a metre
    bool cull_back_faces = true;
    // With cull_back_faces: patches all of whose triangles face away, by a cone of their normals, are neither
    // uploaded nor drawn. Changes nothing in the picture.
    bool skip_back_patches = false;
    // The air between the eye and what it sees, and the sky behind; sunlight and skylight on the ground come
    // through it. Without an atmosphere: black space. Light through the air is in units of the sun's above
    // it: 1 / pi of a white surface that faces the sun.
    bool sky = false;
    // Below the colour table's sea level: a surface at that level with the sun's glint, seen from above. A
    // mask of heights: dry land below the level is flooded. Needs a table with a sea, else Error(usage).
    bool water = false;
    // The meshes' share of the sun's direct light on the ground; water, air and sky know no shadows. Needs
    // RendererOptions::shadowed, else Error(usage).
    bool shadows = false;
    double wind = 5;  // m/s at 12.5 m above the sea, [0, 100]: how rough it is (Cox and Munk 1954)
};

struct FrameCounters {
    std::uint64_t patches_drawn = 0, patches_uploaded = 0, triangles = 0, bytes_uploaded = 0;
    std::uint64_t patches_back = 0;  // of those given, left out for they face away from the eye
    int batches = 0;       // of patches, each with all passes: more than one only if there are too few slots
    int draw_calls = 0;    // indirect multi-draws of patches: one for each batch, pass and buffer of slots
    int passes = 0;        // with patches, of all batches
    int samples = 0;       // a pixel, as used
    double table_ms = 0;   // host and device: making the sky's tables, in the first frame that has one
    double upload_ms = 0;  // host: choosing slots and filling the ring; stall_ms included
    double stall_ms = 0;   // of these, waiting for the device to make room in the ring
    double gpu_ms = 0;     // device: first to last drawing command by time stamps; 0 where there are none
    double readback_ms = 0;  // host: waiting for the frame and taking its pixels
};

struct Frame {
    Picture colour;    // R, G, B, A: A is coverage; background not premultiplied in but filled
    Picture depth;     // Z
    Picture position;  // X, Y, Z
    Picture normal;    // X, Y, Z
    Picture height;    // Y
    std::vector<std::uint64_t> patch;     // DiamondId * 2 + side by pixel, row-major; all ones: background
    std::vector<std::uint32_t> triangle;  // with patch: its place in the order of drawing, below cells^2
    FrameCounters counters;
};

// Half of a Frame::patch entry. Precondition: not background.
Half half_of_pixel(std::uint64_t entry);
inline constexpr std::uint64_t kNoPatch = ~std::uint64_t{0};

using PatchList = std::span<const std::shared_ptr<const PatchMesh>>;

// One device and the patches resident on it. Not thread-safe; several renderers may live in several threads.
class Renderer {
  public:
    // `metres_per_unit`: the length unit of all meshes and cameras, a power of two.
    // Throws Error(unsupported) when no device fits or the validation layer is missing, Error(usage) for bad
    // options.
    Renderer(const Ellipsoid& body, double metres_per_unit, const RendererOptions& options = {});
    ~Renderer();
    Renderer(Renderer&&) noexcept;
    Renderer& operator=(Renderer&&) noexcept;

    const std::string& device_name() const;

    // Colours by height and latitude; initially colours_of(body.name()).
    void set_colours(const ColourTable& table);

    // The air of DrawRequest::sky; initially atmosphere_of(body.name()). Throws Error(usage).
    void set_atmosphere(const std::optional<Atmosphere>& air);

    // Draws the patches. A mesh is uploaded when its half is not resident with the same mesh object.
    // Throws Error(usage) for a bad request or a mesh of other cells, Error(limit) when the picture exceeds
    // what the device can draw or the memory it has, Error(unsupported) for AOVs on a device that cannot
    // number triangles, Error(io) when the device is lost.
    // Precondition: no frame is under way.
    Frame draw(const DrawRequest& request, PatchList patches);

    // The same in two steps. submit() hands the work to the device and returns; the meshes may be let go of
    // then. collect() waits for the oldest frame under way and returns it. Throws Error(usage) if
    // kFramesInFlight frames are under way already, or none. A picture of more than 256 MiB of pixels is read
    // back within submit().
    void submit(const DrawRequest& request, PatchList patches);
    Frame collect();
    int frames_in_flight() const;

    // What uploading one patch takes.
    std::size_t patch_bytes() const;

    // Clip positions of a mesh's vertices as the vertex shader computes them.
    std::vector<std::array<float, 4>> clip_positions(const DrawRequest& request,
                                                     const std::shared_ptr<const PatchMesh>& mesh);

    // What the validation layer has said so far: empty if all is well or validation is off.
    std::vector<std::string> messages() const;

  private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace carat
