// The structure of a whole file: every part of every page, read once in the order of the file.
#pragma once

#include <functional>
#include <vector>

#include "carat/codec/byte_source.hpp"
#include "carat/codec/verify.hpp"
#include "directory.hpp"
#include "file_header.hpp"
#include "page.hpp"

namespace carat {

// Header, root values and directory of a file, checked.
class FileStructure {
  public:
    // Throws what the header, the root values and the directory deserve.
    explicit FileStructure(const ByteSource& source);

    const FileHeader& header() const { return header_; }
    const std::vector<PartEntry>& parts() const { return parts_; }
    // Reads and checks one part. Throws Error(corrupt|truncated|io).
    PagePart part(const PartEntry& entry) const;
    // The census without any page.
    FileCensus empty_census() const;
    // Calls remark for every gap or overlap between the stretches of the file.
    void check_layout(const std::function<void(const std::string&)>& remark) const;

  private:
    const ByteSource& source_;
    FileHeader header_;
    std::uint64_t header_bytes_ = 0;
    std::vector<PartEntry> parts_;
};

// Adds a part to the census.
void count(FileCensus& census, const PartEntry& entry, const PagePart& part);

// Diamonds of a level, 0 <= level - square level, whose page is the given one or nested in it.
std::uint64_t nested_diamonds(PageKey key, int level);

// Calls visit for each diamond that a zero page refines, nested pages after their own, until it returns
// false; returns whether all were visited. A page of a few bytes can refine 2^50: whoever asks for all needs
// a bound.
bool visit_zero_diamonds(PageKey key, int end_level, const std::function<bool(DiamondId)>& visit);

}  // namespace carat
