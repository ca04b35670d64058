// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <set>
#include <utility>

#include "town/opendrive/network.hpp"

namespace gnosphere::town::opendrive {

/// A point of a drive on the road, and the unit vector upright on the road there.
struct WayPoint {
  Vec3 at, up = {0, 0, 1};
};

/// A path along lanes, linked as the file states.
struct Drive {
  std::vector<WayPoint> points;                 ///< on the road, about half a metre apart
  std::set<std::pair<std::string, int>> lanes;  ///< road and lane
  bool uses(const Road& road, const Lane& lane) const { return lanes.contains({road.id, lane.id}); }
};

/// Plans a drive from the lane nearest to the middle of the network that begins a path of at least `metres`; if there
/// is none, the longest path found. Throws Error(format) if the network has no lane to drive on.
Drive planDrive(const Network& network, uint32_t seed, double metres);

}  // namespace gnosphere::town::opendrive
