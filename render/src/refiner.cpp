#include "carat/render/refiner.hpp"

#include "carat/render/draw_list.hpp"
#include "stopwatch.hpp"

namespace carat {

class Refiner::State {
  public:
    explicit State(std::shared_ptr<const Repository> repository) : repository_(std::move(repository)) {}

    RefinedFrame frame(const View& view, const RefineGoal& goal) {
        RefinedFrame out;
        const Stopwatch watch(out.counters.total_ms);
        DrawList list = converged_cut(*repository_, view, goal.threshold, goal.spacing);
        out.upload = list.meshes;  // every frame makes new mesh objects
        out.draw = std::move(list.meshes);
        out.converged = true;
        count(list.counters, out);
        return out;
    }

  private:
    static void count(const CutCounters& cut, RefinedFrame& out) {
        RefineCounters& c = out.counters;
        c.refined = cut.refined;
        c.virtual_refined = cut.virtual_refined;
        c.patches = cut.patches;
        c.triangles = cut.triangles;
        c.limited = cut.limited;
        c.worst_error = cut.worst_error;
        c.uploads = out.upload.size();
        for (const auto& mesh : out.upload) c.upload_bytes += mesh->vertices.size() * sizeof(PatchVertex);
        c.decoded = cut.read.diamonds_decoded;
        c.predicted = cut.read.diamonds_zero;
        c.virtual_decoded = cut.virtual_refined;
        c.built = cut.patches;
        c.selection_ms = cut.selection_ms;
        c.decode_ms = cut.decode_ms;
        c.build_ms = cut.build_ms;
        c.read = cut.read;
    }

    std::shared_ptr<const Repository> repository_;
};

Refiner::Refiner(std::shared_ptr<const Repository> repository, const RefinerOptions&)
    : state_(std::make_unique<State>(std::move(repository))) {}
Refiner::~Refiner() = default;

RefinedFrame Refiner::frame(const View& view, const RefineGoal& goal, const RefineBudget&) {
    return state_->frame(view, goal);
}

}  // namespace carat
