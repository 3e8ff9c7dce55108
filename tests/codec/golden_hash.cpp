// Decodes the golden files of the folder named by the first argument and compares every height with the
// pinned hash. Compiled by hash_matrix.sh with many compilers and flags. --print prints the hashes instead.
#include <cstdio>
#include <cstring>
#include <exception>
#include <filesystem>

#include "golden.hpp"
#include "walk.hpp"

int main(int argc, char** argv) {
    if (argc < 2) return 2;
    const bool print = argc > 2 && std::strcmp(argv[2], "--print") == 0;
    int wrong = 0;
    for (const carat::test::Golden& g : carat::test::kGolden) try {
            const std::filesystem::path file = std::filesystem::path(argv[1]) / g.file;
            const std::uint64_t found = carat::test::hash_heights(carat::Repository::open(file));
            if (print || found != g.heights)
                std::printf("%s 0x%016llX\n", g.file, static_cast<unsigned long long>(found));
            wrong += found != g.heights ? 1 : 0;
        } catch (const std::exception& e) {
            std::printf("%s\n", e.what());
            ++wrong;
        }
    return print || wrong == 0 ? 0 : 1;
}
