// SPDX-License-Identifier: Apache-2.0
// What `exact` must answer, by integers of any size: every beam against every triangle. It shares with the shaders the
// tables of beam directions and the documented way of a corner into the sensor's frame, and nothing after that.
#pragma once

#include <array>
#include <vector>

#include "gnosphere/gnosphere.hpp"

namespace gnosphere::test {

using Float3 = std::array<float, 3>;

/// A triangle as the device sees it: single precision, sensor frame, on the lattice of 2^-30 m.
struct SeenTriangle {
  Float3 a, b, c;
  uint32_t instance = 0;
  uint32_t index = 0;  ///< within the instance's mesh
  bool oneSided = false;
};

/// Corners as the shaders document them: rows * (position - pivot) + offset, in single precision, left to right.
/// In order of the placed triangle. What is broken, degenerate or cannot be reached from the pose is left out.
std::vector<SeenTriangle> seenTriangles(const Scene& scene, const Pose& pose, double rangeMax,
                                        Faces faces = Faces::material);

/// Direction of every beam, as the shaders have it.
std::vector<Float3> seenBeams(const Sensor& sensor);

/// The correctly rounded range of a beam on a triangle, 0 for a miss. The three sides must have one sign, the beam
/// being moved by e up, e^2 left and e^3 forward for a vanishing e; a triangle seen exactly edge-on is a miss.
float exactRange(const SeenTriangle& triangle, const Float3& beam);

/// The cloud of `exact`: ranges, triangles and instances of every beam; no points, no counters but hits.
/// `layers`, if given, receives how many triangles each beam meets within the range window.
Scan exactScan(const Scene& scene, const Sensor& sensor, const Pose& pose, Faces faces = Faces::material,
               std::vector<uint32_t>* layers = nullptr);

}  // namespace gnosphere::test
