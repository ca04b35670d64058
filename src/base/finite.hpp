// SPDX-License-Identifier: Apache-2.0
// Numbers that are neither infinite nor NaN.
#pragma once

#include <algorithm>
#include <cmath>
#include <iterator>

namespace gnosphere {

template <typename Values>
bool allFinite(const Values& values) {
  return std::all_of(std::begin(values), std::end(values), [](auto value) { return std::isfinite(value); });
}

}  // namespace gnosphere
