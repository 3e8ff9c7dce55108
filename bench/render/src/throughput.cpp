#include "carat/bench/throughput.hpp"

#include <time.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstring>
#include <limits>
#include <random>
#include <thread>

#include "carat/globe/patch.hpp"
#include "refinement.hpp"

namespace carat::bench {
namespace {

using Clock = std::chrono::steady_clock;

// Of this thread: what a core needs, whoever else wants it.
double cpu_seconds() {
    timespec t{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

// Refinements of the file with the heights they start from.
class Sample {
  public:
    Sample(const Repository& repository, const RefinementMaker& maker) : maker_(maker) {
        for (int face = 0; face < kFaces; ++face) {
            const std::array<ChildHalf, 2> halves = maker.face(face);
            open_.push_back({halves[0].half.diamond, 0, true, {halves[0].heights, halves[1].heights}, {}});
        }
        deepest_ = repository.header().deepest_level;
    }

    // Refines level by level until `count` diamonds are open whose refinement the file holds.
    std::vector<RefineWork> take(int count) {
        for (int level = 0; level + 1 < deepest_; ++level) {
            std::vector<RefineWork> next = refine_all();
            if (next.empty()) break;
            if (static_cast<int>(next.size()) > 4 * count) next.resize(static_cast<std::size_t>(4 * count));
            open_ = std::move(next);
            if (static_cast<int>(open_.size()) >= count) kept_ = open_;
        }
        if (kept_.empty()) kept_ = open_;
        if (static_cast<int>(kept_.size()) > count) kept_.resize(static_cast<std::size_t>(count));
        return kept_;
    }

  private:
    // The refined children with both halves, in the order of their ids.
    std::vector<RefineWork> refine_all() const {
        std::vector<ChildHalf> halves;
        WorkTimes times;
        for (const RefineWork& work : open_) {
            const std::unique_ptr<Refinement> refinement = maker_.refine(work, times);
            for (ChildHalf& child : refinement->children)
                if (child.refined_by_file) halves.push_back(std::move(child));
        }
        std::sort(halves.begin(), halves.end(),
                  [](const ChildHalf& l, const ChildHalf& r) { return l.half < r.half; });
        std::vector<RefineWork> out;
        for (std::size_t k = 1; k < halves.size(); ++k)
            if (halves[k].half.diamond == halves[k - 1].half.diamond)
                out.push_back({halves[k].half.diamond,
                               open_[0].level + 1,
                               true,
                               {halves[k - 1].heights, halves[k].heights},
                               {}});
        return out;
    }

    const RefinementMaker& maker_;
    int deepest_ = 0;
    std::vector<RefineWork> open_, kept_;
};

// A view that culls nothing and demands everything.
MeshWish all_meshes(const Repository& repository, const Ellipsoid& body) {
    ViewRequest request;
    request.height = 2 * body.a();
    const RepositoryHeader& h = repository.header();
    MeshWish wish;
    wish.visibility = std::make_shared<const Visibility>(View(body, request), body, h.min_height * h.quantum,
                                                         h.max_height * h.quantum, 1);
    wish.threshold = 1;
    wish.culled_too = true;
    return wish;
}

struct Round {
    double seconds = 0, core_seconds = 0;
    WorkTimes times;
};

Round run_round(const RefinementMaker& maker, const std::vector<RefineWork>& work, int threads) {
    std::atomic<std::size_t> next{0};
    std::vector<Round> parts(static_cast<std::size_t>(threads));
    const auto run = [&](Round& own) {
        const double begin = cpu_seconds();
        for (std::size_t k = next++; k < work.size(); k = next++) (void)maker.refine(work[k], own.times);
        own.core_seconds = cpu_seconds() - begin;
    };
    const Clock::time_point start = Clock::now();
    std::vector<std::thread> others;
    for (int t = 1; t < threads; ++t) others.emplace_back(run, std::ref(parts[static_cast<std::size_t>(t)]));
    run(parts[0]);
    for (std::thread& t : others) t.join();
    Round round{seconds_since(start), 0, {}};
    for (const Round& part : parts) {
        round.core_seconds += part.core_seconds;
        round.times.decode_ms += part.times.decode_ms;
        round.times.build_ms += part.times.build_ms;
        round.times.built += part.times.built;
    }
    return round;
}

double copy_rate(std::size_t block, std::size_t blocks) {
    std::vector<char> from(block * 64, 1), to(block * 64);
    const double begin = cpu_seconds();
    for (std::size_t k = 0; k < blocks; ++k)
        std::memcpy(to.data() + (k % 64) * block, from.data() + (k % 64) * block, block);
    const double seconds = cpu_seconds() - begin;
    return to[block / 2] == 1 ? static_cast<double>(block * blocks) / seconds : 0;
}

}  // namespace

Throughput measure_throughput(const std::shared_ptr<const Repository>& repository,
                              const ThroughputOptions& options) {
    const Ellipsoid body = repository->header().ellipsoid();
    const RefinementMaker maker(*repository, body);
    std::vector<RefineWork> work = Sample(*repository, maker).take(options.diamonds);
    const MeshWish wish = all_meshes(*repository, body);
    for (RefineWork& w : work) w.wish = wish;

    const double cells = repository->header().cells(),
                 vertices = half_vertex_count(repository->header().cells());
    const auto count = static_cast<double>(work.size());
    Throughput out;
    out.diamonds = work.size();
    out.bytes_a_diamond = 4 * vertices * (sizeof(PatchVertex) + sizeof(std::int32_t));
    for (const int threads : options.threads) {
        Round best{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity(), {}};
        double wall = std::numeric_limits<double>::infinity();
        for (int k = 0; k < options.rounds; ++k) {
            const Round round = run_round(maker, work, threads);
            if (round.core_seconds < best.core_seconds) best = round;
            wall = std::min(wall, round.seconds);
        }
        const double busy = best.times.decode_ms + best.times.build_ms;
        out.rows.push_back({threads, count / wall, count * cells * cells / wall,
                            count * cells * cells / best.core_seconds,
                            static_cast<double>(best.times.built) * vertices / wall,
                            best.times.decode_ms / busy, best.times.build_ms / busy});
    }
    for (int k = 0; k < options.rounds; ++k)
        out.copy_bytes_per_second = std::max(
            out.copy_bytes_per_second, copy_rate(static_cast<std::size_t>(out.bytes_a_diamond), work.size()));
    return out;
}

}  // namespace carat::bench
