// The frame loop of a Refiner.
#pragma once

#include <algorithm>
#include <chrono>
#include <queue>
#include <unordered_set>
#include <variant>

#include "carat/render/refiner.hpp"
#include "frame_heap.hpp"
#include "live_graph.hpp"
#include "refinement_cache.hpp"
#include "seams.hpp"
#include "worker_pool.hpp"

namespace carat {

// An estimate that follows its measurements up at once and down slowly.
inline double risen_or_eased(double estimate, double measured) {
    return std::max(measured, estimate + 0.1 * (measured - estimate));
}

class Refiner::State {
  public:
    State(std::shared_ptr<const Repository> repository, const RefinerOptions& options);

    void frame(const View& view, const RefineGoal& goal, const RefineBudget& budget, RefinedFrame& out);

  private:
    using Clock = std::chrono::steady_clock;
    static constexpr double kUrgent = 1e12;           // priority of meshes that the frame cannot do without
    static constexpr double kGreatestPriority = 1e9;  // of errors, which may be infinite
    static constexpr std::size_t kLeastSpares = 32, kMostSpares = 512;
    static constexpr std::uint64_t kGrace = 10;  // frames that keep what they no longer need
    // Of the workers' tasks: a mesh of a half, or as many of none.
    struct MeshWork {
        Half half;
        std::shared_ptr<const HalfHeights> heights;
    };
    struct SpareWork {
        int count = 0;
    };
    using Work = std::variant<RefineWork, MeshWork, SpareWork>;
    struct WorkResult {
        std::unique_ptr<Refinement> refinement;
        std::shared_ptr<PatchMesh> mesh;
        std::vector<std::shared_ptr<PatchMesh>> spares;
        WorkTimes times;
    };
    using Pool = WorkerPool<Work, WorkResult>;
    template <class T>
    using List = std::pmr::vector<T>;  // in heap_
    using MeshList = List<std::shared_ptr<const PatchMesh>>;
    // A diamond to refine: greatest error first, coarse before fine.
    struct Candidate {
        double priority;
        int level;
        DiamondId id;
        bool operator<(const Candidate& other) const;
    };
    struct Unneeded {
        int level;
        DiamondId id;
        bool operator<(const Unneeded& other) const {
            return level != other.level ? level > other.level : id < other.id;
        }
    };
    struct Candidates : std::priority_queue<Candidate, List<Candidate>> {
        using priority_queue::priority_queue;
        void clear() { c.clear(); }
    };

    // refiner.cpp: a frame from its parts.
    void begin(const View& view, const RefineGoal& goal, const RefineBudget& budget);
    void refine_until_deadline();
    void finish(RefinedFrame& out);
    void sync_seams();
    void shrink_cache();
    void list_patches(RefinedFrame& out);
    void count(RefinedFrame& out);

    // refiner_select.cpp: which diamonds the view needs refined, in the cut as it is.
    void select();
    void work_through();  // open_
    void need(LiveNode& n, double priority);
    void judge(LiveHalf& half);
    Judgement judge(const ChildHalf& child, int level) const;
    // Whether a frontier half judged so is drawn.
    bool shown(const Judgement& judgement) const;
    bool shown(const LiveHalf& half) const { return half.exists && shown(half.judgement); }
    void enter_frontier(LiveHalf& half);  // precondition: judged
    void leave_frontier(LiveHalf& half);

    // refiner_change.cpp: refining and coarsening within the budgets.
    enum class Step { done, waits, full };
    void refine_candidates();
    Step refine(LiveNode& n);
    bool meshes_ready(const LiveNode& n, const Refinement& refinement);
    bool within_uploads(const LiveNode& n, const Refinement& refinement) const;
    bool within_budgets(const LiveNode& n, const Refinement& refinement) const;
    bool make_room(double priority);
    void install(LiveNode& n);
    void coarsen(LiveNode& n);
    bool try_coarsen(LiveNode& n, double priority);
    void coarsen_unneeded();
    void coarsen_with_children(LiveNode& n);
    void cover_missing_meshes();
    void drop_inner_meshes();

