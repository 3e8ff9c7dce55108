// What an update changes: coarse to fine which diamonds are coded anew, fine to coarse which summaries.
#pragma once

#include <atomic>

#include "build_output.hpp"
#include "carat/codec/file_contents.hpp"
#include "update_heights.hpp"
#include "update_plan.hpp"

namespace carat {

// Refined diamonds before and after.
struct UpdateState {
    const FileContents& before;
    const Repository& file;  // the same, to decode
    RefinedLevels levels_before;
    const UpdatePlan& plan;
    FaceHeights roots_before, roots;  // reconstructed
};

// Thrown, and caught by the update, when what the closure holds exceeds its share of memory.
struct ClosureTooLarge {};

class UpdateClosure {
  public:
    // touched: whether the sources may differ in the region of a diamond that is near. memory: bytes for
    // coded residuals and for decoded heights each.
    UpdateClosure(const OutputJob& job, const UpdateState& state, std::function<bool(DiamondId)> touched,
                  std::size_t memory);

    // Codes the closure. Throws ClosureTooLarge.
    void code();
    // Works out the summaries that changed. Call after code().
    void summarise();

    // All diamonds of the new file, level by level.
    const std::vector<DiamondEntry>& diamonds() const { return diamonds_; }
    void blob(std::size_t index, std::vector<std::byte>& out) const;
    // True if a diamond is all as it was, and neither its residuals nor its summaries need be looked at.
    bool unchanged(std::size_t index) const;
    // All that were looked at: the others are as they were, and no diamond of theirs is near.
    std::vector<std::size_t> looked_at() const;
    // The same diamond in the old file; null if it was not refined there.
    const DiamondEntry* before(std::size_t index) const {
        return before_[index] == kNone ? nullptr : &state_.before.diamonds()[before_[index]];
    }
    // A diamond that was refined before.
    const DiamondEntry& entry_before(DiamondId d, std::size_t level) const {
        return state_.before.diamonds()[first_before_[level] +
                                        *position_of(state_.levels_before, d, static_cast<int>(level))];
    }
    std::uint64_t recoded() const { return recoded_; }
    std::uint64_t changed() const { return changed_; }
    std::uint64_t summaries() const { return summaries_; }

  private:
    static constexpr std::size_t kNone = ~std::size_t{0};
    enum class Fate : std::uint8_t { kept, coded_alike, changed };

    void match(std::size_t level);
    std::size_t index_of(DiamondId d, int level) const;  // kNone if it is not refined
    bool changed(DiamondId d) const;
    std::vector<std::size_t> candidates(std::size_t level) const;
    void code_one(int level, std::size_t index);
    bool vertices_changed(DiamondId d, int level);

    void find_stale();
    void mark_stale(std::size_t level, std::size_t index, int side);
    void mark_stale_above(const Half& half, std::size_t level);
    void find_stale_zero_pages();
    bool mark_zero_pages_near_stale();
    void summarise_half(int level, std::size_t index, int side);

    const OutputJob& job_;
    const UpdateState& state_;
    std::function<bool(DiamondId)> touched_;
    std::size_t memory_;
    int n_;
    SummaryGrid grid_;
    std::vector<std::size_t> first_, first_before_;  // of each level
    std::vector<DiamondEntry> diamonds_;
    std::vector<std::size_t> before_;  // index of the same diamond in the old file
    std::vector<Fate> fate_;
    std::vector<std::vector<std::byte>> blobs_;       // of the changed
    std::vector<std::vector<std::size_t>> work_;      // by level, those that may have changed
    std::vector<std::array<std::uint8_t, 2>> stale_;  // halves
    std::vector<std::vector<std::pair<std::size_t, int>>> stale_halves_;  // by level: index, side
    DecodedHeights old_, new_;
    std::atomic<std::size_t> held_{0};
    std::atomic<std::uint64_t> recoded_{0}, changed_{0}, summaries_{0};
};

}  // namespace carat
