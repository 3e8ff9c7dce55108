#include "carat/globe/error.hpp"

namespace carat {

const char* to_string(ErrorCode code) {
    switch (code) {
        case ErrorCode::corrupt:
            return "corrupt";
        case ErrorCode::truncated:
            return "truncated";
        case ErrorCode::unsupported:
            return "unsupported";
        case ErrorCode::limit:
            return "limit";
        case ErrorCode::io:
            return "io";
        case ErrorCode::usage:
            return "usage";
    }
    return "unknown";
}

}  // namespace carat
