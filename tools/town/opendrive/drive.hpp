// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <set>
#include <utility>

#include "town/opendrive/network.hpp"

namespace gnosphere::town::opendrive {

/// A way along lanes, from one to the next by the file's links.
struct Drive {
  std::vector<Vec3> points;                     ///< on the road, half a metre apart or so
  std::set<std::pair<std::string, int>> lanes;  ///< road and lane
  bool uses(const Road& road, const Lane& lane) const { return lanes.contains({road.id, lane.id}); }
};

/// From the lane nearest to the middle of the network, from which there is a way of at least `metres`; the longest that
/// was found if there is none. Throws Error(format) if the network has no lane to drive on.
Drive planDrive(const Network& network, uint32_t seed, double metres);

}  // namespace gnosphere::town::opendrive
