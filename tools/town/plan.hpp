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

/// A mesh that is used only once, such as a piece of a bend: its index in Plan::pieces.
struct Piece {
  size_t index = 0;

  auto operator<=>(const Piece&) const = default;
};

/// Any object of a town, described by a few integers: equal objects share one mesh.
using Thing = std::variant<Road, Crossing, Block, Building, Tree, Vehicle, Prop, Piece>;

/// Throws std::bad_variant_access for a Piece, whose mesh is in its plan.
Mesh meshOf(const Thing& thing);

/// An object and its placement. The object belongs to every town that extends at least `reach` metres from the origin:
/// the reach combines the object's own distance (so that a small town has all four corners of its crossing) and that of
/// its block (so that blocks are complete). Surfaces of a network's roads come before everything else.
struct Placement {
  Thing thing;
  Transform where;
  double reach = 0;
  bool isRoad = false;  ///< a piece of a road or junction of a network
};

/// Metres around the origin that are built first, in a grid the four blocks there and their streets.
inline constexpr double kBuiltFirst = 55;

/// Combines the distance of an object and that of its block.
inline double blendedReach(double own, double block) {
  return 0.4 * own + 0.6 * block;
}

/// A list of placements that is being filled: a town plan, or a block of it.
class Plan {
 public:
  std::vector<Placement> placements;
  std::vector<Mesh> pieces;
  double blockReach = 0;  ///< reach of the block whose objects are added next

  Mesh meshOf(const Thing& thing) const;
  void add(const Thing& thing, const Vec3& at, double turns = 0, double scale = 1);
  /// Adds a piece of ground. The ground must come before the objects on it, so its nearest point to the origin counts.
  void addGround(const Thing& thing, const Vec3& at, double turns, const Vec3& min, const Vec3& max);
};

/// Level of detail of a town. Small towns have coarser trees and cars, so that there is room for more than a few.
struct Detail {
  int treeLeaves = 300;
  bool fine = false;  ///< for vehicles and people
};

/// A rectangle of ground between streets.
struct Site {
  uint32_t seed = 1;
  int column = 0, row = 0;  ///< in the grid; -1 and 0 are the blocks around the origin
  double x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  bool trafficLights[4] = {};  ///< at the corners, from (x1, y0) counter-clockwise
  bool avenues[4] = {};        ///< whether the streets at its sides are avenues, from y0 counter-clockwise
};

inline constexpr double kSidewalk = 3.5;

/// A rectangle parallel to the axes.
struct Area {
  double x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  bool contains(double x, double y) const { return x >= x0 && x <= x1 && y >= y0 && y <= y1; }
};

/// Plans the street grid up to `extent` metres from the origin along each axis, except the land between the streets
/// around `clearing`.
Plan planGrid(uint32_t seed, double extent, const Detail& detail, const std::optional<Area>& clearing = {});
/// Returns the land between the streets around a clearing.
Area enclosedLand(uint32_t seed, const Area& clearing);
inline constexpr double kDriveMetres = 399 * 0.8;  ///< length of a drive of 400 poses at 8 m/s and 10 Hz

/// Plans a drive that is longer than this, from the origin along the middle of the streets, which traffic leaves free,
/// around one block after the other. Its points are half a metre apart.
std::vector<Vec3> gridDrive(uint32_t seed);

void planBlock(Plan& plan, const Site& site, const Detail& detail);      ///< the objects inside, and the ground
void planSidewalks(Plan& plan, const Site& site, const Detail& detail);  ///< street trees, lamps, signs, people
/// Places vehicles on a carriageway of `length` metres that starts at a point and runs along x, or along y.
void planTraffic(Plan& plan, Dice& dice, const Vec3& start, bool alongY, double length, double halfWidth, bool avenue,
                 const Detail& detail);

}  // namespace gnosphere::town
