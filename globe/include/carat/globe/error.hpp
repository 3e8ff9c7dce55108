// Typed errors, shared by every module and by the exit code of the program.
#pragma once

#include <stdexcept>
#include <string>

namespace carat {

enum class ErrorCode {
    corrupt,      // bytes contradict the format or their checksum
    truncated,    // bytes end before the format says they do
    unsupported,  // a version, coder or feature this build does not know
    limit,        // a stated limit would be exceeded (memory, depth, size)
    io,           // the operating system or a library failed to read or write
    usage,        // the caller asked for something that cannot be done
};

// Name of a code, for messages and JSON: "corrupt", "truncated", ...
const char* to_string(ErrorCode code);

// The one exception type of Carat. The message names the file (or page) and the cause.
class Error : public std::runtime_error {
  public:
    Error(ErrorCode code, const std::string& what) : std::runtime_error(what), code_(code) {}
    ErrorCode code() const { return code_; }

  private:
    ErrorCode code_;
};

}  // namespace carat
