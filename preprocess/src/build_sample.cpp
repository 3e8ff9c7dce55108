#include <cmath>

#include "build_passes.hpp"
#include "carat/globe/error.hpp"

namespace carat {
namespace {

constexpr double kGreatestQuanta = 1 << 30;

}  // namespace

void ErrorSum::add(double error) {
    max = std::max(max, std::abs(error));
    squares += error * error;
    ++count;
}

void ErrorSum::add(const ErrorSum& other) {
    max = std::max(max, other.max);
    squares += other.squares;
    count += other.count;
}

std::vector<std::int32_t> sample_points(const BuildContext& context, std::span<const LatticePoint> points,
                                        std::vector<double>* rounding) {
    std::vector<Vec3> normals(points.size());
    std::vector<double> heights(points.size());
    for (std::size_t k = 0; k < points.size(); ++k) normals[k] = direction(points[k]);
    context.sources.sample(normals, heights, {});
    std::vector<std::int32_t> quanta(points.size());
    if (rounding != nullptr) rounding->resize(points.size());
    for (std::size_t k = 0; k < points.size(); ++k) {
        const double scaled = std::nearbyint(heights[k] / context.quantum);
        if (!(std::abs(scaled) <= kGreatestQuanta))
            throw Error(ErrorCode::limit, "a height of " + std::to_string(heights[k]) +
                                              " m exceeds 2^30 quanta; choose a larger --quantum");
        quanta[k] = static_cast<std::int32_t>(scaled);
        if (rounding != nullptr) (*rounding)[k] = heights[k] - scaled * context.quantum;
    }
    return quanta;
}

FaceHeights sample_roots(const BuildContext& context) {
    const int n = context.n();
    FaceHeights out;
    for (int face = 0; face < kFaces; ++face) {
        const HalfFrame frame = half_frame({root_diamond(face), 0}, n - 1);
        std::vector<LatticePoint> points;
        for (int i = 0; i < n; ++i)
            for (int j = 0; j < n; ++j) points.push_back(frame.vertex(i, j));
        out[static_cast<std::size_t>(face)] = sample_points(context, points, nullptr);
    }
    return out;
}

}  // namespace carat
