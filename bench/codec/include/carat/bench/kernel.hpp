// The one place where benchmarks touch the codec's kernel: residuals of one diamond in, bytes out, and back.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "carat/codec/diamond_codec.hpp"

namespace carat::bench {

struct KernelChoice {
    Mode mode = Mode::interpolating;
    std::string coder = "gamma";
};

class Kernel {
  public:
    // radius: the quantiser's, quanta. Throws Error(usage) for a coder there is not.
    Kernel(const KernelChoice& choice, std::int32_t radius);

    const KernelChoice& choice() const { return choice_; }
    std::int32_t radius() const { return radius_; }
    // Bytes of tables that belong to a file, 0 where the built-in ones serve.
    std::size_t table_bytes() const { return 0; }

    EncodedResiduals encode(std::span<const std::int32_t> p, const RefinedHeights& reference,
                            RefinedHeights& out, CodecScratch& scratch) const;
    void decode(const BlobInfo& info, std::span<const std::byte> blob, std::span<const std::int32_t> p, int n,
                RefinedHeights& out, CodecScratch& scratch) const;

  private:
    KernelChoice choice_;
    std::int32_t radius_;
};

}  // namespace carat::bench
