// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cfenv>

namespace gnosphere {

/// While this lives the thread rounds to the nearest number, keeps denormal numbers and has no floating-point traps, as
/// do threads that it starts meanwhile; then it has the floating-point environment of before.
class NearestRounding {
 public:
  NearestRounding() {
    std::fegetenv(&before_);
    std::fesetenv(FE_DFL_ENV);
  }
  ~NearestRounding() { std::fesetenv(&before_); }
  NearestRounding(const NearestRounding&) = delete;
  NearestRounding& operator=(const NearestRounding&) = delete;

 private:
  std::fenv_t before_;
};

}  // namespace gnosphere
