// SPDX-License-Identifier: Apache-2.0
// How far apart neighbouring floats are.
#pragma once

#include <cmath>
#include <iomanip>
#include <limits>
#include <sstream>
#include <string>

namespace gnosphere {

/// The distance in metres from which on neighbouring floats are 2 mm apart, or more.
inline constexpr double kCoarseFrom = 16384;

/// The distance from a positive number to the next float.
inline double stepAt(float value) {
  return std::nextafter(value, std::numeric_limits<float>::infinity()) - value;
}

/// As "in single precision, which has steps of 0.5 m at 5300020 m".
inline std::string inSinglePrecision(double step, double far) {
  std::ostringstream text;
  text << "in single precision, which has steps of " << std::setprecision(3) << step << " m at "
       << std::setprecision(10) << std::round(far) << " m";
  return text.str();
}

}  // namespace gnosphere
