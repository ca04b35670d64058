// SPDX-License-Identifier: Apache-2.0
#include "town/opendrive/plan.hpp"

#include <algorithm>
#include <cmath>

#include "town/choice.hpp"
#include "town/opendrive/roadside.hpp"

namespace gnosphere::town::opendrive {

Area landOf(const Network& network) {
  constexpr double kMargin = 45;
  Area land = {0, 0, 0, 0};
  for (const Road& road : network.roads)
    for (double s : stations(road, 0, road.length)) {
      const Vec3 p = road.frame(s).at;
      land = {std::min(land.x0, p.x), std::min(land.y0, p.y), std::max(land.x1, p.x), std::max(land.y1, p.y)};
    }
  return {land.x0 - kMargin, land.y0 - kMargin, land.x1 + kMargin, land.y1 + kMargin};
}

Plan planNetwork(const Network& network, const Area& land, const Drive& drive, uint32_t seed, const Detail& detail) {
  Plan plan;
  const Terrain terrain(network, land);
  Roadside roadside(plan, network, terrain, land, drive, detail);
  std::set<std::string> junctions;
  for (const Road& road : network.roads) {
    if (!road.junction.empty()) {
      if (junctions.insert(road.junction).second) roadside.addGround(junctionPieces(network, road.junction), true);
      continue;
    }
    roadside.addGround(roadPieces(road), true);
  }
  roadside.addGround(terrain.tiles(), false);
  uint64_t number = 0;  // ids are arbitrary text, so roads are numbered
  for (const Road& road : network.roads) {
    Dice dice(seed, 32, number++);
    if (!road.junction.empty()) continue;
    for (bool left : {false, true}) roadside.build(road, left, dice);
    for (bool left : {false, true}) roadside.furnish(road, left, dice);
    roadside.addTraffic(road, dice);
  }
  Dice dice(seed, 33);
  roadside.plant(dice);
  return plan;
}

}  // namespace gnosphere::town::opendrive
