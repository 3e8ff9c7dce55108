// Fuzz targets: each takes any bytes and must return, having thrown and caught nothing but typed errors.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace carat::fuzz {

using Target = void (*)(std::span<const std::byte> input);

// Blob of one diamond: 8 bytes of settings (mode, leaf size, N, radius, seed of P), then the blob. What
// decodes must encode and decode again to the same heights.
void gamma_blob(std::span<const std::byte> input);
// The same for the range coder, with the built-in tables.
void range_blob(std::span<const std::byte> input);
// Tables of the range coder, as they stand in a header.
void tables(std::span<const std::byte> input);
// A header; its checksum is made right first.
void header(std::span<const std::byte> input);
// A part of a page: 1 byte for the page's key, 1 for the first slot, then the part; its checksum is made
// right first.
void page(std::span<const std::byte> input);
// A directory: 2 bytes for the length of the first level, which comes first, then what it points into;
// checksums of the blocks are made right first.
void directory(std::span<const std::byte> input);
// A whole file, walked as far as 300 diamonds; all checksums are made right first.
void repository(std::span<const std::byte> input);

struct NamedTarget {
    std::string_view name;
    Target run;
};
inline constexpr NamedTarget kTargets[] = {{"gamma_blob", gamma_blob},
                                           {"range_blob", range_blob},
                                           {"tables", tables},
                                           {"header", header},
                                           {"page", page},
                                           {"directory", directory},
                                           {"repository", repository}};

}  // namespace carat::fuzz
