// Replays the seed corpora of the fuzz targets, and some thousand mutations of each seed.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "globe/random.hpp"
#include "targets.hpp"

namespace carat::fuzz {
namespace {

using Bytes = std::vector<std::byte>;

std::vector<Bytes> corpus(const NamedTarget& target) {
    std::vector<std::filesystem::path> files;
    const auto folder = std::filesystem::path(CARAT_SOURCE_DIR) / "tests/fuzz/corpus" / target.name;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    std::vector<Bytes> out;
    for (const auto& file : files) {
        std::ifstream in(file, std::ios::binary);
        const std::vector<char> chars{std::istreambuf_iterator<char>(in), {}};
        Bytes& bytes = out.emplace_back(chars.size());
        std::transform(chars.begin(), chars.end(), bytes.begin(),
                       [](char c) { return static_cast<std::byte>(c); });
    }
    return out;
}

Bytes mutated(Bytes seed, test::Random& random) {
    for (auto n = random.integer(1, 4); n > 0 && !seed.empty(); --n) {
        const auto at =
            static_cast<std::size_t>(random.integer(0, static_cast<std::int64_t>(seed.size()) - 1));
        switch (random.integer(0, 4)) {
            case 0:
                seed[at] ^= static_cast<std::byte>(1 << random.integer(0, 7));
                break;
            case 1:
                seed[at] = static_cast<std::byte>(random.bits());
                break;
            case 2:
                seed[at] = random.chance(0.5) ? std::byte{0} : std::byte{0xFF};
                break;
            case 3:
                seed.resize(at);
                break;
            default:
                seed.insert(seed.begin() + static_cast<std::ptrdiff_t>(at),
                            static_cast<std::byte>(random.bits()));
        }
    }
    return seed;
}

class Fuzz : public ::testing::TestWithParam<NamedTarget> {};

TEST_P(Fuzz, SeedsAndTheirMutations) {
    test::Random random;
    SCOPED_TRACE(random.trace());
    const auto seeds = corpus(GetParam());
    ASSERT_FALSE(seeds.empty());
    // Some thousand mutations of few seeds; of the many that a fuzzer found, some dozens each.
    const int rounds =
        std::min(2000, (GetParam().name == "repository" ? 900 : 60000) / static_cast<int>(seeds.size()));
    for (const Bytes& seed : seeds) {
        GetParam().run(seed);
        for (int k = 0; k < rounds; ++k) GetParam().run(mutated(seed, random));
    }
}

INSTANTIATE_TEST_SUITE_P(Targets, Fuzz, ::testing::ValuesIn(kTargets),
                         [](const auto& target) { return std::string(target.param.name); });

}  // namespace
}  // namespace carat::fuzz
