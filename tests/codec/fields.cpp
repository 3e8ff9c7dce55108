#include "fields.hpp"

#include <algorithm>

namespace carat::test {
namespace {

std::uint64_t mix(std::uint64_t x) {  // splitmix64
    x += 0x9E3779B97F4A7C15u;
    x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9u;
    x = (x ^ (x >> 27)) * 0x94D049BB133111EBu;
    return x ^ (x >> 31);
}

std::uint64_t hash(std::int64_t x, std::int64_t y, std::int64_t z, std::uint64_t seed) {
    const auto u = [](std::int64_t v) { return static_cast<std::uint64_t>(v); };
    return mix(u(z) ^ mix(u(y) ^ mix(u(x) ^ mix(seed))));
}

// Uniform in [-2^15, 2^15].
std::int64_t knot(std::int64_t x, std::int64_t y, std::int64_t z, std::uint64_t seed) {
    return static_cast<std::int64_t>(hash(x, y, z, seed) % 65537) - 32768;
}

// Trilinear value noise of period 2^bits, scaled by 2^15; integers alone.
std::int64_t value_noise(const LatticePoint& p, int bits, std::uint64_t seed) {
    std::array<std::int64_t, 3> cell{}, at{};
    for (int k = 0; k < 3; ++k) {
        const std::int64_t shifted = p[k] + kLatticeExtent;
        cell[static_cast<std::size_t>(k)] = shifted >> bits;
        const std::int64_t inside = shifted & ((std::int64_t{1} << bits) - 1);
        at[static_cast<std::size_t>(k)] = bits >= 10 ? inside >> (bits - 10) : inside << (10 - bits);
    }
    std::int64_t sum = 0;
    for (int c = 0; c < 8; ++c) {
        const int dx = c & 1, dy = (c >> 1) & 1, dz = c >> 2;
        const std::int64_t weight = (dx != 0 ? at[0] : 1024 - at[0]) * (dy != 0 ? at[1] : 1024 - at[1]) *
                                    (dz != 0 ? at[2] : 1024 - at[2]);
        sum += weight * knot(cell[0] + dx, cell[1] + dy, cell[2] + dz, seed);
    }
    return sum >> 30;
}

}  // namespace

Field white_noise(std::int32_t amplitude, std::uint64_t seed) {
    return [=](const LatticePoint& p) {
        const auto range = static_cast<std::uint64_t>(2 * std::int64_t{amplitude} + 1);
        return static_cast<std::int32_t>(static_cast<std::int64_t>(hash(p.x, p.y, p.z, seed) % range) -
                                         amplitude);
    };
}

Field smooth(std::int32_t amplitude) {
    return [=](const LatticePoint& p) {
        const std::int64_t x = p.x >> 16, y = p.y >> 16, z = p.z >> 16;   // 15 bits
        const std::int64_t bowl = x * x + 2 * y * z - z * z / 3 + x * y;  // below 2^31
        return static_cast<std::int32_t>((amplitude * bowl) >> 31);
    };
}

Field fractal(std::int32_t amplitude, int coarsest_bits, int octaves, std::uint64_t seed) {
    return [=](const LatticePoint& p) {
        std::int64_t sum = 0;
        for (int k = 0; k < octaves && coarsest_bits - k >= 0; ++k)
            sum += (amplitude * value_noise(p, coarsest_bits - k, seed + static_cast<std::uint64_t>(k))) >>
                   (k + 1);
        return static_cast<std::int32_t>(std::clamp<std::int64_t>(sum >> 15, -amplitude, amplitude));
    };
}

Field step(std::int32_t amplitude) {
    return [=](const LatticePoint& p) {
        return 3 * std::int64_t{p.x} + 2 * std::int64_t{p.y} - std::int64_t{p.z} > 12345 ? amplitude
                                                                                         : -amplitude;
    };
}

Field checkerboard(std::int32_t amplitude, int cube_bits) {
    return [=](const LatticePoint& p) {
        const auto cube = [cube_bits](std::int32_t x) { return (x + kLatticeExtent) >> cube_bits; };
        return ((cube(p.x) ^ cube(p.y) ^ cube(p.z)) & 1) != 0 ? amplitude : -amplitude;
    };
}

Field extreme(std::uint64_t seed) {
    return [=](const LatticePoint& p) {
        return (static_cast<std::int32_t>(hash(p.x, p.y, p.z, seed) % 3) - 1) * kGreatestHeight;
    };
}

Field constant(std::int32_t height) {
    return [=](const LatticePoint&) { return height; };
}

std::vector<NamedField> all_fields(std::int32_t amplitude, int cube_bits) {
    return {{"random", white_noise(amplitude)},
            {"smooth", smooth(amplitude)},
            {"fractal", fractal(amplitude)},
            {"step", step(amplitude)},
            {"checkerboard", checkerboard(amplitude, cube_bits)},
            {"extreme", extreme()},
            {"constant", constant(-amplitude / 3)}};
}

}  // namespace carat::test
