#include "carat/vulkan/renderer.hpp"

#include <array>
#include <chrono>
#include <cmath>
#include <cstring>
#include <optional>

#include "air_tables.hpp"
#include "back_faces.hpp"
#include "carat/globe/patch.hpp"
#include "command_buffers.hpp"
#include "frame_data.hpp"
#include "frame_images.hpp"
#include "gpu_timer.hpp"
#include "patch_store.hpp"
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

// A frame under way: what the host will want of it.
struct Pending {
    explicit Pending(const vk::Device& device) : timer(device) {}

    std::vector<vk::ImageRead> reads;
    Frame frame;
    vk::WholeReadback readback;
    vk::GpuTimer timer;
    std::uint64_t done = 0;  // on the timeline
    bool taken = false;      // pixels and times are in the frame already
};

constexpr std::size_t kWholeReadbackBytes = std::size_t{256} << 20;

struct Renderer::State {
    State(const Ellipsoid& b, double unit, const RendererOptions& options);
    ~State() { device.wait_idle(); }

    void set_colours(const ColourTable& table);
    void set_atmosphere(const std::optional<Atmosphere>& air);
    void prepare_sky(const DrawRequest& request, FrameCounters& counters);
    vk::PassKind look(vk::PassKind pass, const DrawRequest& request) const;
    void submit(const DrawRequest& request, PatchList patches);
    Frame collect();
    std::vector<std::array<float, 4>> probe(const DrawRequest& request, const vk::MeshPointer& mesh);

    void prepare_targets(const DrawRequest& request);
    void fill_batch(std::vector<const vk::MeshPointer*>& remaining, FrameCounters& counters);
    void draw_batch(const DrawRequest& request, bool first, bool last, Pending& pending);
    void draw_background(VkCommandBuffer commands, vk::PassKind pass, const DrawRequest& request);
    void read_back(Pending& pending, VkCommandBuffer commands);
    void take_pixels(Pending& pending);

    Ellipsoid body;
    double metres_per_unit;
    std::uint64_t cells;
    vk::Instance instance;
    vk::Device device;
    std::string name;
    vk::UploadRing ring;
    vk::Pipelines pipelines;
    vk::PatchStore store;
    bool coloured, shadowed;
    vk::Sampler sampler;
    vk::TableTexture table;
    vk::AirTables air_tables;
    gpu::AirData air{};
    bool has_air = false, air_made = false;
    vk::Buffer frame_data, probe_data;
    std::optional<vk::Targets> targets;
    BackFaces back_faces;
    vk::CommandBuffers commands;
    vk::BandedReadback banded;
    std::array<Pending, kFramesInFlight> pending;
    std::size_t oldest = 0;
    int in_flight = 0;
    struct Totals {
        std::uint64_t uploads = 0, bytes = 0;
        double stalled_ms = 0;
    } counted, total;  // up to the last frame; so far
};

Renderer::State::State(const Ellipsoid& b, double unit, const RendererOptions& options)
    : body(b),
      metres_per_unit(unit),
      cells(static_cast<std::uint64_t>(options.cells)),
      instance(options.validation),
      device(instance, options.device),
      name(device.name()),
      ring(device, options.upload_bytes),
      pipelines(device, options.pipeline_cache),
      store(device, ring, pipelines.set_layout(), options.cells, options.capacity,
            options.coloured || options.shadowed),
      coloured(options.coloured),
      shadowed(options.shadowed),
      sampler(vk::make_table_sampler(device)),
      air_tables(device),
      frame_data(vk::make_buffer(device, sizeof(gpu::FrameData),
                                 VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT,
                                 vk::Where::device, "frame data")),
      probe_data(vk::make_buffer(device, half_vertex_count(options.cells) * sizeof(gpu::vec4),
                                 VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, vk::Where::readback,
                                 "probed positions")),
      back_faces(options.cells, unit),
      commands(device),
      banded(device),
      pending{Pending(device), Pending(device)} {
    set_atmosphere(atmosphere_of(body.name()));
    set_colours(colours_of(body.name()));
}

void Renderer::State::set_atmosphere(const std::optional<Atmosphere>& atmosphere) {
    if (atmosphere) check_atmosphere(*atmosphere);
    air = make_air_data(body, atmosphere);
    has_air = atmosphere.has_value();
    air_made = false;
}

void Renderer::State::prepare_sky(const DrawRequest& request, FrameCounters& counters) {
    if (!request.sky || !has_air || air_made) return;
    const auto start = Clock::now();
    device.wait_idle();  // frames under way still read the old tables
    air_tables.make(air);
    air_made = true;
    counters.table_ms = ms_since(start);
}

