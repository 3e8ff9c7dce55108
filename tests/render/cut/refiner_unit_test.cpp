// The workers behind the persistent cut: slow files, late work, damaged files.
#include <gtest/gtest.h>

#include <condition_variable>
#include <map>
#include <mutex>
#include <thread>

#include "carat/globe/error.hpp"
#include "carat/render/refiner.hpp"
#include "render/cut/support.hpp"

namespace carat::test {
namespace {

// Passes everything on to rough_earth(), but refines only while it is open, and notes what was refined.
class Gate final : public Repository {
  public:
    const RepositoryHeader& header() const override { return rough_earth().header(); }
    std::uint64_t file_bytes() const override { return 0; }
    ReadCounters counters() const override { return {}; }
    bool refined(DiamondId d) const override { return rough_earth().refined(d); }
    HalfSummary summary(const Half& half) const override { return rough_earth().summary(half); }
    Heights root(int face) const override { return rough_earth().root(face); }
    void refine(DiamondId d, const Heights& p, RefinedHeights& out) const override {
        {
            std::unique_lock lock(mutex_);
            ++times_[d];
            changed_.wait(lock, [this] { return open_; });
            if (broken_ == d) throw Error(ErrorCode::corrupt, "a page fails its checksum");
        }
        rough_earth().refine(d, p, out);
    }

    void open(bool open) {
        const std::lock_guard lock(mutex_);
        open_ = open;
        changed_.notify_all();
    }
    void damage(std::optional<DiamondId> d) {
        const std::lock_guard lock(mutex_);
        broken_ = d;
    }
    std::map<DiamondId, int> times() const {
        const std::lock_guard lock(mutex_);
        return times_;
    }

  private:
    mutable std::mutex mutex_;
    mutable std::condition_variable changed_;
    mutable std::map<DiamondId, int> times_;
    bool open_ = false;
    std::optional<DiamondId> broken_;
};

View near_view() { return test_views(rough_earth(), 1, 12).back().view; }

RefineBudget milliseconds(double ms) {
    RefineBudget budget;
    budget.milliseconds = ms;
    return budget;
}

TEST(Refiner, AFrameDoesNotWaitForData) {
    const auto gate = std::make_shared<Gate>();
    Refiner refiner(gate);
    // Returns at all, although no diamond can be refined.
    const RefinedFrame frame = refiner.frame(near_view(), {1, 0}, milliseconds(3));
    EXPECT_FALSE(frame.converged);
    EXPECT_EQ(frame.counters.refined, 0u);
    EXPECT_GT(frame.counters.waiting, 0u);
    EXPECT_FALSE(frame.draw.empty());
    gate->open(true);
    EXPECT_TRUE(refiner.frame(near_view(), {1, 0}).converged);
}

TEST(Refiner, LateWorkIsNotDoneAgain) {
    const auto gate = std::make_shared<Gate>();
    gate->open(true);
    Refiner refiner(gate);
    RefinedFrame frame;
    std::uint64_t frames = 0;
    for (; !frame.converged; ++frames) {
        ASSERT_LT(frames, 5000u);
        frame = refiner.frame(near_view(), {1, 0}, milliseconds(0.3));
    }
    EXPECT_GT(frames, 2u);
    EXPECT_GT(frame.counters.refined, 10u);
    for (const auto& [id, times] : gate->times()) EXPECT_EQ(times, 1) << to_string(id);

    // What is coarsened away is kept for the next time.
    ASSERT_TRUE(refiner.frame(near_view(), {1e6, 0}).converged);
    ASSERT_TRUE(refiner.frame(near_view(), {1, 0}).converged);
    for (const auto& [id, times] : gate->times()) EXPECT_EQ(times, 1) << to_string(id);
}

TEST(Refiner, ADamagedFileIsReportedAndTheRestStaysUsable) {
    const auto gate = std::make_shared<Gate>();
    gate->open(true);
    Refiner refiner(gate);
    ASSERT_TRUE(refiner.frame(near_view(), {1, 0}).converged);
    const std::map<DiamondId, int> all = gate->times();
    Refiner again(gate);
    gate->damage(all.rbegin()->first);
    EXPECT_THROW(
        {
            for (int k = 0; k < 100; ++k) (void)again.frame(near_view(), {1, 0});
        },
        Error);
    gate->damage({});
    EXPECT_TRUE(again.frame(near_view(), {1, 0}).converged);
}

TEST(Refiner, RefusesWhatCannotBeMeant) {
    Refiner refiner(std::make_shared<Gate>());
    EXPECT_THROW((void)refiner.frame(near_view(), {0, 0}, milliseconds(1)), Error);
    EXPECT_THROW((void)refiner.frame(near_view(), {1, -1}, milliseconds(1)), Error);
    EXPECT_THROW((void)refiner.frame(near_view(), {1, 0}, milliseconds(0)), Error);
    ViewRequest request;
    request.height = 1e6;
    EXPECT_THROW((void)refiner.frame(View(Ellipsoid(2, 2), request), {1, 0}, milliseconds(1)), Error);
}

// Workers are let go of while they work: what they have begun is finished, nothing else is, and the file is
// let go of.
TEST(Refiner, EndsWithWorkInHand) {
    const auto gate = std::make_shared<Gate>();
    std::map<DiamondId, int> begun;
    std::thread opens;
    {
        RefinerOptions options;
        options.threads = 2;
        Refiner refiner(gate, options);
        const RefinedFrame frame = refiner.frame(near_view(), {1, 0}, milliseconds(1));
        EXPECT_GE(frame.counters.waiting, 2u);
        while ((begun = gate->times()).size() < 2) std::this_thread::yield();
        // The refiner is ending when they are let through.
        opens = std::thread([&] {
            std::this_thread::sleep_for(std::chrono::milliseconds(50));
            gate->open(true);
        });
    }
    opens.join();
    EXPECT_EQ(gate->times(), begun);
    EXPECT_EQ(gate.use_count(), 1);
}

}  // namespace
}  // namespace carat::test
