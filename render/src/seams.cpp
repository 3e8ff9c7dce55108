#include "seams.hpp"

#include <algorithm>
#include <cassert>
#include <utility>

namespace carat {

Seams::Seams(int cells, FrameHeap& heap)
    : cells_(cells), heap_(&heap), normals_(static_cast<std::size_t>(cells - 1)) {}

void Seams::spoil(Table& table, const LatticePoint& at, Seam& seam) {
    if (seam.stale) return;
    seam.stale = true;
    ++pending_;
    table.stale.push_back(at);
}

void Seams::add(Table& table, const LatticePoint& at, LiveHalf& half, int part) {
    Seam& seam = table.seams.try_emplace(at, heap_).first->second;
    const auto place = std::find_if(seam.uses.begin(), seam.uses.end(),
                                    [&](const Use& u) { return half.half() < u.half->half(); });
    seam.uses.insert(place, {&half, part});
    spoil(table, at, seam);
}

void Seams::remove(Table& table, const LatticePoint& at, LiveHalf& half) {
    const auto it = table.seams.find(at);
    Seam& seam = it->second;
    std::erase_if(seam.uses, [&](const Use& u) { return u.half == &half; });
    if (!seam.uses.empty()) return spoil(table, at, seam);
    if (seam.stale) --pending_;
    table.seams.erase(it);
}

void Seams::add(LiveHalf& half) {
    assert(half.data.mesh && !half.in_seams);
    half.in_seams = true;
    const std::array<LatticePoint, 3> middles = edge_midpoints(half.half()),
                                      ends = corner_points(half.half());
    for (const int part : {0, 1, 2}) {
        add(edges_, middles[static_cast<std::size_t>(part)], half, part);
        add(corners_, ends[static_cast<std::size_t>(part)], half, part);
    }
}

void Seams::remove(LiveHalf& half) {
    assert(half.in_seams);
    half.in_seams = false;
    for (const LatticePoint& p : edge_midpoints(half.half())) remove(edges_, p, half);
    for (const LatticePoint& p : corner_points(half.half())) remove(corners_, p, half);
}

// A mesh that nobody else looks at.
PatchMesh& Seams::own_mesh(LiveHalf& half) {
    if (half.data.published) {
        std::shared_ptr<PatchMesh> mesh;
        if (spares_->empty()) {
            mesh = std::make_shared<PatchMesh>(*half.data.mesh);
        } else {
            mesh = std::move(spares_->back());
            spares_->pop_back();
            *mesh = *half.data.mesh;
        }
        old_->push_back(std::exchange(half.data.mesh, std::move(mesh)));
        half.data.published = false;
        if (copies_ > 0) --copies_;
    }
    return *half.data.mesh;
}

void Seams::gather(const Seam& seam) {
    uses_.clear();
    for (const Use& u : seam.uses) uses_.push_back({u.half->data.mesh.get(), u.part});
}

void Seams::stitch_edge(const Seam& seam) {
    gather(seam);
    edge_normals(cells_, uses_, normals_);
    for (const Use& u : seam.uses) {
        const EdgePath path(u.half->half(), u.part, cells_);
        const auto differs = [&](int t) {
            return u.half->data.mesh->vertices[path(t)].normal != normals_[static_cast<std::size_t>(t - 1)];
        };
        int t = 1;
        while (t < cells_ && !differs(t)) ++t;
        if (t == cells_) continue;
        PatchMesh& mesh = own_mesh(*u.half);
        for (; t < cells_; ++t) mesh.vertices[path(t)].normal = normals_[static_cast<std::size_t>(t - 1)];
    }
}

void Seams::stitch_corner(const Seam& seam) {
    gather(seam);
    const CodedNormal normal = corner_normal(cells_, uses_);
    for (const Use& u : seam.uses) {
        const std::uint32_t index = corner_vertex_index(u.part, cells_);
        if (u.half->data.mesh->vertices[index].normal != normal)
            own_mesh(*u.half).vertices[index].normal = normal;
    }
}

template <class Stitch>
bool Seams::work_through(Table& table, const Limits& limits, Stitch stitch) {
    while (!table.stale.empty()) {
        if (stitched_ && (copies_ == 0 || Clock::now() >= limits.deadline)) return false;
        const auto it = table.seams.find(table.stale.back());
        const bool stale = it != table.seams.end() && it->second.stale;
        if (stale && stitched_ && copies_ < it->second.uses.size()) return false;
        if (stale && limits.only_spares && spares_->size() < it->second.uses.size() + limits.spares_left)
            return false;
        table.stale.pop_back();
        if (!stale) continue;
        stitch(it->second);
        stitched_ = true;
        it->second.stale = false;
        --pending_;
    }
    return true;
}

void Seams::stitch(const Limits& limits, std::pmr::vector<std::shared_ptr<PatchMesh>>& spares,
                   std::pmr::vector<std::shared_ptr<PatchMesh>>& old) {
    spares_ = &spares;
    old_ = &old;
    copies_ = limits.copies;
    stitched_ = false;
    if (work_through(edges_, limits, [this](const Seam& seam) { stitch_edge(seam); }))
        work_through(corners_, limits, [this](const Seam& seam) { stitch_corner(seam); });
}

}  // namespace carat
