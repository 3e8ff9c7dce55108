#include "carat/vulkan/renderer.hpp"

#include <array>
#include <chrono>
#include <cmath>
#include <cstring>
#include <optional>

#include "carat/globe/patch.hpp"
#include "frame_data.hpp"
#include "gpu_timer.hpp"
#include "patch_store.hpp"
#include "pixels.hpp"
#include "readback.hpp"
#include "table_texture.hpp"
#include "targets.hpp"

namespace carat {

namespace {

using Clock = std::chrono::steady_clock;

double ms_since(Clock::time_point start) {
    return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

void check_options(const RendererOptions& o) {
    const bool power = o.cells >= 2 && o.cells <= 128 && (o.cells & (o.cells - 1)) == 0;
    if (!power) throw Error(ErrorCode::usage, "renderer: cells must be a power of two from 2 to 128");
    if (o.capacity < 1 || o.capacity > 1 << 20) {
        throw Error(ErrorCode::usage, "renderer: capacity must be from 1 to 1048576 patches");
    }
}

}  // namespace

struct Renderer::State {
    State(const Ellipsoid& b, double unit, const RendererOptions& options);
    ~State() { device.wait_idle(); }

    void set_colours(const ColourTable& table);
    Frame draw(const DrawRequest& request, PatchList patches);
    std::vector<std::array<float, 4>> probe(const DrawRequest& request, const vk::MeshPointer& mesh);

    void prepare_targets(const DrawRequest& request);
    void fill_batch(std::vector<const vk::MeshPointer*>& remaining, FrameCounters& counters);
    void draw_batch(const DrawRequest& request, bool first, bool last, FrameCounters& counters);
    void read_back(const DrawRequest& request, Frame& frame);

