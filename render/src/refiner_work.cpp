#include <algorithm>

#include "refiner_state.hpp"
#include "stopwatch.hpp"

namespace carat {
namespace {

// Names of jobs.
std::uint64_t refinement_key(DiamondId id) { return id.bits() * 4; }
constexpr std::uint64_t kSpares = ~std::uint64_t{0};
std::uint64_t mesh_key(const Half& half) {
    return half.diamond.bits() * 4 + 1 + static_cast<std::uint64_t>(half.side);
}

}  // namespace

void Refiner::State::request(const LiveNode& n) {
    const std::uint64_t key = refinement_key(n.id);
    if (!requested_.insert(key).second) return;
    RefineWork work{n.id, n.level, n.by_file(), {n.halves[0].data.heights, n.halves[1].data.heights}, {}};
    work.wish = {visibility_, goal_.threshold, goal_.spacing, direct_, false};
    posted_.push_back({n.priority, key, std::move(work)});
}

void Refiner::State::request_mesh(const ChildHalf& child, double priority) {
    const std::uint64_t key = mesh_key(child.half);
    if (!requested_.insert(key).second) return;
    posted_.push_back({priority, key, MeshWork{child.half, child.heights}});
}

// In a worker.
Refiner::State::WorkResult Refiner::State::work(Work& task) const {
    WorkResult out;
    if (const auto* refine = std::get_if<RefineWork>(&task))
        out.refinement = maker_.refine(*refine, out.times);
    else if (const auto* mesh = std::get_if<MeshWork>(&task))
        out.mesh = maker_.build(mesh->half, *mesh->heights, out.times);
    else
        out.spares = maker_.spare_meshes(std::get<SpareWork>(task).count);
    return out;
}

// Twice what a frame takes, so that the next frames find some while a worker makes more.
void Refiner::State::request_spares() {
    if (to_the_end_) return;
    const std::size_t most = std::clamp<std::size_t>(options_.bytes / kShareOfSpares / maker_.mesh_bytes(),
                                                     kLeastSpares, kMostSpares);
    const std::size_t wanted = std::clamp(2 * spares_used_, kLeastSpares, most);
    if (2 * spares_.size() >= wanted + kLeastSpares / 2 || !requested_.insert(kSpares).second) return;
    posted_.push_back({kUrgent, kSpares, SpareWork{static_cast<int>(wanted - spares_.size())}});
}

// False if there is nothing to wait for or the time is up. Spare meshes are for later frames.
bool Refiner::State::wait_for_work() {
    const bool built = build_missing_meshes();
    const bool in_hand = requested_.size() > (requested_.contains(kSpares) ? 1 : 0);
    if (!built && in_hand) {
        const Stopwatch watch(counters_.wait_ms);
        const Clock::time_point until = stop_at();
        const std::uint64_t before = pool_.sleeps();
        pool_.wait(until);
        counters_.waits += pool_.sleeps() - before;
        if (const auto now = Clock::now(); now > until)
            counters_.overslept_ms += std::chrono::duration<double, std::milli>(now - until).count();
    }
    return collect() || built;
}

bool Refiner::State::collect() {
    const bool any = pool_.take([this](Pool::Done& done) { collect(done); }) > 0;
    if (error_) std::rethrow_exception(std::exchange(error_, nullptr));
    return any;
}

void Refiner::State::collect(Pool::Done& done) {
    requested_.erase(done.key);
    if (done.error && !error_) error_ = done.error;
    counters_.decode_ms += done.result.times.decode_ms;
    counters_.build_ms += done.result.times.build_ms;
    counters_.built += done.result.times.built;
    if (done.result.refinement) take_refinement(std::move(done.result.refinement));
    if (done.result.mesh) take_mesh(done.result.mesh);
    for (std::shared_ptr<PatchMesh>& mesh : done.result.spares) spares_.push_back(std::move(mesh));
}

void Refiner::State::take_refinement(std::unique_ptr<Refinement> refinement) {
    if (!refinement->by_file) ++counters_.virtual_decoded;
    const LiveNode* const n = graph_.find(refinement->id);
    if (n != nullptr && n->refined) return discard(std::move(refinement));
    if (n != nullptr) tell_candidate(*n);
    discard(cache_.insert(std::move(refinement)));
}

void Refiner::State::take_mesh(std::shared_ptr<PatchMesh>& mesh) {
    const Half half = mesh->half;
    LiveNode* const n = graph_.find(half.diamond);
    if (n != nullptr && n->halves[static_cast<std::size_t>(half.side)].exists) {
        ChildHalf& data = n->halves[static_cast<std::size_t>(half.side)].data;
        if (data.mesh) return;
        data.mesh = std::move(mesh);
        live_bytes_ += maker_.mesh_bytes();
        remove_missing(half);
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
    if (const LiveNode* const waiting = graph_.find(up)) tell_candidate(*waiting);
}

// One in hand has something new.
void Refiner::State::tell_candidate(const LiveNode& n) {
    if (in_hand_.contains(n.id)) arrived_.push({n.priority, n.level, n.id});
}

}  // namespace carat
