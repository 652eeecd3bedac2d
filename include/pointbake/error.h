// The one exception of the library. Messages say what, where (file and line or byte) and what would
// be accepted.
#pragma once

#include <stdexcept>
#include <string>

namespace pointbake {

enum class ErrorCode {
    kInvalidOption,  ///< an option's value is out of range or contradicts another
    kInvalidInput,   ///< a file or value does not hold what it promises
    kUnsupported,    ///< well-formed, but of a kind that is not read (yet)
    kIo,             ///< the input cannot be opened or read
    kOutput,         ///< the output cannot be written
    kDegenerate,     ///< nothing can be built from these points (all equal, collinear, too few)
    kLimit,          ///< a limit (memory, index range) or a bound under --strict is exceeded
    kEmpty,          ///< nothing left after cleaning
    kCancelled,
};

class Error : public std::runtime_error {
 public:
    Error(ErrorCode code, const std::string& message) : std::runtime_error(message), code_(code) {}
    ErrorCode code() const { return code_; }

 private:
    ErrorCode code_;
};

}  // namespace pointbake
