#include "geoid.hpp"

#include <GeographicLib/Geoid.hpp>
#include <filesystem>

#include "carat/globe/error.hpp"
#include "source_layer.hpp"

namespace carat {
namespace {

class PgmGeoid final : public Geoid {
  public:
    explicit PgmGeoid(const std::filesystem::path& path)
        : geoid_(path.stem().string(), path.has_parent_path() ? path.parent_path().string() : ".", true,
                 true) {}

    void add(std::span<const double> lat, std::span<const double> lon, std::span<double> heights,
             std::span<std::uint8_t>) const override {
        for (std::size_t i = 0; i < heights.size(); ++i) heights[i] += geoid_(lat[i], lon[i]);
    }

  private:
    GeographicLib::Geoid geoid_;  // wholly in memory, which is what makes it safe for threads
};

class RasterGeoid final : public Geoid {
  public:
    explicit RasterGeoid(std::unique_ptr<SourceLayer> layer) : layer_(std::move(layer)) {}

    void add(std::span<const double> lat, std::span<const double> lon, std::span<double> heights,
             std::span<std::uint8_t> valid) const override {
        std::vector<double> geoid(heights.size());
        std::vector<std::uint8_t> there(heights.size());
        layer_->sample(lat, lon, Cap{}, geoid, there, {});
        for (std::size_t i = 0; i < heights.size(); ++i) {
            heights[i] += geoid[i];
            valid[i] = there[i] != 0 ? valid[i] : 0;
        }
    }

  private:
    std::unique_ptr<SourceLayer> layer_;
};

}  // namespace

std::unique_ptr<Geoid> Geoid::open(const std::string& path, const Ellipsoid& body, HandlePool& handles,
                                   TileCache& cache, std::uint64_t key, std::vector<std::string>& warnings) {
    const std::filesystem::path file(path);
    if (file.extension() != ".pgm") {
        LayerOptions options;
        options.files = {path};
        return std::make_unique<RasterGeoid>(
            std::make_unique<SourceLayer>(options, body, handles, cache, key, warnings));
    }
    try {
        return std::make_unique<PgmGeoid>(file);
    } catch (const std::exception& error) {
        throw Error(ErrorCode::io, path + ": cannot read the geoid: " + error.what());
    }
}

}  // namespace carat
