// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdexcept>
#include <string>

#include "gnosphere/export.hpp"

namespace gnosphere {

/// What kind of failure an Error reports. `invalidArgument` means the call was wrong; every other code means that the
/// call was right and the work failed.
enum class ErrorCode { invalidArgument, file, format, device, outOfMemory };

/// The one exception of the library. The message is a single sentence that names the culprit and the way out.
class GNOSPHERE_API Error : public std::runtime_error {
 public:
  Error(ErrorCode code, const std::string& message) : std::runtime_error(message), code_(code) {}
  ErrorCode code() const noexcept { return code_; }

 private:
  ErrorCode code_;
};

}  // namespace gnosphere
