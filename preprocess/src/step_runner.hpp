// Runs the steps of a level: diamonds in parallel, files written while the next step is worked on.
#pragma once

#include <tbb/parallel_for.h>

#include <future>
#include <memory>
#include <utility>
#include <vector>

#include "build_passes.hpp"

namespace carat {

// One list of records for each kind that a step leaves behind.
using StepOutput = std::vector<std::pair<StepKind, StepRecords>>;

// make(position, index in step, output) fills the records of one diamond. Steps that have all their files are
// left out.
template <class Make>
void run_level(const BuildContext& context, int level, const std::vector<StepKind>& kinds, Make make) {
    const std::size_t diamonds = context.ids(level).size();
    std::future<void> writing;
    const auto finish_writing = [&] {
        if (writing.valid()) writing.get();
    };
    for (std::size_t step = 0; step < context.steps(level); ++step) {
        const std::size_t first = step * kStepDiamonds, last = std::min(diamonds, first + kStepDiamonds);
        bool there = true;
        for (const StepKind kind : kinds) there = there && context.store.has({kind, level, step});
        if (there) {
            context.progress.step(last - first);
            continue;
        }
        auto output = std::make_shared<StepOutput>();
        for (const StepKind kind : kinds) output->emplace_back(kind, StepRecords(last - first));
        tbb::parallel_for(first, last, [&](std::size_t position) {
            make(position, position - first, *output);
            context.progress.step();
        });
        finish_writing();
        context.progress.flush();
        writing = std::async(std::launch::async, [&context, level, step, output] {
            for (const auto& [kind, records] : *output) context.store.put({kind, level, step}, records);
        });
    }
    finish_writing();
}

}  // namespace carat
