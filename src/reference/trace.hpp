// SPDX-License-Identifier: Apache-2.0
// What one line of light meets, in double, and whether single precision may see it otherwise.
#pragma once

#include <span>

#include "gnosphere/simulator.hpp"
#include "reference/doubt.hpp"
#include "reference/surface.hpp"
#include "reference/world.hpp"

namespace gnosphere::reference {

/// What all beams of one scan share.
struct View {
  const Scene& scene;
  const Bvh& tree;
  const Sensor& sensor;
  bool cutOuts = false;                  ///< holes of textures count
  std::vector<CornerError> errors = {};  ///< per instance
  std::vector<uint8_t> dropped = {};     ///< per triangle of the tree: out of bounds from this pose; empty if none is
  double spread = 0;                     ///< of the fat beam that finds every triangle in doubt
  double floor = 0;

  bool isDropped(uint32_t triangle) const { return !dropped.empty() && dropped[triangle] != 0; }
};

/// `pose` decides what is out of bounds, which is counted, and how large errors are.
View viewOf(const Scene& scene, const Bvh& tree, const std::vector<PlacedMesh>& places, const Sensor& sensor,
            const Pose& pose, Counters& counters);

/// A beam or a part of it.
struct Line {
  SensorFrame frame;  ///< where it leaves from
  Vec3 direction;     ///< unit, in that frame
  double time = 0;    ///< seconds after the start of the scan
  double astray = 0;  ///< radians that single precision may turn it by, beyond kDirectionError
};

inline constexpr uint32_t kNobody = kNoTriangle;

struct Hit {
  uint32_t triangle = kNobody;  ///< in the tree
  double range = 0;
  Weights weights = {};
};

/// Surfaces nearer to each other, relative to their range, are one: light that passes an edge passes both of its
/// triangles, and they are no two panes.
inline constexpr double kOneSurface = 0x1p-20;

/// The nearest hit, or the nearest that is well behind a range; of equal ones the lower instance and triangle.
Hit nearest(const View& view, const Line& line, double behind = 0);

/// Whether single precision may see anything else than these hits, in order: a line is a tie unless each must be hit
/// and nothing else may be, up to the last or, where light goes on behind it, up to the end of the range. `tolerance`
/// is made the range error that single precision may show, if it is less.
bool inDoubt(const View& view, const Line& line, std::span<const Hit> hits, bool goesOn, double& tolerance);

}  // namespace gnosphere::reference
