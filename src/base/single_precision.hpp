// SPDX-License-Identifier: Apache-2.0
// How far apart neighbouring floats are.
#pragma once

#include <cmath>
#include <cstdio>
#include <limits>
#include <string>

#include "base/decimal_point.hpp"

namespace gnosphere {

/// The distance in metres from which on neighbouring floats are 2 mm apart, or more.
inline constexpr double kCoarseFrom = 16384;

/// The distance from a positive number to the next float.
inline double stepAt(float value) {
  return std::nextafter(value, std::numeric_limits<float>::infinity()) - value;
}

/// As "in single precision, which has steps of 0.5 m at 5300020 m".
inline std::string inSinglePrecision(double step, double far) {
  const DecimalPoint point;
  char text[96];
  std::snprintf(text, sizeof text, "in single precision, which has steps of %.3g m at %.10g m", step, std::round(far));
  return text;
}

}  // namespace gnosphere
