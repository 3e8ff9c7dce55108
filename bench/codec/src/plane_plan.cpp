#include <algorithm>
#include <unordered_map>

#include "carat/bench/plane.hpp"
#include "carat/globe/error.hpp"

namespace carat::bench {
namespace {

constexpr int kFace = 4;  // +z: x and y of the lattice are x and y of the plane
constexpr int kGreatestK = 14;

class Planner {
  public:
    Planner(int width, int height) {
        plan_.width = width;
        plan_.height = height;
        while ((kPlaneCells << plan_.k) < std::max(width, height) - 1) ++plan_.k;
        if (plan_.k > kGreatestK) throw Error(ErrorCode::limit, "a raster of more than 2^20 samples a side");
        shift_ = kLatticeBits - 5 - plan_.k;
    }

    PlanePlan run() {
        visit_leaves(0, 0, 1 << plan_.k);
        assign_slots();
        return std::move(plan_);
    }

  private:
    // Leaf squares [a, a + size) x [b, b + size), in Morton order.
    void visit_leaves(int a, int b, int size) {
        if (a * kPlaneCells > std::max(plan_.width - 2, 0) || b * kPlaneCells > std::max(plan_.height - 2, 0))
            return;
        if (size > 1) {
            const int half = size / 2;
            for (int q = 0; q < 4; ++q) visit_leaves(a + (q & 1) * half, b + (q >> 1) * half, half);
            return;
        }
        const auto centre = [&](int cell) {
            return ((std::int64_t{cell} * kPlaneCells + kPlaneCells / 2) << shift_) - kLatticeExtent;
        };
        visit(DiamondId::of_centre(narrow({centre(a), centre(b), kLatticeExtent})));
        ++plan_.leaves;
    }

    int visit(DiamondId d) {
        if (const auto known = known_.find(d); known != known_.end()) return known->second;
        PlaneStep step;
        step.id = d;
        step.level = d.level();
        const DiamondCorners corner = corners(d);
        for (std::size_t side = 0; side < 2; ++side) {
            step.has[side] = on_face(corner.x[side], kFace);
            if (!step.has[side] || step.level == 0) continue;
            step.parent[side] = *parent(d, static_cast<int>(side));
            step.parent_step[side] = visit(step.parent[side]);
        }
        step.frame = pixel_frame({d, step.has[0] ? 0 : 1});
        find_maps(step);
        const int index = static_cast<int>(plan_.steps.size());
        plan_.steps.push_back(step);
        known_.emplace(d, index);
        return index;
    }

    void find_maps(PlaneStep& step) const {
        for (std::size_t side = 0; side < 2; ++side) {
            if (step.parent_step[side] < 0) continue;
            step.map[side] = child_map(step.parent[side], {step.id, static_cast<int>(side)}, kPlaneCells);
            if (step.level == 2 * plan_.k) along_raster(step.frame, step.map[side], step.part[side]);
        }
    }

    // Rows go down the raster and columns to its right instead of along the half's own axes.
    static void along_raster(const PixelFrame& f, ChildMap& m, Triangle& part) {
        const auto reverse = [](int& at, int& step) {
            at += kPlaneCells * step;
            step = -step;
        };
        const bool turned = f.ux != 0, flip_i = f.ux + f.uy < 0, flip_j = f.vx + f.vy < 0;
        if (flip_i) {
            reverse(m.p0, m.pi);
            reverse(m.q0, m.qi);
        }
        if (flip_j) {
            reverse(m.p0, m.pj);
            reverse(m.q0, m.qj);
        }
        bool lower = part == Triangle::left_lower;  // i >= j, before and after flipping i and j
        if (flip_i && flip_j) lower = !lower;
        if (flip_i == flip_j) {
            if (turned) lower = !lower;
            part = lower ? Triangle::left_lower : Triangle::right_upper;
        } else {  // N - 1 - i >= j, or i >= N - 1 - j
            part = lower == flip_i ? Triangle::left_upper : Triangle::right_lower;
        }
        if (turned) {
            std::swap(m.pi, m.pj);
            std::swap(m.qi, m.qj);
        }
    }

    // One cell of the frame is two half cells, one sample two half samples.
    PixelFrame pixel_frame(const Half& half) const {
        const HalfFrame f = half_frame(half, kPlaneCells);
        const auto samples = [&](std::int64_t x) { return static_cast<int>(x >> shift_); };
        return {2 * samples(f.origin.x + kLatticeExtent),
                2 * samples(f.origin.y + kLatticeExtent),
                samples(f.u.x),
                samples(f.u.y),
                samples(f.v.x),
                samples(f.v.y)};
    }

    // A slot is free again once all visited children have gathered their halves.
    void assign_slots() {
        std::vector<int> pending(plan_.steps.size()), free;
        for (const PlaneStep& step : plan_.steps)
            for (const int p : step.parent_step)
                if (p >= 0) ++pending[static_cast<std::size_t>(p)];
        for (PlaneStep& step : plan_.steps) {
            for (std::size_t side = 0; side < 2; ++side) {
                if (step.parent_step[side] < 0) continue;
                const auto above = static_cast<std::size_t>(step.parent_step[side]);
                step.parent_slot[side] = plan_.steps[above].slot;
                if (--pending[above] == 0) free.push_back(plan_.steps[above].slot);
            }
            if (step.level == 2 * plan_.k) continue;
            ++plan_.refined;
            if (free.empty()) free.push_back(plan_.slots++);
            step.slot = free.back();
            free.pop_back();
        }
    }

    PlanePlan plan_;
    int shift_ = 0;
    std::unordered_map<DiamondId, int, DiamondIdHash> known_;
};

}  // namespace

PlanePlan PlanePlan::of(int width, int height) {
    if (width < 1 || height < 1) throw Error(ErrorCode::usage, "a raster without samples");
    return Planner(width, height).run();
}

}  // namespace carat::bench
