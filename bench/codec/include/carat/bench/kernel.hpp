// The one place where benchmarks touch the codec's kernel: residuals of one diamond in, bytes out, and back.
#pragma once

#include <cstdint>
#include <span>

#include "carat/codec/diamond_codec.hpp"

namespace carat::bench {

struct KernelChoice {
    Mode mode = Mode::interpolating;
    Coding coding = Coding::gamma();
    bool fit_tables = false;  // range only: a first pass counts tokens, the second codes with fitted tables
};

class Kernel {
  public:
    // radius: the quantiser's, quanta.
    Kernel(const KernelChoice& choice, std::int32_t radius) : choice_(choice), radius_(radius) {}

    const KernelChoice& choice() const { return choice_; }
    std::int32_t radius() const { return radius_; }
    void set_tables(std::shared_ptr<const RangeTables> tables) { choice_.coding.tables = std::move(tables); }
    // Bytes of tables that belong to a file, 0 where the built-in ones serve.
    std::size_t table_bytes() const;

    EncodedResiduals encode(std::span<const std::int32_t> p, const RefinedHeights& reference,
                            RefinedHeights& out, CodecScratch& scratch) const;
    // The same with other orders allowed than the choice's.
    EncodedResiduals encode_with(unsigned orders, std::span<const std::int32_t> p,
                                 const RefinedHeights& reference, RefinedHeights& out,
                                 CodecScratch& scratch) const;
    void decode(const BlobInfo& info, std::span<const std::byte> blob, std::span<const std::int32_t> p, int n,
                RefinedHeights& out, CodecScratch& scratch) const;

  private:
    KernelChoice choice_;
    std::int32_t radius_;
};

}  // namespace carat::bench
