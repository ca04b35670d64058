// SPDX-License-Identifier: Apache-2.0
// Numbers that are neither infinite nor NaN, in double or in single precision.
#pragma once

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

namespace gnosphere {

/// Whether a number is finite when it is rounded to a float.
inline bool isFiniteFloat(double value) {
  return std::abs(value) <= std::numeric_limits<float>::max();
}

template <typename Values>
bool allFinite(const Values& values) {
  return std::all_of(std::begin(values), std::end(values), [](auto value) { return std::isfinite(value); });
}

}  // namespace gnosphere
