#include <memory>
#include <numeric>

#include "carat/bench/contestant.hpp"
#include "carat/bench/plane.hpp"
#include "tile_codec.hpp"

namespace carat::bench {
namespace {

// Carat's kernel: one lattice over the whole raster; the unit of random access is the diamond.
class CaratKernel : public Contestant {
  public:
    explicit CaratKernel(KernelChoice choice) : choice_(std::move(choice)) {}

    void prepare(const std::vector<Raster>& tiles, double tolerance) override {
        codec_ = std::make_unique<PlaneCodec>(tiles.at(0), choice_, tolerance);
    }
    std::size_t encode(const std::vector<Raster>& tiles) override { return codec_->encode(tiles.at(0)); }
    void decode(std::vector<Raster>& tiles) override { codec_->decode(tiles.at(0)); }
    std::vector<double> decode_shares() const override {
        const PlaneCycles& c = codec_->cycles();
        const auto total = static_cast<double>(c.gather + c.kernel + c.store);
        if (total == 0) return {};
        return {static_cast<double>(c.gather) / total, static_cast<double>(c.kernel) / total,
                static_cast<double>(c.store) / total};
    }

  private:
    KernelChoice choice_;
    std::unique_ptr<PlaneCodec> codec_;
};

std::unique_ptr<Contestant> make_paper() {
    return std::make_unique<CaratKernel>(KernelChoice{Mode::paper, Coding::paper()});
}
std::unique_ptr<Contestant> make_gamma() {
    return std::make_unique<CaratKernel>(KernelChoice{Mode::interpolating, Coding::gamma()});
}
std::unique_ptr<Contestant> make_range() {
    return std::make_unique<CaratKernel>(KernelChoice{Mode::interpolating, Coding{}});
}
std::unique_ptr<Contestant> make_range_fit() {
    return std::make_unique<CaratKernel>(KernelChoice{Mode::interpolating, Coding{}, true});
}

}  // namespace

const std::vector<ContestantInfo>& contestants() {
    static const std::vector<ContestantInfo> all = {{"carat-range", "diamond", false, make_range},
                                                    {"carat-fit", "diamond", false, make_range_fit},
                                                    {"carat-gamma", "diamond", false, make_gamma},
                                                    {"carat-paper", "diamond", false, make_paper},
                                                    {"lerc", "none", true, make_lerc},
                                                    {"lerc+zstd", "none", true, make_lerc_zstd},
                                                    {"zfp", "4x4 block", false, make_zfp},
                                                    {"zfp-tuned", "4x4 block", false, make_zfp_tuned},
                                                    {"pred2+zstd", "none", true, make_predictor_zstd},
                                                    {"jp2k", "codeblock", false, make_openjpeg},
                                                    {"jxl-e3", "none", true, make_jxl_e3},
                                                    {"jxl-e7", "none", true, make_jxl_e7}};
    return all;
}

}  // namespace carat::bench
