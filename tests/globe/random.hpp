// Random numbers of the property tests. The seed is printed and stands in the message of every failure;
// CARAT_TEST_SEED=<number> repeats a run or asks for another one.
#pragma once

#include <cstdint>
#include <cstdlib>
#include <iostream>
#include <random>
#include <string>

namespace carat::test {

class Random {
  public:
    Random() : seed_(asked_seed()), engine_(seed_) { std::cout << trace() << '\n'; }

    std::string trace() const { return "CARAT_TEST_SEED=" + std::to_string(seed_); }

    // Uniform in [low, high], both ends possible.
    std::int64_t integer(std::int64_t low, std::int64_t high) {
        return std::uniform_int_distribution<std::int64_t>(low, high)(engine_);
    }
    // Uniform in [low, high).
    double real(double low, double high) {
        return std::uniform_real_distribution<double>(low, high)(engine_);
    }
    bool chance(double probability) { return real(0, 1) < probability; }
    std::uint64_t bits() { return engine_(); }

  private:
    static std::uint64_t asked_seed() {
        const char* text = std::getenv("CARAT_TEST_SEED");
        return text != nullptr && *text != '\0' ? std::strtoull(text, nullptr, 10) : 20060607;
    }

    std::uint64_t seed_;
    std::mt19937_64 engine_;
};

}  // namespace carat::test
