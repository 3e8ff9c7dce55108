#include <algorithm>

#include "refiner_state.hpp"
#include "stopwatch.hpp"

namespace carat {
namespace {

// Names of jobs.
std::uint64_t refinement_key(DiamondId id) { return id.bits() * 4; }
std::uint64_t mesh_key(const Half& half) {
    return half.diamond.bits() * 4 + 1 + static_cast<std::uint64_t>(half.side);
}

}  // namespace

void Refiner::State::request(const LiveNode& n) {
    const std::uint64_t key = refinement_key(n.id);
    if (!requested_.insert(key).second) return;
    RefineWork work{n.id, n.level, n.by_file(), {n.halves[0].data.heights, n.halves[1].data.heights}, {}};
    work.wish = {visibility_, goal_.threshold, goal_.spacing, direct_, false};
    posted_.push_back({n.priority, key, [this, work = std::move(work)] {
                           WorkResult result;
                           result.refinement = maker_.refine(work, result.times);
                           return result;
                       }});
}

void Refiner::State::request_mesh(const ChildHalf& child, double priority) {
    const std::uint64_t key = mesh_key(child.half);
    if (!requested_.insert(key).second) return;
    posted_.push_back({priority, key, [this, half = child.half, heights = child.heights] {
                           WorkResult result;
                           result.mesh = maker_.build(half, *heights, result.times);
                           return result;
                       }});
}

// To the end, halves that will be refined need none.
void Refiner::State::request_missing_meshes() {
    for (const Half& half : missing_) {
        const LiveNode& n = *graph_.find(half.diamond);
        if (direct_ && !full_ && n.needed == frame_) continue;
        request_mesh(n.halves[static_cast<std::size_t>(half.side)].data, kUrgent);
    }
}

// False if there is nothing to wait for or the time is up.
bool Refiner::State::wait_for_work() {
    while (!missing_.empty() && !time_is_up() && pool_.run_one(kUrgent)) {
    }
    std::vector<Pool::Done> results;
    {
        const Stopwatch watch(counters_.wait_ms);
        results = pool_.take(stop_at());
    }
    const bool any = !results.empty();
    collect(std::move(results));
    return any;
}

void Refiner::State::collect(std::vector<Pool::Done> results) {
    std::exception_ptr error;
    for (Pool::Done& done : results) {
        requested_.erase(done.key);
        if (done.error && !error) error = done.error;
        counters_.decode_ms += done.result.times.decode_ms;
        counters_.build_ms += done.result.times.build_ms;
        counters_.built += done.result.times.built;
        if (done.result.refinement) take_refinement(std::move(done.result.refinement));
        if (done.result.mesh) take_mesh(std::move(done.result.mesh));
    }
    if (error) std::rethrow_exception(error);
}

void Refiner::State::take_refinement(std::unique_ptr<Refinement> refinement) {
    if (!refinement->by_file) ++counters_.virtual_decoded;
    const LiveNode* const n = graph_.find(refinement->id);
    if (n != nullptr && n->refined) return discard(std::move(refinement));
    if (n != nullptr && n->needed == frame_ && n->complete())
        candidates_.push({n->priority, n->level, n->id});
    discard(cache_.insert(std::move(refinement)));
}

void Refiner::State::take_mesh(std::shared_ptr<PatchMesh> mesh) {
    const Half half = mesh->half;
    LiveNode* const n = graph_.find(half.diamond);
    if (n != nullptr && n->halves[static_cast<std::size_t>(half.side)].exists) {
        ChildHalf& data = n->halves[static_cast<std::size_t>(half.side)].data;
        if (data.mesh) return;
        data.mesh = std::move(mesh);
        live_bytes_ += maker_.mesh_bytes();
        missing_.erase(half);
        return;
    }
    const DiamondId up = *parent(half.diamond, half.side);  // the faces' halves always exist
    Refinement* const refinement = cache_.find(up);
    if (refinement == nullptr) return;
    for (ChildHalf& child : refinement->children) {
        if (child.half != half || child.mesh) continue;
        child.mesh = std::move(mesh);
        cache_.grew(maker_.mesh_bytes());
        break;
    }
    const LiveNode* const waiting = graph_.find(up);
    if (waiting != nullptr && waiting->needed == frame_ && waiting->complete() && !waiting->refined)
        candidates_.push({waiting->priority, waiting->level, waiting->id});
}

}  // namespace carat
