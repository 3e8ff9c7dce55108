#include "walk.hpp"

#include <bit>
#include <deque>
#include <set>
#include <string>

#include "carat/codec/surface.hpp"

namespace carat::test {
namespace {

struct Hash {  // FNV-1a over 64-bit words
    std::uint64_t value = 0xCBF29CE484222325u;
    void add(std::uint64_t word) { value = (value ^ word) * 0x100000001B3u; }
    void add(std::int32_t word) { add(static_cast<std::uint64_t>(static_cast<std::uint32_t>(word))); }
    void add(double word) { add(std::bit_cast<std::uint64_t>(word)); }
    void add(const std::string& text) {
        for (const char c : text) add(static_cast<std::uint64_t>(static_cast<unsigned char>(c)));
        add(std::uint64_t{text.size()});
    }
    template <class T>
    void add(const std::vector<T>& words) {
        for (const T& w : words) add(w);
    }
};

void add_header(Hash& hash, const RepositoryHeader& h) {
    for (const double x : {h.quantum, h.tolerance, h.body_a, h.body_b}) hash.add(x);
    for (const std::int32_t x : {h.log2_cells, h.deepest_level, h.min_height, h.max_height}) hash.add(x);
    for (const std::string& s : {h.coder, h.body, h.vertical_datum, h.provenance}) hash.add(s);
    hash.add(h.refined_diamonds);
}

void add_summary(Hash& hash, const HalfSummary& s) {
    for (const double x : {s.min_height, s.max_height, s.delta}) hash.add(x);
}

// Visits refined diamonds, coarse to fine, both parents before their child.
template <class Visit>
void for_refined(const Repository& repository, int diamonds, Visit visit) {
    std::set<std::pair<int, DiamondId>> queue;
    for (int face = 0; face < kFaces; ++face) queue.insert({0, root_diamond(face)});
    for (; !queue.empty() && diamonds > 0; --diamonds) {
        const auto [level, d] = *queue.begin();
        queue.erase(queue.begin());
        if (!repository.refined(d)) continue;
        visit(d);
        for (const DiamondId k : children(d)) queue.insert({level + 1, k});
    }
}

}  // namespace

std::uint64_t walk(const std::shared_ptr<const Repository>& repository, int diamonds) {
    Hash hash;
    add_header(hash, repository->header());
    for (int face = 0; face < kFaces; ++face) hash.add(repository->root(face).values);
    const Surface surface(repository);
    for_refined(*repository, diamonds, [&](DiamondId d) {
        const auto refined = surface.refined_heights(d);
        hash.add(d.bits());
        hash.add(refined->v);
        hash.add(refined->c);
        for (int side = 0; side < 2; ++side) {
            add_summary(hash, repository->summary({d, side}));
            for (const Half& child : child_halves({d, side})) add_summary(hash, repository->summary(child));
        }
    });
    for (int face = 0; face < kFaces; ++face)
        for (const double x : {-0.97, -0.3, 0.2, 1.0}) {
            RealLattice place;
            place.face = face;
            place.coordinates.fill(x * static_cast<double>(kLatticeExtent));
            place.coordinates[static_cast<std::size_t>(face_axis(face))] =
                static_cast<double>(face_sign(face) * kLatticeExtent);
            hash.add(surface.sample(place).height);
        }
    return hash.value;
}

std::uint64_t hash_heights(const std::shared_ptr<const Repository>& repository) {
    Hash hash;
    const Surface surface(repository);
    for (int face = 0; face < kFaces; ++face) hash.add(repository->root(face).values);
    for_refined(*repository, 1 << 30, [&](DiamondId d) {
        const auto refined = surface.refined_heights(d);
        hash.add(d.bits());
        hash.add(refined->v);
        hash.add(refined->c);
    });
    return hash.value;
}

}  // namespace carat::test
