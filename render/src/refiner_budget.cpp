// What the budgets of memory, triangles and uploads allow.
//
// They limit what the cut itself takes: the heights of all its halves, and a mesh for each in sight, built or
// not. So what fits does not depend on time or on what was shown before. Meshes kept to coarsen at once,
// those of halves out of sight and refinements out of the cut have what is left.
#include <algorithm>
#include <limits>

#include "carat/globe/patch.hpp"
#include "refiner_state.hpp"

namespace carat {
namespace {

constexpr std::int64_t kNoLimit = std::numeric_limits<std::int64_t>::max() / 2;

std::int64_t limit(std::uint64_t most) {
    return static_cast<std::int64_t>(std::min(most, static_cast<std::uint64_t>(kNoLimit)));
}

}  // namespace

Refiner::State::Load& Refiner::State::Load::operator+=(const Load& other) {
    bytes += other.bytes;
    patches += other.patches;
    uploads += other.uploads;
    return *this;
}

// A part of the memory is left to what workers have in hand, lest results be dropped before they are used,
// and to the faces' meshes, which are always there.
void Refiner::State::set_limits(const RefineBudget& budget) {
    constexpr std::uint64_t kShareInHand = 16;
    const auto vertices = static_cast<std::uint64_t>(half_vertex_count(cells_));
    const std::uint64_t greatest = 4 * (sizeof(ChildHalf) + sizeof(HalfFacts) + maker_.mesh_bytes() +
                                        vertices * (sizeof(std::int64_t) + sizeof(std::int32_t)));
    const std::uint64_t in_hand = std::max(options_.bytes / kShareInHand, 2 * greatest);
    most_in_hand_ = static_cast<std::size_t>(in_hand / greatest) - 1;  // one that is there and does not fit
    const auto cells = static_cast<std::uint64_t>(cells_);
    const std::uint64_t faces = 2 * kFaces * maker_.mesh_bytes();
    most_.bytes = limit(options_.bytes - std::min(options_.bytes, in_hand + faces));
    most_.patches = limit(options_.triangles / (cells * cells));
    most_.uploads = limit(budget.upload_bytes / maker_.mesh_bytes());
}

Refiner::State::Load Refiner::State::load() const {
    return {height_bytes_ + drawn_ * static_cast<std::int64_t>(maker_.mesh_bytes()), drawn_, uploads_};
}

std::int64_t Refiner::State::bytes_of_heights(const ChildHalf& child) const {
    return static_cast<std::int64_t>(bytes_of(child) - (child.mesh ? maker_.mesh_bytes() : 0));
}

// With a frontier half more or, sign -1, fewer; its heights aside.
Refiner::State::Load Refiner::State::add(Load load, const LiveHalf& half, int sign) const {
    if (!shown(half)) return load;
    load += {sign * static_cast<std::int64_t>(maker_.mesh_bytes()), sign, is_upload(half) ? sign : 0};
    return load;
}

// The least that it can be if there is no refinement yet.
Refiner::State::Load Refiner::State::load_of_refining(const LiveNode& n, const Refinement* refinement) const {
    Load out;
    if (refinement == nullptr) {
        const std::size_t heights =
            sizeof(std::int32_t) * static_cast<std::size_t>(half_vertex_count(cells_));
        out.bytes = static_cast<std::int64_t>(4 * (sizeof(ChildHalf) + sizeof(HalfFacts) + heights));
        return out;
    }
    for (const ChildHalf& child : refinement->children) {
        out.bytes += bytes_of_heights(child);
        if (shown(judge(child, n.level + 1))) out += {static_cast<std::int64_t>(maker_.mesh_bytes()), 1, 1};
    }
    for (const LiveHalf& half : n.halves) out = add(out, half, -1);
    return out;
}

Refiner::State::Load Refiner::State::load_of_coarsening(LiveNode& n) {
    Load out;
    for (const LiveHalf* child : n.child_halves) {
        out.bytes -= bytes_of_heights(child->data);
        out = add(out, *child, -1);
    }
    for (LiveHalf& half : n.halves) {
        if (half.judged != frame_) judge(half);
        out = add(out, half, 1);
    }
    return out;
}

// Where it is wanted, and not at the cost of the other.
bool Refiner::State::helps(const Load& change, const Load& total) const {
    if (total.bytes > most_.bytes && change.bytes < 0) return true;
    if (total.patches > most_.patches && change.patches < 0) return true;
    return total.uploads > most_.uploads && change.uploads < 0;
}

// Whether coarsening what matters less than n lets it be refined, which adds so much: then chosen_ is that.
bool Refiner::State::choose_room(const LiveNode& n, const Load& change) {
    constexpr std::size_t kMost = 64;  // as much as is worth one refinement
    chosen_.clear();
    Load extra = change;
    const auto total = [&] {
        Load out = load();
        out += extra;
        return out;
    };
    if (!exceeds(total())) return true;
    put_back(set_aside_);
    while (exceeds(total()) && chosen_.size() < kMost) {
        LiveNode* const least = pop_least(n.priority);
        if (least == nullptr) break;
        const Load less = load_of_coarsening(*least);
        const bool useful = helps(less, total());
        if (!useful && drop_unneeded(*least, less)) continue;
        choose(*least, useful);
        extra += less;
    }
    const bool enough = !exceeds(total());
    if (enough) keep_what_helps(total());
    for (const Chosen& c : chosen_) c.node->chosen = false;
    for (const Chosen& c : chosen_) enqueue(*c.node);
    return enough;
}

// What is in the way of what makes room, and no longer needed. False if n is not, or may not go now.
bool Refiner::State::drop_unneeded(LiveNode& n, const Load& change) {
    if (n.needed == frame_ || LiveGraph::has_refined_child(n) || time_is_up()) return false;
    if (change.bytes > 0 || change.patches > 0 || !uncover(n, 0, true)) return false;
    coarsen(n);
    return true;
}

void Refiner::State::choose(LiveNode& n, bool helps) {
    n.chosen = true;
    chosen_.push_back({&n, helps});
    enqueue_parents(n);
}

// Of chosen_, whose result is so much in all.
void Refiner::State::keep_what_helps(Load total) {
    const auto helps = [this](const Chosen& c) {
        if (c.helps || c.node->level == 0) return c.helps;
        const auto is_kept = [this, &c](int side) { return graph_.find(*parent(c.node->id, side))->chosen; };
        return is_kept(0) || is_kept(1);
    };
    for (auto c = chosen_.rbegin(); c != chosen_.rend(); ++c) c->node->chosen = c->helps = helps(*c);
    for (const Chosen& c : chosen_) {
        if (c.helps) continue;
        const Load change = load_of_coarsening(*c.node);
        total += {-change.bytes, -change.patches, -change.uploads};
    }
    if (exceeds(total)) return;
    for (const Chosen& c : chosen_)
        if (!c.helps) enqueue(*c.node);
    std::erase_if(chosen_, [](const Chosen& c) { return !c.helps; });
}

// Precondition: choose_room().
Refiner::State::Step Refiner::State::make_room(const LiveNode& n) {
    bool ready = true;
    for (const Chosen& c : chosen_) c.node->chosen = true;
    for (const Chosen& c : chosen_) ready = uncover(*c.node, n.priority, true) && ready;
    for (const Chosen& c : chosen_) c.node->chosen = false;
    if (!ready) return Step::blocked;
    for (const Chosen& c : chosen_) coarsen(*c.node);
    return Step::done;
}

// A change of the view may bring more into sight than the budgets allow. What matters least is coarsened,
// where that helps or costs nothing; else what is in the way, a little at a time. Meshes that this uncovers
// may be missing then.
void Refiner::State::meet_budgets() {
    constexpr int kAtATime = 16;
    const auto over = [this] { return exceeds(load()) || uploads_ > most_.uploads; };
    if (!over()) return;
    put_back(set_aside_);
    for (int in_the_way = 0; over();) {
        LiveNode* const least = pop_least(std::numeric_limits<double>::infinity());
        if (least == nullptr && useless_.empty()) return;
        if (least == nullptr) {
            in_the_way = kAtATime;
            put_back(useless_);
        } else if (helps(load_of_coarsening(*least), load()) || costs_nothing(*least) || in_the_way-- > 0) {
            coarsen(*least);
        } else {
            useless_.push_back(least->id);
        }
    }
}

bool Refiner::State::costs_nothing(LiveNode& n) {
    const Load change = load_of_coarsening(n);
    const auto has_mesh = [this](const LiveHalf& half) { return half.data.mesh || !shown(half); };
    return n.needed != frame_ && change.bytes <= 0 && change.patches <= 0 && change.uploads <= 0 &&
           has_mesh(n.halves[0]) && has_mesh(n.halves[1]);
}

// Meshes of refined diamonds serve only to coarsen at once, those out of sight for when they come into it.
void Refiner::State::drop_unseen_meshes(bool coarsenable_too) {
    for (const auto& n : graph_.nodes()) {
        if (n->level == 0 || (!coarsenable_too && !(n->refined && LiveGraph::has_refined_child(*n))))
            continue;
        for (LiveHalf& half : n->halves) {
            if (!half.exists || !half.data.mesh || (!n->refined && shown(half))) continue;
            if (live_bytes_ + cache_.bytes() <= options_.bytes) return;
            if (half.in_seams) seams_.remove(half);
            live_bytes_ -= maker_.mesh_bytes();
            pool_.discard(std::exchange(half.data.mesh, nullptr));
            half.data.published = false;
        }
    }
}

// Drops first what is easiest to make again and least likely to be wanted.
void Refiner::State::keep_within_memory() {
    const auto over = [this] { return live_bytes_ + cache_.bytes() > options_.bytes; };
    if (!over()) return;
    for (const DiamondId id : in_hand_) (void)cache_.find(id);  // to be dropped last
    drop_unseen_meshes(false);
    while (over() && !cache_.empty() && !in_hand_.contains(cache_.oldest())) discard(cache_.extract_oldest());
    drop_unseen_meshes(true);
    while (over() && !cache_.empty()) discard(cache_.extract_oldest());
}

}  // namespace carat
