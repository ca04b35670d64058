// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdexcept>
#include <string>

#include "gnosphere/export.hpp"

namespace gnosphere {

/// The kind of failure that an Error reports. `invalidArgument` means that the call was wrong; every other code means
/// that the call was right but could not be carried out.
enum class ErrorCode { invalidArgument, file, format, device, outOfMemory };

/// The exception of the library, which throws no other one but std::bad_alloc, where the host's memory is at its end.
/// Its message is one sentence that names the cause and the remedy.
class GNOSPHERE_API Error : public std::runtime_error {
 public:
  Error(ErrorCode code, const std::string& message) : std::runtime_error(message), code_(code) {}
  ErrorCode code() const noexcept { return code_; }

 private:
  ErrorCode code_;
};

}  // namespace gnosphere
