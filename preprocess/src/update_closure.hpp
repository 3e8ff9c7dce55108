// What an update changes: coarse to fine which diamonds are coded anew, fine to coarse which summaries.
#pragma once

#include <atomic>

#include "build_output.hpp"
#include "carat/codec/file_contents.hpp"
#include "update_heights.hpp"

namespace carat {

// Refined diamonds before and after.
struct UpdateState {
    const FileContents& before;
    const Repository& file;  // the same, to decode
    RefinedLevels levels_before;
    const RefinedLevels& levels;
    FaceHeights roots_before, roots;  // reconstructed
};

// Thrown, and caught by the update, when what the closure holds exceeds its share of memory.
struct ClosureTooLarge {};

class UpdateClosure {
  public:
    // touched: whether the sources may differ in the region of a diamond. memory: bytes for coded residuals
    // and for decoded heights each.
    UpdateClosure(const OutputJob& job, const UpdateState& state, std::function<bool(DiamondId)> touched,
                  std::size_t memory);

    // Codes the closure. Throws ClosureTooLarge.
    void code();
    // Works out the summaries that changed. Call after code().
    void summarise();

    // All diamonds of the new file, level by level.
    const std::vector<DiamondEntry>& diamonds() const { return diamonds_; }
    void blob(std::size_t index, std::vector<std::byte>& out) const;
    std::uint64_t recoded() const { return recoded_; }
    std::uint64_t changed() const { return changed_; }
    std::uint64_t summaries() const { return summaries_; }

  private:
    static constexpr std::size_t kNone = ~std::size_t{0};
    enum class Fate : std::uint8_t { kept, coded_alike, changed };

    std::size_t index_of(DiamondId d, int level) const;  // kNone if it is not refined
    bool changed(DiamondId d) const;
    void code_one(int level, std::size_t index);
    bool vertices_changed(DiamondId d, int level);
    bool old_refined(DiamondId d, int level) const;

    void find_stale();
    bool stale_half(int level, std::size_t index, int side) const;
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
    std::vector<std::array<std::uint8_t, 2>> stale_;  // halves
    DecodedHeights old_, new_;
    std::atomic<std::size_t> held_{0};
    std::atomic<std::uint64_t> recoded_{0}, changed_{0}, summaries_{0};
};

}  // namespace carat