    // refiner_work.cpp: asking the workers, and what comes back.
    void request(const LiveNode& n);
    void request_mesh(const ChildHalf& child, double priority);
    void request_missing_meshes();
    void request_spares();
    WorkResult work(Work& work) const;
    bool wait_for_work();
    bool build_missing_meshes();  // any
    // Whether there were results.
    bool collect();
    void collect(Pool::Done& done);
    // Workers destroy what falls away: that takes longer than a frame may.
    void discard(std::unique_ptr<Refinement> refinement) {
        using Allocator = std::pmr::polymorphic_allocator<Refinement>;
        if (refinement)
            pool_.discard(std::shared_ptr<const Refinement>(
                refinement.release(), std::default_delete<const Refinement>(), Allocator(&heap_)));
    }
    void take_refinement(std::unique_ptr<Refinement> refinement);
    // Leaves one that is not wanted.
    void take_mesh(std::shared_ptr<PatchMesh>& mesh);

    // Of refinement: leaves what covering halves without meshes would take if it were now.
    Clock::time_point stop_at() const {
        if (to_the_end_ || missing_.empty()) return deadline_;
        const double cover_ms = std::min(0.3 * budget_ms_, cover_ms_ * static_cast<double>(missing_.size()));
        return deadline_ - std::chrono::nanoseconds(static_cast<std::int64_t>(1e6 * cover_ms));
    }
    bool time_is_up() const { return Clock::now() >= stop_at(); }

    const std::shared_ptr<const Repository> repository_;
    const RefinerOptions options_;
    const Ellipsoid body_;
    const int cells_;
    const double unit_;
    ReadCounters read_before_;  // what had been read by the end of the last frame
    const RefinementMaker maker_;
    FrameHeap heap_;  // before all that lies in it
    LiveGraph graph_;
    RefinementCache cache_;
    Seams seams_;

    // Of the current frame.
    std::uint64_t frame_ = 0;
    Clock::time_point start_, deadline_, end_;  // of refinement; of the frame
    double budget_ms_ = 0;
    bool to_the_end_ = false;  // no time limit: the least cut, nothing kept
    bool direct_ = false;      // moreover, no meshes for steps on the way
    RefineGoal goal_;
    std::uint64_t upload_left_ = 0;  // bytes
    bool full_ = false;              // a budget other than time stopped refinement
    std::shared_ptr<const Visibility> visibility_;
    Candidates candidates_{List<Candidate>::allocator_type(&heap_)};
    List<LiveHalf*> open_{&heap_};                             // to judge
    List<LiveHalf*> listed_{&heap_};                           // to draw
    List<Unneeded> unneeded_{&heap_};                          // refined, fine before coarse
    std::pmr::unordered_set<Half, HalfHash> missing_{&heap_};  // frontier halves in sight without mesh
    Pool::Jobs posted_{&heap_};                                // asked for, not yet in the pool
    std::pmr::unordered_set<std::uint64_t> requested_{&heap_};
    std::exception_ptr error_;    // of a worker
    std::uint64_t unsynced_ = 0;  // patches whose coming or going their neighbours have not been told
    std::uint64_t drawn_ = 0;     // frontier halves in sight
    RefineCounters counters_;

    // Of all frames.
    std::uint64_t live_bytes_ = 0;  // in the graph
    double reserve_ms_ = 0;         // of the frame, after refinement
    double cover_ms_ = 0.005;       // what covering a half without mesh took lately
    double finish_ms_ = 0.2;        // what a frame's end took lately
    MeshList previous_{&heap_};     // drawn in the last frame, by half
    List<std::shared_ptr<PatchMesh>> spares_{&heap_}, replaced_{&heap_};
    std::size_t spares_used_ = 0;  // in a frame lately

    Pool pool_;  // last: its threads use the members above
};

}  // namespace carat
