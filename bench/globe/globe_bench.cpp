// Speed of what codec, preprocess and render ask of globe for every vertex, query or half. Each figure is to
// be read against the control: copying the inputs.
#include <benchmark/benchmark.h>

#include <random>
#include <vector>

#include "carat/globe/globe.hpp"

namespace {

using namespace carat;

constexpr std::size_t kCount = 4096;

std::vector<LatticePoint> points() {
    std::mt19937_64 random(1);
    std::uniform_int_distribution<std::int32_t> in_face(-(1 << kLatticeBits), 1 << kLatticeBits);
    std::vector<LatticePoint> out;
    for (std::size_t k = 0; k < kCount; ++k)
        out.push_back({static_cast<std::int32_t>(kLatticeExtent), in_face(random), in_face(random)});
    return out;
}

std::vector<Vec3> normals() {
    std::vector<Vec3> out;
    for (const LatticePoint& p : points()) out.push_back(direction(p));
    return out;
}

std::vector<Half> halves(int level) {
    std::vector<Half> out;
    for (const Vec3& n : normals()) out.push_back(locate(lattice_position(n), level).half);
    return out;
}

// Calls f on each input in turn and counts them as items.
template <class Input, class Function>
void each(benchmark::State& state, const std::vector<Input>& inputs, Function f) {
    for (auto _ : state)
        for (const Input& input : inputs) {
            auto result = f(input);
            benchmark::DoNotOptimize(result);
        }
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(inputs.size()));
}

void control_copy(benchmark::State& state) {
    each(state, normals(), [](const Vec3& n) { return n; });
}
BENCHMARK(control_copy);

void lattice_to_normal(benchmark::State& state) {
    each(state, points(), [](const LatticePoint& p) { return direction(p); });
}
BENCHMARK(lattice_to_normal);

void normal_to_lattice(benchmark::State& state) {
    each(state, normals(), [](const Vec3& n) { return lattice_position(n); });
}
BENCHMARK(normal_to_lattice);

void normal_to_position(benchmark::State& state) {
    const Ellipsoid earth = Ellipsoid::earth();
    each(state, normals(), [&](const Vec3& n) { return earth.position(n, 1000); });
}
BENCHMARK(normal_to_position);

void position_to_normal_and_height(benchmark::State& state) {
    const Ellipsoid earth = Ellipsoid::earth();
    std::vector<Vec3> positions;
    for (const Vec3& n : normals()) positions.push_back(earth.position(n, 1000));
    each(state, positions, [&](const Vec3& p) { return earth.normal_height(p); });
}
BENCHMARK(position_to_normal_and_height);

void latitude_longitude_to_half(benchmark::State& state) {
    std::vector<Geodetic> places;
    for (const Vec3& n : normals()) places.push_back(geodetic(n));
    const int level = static_cast<int>(state.range(0));
    each(state, places, [=](const Geodetic& g) { return locate(lattice_position(direction(g)), level); });
}
BENCHMARK(latitude_longitude_to_half)->Arg(20)->Arg(21);

void corners_of_a_diamond(benchmark::State& state) {
    each(state, halves(static_cast<int>(state.range(0))), [](const Half& h) { return corners(h.diamond); });
}
BENCHMARK(corners_of_a_diamond)->Arg(20)->Arg(21);

void both_child_halves(benchmark::State& state) {
    each(state, halves(20), [](const Half& h) { return child_halves(h); });
}
BENCHMARK(both_child_halves);

void neighbour_across_a_leg(benchmark::State& state) {
    each(state, halves(20), [](const Half& h) { return neighbour(h, 1); });
}
BENCHMARK(neighbour_across_a_leg);

void parse_an_id(benchmark::State& state) {
    each(state, halves(20), [](const Half& h) { return DiamondId::parse(h.diamond.bits()); });
}
BENCHMARK(parse_an_id);

void bounds_of_a_half(benchmark::State& state) {
    const Ellipsoid earth = Ellipsoid::earth();
    each(state, halves(static_cast<int>(state.range(0))),
         [&](const Half& h) { return curvature_bound(earth, h, 64).ellipsoid_sagitta; });
}
BENCHMARK(bounds_of_a_half)->Arg(4)->Arg(20);

void ball_of_a_half(benchmark::State& state) {
    const Ellipsoid earth = Ellipsoid::earth();
    each(state, halves(20), [&](const Half& h) { return bounding_ball(earth, h, -100, 1000).radius; });
}
BENCHMARK(ball_of_a_half);

void spacing_of_a_diamond(benchmark::State& state) {
    const Ellipsoid earth = Ellipsoid::earth();
    each(state, halves(20), [&](const Half& h) { return sample_spacing(earth, h.diamond, 64); });
}
BENCHMARK(spacing_of_a_diamond);

void making_an_ellipsoid(benchmark::State& state) {
    for (auto _ : state) {
        Ellipsoid earth = Ellipsoid::earth();
        benchmark::DoNotOptimize(earth);
    }
}
BENCHMARK(making_an_ellipsoid);

}  // namespace
