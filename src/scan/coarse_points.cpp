// SPDX-License-Identifier: Apache-2.0
#include "scan/coarse_points.hpp"

#include <algorithm>
#include <cmath>

#include "base/single_precision.hpp"

namespace gnosphere {

std::string coarsePoints(const Scan& world) {
  float farthest = 0;
  for (const float coordinate : world.points) farthest = std::max(farthest, std::abs(coordinate));
  if (!(farthest >= kCoarseFrom) || !std::isfinite(farthest)) return "";
  return "points in the world frame are " + inSinglePrecision(stepAt(farthest), farthest);
}

}  // namespace gnosphere
