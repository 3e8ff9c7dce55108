#include "carat/render/refiner.hpp"

#include <algorithm>
#include <thread>

#include "carat/globe/error.hpp"
#include "carat/render/draw_list.hpp"
#include "refiner_state.hpp"
#include "stopwatch.hpp"
#include "thread_priority.hpp"

namespace carat {
namespace {

int worker_count(int threads) {
    return threads > 0 ? threads : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

ReadCounters difference(const ReadCounters& after, const ReadCounters& before) {
    return {after.pages - before.pages, after.bytes - before.bytes,
            after.diamonds_decoded - before.diamonds_decoded, after.diamonds_zero - before.diamonds_zero};
}

std::chrono::nanoseconds nanoseconds(double milliseconds) {
    return std::chrono::nanoseconds(static_cast<std::int64_t>(milliseconds * 1e6));
}

void check(bool ok, const char* what) {
    if (!ok) throw Error(ErrorCode::usage, what);
}

}  // namespace

Refiner::State::State(std::shared_ptr<const Repository> repository, const RefinerOptions& options)
    : repository_(std::move(repository)),
      options_(options),
      body_(repository_->header().ellipsoid()),
      cells_(repository_->header().cells()),
      unit_(length_unit(body_)),
      read_before_(repository_->counters()),
      maker_(*repository_, body_, options.colour, options.detail.get()),
      graph_(maker_, heap_),
      cache_(heap_),
      seams_(cells_, heap_),
      pool_(
          worker_count(options.threads), lower_thread_priority, [this](Work& task) { return work(task); },
          heap_) {
    if (options.colour) check_colours_fit(*options.colour, repository_->header());
    for (const auto& n : graph_.nodes())
        for (const LiveHalf& h : n->halves) {
            live_bytes_ += bytes_of(h.data);
            height_bytes_ += bytes_of_heights(h.data);
        }
}

void Refiner::State::begin(const View& view, const RefineGoal& goal, const RefineBudget& budget) {
    start_ = Clock::now();
    heap_.own();
    check(view.unit() == unit_, "the view is of another body than the file");
    check(goal.threshold > 0, "the threshold on screen must be positive");
    check(goal.spacing >= 0, "the spacing on screen must not be negative");
    check(budget.milliseconds > 0, "the time of a frame must be positive");
    constexpr double kForEver = 1e8;  // more than a day
    budget_ms_ = budget.milliseconds;
    to_the_end_ = !(budget.milliseconds < kForEver);
    direct_ = to_the_end_ && budget.upload_bytes == std::numeric_limits<std::size_t>::max();
    end_ = to_the_end_ ? Clock::time_point::max() : start_ + nanoseconds(budget.milliseconds);
    // What refinement leaves: a twentieth for border normals, and the lists.
    reserve_ms_ = std::min(0.4 * budget.milliseconds, 0.05 * budget.milliseconds + 1.5 * finish_ms_);
    deadline_ = to_the_end_ ? end_ : end_ - nanoseconds(reserve_ms_);
    ++frame_;
    goal_ = goal;
    set_limits(budget);
    full_ = false;
    counters_ = {};
    candidates_.clear();
    arrived_.clear();
    in_hand_.clear();
    coarsenable_.clear();
    set_aside_.clear();
    useless_.clear();
    spares_built_ = 0;
    queue_filled_ = false;
    missing_.clear();
    missing_ms_ = 0;
    requested_.clear();
    posted_.clear();
    visibility_ = heap_.share<Visibility>(
        visibility_of(repository_->header(), body_, view, goal.threshold, options_.detail.get()));
}

void Refiner::State::frame(const View& view, const RefineGoal& goal, const RefineBudget& budget,
                           RefinedFrame& out) {
    const double first = thread_milliseconds();
    begin(view, goal, budget);
    pool_.drop_unstarted();
    {
        const Stopwatch watch(counters_.selection_ms);
        collect();
        request_spares();
        select();
        meet_budgets();
        build_what_covering_costs_more();
    }
    refine_until_deadline();
    const double refined = thread_milliseconds();
    // Refinement may be done early, or late by the doings of others.
    const double left =
        std::max(reserve_ms_,
                 to_the_end_ ? 0 : std::chrono::duration<double, std::milli>(end_ - Clock::now()).count());
    collect();
    cover_missing_meshes();
    while (exceeds(load()) && graph_.refined() > 0) {  // always coarsens some
        meet_budgets();
        cover_missing_meshes();
    }
    keep_within_memory();
    finish(out);
    if (!to_the_end_) {
        const double last = thread_milliseconds();
        out.counters.late_ms = std::max({0.0, last - refined - left, last - first - budget.milliseconds});
    }
}

void Refiner::State::refine_until_deadline() {
    do {
        const Stopwatch watch(counters_.selection_ms);
        refine_candidates();
        coarsen_unneeded();
        request_missing_meshes();
        pool_.add(posted_);
    } while (!time_is_up() && wait_for_work());
}

// Patches that the frame draws from now on, and those it no longer does.
void Refiner::State::sync_seams() {
    constexpr int kLeast = 16;  // changes that every frame makes, however short
    int changes = 0;
    unsynced_ = 0;
    for (std::size_t k = 0; k < graph_.nodes().size();) {
        LiveNode& n = *graph_.nodes()[k];
        if (!n.halves[0].exists && !n.halves[1].exists) {
            graph_.remove_if_void(n);  // another node takes this place
            continue;
        }
        ++k;
        if (n.refined) continue;
        for (LiveHalf& half : n.halves) {
            // Culled halves, where they are drawn at all, are no neighbours: those in sight look the same.
            const bool drawn = half.exists && half.visible();
            if (drawn == half.in_seams) continue;
            if (!to_the_end_ && ++changes > kLeast && Clock::now() >= end_)
                ++unsynced_;  // its border waits for another frame
            else if (drawn)
                seams_.add(half);
            else
                seams_.remove(half);
        }
    }
}

void Refiner::State::finish(RefinedFrame& out) {
    double list_ms = 0;
    {
        const Stopwatch watch(list_ms);
        sync_seams();
    }
    {
        const Stopwatch watch(counters_.stitch_ms);
        const auto until = to_the_end_ ? end_ : end_ - nanoseconds(finish_ms_);
        const std::size_t spares = spares_.size();
        const std::int64_t copies = std::max<std::int64_t>(0, most_.uploads - uploads_);
        seams_.stitch({until, static_cast<std::uint64_t>(copies), !to_the_end_, kSparesForMissing}, spares_,
                      replaced_);
        spares_used_ = std::max(spares_built_ + spares - spares_.size(), spares_used_ - spares_used_ / 16);
        for (std::shared_ptr<PatchMesh>& mesh : replaced_) pool_.discard(std::move(mesh));
        replaced_.clear();
    }
    {
        const Stopwatch watch(list_ms);
        list_patches(out);
        count(out);
    }
    finish_ms_ = risen_or_eased(finish_ms_, list_ms);
    pool_.empty_waste();
    out.counters = counters_;
    out.counters.total_ms = std::chrono::duration<double, std::milli>(Clock::now() - start_).count();
}

void Refiner::State::list_patches(RefinedFrame& out) {
    listed_.clear();
    for (const auto& n : graph_.nodes()) {
        if (n->refined) continue;
        for (LiveHalf& half : n->halves) {
            if (!half.exists) continue;
            if (half.judgement.culled == Culled::frustum) ++counters_.culled_frustum;
            if (half.judgement.culled == Culled::horizon) ++counters_.culled_horizon;
            if (shown(half)) listed_.push_back(&half);
        }
    }
    std::sort(listed_.begin(), listed_.end(),
              [](const LiveHalf* l, const LiveHalf* r) { return l->half() < r->half(); });
    out.draw.clear();
    out.upload.clear();
    auto before = previous_.begin();
    for (LiveHalf* half : listed_) {
        half->data.published = true;
        half->listed = frame_;
        out.draw.push_back(half->data.mesh);
        while (before != previous_.end() && (*before)->half < half->half()) ++before;
        if (before == previous_.end() || *before != half->data.mesh) out.upload.push_back(half->data.mesh);
        counters_.worst_error = std::max(counters_.worst_error, half->judgement.error);
        if (half->judgement.error > goal_.threshold && !half->judgement.demands) ++counters_.limited;
    }
    pool_.discard(heap_.share<MeshList>(std::move(previous_)));
    previous_.assign(out.draw.begin(), out.draw.end());
}

void Refiner::State::count(RefinedFrame& out) {
    RefineCounters& c = counters_;
    std::uint64_t wanting = 0, too_many = 0;
    for (const auto& n : graph_.nodes()) {
        if (n->refined && !n->by_file()) ++c.virtual_refined;
        if (n->needed == frame_ && !n->refined) ++wanting;
        if (n->refined && n->needed != frame_) ++too_many;
    }
    c.refined = graph_.refined();
    c.patches = out.draw.size();
    c.triangles = c.patches * static_cast<std::uint64_t>(cells_) * static_cast<std::uint64_t>(cells_);
    c.uploads = out.upload.size();
    c.upload_bytes = c.uploads * maker_.mesh_bytes();
    c.unstitched = seams_.pending() + unsynced_;
    c.waiting = wanting;
    c.bytes = live_bytes_ + cache_.bytes();
    const ReadCounters read = repository_->counters();
    c.read = difference(read, std::exchange(read_before_, read));
    c.decoded = c.read.diamonds_decoded;
    c.predicted = c.read.diamonds_zero;
    out.converged = wanting == 0 && too_many == 0 && c.unstitched == 0;
}

Refiner::Refiner(std::shared_ptr<const Repository> repository, const RefinerOptions& options)
    : state_(std::make_unique<State>(std::move(repository), options)) {}
Refiner::~Refiner() = default;

RefinedFrame Refiner::frame(const View& view, const RefineGoal& goal, const RefineBudget& budget) {
    RefinedFrame out;
    state_->frame(view, goal, budget, out);
    return out;
}

void Refiner::frame(const View& view, const RefineGoal& goal, const RefineBudget& budget, RefinedFrame& out) {
    state_->frame(view, goal, budget, out);
}

}  // namespace carat
