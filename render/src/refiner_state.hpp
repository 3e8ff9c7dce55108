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

// The same both ways, whatever a single one was held up by.
inline double eased(double estimate, double measured) {
    return estimate + 0.1 * (std::min(measured, 4 * estimate) - estimate);
}

class Refiner::State {
  public:
    State(std::shared_ptr<const Repository> repository, const RefinerOptions& options);

    void frame(const View& view, const RefineGoal& goal, const RefineBudget& budget, RefinedFrame& out);

  private:
    using Clock = std::chrono::steady_clock;
    static constexpr double kUrgent = 1e12;           // priority of meshes that the frame cannot do without
    static constexpr double kGreatestPriority = 1e9;  // of finite errors, pixels
    static constexpr std::size_t kLeastSpares = 64, kMostSpares = 512;
    static constexpr std::size_t kSparesForMissing = 32;  // of these, for nothing else
    static constexpr std::uint64_t kShareOfSpares = 8;    // of the memory, at most
    static constexpr std::uint64_t kGrace = 10;           // frames that keep what they no longer need
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
    // A refined diamond without refined children: what the view does not need first, then least error first,
    // fine before coarse.
    struct Coarsenable {
        bool needed;
        double error;  // pixels, on screen once it is coarsened
        int level;
        DiamondId id;
        bool operator<(const Coarsenable& other) const;
    };
    struct Chosen {
        LiveNode* node;
        bool helps;  // or lies in the way of one that does
    };
    template <class T>
    struct Queue : std::priority_queue<T, List<T>> {
        using Base = std::priority_queue<T, List<T>>;
        using Base::Base;
        void clear() { Base::c.clear(); }
    };
    // What budgets limit, or what a change of the cut adds to it.
    struct Load {
        std::int64_t bytes = 0;    // of heights, and of the meshes of what is in sight
        std::int64_t patches = 0;  // in sight
        std::int64_t uploads = 0;  // of these, what the last frame did not draw
        Load& operator+=(const Load& other);
    };

    // refiner.cpp: a frame from its parts.
    void begin(const View& view, const RefineGoal& goal, const RefineBudget& budget);
    void refine_until_deadline();
    void finish(RefinedFrame& out);
    void sync_seams();
    void list_patches(RefinedFrame& out);
    void count(RefinedFrame& out);

    // refiner_select.cpp: which diamonds the view needs refined, in the cut as it is.
    void select();
    void work_through();  // open_
    void need(LiveNode& n, double priority);
    void judge(LiveHalf& half);
    static double priority(const LiveHalf& half);
    Judgement judge(const ChildHalf& child, int level) const;
    // Whether a frontier half judged so is drawn.
    bool shown(const Judgement& judgement) const;
    bool shown(const LiveHalf& half) const { return half.exists && shown(half.judgement); }
    void decode_unseen(LiveNode& n);
    void enter_frontier(LiveHalf& half);  // precondition: judged
    void leave_frontier(LiveHalf& half);

    // refiner_change.cpp: refining and coarsening.
    enum class Step {
        done,
        moot,     // not to be refined any more
        stale,    // named twice
        waits,    // for its own refinement or meshes: called again when they come
        blocked,  // until others are done
        full,     // a budget does not allow it
    };
    void refine_candidates();
    Step refine(const Candidate& c);
    Step refine(LiveNode& n);
    bool meshes_ready(const LiveNode& n, const Refinement& refinement);
    void install(LiveNode& n);
    void coarsen(LiveNode& n);
    bool uncover(LiveNode& n, double priority, bool here);
    void coarsen_with_children(LiveNode& n);

    // refiner_missing.cpp: halves in sight without mesh.
    double cover_ms(const Half& half) const;
    bool build_is_cheaper(double cover_ms) const { return cover_ms > build_ms_; }
    void add_missing(const LiveHalf& half);
    void remove_missing(const Half& half);
    void request_missing_meshes();
    bool build_missing_meshes();  // any
    void build_what_covering_costs_more();
    bool build_here(LiveHalf& half, std::size_t spares_left);
    void cover_missing_meshes();

    // refiner_coarsen.cpp: the coarsening queue, and what is no longer needed.
    Coarsenable coarsenable(LiveNode& n);
    static bool may_be_next(const LiveNode& n);
    void fill_queue();
    void enqueue(LiveNode& n);
    void enqueue_parents(const LiveNode& n);
    LiveNode* pop_least(double below);
    bool ripe(const LiveNode& n) const { return to_the_end_ || frame_ - n.needed > kGrace; }
    void put_back(List<DiamondId>& popped);
    void coarsen_unneeded();

