// Numbers as people read them.
#pragma once

#include <cstdint>
#include <string>

namespace carat::cli {

// "12,345,678"
std::string grouped(std::uint64_t n);
// "1.23 MB": powers of 1000.
std::string bytes_text(std::uint64_t bytes);
// "0.3 s", "4 min 05 s", "2 h 10 min"
std::string duration(double seconds);
// "12.3 m", "4.56 km", "3 mm"
std::string length_text(double metres);
// The shortest decimal that reads back as the same double: "0.1".
std::string number(double x);

}  // namespace carat::cli
