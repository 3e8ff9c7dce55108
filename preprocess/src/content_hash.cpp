#include "content_hash.hpp"

#include <cpl_vsi.h>
#include <xxhash.h>

#include <memory>

#include "carat/globe/error.hpp"
#include "gdal_errors.hpp"

namespace carat {
namespace {

constexpr std::size_t kBuffer = std::size_t{1} << 20;

struct StateDeleter {
    void operator()(XXH3_state_t* s) const { XXH3_freeState(s); }
};
struct FileCloser {
    void operator()(VSILFILE* f) const { VSIFCloseL(f); }
};

bool is_file(const std::string& path) {
    VSIStatBufL stat{};
    return VSIStatExL(path.c_str(), &stat, VSI_STAT_EXISTS_FLAG | VSI_STAT_NATURE_FLAG) == 0 &&
           VSI_ISREG(stat.st_mode);
}

}  // namespace

ContentHash content_size(const std::vector<std::string>& files) {
    ContentHash result;
    for (const std::string& path : files) {
        VSIStatBufL stat{};
        if (is_file(path) && VSIStatL(path.c_str(), &stat) == 0)
            result.bytes += static_cast<std::uint64_t>(stat.st_size);
    }
    return result;
}

ContentHash content_hash(const std::vector<std::string>& files) {
    const std::unique_ptr<XXH3_state_t, StateDeleter> state(XXH3_createState());
    XXH3_64bits_reset(state.get());
    std::vector<char> buffer(kBuffer);
    ContentHash result;
    const GdalErrors errors;
    for (const std::string& path : files) {
        if (!is_file(path)) continue;
        const std::unique_ptr<VSILFILE, FileCloser> file(VSIFOpenL(path.c_str(), "rb"));
        if (!file) throw Error(ErrorCode::io, path + ": cannot open: " + errors.text());
        for (;;) {
            const std::size_t n = VSIFReadL(buffer.data(), 1, buffer.size(), file.get());
            XXH3_64bits_update(state.get(), buffer.data(), n);
            result.bytes += n;
            if (n == buffer.size()) continue;
            if (VSIFEofL(file.get()) == 0)
                throw Error(ErrorCode::io, path + ": cannot read: " + errors.text());
            break;
        }
    }
    result.hash = XXH3_64bits_digest(state.get());
    return result;
}

}  // namespace carat
