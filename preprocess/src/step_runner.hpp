// Runs the steps of a level: diamonds in parallel; meanwhile the files of the step before are written, and
// those that the next step reads are fetched from disk.
#pragma once

#include <tbb/parallel_for.h>

#include <future>
#include <memory>
#include <set>
#include <utility>
#include <vector>

#include "build_passes.hpp"

namespace carat {

// One list of records for each kind that a step leaves behind.
using StepOutput = std::vector<std::pair<StepKind, StepRecords>>;

// Hints at the files that a step will read, from some of its diamonds; neighbours share them.
template <class Reads>
void expect_step(const BuildContext& context, int level, std::size_t step, Reads reads) {
    constexpr std::size_t kEvery = 16;
    const std::vector<DiamondId>& ids = context.ids(level);
    const std::size_t last = std::min(ids.size(), (step + 1) * kStepDiamonds);
    std::set<StepKey> keys;
    for (std::size_t k = step * kStepDiamonds; k < last; k += kEvery) reads(ids[k], keys);
    for (const StepKey& key : keys) context.store.expect(key);
}

// reads(diamond, keys) adds the files that a diamond needs.
// make(position, index in step, output) fills the records of one diamond. Steps that have all their files are
// left out.
template <class Reads, class Make>
void run_level(const BuildContext& context, int level, const std::vector<StepKind>& kinds, Reads reads,
               Make make) {
    const std::size_t diamonds = context.ids(level).size();
    std::future<void> writing, fetching;
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
        if (step + 1 < context.steps(level))
            fetching = std::async(std::launch::async, [&context, level, step, &reads] {
                expect_step(context, level, step + 1, reads);
            });
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
