// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cfenv>

namespace gnosphere {

/// While this lives the thread rounds to the nearest number, keeps denormal numbers and has no floating-point traps, as
/// do threads that it starts meanwhile; then it has the floating-point environment of before.
class DefaultFloatEnvironment {
 public:
  DefaultFloatEnvironment() {
    std::fegetenv(&before_);
    std::fesetenv(FE_DFL_ENV);
  }
  ~DefaultFloatEnvironment() { std::fesetenv(&before_); }
  DefaultFloatEnvironment(const DefaultFloatEnvironment&) = delete;
  DefaultFloatEnvironment& operator=(const DefaultFloatEnvironment&) = delete;

 private:
  std::fenv_t before_;
};

}  // namespace gnosphere
