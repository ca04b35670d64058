// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace gnosphere::drive {

/// Returns the median of numbers, of an even count the greater of the two in the middle; 0 if there are none. The
/// numbers change their order.
template <class Number>
double medianOf(std::vector<Number>& numbers) {
  if (numbers.empty()) return 0;
  const auto middle = numbers.begin() + static_cast<std::ptrdiff_t>(numbers.size() / 2);
  std::nth_element(numbers.begin(), middle, numbers.end());
  return *middle;
}

}  // namespace gnosphere::drive