    Ellipsoid body;
    double metres_per_unit;
    std::uint64_t cells;
    vk::Instance instance;
    vk::Device device;
    std::string name;
    vk::UploadRing ring;
    vk::Pipelines pipelines;
    vk::PatchStore store;
    vk::Sampler sampler;
    vk::TableTexture table;
    vk::Buffer frame_data, probe_data;
    std::optional<vk::Targets> targets;
    vk::GpuTimer timer;
    vk::Readback readback;
    VkCommandBuffer commands;
};

Renderer::State::State(const Ellipsoid& b, double unit, const RendererOptions& options)
    : body(b),
      metres_per_unit(unit),
      cells(static_cast<std::uint64_t>(options.cells)),
      instance(options.validation),
      device(instance, options.device),
      name(device.name()),
      ring(device, options.upload_bytes),
      pipelines(device),
      store(device, ring, pipelines.set_layout(), options.cells, options.capacity),
      sampler(vk::make_table_sampler(device)),
      frame_data(vk::make_buffer(device, sizeof(gpu::FrameData),
                                 VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT,
                                 vk::Where::device, "frame data")),
      probe_data(vk::make_buffer(device, half_vertex_count(options.cells) * sizeof(gpu::vec4),
                                 VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, vk::Where::readback,
                                 "probed positions")),
      timer(device),
      readback(device),
      commands(device.new_commands()) {
    set_colours(colours_of(body.name()));
}

void Renderer::State::set_colours(const ColourTable& colours) {
    auto texture = vk::make_table_texture(device, colours);
    device.wait_idle();
    table = std::move(texture);
    store.bind_shared(
        {frame_data.handle.get(), probe_data.handle.get(), table.image.view.get(), sampler.get()});
}

void Renderer::State::prepare_targets(const DrawRequest& request) {
    const vk::TargetWish wish{
        {static_cast<std::uint32_t>(request.camera.width), static_cast<std::uint32_t>(request.camera.height)},
        vk::supported_samples(device, request.samples),
        request.aovs.any()};
    if (targets && targets->wish() == wish) return;
    targets.reset();  // free the old ones first
    targets.emplace(device, wish);
}

// Takes as many patches as there are slots: first those that are resident, so that none of them is pushed out
// by a patch that must be uploaded anyway.
void Renderer::State::fill_batch(std::vector<const vk::MeshPointer*>& remaining, FrameCounters& counters) {
    store.begin_batch();
    std::vector<bool> taken(remaining.size(), false);
    for (const bool resident : {true, false}) {
        for (std::size_t i = 0; i < remaining.size(); ++i) {
            if (!taken[i] && store.resident(*remaining[i]) == resident) taken[i] = store.add(*remaining[i]);
        }
    }
    std::size_t kept = 0;
    for (std::size_t i = 0; i < remaining.size(); ++i) {
        if (!taken[i]) remaining[kept++] = remaining[i];
    }
    counters.patches_drawn += remaining.size() - kept;
    remaining.resize(kept);
    store.end_batch();
    ring.flush();
}

void Renderer::State::draw_batch(const DrawRequest& request, bool first, bool last, FrameCounters& counters) {
    device.begin(commands);
    vk::full_barrier(commands);
    timer.start(commands);
    if (first) targets->prepare(commands);
    for (const vk::PassKind& pass : targets->passes(request.cull_back_faces)) {
        targets->begin(commands, pass, request.background, first, last);
        vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipelines.draw(pass));
        store.draw(commands, pipelines.layout());
        vkCmdEndRendering(commands);
        vk::full_barrier(commands);
    }
    if (last) targets->finish(commands);
    timer.stop(commands);
    device.wait(device.submit(commands));
    counters.gpu_ms += timer.milliseconds();
    ++counters.batches;
}

Frame Renderer::State::draw(const DrawRequest& request, PatchList patches) {
    check_request(request);
    prepare_targets(request);
    Frame frame;
    FrameCounters& c = frame.counters;
    const auto uploads = store.uploads(), bytes = store.upload_bytes();
    c.samples = static_cast<int>(targets->wish().samples);

    const gpu::FrameData data = make_frame_data(request, body, metres_per_unit, table);
    ring.copy(frame_data.handle.get(), 0, &data, sizeof(data));
    std::vector<const vk::MeshPointer*> remaining;
    remaining.reserve(patches.size());
    for (const auto& mesh : patches) remaining.push_back(&mesh);
    do {
        const auto start = Clock::now();
        fill_batch(remaining, c);
        c.upload_ms += ms_since(start);
        draw_batch(request, c.batches == 0, remaining.empty(), c);
    } while (!remaining.empty());

    c.triangles = c.patches_drawn * cells * cells;
    c.patches_uploaded = store.uploads() - uploads;
    c.bytes_uploaded = store.upload_bytes() - bytes;
    const auto start = Clock::now();
    read_back(request, frame);
    c.readback_ms = ms_since(start);
    return frame;
}

void Renderer::State::read_back(const DrawRequest& request, Frame& frame) {
    const int width = request.camera.width, height = request.camera.height;
    const auto read = [&](const vk::Image& image, std::size_t pixel_bytes, const auto& take) {
        readback.read(image, pixel_bytes,
                      [&](std::uint32_t row, std::uint32_t rows, const std::byte* pixels) {
                          const std::size_t first = std::size_t{row} * static_cast<std::size_t>(width);
                          take(first, std::size_t{rows} * static_cast<std::size_t>(width), pixels);
                      });
    };
    frame.colour = empty_picture(width, height, {"R", "G", "B", "A"});
    read(targets->colour(), 8, [&](std::size_t first, std::size_t count, const std::byte* pixels) {
        take_half4(frame.colour, first, count, pixels);
    });
    const Aovs& want = request.aovs;
    if (want.position) frame.position = empty_picture(width, height, {"X", "Y", "Z"});
    if (want.depth) frame.depth = empty_picture(width, height, {"Z"});
    if (want.position || want.depth) {
        read(targets->position(), 16, [&](std::size_t first, std::size_t count, const std::byte* pixels) {
            if (want.position) take_float4(frame.position, first, count, pixels, 0);
            if (want.depth) take_float4(frame.depth, first, count, pixels, 3);
        });
    }
    if (want.normal) frame.normal = empty_picture(width, height, {"X", "Y", "Z"});
    if (want.height) frame.height = empty_picture(width, height, {"Y"});
    if (want.normal || want.height) {
        read(targets->normal(), 16, [&](std::size_t first, std::size_t count, const std::byte* pixels) {
            if (want.normal) take_float4(frame.normal, first, count, pixels, 0);
            if (want.height) take_float4(frame.height, first, count, pixels, 3);
        });
    }
    if (want.patch) {
        frame.patch.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
        read(targets->patch(), 8, [&](std::size_t first, std::size_t count, const std::byte* pixels) {
            std::memcpy(frame.patch.data() + first, pixels, count * sizeof(frame.patch[0]));
        });
    }
}

std::vector<std::array<float, 4>> Renderer::State::probe(const DrawRequest& request,
                                                         const vk::MeshPointer& mesh) {
    check_request(request);
    const gpu::FrameData data = make_frame_data(request, body, metres_per_unit, table);
    ring.copy(frame_data.handle.get(), 0, &data, sizeof(data));
    store.begin_batch();
    store.add(mesh);
    ring.flush();
    const auto [set, slot] = store.last_added();
    const auto count = static_cast<std::uint32_t>(mesh->vertices.size());
    const vk::ProbeRange range{slot, count};

    device.begin(commands);
    vk::full_barrier(commands);
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipelines.probe());
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipelines.layout(), 0, 1, &set, 0,
                            nullptr);
    vkCmdPushConstants(commands, pipelines.layout(), VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof(range), &range);
    vkCmdDispatch(commands, (count + gpu::kProbeGroup - 1) / gpu::kProbeGroup, 1, 1);
    vk::host_barrier(commands);
    device.wait(device.submit(commands));

    std::vector<std::array<float, 4>> positions(count);
    std::memcpy(positions.data(), probe_data.mapped, count * sizeof(positions[0]));
    return positions;
}

std::vector<std::string> vulkan_devices() {
    const vk::Instance instance(false);
    std::vector<std::string> names;
    for (const VkPhysicalDevice device : instance.devices()) {
        VkPhysicalDeviceProperties properties;
        vkGetPhysicalDeviceProperties(device, &properties);
        names.emplace_back(properties.deviceName);
    }
    return names;
}

Half half_of_pixel(std::uint64_t entry) {
    return {DiamondId::parse(entry >> 1).value(), static_cast<int>(entry & 1)};
}

Renderer::Renderer(const Ellipsoid& body, double metres_per_unit, const RendererOptions& options) {
    check_options(options);
    state_ = std::make_unique<State>(body, metres_per_unit, options);
}

Renderer::~Renderer() = default;
Renderer::Renderer(Renderer&&) noexcept = default;
Renderer& Renderer::operator=(Renderer&&) noexcept = default;

const std::string& Renderer::device_name() const { return state_->name; }
void Renderer::set_colours(const ColourTable& table) { state_->set_colours(table); }
Frame Renderer::draw(const DrawRequest& request, PatchList patches) { return state_->draw(request, patches); }
std::vector<std::array<float, 4>> Renderer::clip_positions(const DrawRequest& request,
                                                           const std::shared_ptr<const PatchMesh>& mesh) {
    return state_->probe(request, mesh);
}
std::vector<std::string> Renderer::messages() const { return state_->instance.messages(); }

}  // namespace carat
