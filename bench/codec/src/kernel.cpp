#include "carat/bench/kernel.hpp"

#include "carat/globe/error.hpp"

namespace carat::bench {

Kernel::Kernel(const KernelChoice& choice, std::int32_t radius) : choice_(choice), radius_(radius) {
    if (choice.coder != "gamma") throw Error(ErrorCode::usage, "there is no coder '" + choice.coder + "'");
}

EncodedResiduals Kernel::encode(std::span<const std::int32_t> p, const RefinedHeights& reference,
                                RefinedHeights& out, CodecScratch& scratch) const {
    return encode_residuals(choice_.mode, p, reference, radius_, out, scratch);
}

void Kernel::decode(const BlobInfo& info, std::span<const std::byte> blob, std::span<const std::int32_t> p,
                    int n, RefinedHeights& out, CodecScratch& scratch) const {
    decode_residuals(info, blob, p, n, radius_, out, scratch);
}

}  // namespace carat::bench
