// SPDX-License-Identifier: Apache-2.0
// Measures processor time, which other programs of the machine do not lengthen.
#pragma once

#include <ctime>

namespace gnosphere::test {

/// Returns the seconds of processor time that a call takes.
template <class Call>
double cpuSeconds(const Call& call) {
  const std::clock_t start = std::clock();
  call();
  return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
}

}  // namespace gnosphere::test
