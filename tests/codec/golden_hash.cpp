// Decodes the golden files of the folder named by the first argument and compares every height with the
// pinned hash: with every Highway target that this build holds and this processor has, with one thread and
// with many at once. Compiled by hash_matrix.sh with many compilers and flags. --print prints the hashes
// instead.
#include <hwy/targets.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <exception>
#include <filesystem>
#include <future>
#include <vector>

#include "golden.hpp"
#include "walk.hpp"

namespace {

using carat::test::Golden;

constexpr int kThreads = 4;

bool right(const Golden& g, std::uint64_t found, const char* how) {
    if (found == g.heights) return true;
    std::printf("%s 0x%016llX (%s)\n", g.file, static_cast<unsigned long long>(found), how);
    return false;
}

// Several threads read one repository, whose caches they share.
bool right_with_threads(const Golden& g, const std::filesystem::path& file, const char* how) {
    const auto repository = carat::Repository::open(file);
    std::vector<std::future<std::uint64_t>> found;
    for (int k = 0; k < kThreads; ++k)
        found.push_back(
            std::async(std::launch::async, [&] { return carat::test::hash_heights(repository); }));
    bool all = true;
    for (auto& f : found) all = right(g, f.get(), how) && all;
    return all;
}

bool check(const std::filesystem::path& folder, const char* how) {
    bool all = true;
    for (const Golden& g : carat::test::kGolden) try {
            const std::filesystem::path file = folder / g.file;
            all = right(g, carat::test::hash_heights(carat::Repository::open(file)), how) && all;
            all = right_with_threads(g, file, how) && all;
        } catch (const std::exception& e) {
            std::printf("%s\n", e.what());
            all = false;
        }
    return all;
}

void print(const std::filesystem::path& folder) {
    for (const Golden& g : carat::test::kGolden)
        std::printf("%s 0x%016llX\n", g.file,
                    static_cast<unsigned long long>(
                        carat::test::hash_heights(carat::Repository::open(folder / g.file))));
}

}  // namespace

int main(int argc, char** argv) {
    if (argc < 2) return 2;
    if (argc > 2 && std::strcmp(argv[2], "--print") == 0) {
        print(argv[1]);
        return 0;
    }
    bool all = check(argv[1], "the best target");
    // Every target that was compiled and that runs here, one bit each.
    const std::int64_t targets = hwy::SupportedTargets() & HWY_TARGETS;
    for (std::int64_t left = targets; left != 0; left &= left - 1) {
        const std::int64_t target = left & -left;
        hwy::SetSupportedTargetsForTest(target);
        all = check(argv[1], hwy::TargetName(target)) && all;
        std::printf("%s: %s\n", hwy::TargetName(target), all ? "same heights" : "WRONG");
        hwy::SetSupportedTargetsForTest(0);
    }
    return all ? 0 : 1;
}