    // refiner_budget.cpp: what the budgets allow.
    void set_limits(const RefineBudget& budget);
    Load load() const;
    std::int64_t bytes_of_heights(const ChildHalf& child) const;
    bool is_upload(const LiveHalf& half) const { return half.listed + 1 != frame_; }
    Load add(Load load, const LiveHalf& half, int sign) const;
    Load load_of_refining(const LiveNode& n, const Refinement* refinement) const;
    Load load_of_coarsening(LiveNode& n);
    bool exceeds(const Load& l) const { return l.bytes > most_.bytes || l.patches > most_.patches; }
    bool fits(const Load& change) const {
        Load total = load();
        total += change;
        return !exceeds(total);
    }
    bool helps(const Load& change, const Load& total) const;
    bool choose_room(const LiveNode& n, const Load& change);
    bool drop_unneeded(LiveNode& n, const Load& change);
    void choose(LiveNode& n, bool helps);
    void keep_what_helps(Load total);
    Step make_room(const LiveNode& n);
    void meet_budgets();
    bool costs_nothing(LiveNode& n);
    void drop_unseen_meshes(bool coarsenable_too);
    void keep_within_memory();

    // refiner_work.cpp: asking the workers, and what comes back.
    void request(const LiveNode& n);
    void request_mesh(const ChildHalf& child, double priority);
    void request_spares();
    WorkResult work(Work& work) const;
    bool wait_for_work();
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
    void tell_candidate(const LiveNode& n);

    // Of refinement: leaves what building or covering halves without meshes would take if it were now.
    Clock::time_point stop_at() const {
        if (to_the_end_ || missing_.empty()) return deadline_;
        const double ms = std::min(0.5 * budget_ms_, missing_ms_);
        return deadline_ - std::chrono::nanoseconds(static_cast<std::int64_t>(1e6 * ms));
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
    std::uint64_t frame_ = 1;                   // 0, 1: none
    Clock::time_point start_, deadline_, end_;  // of refinement; of the frame
    double budget_ms_ = 0;
    bool to_the_end_ = false;  // no time limit: the least cut, nothing kept
    bool direct_ = false;      // moreover, no meshes for steps on the way
    RefineGoal goal_;
    Load most_;          // that the budgets allow
    bool full_ = false;  // a budget other than time stopped refinement
    std::shared_ptr<const Visibility> visibility_;
    Queue<Candidate> candidates_{List<Candidate>::allocator_type(&heap_)};
    Queue<Candidate> arrived_{List<Candidate>::allocator_type(&heap_)};  // in hand, with new results
    // Diamonds to refine that workers work for, or whose refinement is there and waits for meshes or a
    // budget: no more than fit into what the cut leaves of the memory.
    std::pmr::unordered_set<DiamondId, DiamondIdHash> in_hand_{&heap_};
    std::size_t most_in_hand_ = 0;
    Queue<Coarsenable> coarsenable_{List<Coarsenable>::allocator_type(&heap_)};
    bool queue_filled_ = false;          // coarsenable_; else it is empty
    List<Chosen> chosen_{&heap_};        // to coarsen, in this order
    List<DiamondId> set_aside_{&heap_};  // popped in this frame, to be coarsened only if it must be
    List<DiamondId> useless_{&heap_};    // the same, and making no room
    List<LiveHalf*> open_{&heap_};       // to judge
    List<LiveHalf*> listed_{&heap_};     // to draw
    bool unneeded_ = false;              // anything is refined and ripe to be coarsened
    // Frontier halves in sight without mesh, and what covering each would take; in all, if what is cheaper is
    // done.
    std::pmr::unordered_map<Half, double, HalfHash> missing_{&heap_};
    double missing_ms_ = 0;
    Pool::Jobs posted_{&heap_};  // asked for, not yet in the pool
    std::pmr::unordered_set<std::uint64_t> requested_{&heap_};
    std::exception_ptr error_;    // of a worker
    std::uint64_t unsynced_ = 0;  // patches whose coming or going their neighbours have not been told
    std::int64_t drawn_ = 0, uploads_ = 0;  // frontier halves in sight; of these, new to the list
    RefineCounters counters_;

    // Of all frames.
    std::uint64_t live_bytes_ = 0;   // in the graph
    std::int64_t height_bytes_ = 0;  // of these, without meshes
    double reserve_ms_ = 0;          // of the frame, after refinement
    double coarsen_ms_ = 0.003;      // what coarsening a diamond took lately
    double build_ms_ = 0.02;         // the same of building a mesh here
    double finish_ms_ = 0.2;         // what a frame's end took lately
    MeshList previous_{&heap_};      // drawn in the last frame, by half
    List<std::shared_ptr<PatchMesh>> spares_{&heap_}, replaced_{&heap_};
    std::size_t spares_used_ = 0;   // in a frame lately
    std::size_t spares_built_ = 0;  // in this frame, by build_here()

    Pool pool_;  // last: its threads use the members above
};

}  // namespace carat
