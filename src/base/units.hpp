// SPDX-License-Identifier: Apache-2.0
// Factors of units: degrees, and the prefixes of SI.
#pragma once

#include <numbers>

namespace gnosphere {

inline constexpr double kDegree = std::numbers::pi / 180;  ///< in radians
inline constexpr double kRadian = 180 / std::numbers::pi;  ///< in degrees
inline constexpr double kMilli = 1e-3, kMicro = 1e-6, kNano = 1e-9;
inline constexpr double kMilliPerUnit = 1000;  ///< not 1 / kMilli, because 1e-3 is rounded

}  // namespace gnosphere
