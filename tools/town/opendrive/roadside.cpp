// SPDX-License-Identifier: Apache-2.0
#include "town/opendrive/roadside.hpp"

#include <algorithm>
#include <cmath>

#include "town/choice.hpp"

namespace gnosphere::town::opendrive {
namespace {

/// Returns the priority (Placement::reach) of an object at a distance from the middle: as in the grid, nearby objects
/// come first.
double reachOf(double distance, double ahead) {
  return blendedReach(std::max(0.0, distance - ahead), std::max(0.0, distance - kBuiltFirst));
}

Vec3 turned(const Vec3& v, double turns) {
  const double c = cosine(turns), s = sine(turns);
  return {c * v.x - s * v.y, s * v.x + c * v.y, 0};
}

}  // namespace

/// A place beside a road: at the road's edge, or at the kerb of its sidewalk.
struct Roadside::Spot {
  Vec3 at;
  Vec3 along;        ///< level; the direction of traffic on this side in countries that drive on the right
  Vec3 outward;      ///< level, away from the road
  double width = 0;  ///< of the sidewalk
  Vec3 point(double forward, double out) const { return at + forward * along + out * outward; }
};

void Roadside::put(const Thing& thing, const Transform& where) {
  const double ahead = std::holds_alternative<Building>(thing) ? 10 : 0;
  const double distance = std::max(std::abs(where.rows[3] - focus_.x), std::abs(where.rows[7] - focus_.y));
  plan_.placements.push_back({thing, where, reachOf(distance, ahead)});
}

void Roadside::addGround(std::vector<GroundPiece> pieces, bool areRoads) {
  for (GroundPiece& piece : pieces) {
    // The distance of the piece's nearest vertex, slightly reduced so that ground comes before the objects on it.
    double nearest = 1e9;
    for (size_t v = 0; v < piece.mesh.vertexCount(); ++v) {
      const float* p = &piece.mesh.positions[3 * v];
      nearest =
          std::min(nearest, std::max(std::abs(piece.at.x + p[0] - focus_.x), std::abs(piece.at.y + p[1] - focus_.y)));
    }
    plan_.placements.push_back({Piece{plan_.pieces.size()}, place(piece.at), reachOf(nearest, 12), areRoads});
    plan_.pieces.push_back(std::move(piece.mesh));
  }
}

Roadside::Spot Roadside::edgeOf(const Road& road, bool left, double s) const {
  const LaneSection& section = road.sectionAt(s);
  const std::vector<double> edges = laneEdges(road, section, s);
  const std::vector<VisibleLane> lanes = visibleLanes(section, edges);
  const RoadFrame frame = road.frame(s);
  const Vec3 level = {-frame.along.y, frame.along.x, 0};
  if (left) return {frame.point(lanes.empty() ? edges.front() : edges[lanes.front().index]), -1 * frame.along, level};
  return {frame.point(lanes.empty() ? edges.back() : edges[lanes.back().index + 1]), frame.along, -1 * level};
}

bool Roadside::sidewalkOf(const Road& road, bool left, double s, Spot& spot) const {
  const LaneSection& section = road.sectionAt(s);
  const std::vector<double> edges = laneEdges(road, section, s);
  for (size_t i = 0; i < section.lanes.size(); ++i) {
    const Lane& lane = section.lanes[i];
    if (lane.use != LaneUse::sidewalk || (lane.id > 0) != left || edges[i] - edges[i + 1] < 1) continue;
    const RoadFrame frame = road.frame(s);
    const Vec3 level = {-frame.along.y, frame.along.x, 0};
    const double height = lane.hasHeight ? valueAt(lane.inner, s - section.s) : kCurbHeight;
    spot = {frame.point(edges[left ? i + 1 : i], height), left ? -1 * frame.along : frame.along,
            left ? level : -1 * level, edges[i] - edges[i + 1]};
    return true;
  }
  return false;
}

bool Roadside::addBuilding(const Spot& spot, const Building& building, double setback) {
  const double halfWidth = building.width / 2.0, halfDepth = building.depth / 2.0;
  const Vec3 centre = spot.point(0, setback + halfDepth);
  if (!occupancy_.isFree(centre, spot.along, halfWidth - 0.6, halfDepth + 0.2)) return false;
  occupancy_.take(centre, spot.along, halfWidth, halfDepth);
  Vec3 at = spot.point(0, setback);
  at.z = terrain_.at(centre.x, centre.y);
  for (double u : {-halfWidth, halfWidth})
    for (double v : {0.0, 2 * halfDepth}) {
      const Vec3 corner = spot.point(u, setback + v);
      at.z = std::min(at.z, terrain_.at(corner.x, corner.y));
    }
  put(building, placeAlong(at, -1 * turned(spot.outward, 0.25)));  // its front faces the road
  return true;
}

void Roadside::addGarden(const Spot& spot, double width, Dice& dice) {
  const auto onGround = [&](double forward, double out) {
    Vec3 p = spot.point(forward, out);
    p.z = terrain_.at(p.x, p.y);
    return p;
  };
  const double setback = dice.between(4.5, 6.5);
  const Building house = anyHouse(dice);
  if (!addBuilding(spot, house, setback)) return;
  const Vec3 x = -1 * turned(spot.outward, 0.25);
  const double run = std::floor(width) - 4;
  const Vec3 fence = onGround(0, 0.6), far = fence + run / 2 * spot.along;
  if (occupancy_.isFree(fence, spot.along, run / 2, 0.1) && land_.contains(far.x, far.y)) {
    put(Prop{dice.chance(50) ? PropKind::hedge : PropKind::fence, 0, static_cast<int>(run)},
        placeAlong(fence - run / 2 * x, x));
    occupancy_.take(fence, spot.along, run / 2, 0.2);
  }
  for (int i = 0; i < 4; ++i) {
    const double out = i == 0 ? setback + house.depth + dice.between(2, 6) : dice.between(1.6, setback - 1.2);
    const Vec3 p = onGround(dice.between(-width / 2 + 1, width / 2 - 1), out);
    const Vec3 direction = turned(spot.along, dice.uniform());
    const double size = dice.between(0.7, 1.3);
    const int variant = dice.below(4);
    if (!occupancy_.isFree(p, spot.along, 0.6, 0.6)) continue;
    if (i == 0)
      put(anyTree(dice, detail_), placeAlong(p, direction, size));
    else
      put(Tree{TreeKind::bush, detail_.treeLeaves / 4, variant}, placeAlong(p, direction, size));
  }
}

void Roadside::build(const Road& road, bool left, Dice& dice) {
  const int pick = dice.below(100);
  const bool gardens = pick >= 50 && pick < 80, offices = pick >= 80;
  const int depth = 10 + dice.below(3);
  double from = 2;
  while (from < road.length - 8) {
    Building building;
    double gap = 0;
    if (gardens) {
      building.width = 15;
      gap = 0.5;
    } else if (offices) {
      building = {BuildingKind::office,
                  18 + 2 * dice.below(5),
                  15,
                  3 + dice.below(6),
                  RoofKind::flat,
                  dice.chance(60) ? Surface::concrete : Surface::plasterWhite,
                  Surface::roofTile,
                  true,
                  dice.below(6)};
      gap = 7;
    } else {
      building = anyRowBuilding(dice, anyRowWidth(dice), depth, true);
    }
    const double middle = from + building.width / 2.0;
    if (middle + building.width / 2.0 > road.length - 2) break;
    const Spot spot = edgeOf(road, left, middle);
    if (gardens) {
      addGarden(spot, building.width, dice);
    } else if (!addBuilding(spot, building, 1.2)) {
      from += 3;  // there is a bend or another house: try a little further on
      continue;
    }
    from += building.width + gap;
  }
}

void Roadside::addSmallThing(const Spot& spot, Dice& dice) {
  const Vec3 toRoad = -1 * spot.outward;
  const auto prop = [&](PropKind kind, double out, const Vec3& x) {
    put(Prop{kind}, placeAlong(spot.point(0, out), x));
  };
  switch (dice.below(9)) {
    case 0: prop(PropKind::bench, 0.9, spot.outward); break;
    case 1: prop(PropKind::bin, 0.6, toRoad); break;
    case 2: prop(PropKind::hydrant, 0.5, toRoad); break;
    case 3: prop(PropKind::signBlue, 0.5, -1 * spot.along); break;
    case 4: prop(PropKind::signDisc, 0.5, -1 * spot.along); break;
    case 5: prop(PropKind::bicycle, 0.9, toRoad); break;
    default: break;
  }
}

void Roadside::furnish(const Road& road, bool left, Dice& dice) {
  constexpr double kSpacing = 8.5;
  const bool trees = dice.chance(60);
  const int kind = dice.below(5);
  int number = 0;
  Spot spot;
  for (double s = 4; s < road.length - 3; s += kSpacing) {
    if (!sidewalkOf(road, left, s, spot)) continue;
    const Vec3 toRoad = -1 * spot.outward;
    if (++number % 3 == 1) {
      put(Prop{PropKind::lamp}, placeAlong(spot.point(0, 0.55), toRoad));
    } else if (trees && spot.width > 1.8) {
      const Tree tree = {kind == 4 ? TreeKind::poplar : TreeKind::broadleaf, detail_.treeLeaves, dice.below(6)};
      const double turns = dice.uniform(), size = dice.between(0.75, 1.05);
      put(tree, placeAlong(spot.point(0, 0.9), turned(spot.along, turns), size));
    } else {
      addSmallThing(spot, dice);
    }
    if (dice.chance(60) && s + 4.2 < road.length - 3 && sidewalkOf(road, left, s + 4.2, spot))
      addSmallThing(spot, dice);
    if (dice.chance(35) && sidewalkOf(road, left, s + 2, spot)) {
      const double out = dice.between(std::min(1.3, spot.width / 2), spot.width - 0.3);
      const double turns = (dice.chance(50) ? 0.0 : 0.5) + dice.between(-0.04, 0.04), size = dice.between(0.92, 1.06);
      put(Prop{PropKind::person, dice.below(12), 0, detail_.fine},
          placeAlong(spot.point(0, out), turned(spot.along, turns), size));
    }
  }
}

void Roadside::addTraffic(const Road& road, Dice& dice) {
  constexpr double kCar = 5;  // metres of lane per car
  for (const LaneSection& section : road.sections)
    for (size_t i = 0; i < section.lanes.size(); ++i) {
      const Lane& lane = section.lanes[i];
      if ((!lane.driving && !lane.parking) || drive_.uses(road, lane)) continue;
      double s = section.s + (lane.parking ? kCar : dice.between(kCar, 30));
      for (; s < section.end - kCar; s += lane.parking ? 6.1 : dice.between(20, 80)) {
        const Vehicle car = anyCar(dice, detail_.fine);
        const std::vector<double> edges = laneEdges(road, section, s);
        if ((lane.parking && !dice.chance(40)) || edges[i] - edges[i + 1] < 2.2) continue;
        const LaneMiddle middle = laneMiddle(road, section, i, s);
        put(car, placeOn(middle.at, (road.isForward(lane) ? 1.0 : -1.0) * middle.along, middle.up));
      }
    }
}

void Roadside::plant(Dice& dice) {
  constexpr double kStep = 7.5, kMost = 1e6;  // metres between trees, more if there would be more than kMost
  const double step = std::max(kStep, std::sqrt((land_.x1 - land_.x0) * (land_.y1 - land_.y0) / kMost));
  for (double y = land_.y0 + step; y < land_.y1 - step / 2; y += step)
    for (double x = land_.x0 + step; x < land_.x1 - step / 2; x += step) {
      Vec3 at = {x + dice.between(-2.5, 2.5), y + dice.between(-2.5, 2.5), 0};
      const Vec3 direction = turned({1, 0, 0}, dice.uniform());
      const double size = dice.between(0.75, 1.3);
      const int pick = dice.below(100), variant = dice.below(4);
      const Tree tree = anyTree(dice, detail_);
      if (pick >= 75 || !occupancy_.isFree(at, {1, 0, 0}, 1.6, 1.6)) continue;
      at.z = terrain_.at(at.x, at.y);
      if (pick < 50)
        put(tree, placeAlong(at, direction, size));
      else
        put(Tree{TreeKind::bush, detail_.treeLeaves / 4, variant}, placeAlong(at, direction, size));
    }
}

}  // namespace gnosphere::town::opendrive
