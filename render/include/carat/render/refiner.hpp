// Refinement against a deadline: a cut that persists between frames.
//
// Each frame the cut is judged against the view; what demands refinement is refined, greatest screen error
// first, and what no longer does is coarsened, least error first, until nothing is left to do or the time is
// up (dual-queue refinement: Duchaineau et al. 1997, ROAM; Gobbetti et al. 2006, C-BDAM). Where a budget is
// full, what is refined gives way to what has a greater error, least error first, fine before coarse. Files
// are read, residuals decoded and patches built by worker threads; a frame takes what is ready and never
// waits for a file beyond its deadline. Work that comes too late is kept for later frames.
//
// Whatever was shown before, and however often a frame was cut short, the drawn patches tile what is visible
// conformingly, with identical positions on shared vertices. Once a frame reports `converged`, its cut and
// its meshes are bit for bit those of converged_cut() (draw_list.hpp) for the same view and goal.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "carat/codec/colour.hpp"
#include "carat/codec/repository.hpp"
#include "carat/render/detail.hpp"
#include "carat/render/patch_mesh.hpp"
#include "carat/render/view.hpp"

namespace carat {

// What to refine to: as for converged_cut().
struct RefineGoal {
    double threshold = 1;  // greatest screen error, pixels, > 0
    double spacing = 0;    // greatest distance of samples on screen, pixels; 0: the error alone decides
};

// What a frame may cost.
struct RefineBudget {
    // Wall time from the call of frame() to its return; infinity: until converged.
    double milliseconds = std::numeric_limits<double>::infinity();
    // Bytes of meshes new to the draw list. Rather than exceed it refinement pauses, and what a change of
    // view brings into sight is drawn coarser at first. At most one refinement (4 meshes), the copies for one
    // seam (8), or what covers meshes not built in time come on top, so that every frame makes some progress.
    std::size_t upload_bytes = std::numeric_limits<std::size_t>::max();
};

struct RefinerOptions {
    // Frontier halves off the screen and behind the horizon are neither built nor drawn, nor their diamonds
    // decoded. Off: they are, and change nothing in the picture; the cut and all other meshes are the same.
    bool skip_frustum = true, skip_horizon = true;
    int threads = 0;  // workers; 0: one for each core
    // Drawn at most in any frame; but the coarsest cut, 12 patches, always is.
    std::uint64_t triangles = 16'000'000;
    // Of heights and meshes held after any frame, those kept for later included: at most, but for the
    // coarsest cut. A sixteenth is for work under way. Up to 64 empty meshes, or an eighth of this if that is
    // more and no more than 512 of them, come on top.
    std::uint64_t bytes = std::uint64_t{2} << 30;
    // Draped over the relief, as for converged_cut(); null: none.
    std::shared_ptr<const ColourRepository> colour = nullptr;
    // Procedural detail of this file, as for converged_cut(); null: none.
    std::shared_ptr<const Detail> detail = nullptr;
};

struct RefineCounters {
    // The cut.
    std::uint64_t refined = 0;                             // diamonds in it
    std::uint64_t virtual_refined = 0;                     // of these, below the file's leaves
    std::uint64_t culled_frustum = 0, culled_horizon = 0;  // frontier halves not drawn, by reason
    std::uint64_t patches = 0, triangles = 0;              // drawn
    std::uint64_t limited = 0;  // drawn patches above the threshold with nothing finer
    double worst_error = 0;     // pixels, greatest error bound among the drawn patches
    // This frame.
    std::uint64_t installed = 0, coarsened = 0;  // diamonds that entered and left the cut
    std::uint64_t forced_coarse = 0;  // times that a coarser patch stood in for one not built in time
    std::uint64_t uploads = 0, upload_bytes = 0;  // meshes new to the draw list
    std::uint64_t unstitched = 0;  // borders of drawn patches whose normals wait for a later frame
    std::uint64_t waiting = 0;     // diamonds requested and not yet there
    double selection_ms = 0, stitch_ms = 0, wait_ms = 0, total_ms = 0;  // wall time of frame() and its parts
    std::uint64_t waits = 0;  // times that frame() slept until workers had results
    double overslept_ms = 0;  // of wait_ms, what waits took longer than they were asked to
    // By the processor time of the calling thread, how much it took beyond the budget, or after refinement
    // beyond what is set aside for the frame's end: what the frame is late by on a core of its own. 0 without
    // a time limit.
    double late_ms = 0;
    // Since the last frame, by the workers.
    std::uint64_t decoded = 0;           // diamonds decoded from residuals
    std::uint64_t predicted = 0;         // diamonds of the file without residuals: predicted alone
    std::uint64_t virtual_decoded = 0;   // diamonds refined virtually
    std::uint64_t built = 0;             // patches
    double decode_ms = 0, build_ms = 0;  // summed over the workers
    ReadCounters read;                   // what the repository read
    // Now.
    std::uint64_t bytes = 0;  // of heights and meshes held
};

struct RefinedFrame {
    // The patches to draw, sorted by half. Meshes are immutable and may outlive
    // the Refiner. A half whose border normals change is given a new mesh object.
    std::vector<std::shared_ptr<const PatchMesh>> draw;
    // Those of `draw` that were not in the previous frame's list as the same object: to upload.
    std::vector<std::shared_ptr<const PatchMesh>> upload;
    bool converged = false;  // to the goal; false while time, data or a budget are wanting
    RefineCounters counters;
};

// Not thread-safe: one thread at a time calls its members.
class Refiner {
  public:
    // Reads the root values. Throws what the repository throws.
    explicit Refiner(std::shared_ptr<const Repository> repository, const RefinerOptions& options = {});
    ~Refiner();
    Refiner(const Refiner&) = delete;
    Refiner& operator=(const Refiner&) = delete;

    // Throws Error(usage) for a view of another body or a goal out of range, and what the repository throws,
    // also for work requested by earlier frames; the Refiner stays usable.
    RefinedFrame frame(const View& view, const RefineGoal& goal, const RefineBudget& budget = {});
    // The same into the last frame, whose lists keep their memory: then a frame with a time limit allocates
    // nothing from the system but what the lists and the cut grow by.
    void frame(const View& view, const RefineGoal& goal, const RefineBudget& budget, RefinedFrame& out);

  private:
    class State;
    std::unique_ptr<State> state_;
};

}  // namespace carat
