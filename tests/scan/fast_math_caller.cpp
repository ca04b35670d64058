// SPDX-License-Identifier: Apache-2.0
// A caller that is compiled with -ffast-math, which lets a compiler take every comparison with NaN for a usual one.
#include <gnosphere/scan.hpp>
#include <limits>

int main() {
  gnosphere::Scan scan;
  scan.ranges = {0, 5, std::numeric_limits<float>::infinity(), std::numeric_limits<float>::quiet_NaN(),
                 -std::numeric_limits<float>::quiet_NaN()};
  for (size_t entry = 0; entry < scan.ranges.size(); ++entry)
    if (scan.returned(entry) != (entry < 3)) return 1;
  return 0;
}