// A pass with what a request adds to its colours.
vk::PassKind Renderer::State::look(vk::PassKind pass, const DrawRequest& request) const {
    pass.sky = pass.colour && request.sky && has_air;
    pass.water = pass.colour && request.water;
    pass.drape = pass.colour && coloured;
    pass.shadows = pass.colour && request.shadows;
    return pass;
}

void Renderer::State::set_colours(const ColourTable& colours) {
    auto texture = vk::make_table_texture(device, colours);
    device.wait_idle();
    table = std::move(texture);
    store.bind_shared({frame_data.handle.get(), probe_data.handle.get(), table.image.view.get(),
                       sampler.get(), air_tables.views()});
}

void Renderer::State::prepare_targets(const DrawRequest& request) {
    const vk::TargetWish wish{
        {static_cast<std::uint32_t>(request.camera.width), static_cast<std::uint32_t>(request.camera.height)},
        vk::supported_samples(device, request.samples),
        request.aovs.any()};
    if (targets && targets->wish() == wish) return;
    device.wait_idle();  // frames under way still draw into the old ones
    targets.reset();     // free them first
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

void Renderer::State::draw_batch(const DrawRequest& request, bool first, bool last, Pending& frame) {
    const VkCommandBuffer buffer = commands.begin();
    vk::full_barrier(buffer);
    if (first) {
        frame.timer.start(buffer);
        targets->prepare(buffer);
    }
    for (const vk::PassKind& kind : targets->passes(request.cull_back_faces)) {
        const vk::PassKind pass = look(kind, request);
        const bool background = last && (pass.sky || pass.water);
        targets->begin(buffer, pass, request.background, first, last && !background);
        vkCmdBindPipeline(buffer, VK_PIPELINE_BIND_POINT_GRAPHICS, pipelines.draw(pass));
        ++frame.frame.counters.passes;
        frame.frame.counters.draw_calls += store.draw(buffer, pipelines.layout());
        vkCmdEndRendering(buffer);
        vk::full_barrier(buffer);
        if (background) draw_background(buffer, pass, request);
    }
    if (last) {
        targets->finish(buffer);
        frame.timer.stop(buffer);
        read_back(frame, buffer);
    }
    frame.done = commands.submit();
    ++frame.frame.counters.batches;
}

// Where a pass with all its batches has left the depth clear. AOVs know no background.
void Renderer::State::draw_background(VkCommandBuffer buffer, vk::PassKind pass, const DrawRequest& request) {
    const VkDescriptorSet set = store.shared_set();
    pass.aovs = false;
    targets->begin(buffer, pass, request.background, false, true);
    vkCmdBindPipeline(buffer, VK_PIPELINE_BIND_POINT_GRAPHICS, pipelines.background(pass));
    vkCmdBindDescriptorSets(buffer, VK_PIPELINE_BIND_POINT_GRAPHICS, pipelines.layout(), 0, 1, &set, 0,
                            nullptr);
    vkCmdDraw(buffer, 3, 1, 0, 0);
    vkCmdEndRendering(buffer);
    vk::full_barrier(buffer);
}

void Renderer::State::read_back(Pending& frame, VkCommandBuffer buffer) {
    std::size_t bytes = 0;
    for (const vk::ImageRead& read : frame.reads) bytes += read.bytes();
    frame.taken = bytes > kWholeReadbackBytes;
    if (!frame.taken) frame.readback.record(device, buffer, frame.reads);
}

void Renderer::State::submit(const DrawRequest& request, PatchList patches) {
    check_request(request);
    if (request.aovs.any() && !device.has_primitive_numbers())
        throw Error(ErrorCode::unsupported, "AOVs: " + name + " lacks geometryShader, for gl_PrimitiveID");
    if (request.water && !table.has_sea)
        throw Error(ErrorCode::usage, "draw request: water needs a colour table with a sea level");
    if (request.shadows && !shadowed)
        throw Error(ErrorCode::usage, "draw request: shadows need a renderer for shadowed meshes");
    if (in_flight == kFramesInFlight)
        throw Error(ErrorCode::usage, "renderer: " + std::to_string(kFramesInFlight) +
                                          " frames are under way; collect one first");
    prepare_targets(request);
    Pending& next = pending[(oldest + static_cast<std::size_t>(in_flight)) % pending.size()];
    next.frame = {};
    next.reads = frame_images(request, *targets, next.frame);
    FrameCounters& c = next.frame.counters;
    c.samples = static_cast<int>(targets->wish().samples);

    prepare_sky(request, c);
    const gpu::FrameData data = make_frame_data(request, body, metres_per_unit, table, air);
    ring.copy(frame_data.handle.get(), 0, &data, sizeof(data));
    std::vector<const vk::MeshPointer*> remaining;
    remaining.reserve(patches.size());
    back_faces.begin();
    const bool skips = request.cull_back_faces && request.skip_back_patches;
    for (const auto& mesh : patches) {
        if (skips && back_faces.faces_away(mesh, request.camera.eye))
            ++c.patches_back;
        else
            remaining.push_back(&mesh);
    }
    do {
        const auto start = Clock::now();
        fill_batch(remaining, c);
        c.upload_ms += ms_since(start);
        draw_batch(request, c.batches == 0, remaining.empty(), next);
    } while (!remaining.empty());

    total = {store.uploads(), store.upload_bytes(), ring.stalled_ms()};
    c.triangles = c.patches_drawn * cells * cells;
    c.patches_uploaded = total.uploads - counted.uploads;
    c.bytes_uploaded = total.bytes - counted.bytes;
    c.stall_ms = total.stalled_ms - counted.stalled_ms;
    counted = total;
    ++in_flight;
    if (next.taken) take_pixels(next);
}

// Times and pixels of a frame, waiting for the device.
void Renderer::State::take_pixels(Pending& frame) {
    const auto start = Clock::now();
    device.wait(frame.done);
    if (frame.taken) {
        for (const vk::ImageRead& read : frame.reads) banded.read(read);
    } else {
        frame.readback.take(frame.reads);
    }
    frame.frame.counters.gpu_ms = frame.timer.milliseconds();
    frame.frame.counters.readback_ms = ms_since(start);
}

Frame Renderer::State::collect() {
    if (in_flight == 0) throw Error(ErrorCode::usage, "renderer: no frame is under way");
    Pending& first = pending[oldest];
    if (!first.taken) take_pixels(first);
    oldest = (oldest + 1) % pending.size();
    --in_flight;
    first.reads.clear();
    return std::move(first.frame);
}

std::vector<std::array<float, 4>> Renderer::State::probe(const DrawRequest& request,
                                                         const vk::MeshPointer& mesh) {
    check_request(request);
    const gpu::FrameData data = make_frame_data(request, body, metres_per_unit, table, air);
    ring.copy(frame_data.handle.get(), 0, &data, sizeof(data));
    store.begin_batch();
    store.add(mesh);
    ring.flush();
    const auto [set, slot] = store.last_added();
    const auto count = static_cast<std::uint32_t>(mesh->vertices.size());
    const vk::ProbeRange range{slot, count};

    const VkCommandBuffer buffer = commands.begin();
    vk::full_barrier(buffer);
    vkCmdBindPipeline(buffer, VK_PIPELINE_BIND_POINT_COMPUTE, pipelines.probe());
    vkCmdBindDescriptorSets(buffer, VK_PIPELINE_BIND_POINT_COMPUTE, pipelines.layout(), 0, 1, &set, 0,
                            nullptr);
    vkCmdPushConstants(buffer, pipelines.layout(), VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof(range), &range);
    vkCmdDispatch(buffer, (count + gpu::kProbeGroup - 1) / gpu::kProbeGroup, 1, 1);
    vk::host_barrier(buffer);
    device.wait(commands.submit());

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
void Renderer::set_atmosphere(const std::optional<Atmosphere>& air) { state_->set_atmosphere(air); }
Frame Renderer::draw(const DrawRequest& request, PatchList patches) {
    if (state_->in_flight > 0)
        throw Error(ErrorCode::usage, "renderer: frames are under way; collect them before draw()");
    state_->submit(request, patches);
    return state_->collect();
}
void Renderer::submit(const DrawRequest& request, PatchList patches) { state_->submit(request, patches); }
Frame Renderer::collect() { return state_->collect(); }
int Renderer::frames_in_flight() const { return state_->in_flight; }
std::size_t Renderer::patch_bytes() const { return state_->store.patch_bytes(); }
std::vector<std::array<float, 4>> Renderer::clip_positions(const DrawRequest& request,
                                                           const std::shared_ptr<const PatchMesh>& mesh) {
    return state_->probe(request, mesh);
}
std::vector<std::string> Renderer::messages() const { return state_->instance.messages(); }

}  // namespace carat
