#include "carat/bench/kernel.hpp"

namespace carat::bench {

std::size_t Kernel::table_bytes() const {
    const bool fitted =
        choice_.coding.coder == CoderId::range && choice_.coding.tables != RangeTables::built_in();
    return fitted ? choice_.coding.tables->bytes().size() : 0;
}

EncodedResiduals Kernel::encode(std::span<const std::int32_t> p, const RefinedHeights& reference,
                                RefinedHeights& out, CodecScratch& scratch) const {
    return encode_residuals(choice_.coding, choice_.mode, p, reference, radius_, out, scratch);
}

EncodedResiduals Kernel::encode_with(unsigned orders, std::span<const std::int32_t> p,
                                     const RefinedHeights& reference, RefinedHeights& out,
                                     CodecScratch& scratch) const {
    Coding coding = choice_.coding;
    coding.orders = orders;
    return encode_residuals(coding, choice_.mode, p, reference, radius_, out, scratch);
}

void Kernel::decode(const BlobInfo& info, std::span<const std::byte> blob, std::span<const std::int32_t> p,
                    int n, RefinedHeights& out, CodecScratch& scratch) const {
    decode_residuals(choice_.coding, info, blob, p, n, radius_, out, scratch);
}

}  // namespace carat::bench
