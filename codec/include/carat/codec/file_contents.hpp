// What a file was written from: its refined diamonds as the writer was given them, nothing decoded.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <vector>

#include "carat/codec/writer.hpp"

namespace carat {

// Thread-safe once made.
class FileContents : public PageStock {
  public:
    // Reads every page once and checks it. Throws Error(corrupt|truncated|unsupported|limit|io).
    explicit FileContents(const std::filesystem::path& file);
    ~FileContents() override;
    FileContents(const FileContents&) = delete;
    FileContents& operator=(const FileContents&) = delete;

    const RepositoryHeader& header() const;
    const Coding& coding() const;  // all orders: the file does not say which the encoder allowed
    // Level by level, each in the order of ids. Under a zero page the summaries are the page's: min and max
    // of all its halves, the greatest delta of the level.
    const std::vector<DiamondEntry>& diamonds() const;
    // Zero pages are numbered; -1 for a diamond that is not under one.
    std::int32_t zero_page(std::size_t index) const;
    std::size_t zero_pages() const;
    // The blob of a diamond, as it lies in the file. Throws Error(io|truncated).
    void blob(std::size_t index, std::vector<std::byte>& out) const;
    // Throws Error(io|truncated).
    bool copy(std::uint64_t key, std::size_t diamonds,
              const std::function<void(int, std::span<const std::byte>)>& add) const override;

  private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace carat
