// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "town/building.hpp"
#include "town/ground.hpp"
#include "town/prop.hpp"
#include "town/tree.hpp"
#include "town/vehicle.hpp"

namespace gnosphere::town {

/// A mesh that there is but once, such as a piece of a bend: its index in Plan::pieces.
struct Piece {
  size_t index = 0;

  auto operator<=>(const Piece&) const = default;
};

/// Anything that stands in a town, described by a few whole numbers: equal things share one mesh.
using Thing = std::variant<Road, Crossing, Block, Building, Tree, Vehicle, Prop, Piece>;

/// Throws std::bad_variant_access for a Piece, whose mesh is in its plan.
Mesh meshOf(const Thing& thing);

/// A thing and where it is. A town that reaches `reach` metres from the origin contains it: partly its own distance
/// (so that a small town has all four corners of its crossing), partly that of its block (so that blocks are complete).
struct Placement {
  Thing thing;
  Transform where;
  double reach = 0;
};

/// A list of placements in the making: a town plan, or a block of it.
class Plan {
 public:
  std::vector<Placement> placements;
  std::vector<Mesh> pieces;
  double blockReach = 0;  ///< of what is added from now on

  Mesh meshOf(const Thing& thing) const;
  void add(const Thing& thing, const Vec3& at, double turns = 0, double scale = 1);
  /// Ground is there before anything stands on it: it counts from its nearest point to the origin.
  void addGround(const Thing& thing, const Vec3& at, double turns, const Vec3& min, const Vec3& max);
};

/// How fine the town is. Small towns take coarser trees and cars, so that there is room for more than a few of them.
struct Detail {
  int treeLeaves = 300;
  bool fine = false;  ///< vehicles and people
};

/// A rectangle of ground between streets.
struct Site {
  uint32_t seed = 1;
  int column = 0, row = 0;  ///< in the grid; -1, 0 are the blocks around the origin
  double x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  bool trafficLights[4] = {};  ///< at the corners, from (x1, y0) counter-clockwise
  bool avenues[4] = {};        ///< beside the sides, from y0 counter-clockwise
};

inline constexpr double kSidewalk = 3.5;

/// A rectangle, level with the axes.
struct Area {
  double x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  bool contains(double x, double y) const { return x >= x0 && x <= x1 && y >= y0 && y <= y1; }
};

/// The street grid, as far as `extent` metres from the origin along each axis, without what is between the streets
/// around `clearing`.
Plan planGrid(uint32_t seed, double extent, const Detail& detail, const std::optional<Area>& clearing = {});
/// The land between the streets around a clearing.
Area enclosedLand(uint32_t seed, const Area& clearing);
inline constexpr double kDriveMetres = 399 * 0.8;  ///< what a drive of 400 poses takes at 8 m/s and 10 Hz

/// A drive of more than that from the origin on: the middle of the streets, which their traffic leaves free, around
/// one block after the other, by points half a metre apart.
std::vector<Vec3> gridDrive(uint32_t seed);

void planBlock(Plan& plan, const Site& site, const Detail& detail);      ///< what is inside, and the ground
void planSidewalks(Plan& plan, const Site& site, const Detail& detail);  ///< street trees, lamps, signs, people
/// Vehicles on a carriageway of `length` metres that starts at a point and runs along x, or along y.
void planTraffic(Plan& plan, Dice& dice, const Vec3& start, bool alongY, double length, double halfWidth, bool avenue,
                 const Detail& detail);

}  // namespace gnosphere::town
