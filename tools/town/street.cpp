// SPDX-License-Identifier: Apache-2.0
// Places the objects on sidewalks and carriageways.
#include <algorithm>
#include <cmath>

#include "town/choice.hpp"

namespace gnosphere::town {
namespace {

/// One side of a block of houses: at() gives points by their distance along the kerb and from it, on the sidewalk.
struct Side {
  Vec3 corner, along, inward;
  double length;
  double turns;  ///< heading of objects that face the road
  Vec3 at(double distance, double depth) const {
    return corner + distance * along + depth * inward + Vec3{0, 0, kKerbHeight};
  }
};

Side sideOf(const Site& site, int side) {
  const double width = site.x1 - site.x0, depth = site.y1 - site.y0;
  switch (side) {
    case 0: return {{site.x0, site.y0, 0}, {1, 0, 0}, {0, 1, 0}, width, 0.75};
    case 1: return {{site.x1, site.y0, 0}, {0, 1, 0}, {-1, 0, 0}, depth, 0};
    case 2: return {{site.x1, site.y1, 0}, {-1, 0, 0}, {0, -1, 0}, width, 0.25};
    default: return {{site.x0, site.y1, 0}, {0, -1, 0}, {1, 0, 0}, depth, 0.5};
  }
}

void planCorner(Plan& plan, Dice& dice, const Side& side, bool lights) {
  // The end of a side, just before the crossing. With traffic on the right, vehicles arrive along the side's direction.
  if (lights) {
    plan.add(Prop{PropKind::trafficLight}, side.at(side.length - 5.2, 0.6), side.turns - 0.25);
  } else if (dice.chance(60)) {
    plan.add(Prop{PropKind::signStop}, side.at(side.length - 5.2, 0.5), side.turns - 0.25);
  }
  for (int i = 0; i < 3; ++i)
    if (dice.chance(50)) plan.add(Prop{PropKind::bollard}, side.at(5.0 + 1.6 * i, 0.4));
}

void planSmallThings(Plan& plan, Dice& dice, const Side& side, double spot) {
  switch (dice.below(9)) {
    case 0: plan.add(Prop{PropKind::bench}, side.at(spot, 0.9), side.turns + 0.5); break;
    case 1: plan.add(Prop{PropKind::bin}, side.at(spot, 0.6)); break;
    case 2: plan.add(Prop{PropKind::hydrant}, side.at(spot, 0.5), side.turns); break;
    case 3: plan.add(Prop{PropKind::signBlue}, side.at(spot, 0.5), side.turns - 0.25); break;
    case 4: plan.add(Prop{PropKind::signDisc}, side.at(spot, 0.5), side.turns - 0.25); break;
    case 5:
      for (int i = 0; i < 2; ++i)
        plan.add(Prop{PropKind::bicycle}, side.at(spot + 0.7 * i, 0.9), side.turns + dice.between(-0.02, 0.02));
      break;
    default: break;
  }
}

void planPeople(Plan& plan, Dice& dice, const Side& side, bool fine) {
  const int count = dice.below(5);
  for (int i = 0; i < count; ++i) {
    const double distance = dice.between(3, side.length - 3), depth = dice.between(1.3, kSidewalk - 0.5);
    const double heading = side.turns + (dice.chance(50) ? 0.25 : -0.25) + dice.between(-0.04, 0.04);
    const double size = dice.between(0.92, 1.06);
    plan.add(Prop{PropKind::person, dice.below(12), 0, fine}, side.at(distance, depth), heading, size);
  }
}

}  // namespace

void planSidewalks(Plan& plan, const Site& site, const Detail& detail) {
  for (int k = 0; k < 4; ++k) {
    Dice dice(site.seed, 16 + static_cast<uint64_t>(k), static_cast<uint64_t>(site.column + 4096),
              static_cast<uint64_t>(site.row + 4096));
    const Side side = sideOf(site, k);
    planCorner(plan, dice, side, site.trafficLights[k]);
    const bool busStop = site.avenues[k] && side.length > 45 && dice.chance(60);
    if (busStop) plan.add(Prop{PropKind::busStop}, side.at(side.length * 0.62, 1.7), side.turns);
    const bool trees = site.avenues[k] || dice.chance(30);
    const int kind = dice.below(5), spots = std::max(1, static_cast<int>((side.length - 20) / 8.5));
    for (int i = 0; i <= spots; ++i) {
      const double spot = 10 + (side.length - 20) * i / spots;
      if (busStop && std::abs(spot - side.length * 0.62) < 4.5) continue;
      if (i % 3 == 1) {
        plan.add(Prop{PropKind::lamp}, side.at(spot, 0.55), side.turns);
      } else if (trees) {
        const int variant = dice.below(6);
        const double turns = dice.uniform(), size = dice.between(0.75, 1.05);
        plan.add(Tree{kind == 4 ? TreeKind::poplar : TreeKind::broadleaf, detail.treeLeaves, variant},
                 side.at(spot, 0.9), turns, size);
      } else {
        planSmallThings(plan, dice, side, spot);
      }
      if (dice.chance(60)) planSmallThings(plan, dice, side, spot + 4.2);
    }
    planPeople(plan, dice, side, detail.fine);
  }
}

void planTraffic(Plan& plan, Dice& dice, const Vec3& start, bool alongY, double length, double halfWidth, bool avenue,
                 const Detail& detail) {
  const auto put = [&](const Vehicle& vehicle, double along, double across, double turns) {
    const Vec3 at = alongY ? Vec3{start.x - across, start.y + along, 0} : Vec3{start.x + along, start.y + across, 0};
    plan.add(vehicle, at, turns + (alongY ? 0.25 : 0));
  };
  for (double side : {-1.0, 1.0}) {  // traffic keeps to the right: side -1 drives along the axis
    const double heading = side < 0 ? 0 : 0.5;
    if (!avenue)
      for (double along = 4; along < length - 4; along += 6.1) {
        const double shift = dice.between(-0.5, 0.5), skew = dice.between(-0.006, 0.006);
        const Vehicle car = anyCar(dice, detail.fine);
        if (dice.chance(30)) put(car, along + shift, side * (halfWidth - 1.0), heading + skew);
      }
    const int lanes = avenue ? 2 : 1;
    for (int lane = 0; lane < lanes; ++lane) {
      const double across = side * (avenue ? halfWidth * (lane + 0.5) / 2 : (halfWidth - 2) / 2);
      for (double along = dice.between(2, 30); along < length - 7; along += dice.between(20, 80)) {
        const bool bus = avenue && lane == 1 && dice.chance(15);
        const Vehicle vehicle =
            bus ? Vehicle{VehicleKind::bus, Surface::paintYellow, detail.fine} : anyCar(dice, detail.fine);
        put(vehicle, along + (bus ? 6 : 0), across, heading);
      }
    }
  }
}

}  // namespace gnosphere::town
