// SPDX-License-Identifier: Apache-2.0
// The hits of one line of light, in double, and whether single precision may see others.
#pragma once

#include <span>

#include "gnosphere/simulator.hpp"
#include "reference/doubt.hpp"
#include "reference/surface.hpp"
#include "reference/world.hpp"
#include "sensor/beams.hpp"

namespace gnosphere::reference {

/// Data that all beams of a scan share.
struct View {
  const Scene& scene;
  const Bvh& tree;
  const Sensor& sensor;
  bool cutOuts = false;                  ///< whether textures may have holes
  std::vector<uint8_t> panes = {};       ///< per material: whether light passes it; empty if it passes none
  std::vector<CornerError> errors = {};  ///< per instance
  std::vector<uint8_t> dropped = {};     ///< per triangle of the tree: out of bounds from this pose; empty if none is
  double spread = 0;                     ///< relative widening of a beam, so that it finds every triangle in doubt
  double floor = 0;

  bool isDropped(uint32_t triangle) const { return !dropped.empty() && dropped[triangle] != 0; }
};

/// `pose` decides which triangles are out of bounds, which are counted, and how large errors are.
View viewOf(const Scene& scene, const Bvh& tree, const std::vector<PlacedMesh>& places, const Sensor& sensor,
            const Pose& pose, Counters& counters);

/// The axis of a beam, or one of its sub-rays.
struct Line {
  SensorFrame frame;   ///< the frame in which it starts
  Vec3 direction;      ///< unit, in that frame
  double time = 0;     ///< seconds after the start of the scan
  RangeWindow window;  ///< a surface counts only within it
  /// Metres from the laser to the place that triangles are seen from: their rounding adds to that of the corners.
  double reach = 0;
  double astray = 0;  ///< bound in radians on an error of its direction in single precision, besides kDirectionError
};

/// The error of a corner of an instance as the laser of the line sees it.
CornerError errorOf(const View& view, const Line& line, uint32_t instance);

inline constexpr uint32_t kNobody = kNoTriangle;

struct Hit {
  uint32_t triangle = kNobody;  ///< index in the tree
  double range = 0;
  Weights weights = {};
};

/// Panes closer to each other than this, relative to their range, count as one: a line through a shared edge passes
/// both triangles, and those are not two panes.
inline constexpr double kOneSurface = 0x1p-20;

/// Returns the nearest hit, or the nearest one after that of a pane at the range `behind`: an opaque one, however close
/// to the pane, or another pane clearly behind it. Among equals it is the lower instance and triangle.
Hit nearest(const View& view, const Line& line, double behind = 0);

/// Returns whether single precision may see other hits than these. A line is certain if every hit is certain and no
/// other triangle can be hit before the last one (or before the end of the range if light passes the last, `goesOn`),
/// and their order is certain; otherwise it is a tie. `tolerance` is raised to the range error that single precision
/// may show.
bool inDoubt(const View& view, const Line& line, std::span<const Hit> hits, bool goesOn, double& tolerance);

}  // namespace gnosphere::reference
