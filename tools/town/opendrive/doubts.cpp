// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include "town/opendrive/network.hpp"

namespace gnosphere::town::opendrive {
namespace {

/// Mistakes of one kind: the words for the first, and how many there are.
struct Mistakes {
  std::string first;
  size_t count = 0;

  void add(const std::string& words) {
    if (count++ == 0) first = words;
  }
  void tell(std::vector<std::string>& warnings) const {
    if (count == 0) return;
    warnings.push_back(first + (count > 1 ? " (and " + std::to_string(count - 1) + " more)" : ""));
  }
};

Mistakes gapsOf(const Network& network) {
  constexpr double kGap = 0.1;  // metres
  Mistakes gaps;
  for (const Road& road : network.roads)
    for (size_t i = 0; i + 1 < road.geometries.size(); ++i) {
      const Geometry &geometry = road.geometries[i], &next = road.geometries[i + 1];
      const double gap = lengthOf(next.start - geometry.at(geometry.length).at);
      if (!(gap > kGap)) continue;
      char text[96];
      std::snprintf(text, sizeof text, "its reference line jumps by %.2f m at s = %.6g m", gap, next.s);
      gaps.add("road " + road.id + ": " + text);
    }
  return gaps;
}

Mistakes danglingLinksOf(const Network& network) {
  std::set<std::string, std::less<>> roads, junctions;
  for (const Road& road : network.roads) roads.insert(road.id);
  for (const Junction& junction : network.junctions) junctions.insert(junction.id);
  Mistakes links;
  const auto check = [&](const std::string& who, bool isRoad, const std::string& id) {
    if ((isRoad ? roads : junctions).contains(id)) return;
    links.add(who + ": it is linked to " + (isRoad ? "road " : "junction ") + id + ", which the file lacks");
  };
  for (const Road& road : network.roads)
    for (const RoadLink* link : {&road.predecessor, &road.successor})
      if (link->kind != RoadLink::nothing) check("road " + road.id, link->kind == RoadLink::road, link->id);
  for (const Junction& junction : network.junctions)
    for (const Connection& connection : junction.connections)
      for (const std::string& id : {connection.incoming, connection.connecting})
        check("junction " + junction.id, true, id);
  return links;
}

}  // namespace

std::vector<std::string> doubtsOf(const Network& network) {
  std::vector<std::string> warnings;
  gapsOf(network).tell(warnings);
  danglingLinksOf(network).tell(warnings);
  return warnings;
}

}  // namespace gnosphere::town::opendrive
