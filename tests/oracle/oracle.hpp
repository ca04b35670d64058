// SPDX-License-Identifier: Apache-2.0
// Computes what `exact` must return, with integers of any size: every beam against every triangle. The oracle shares
// the tables of beam directions and the documented transformation of corners with the shaders, and nothing else.
#pragma once

#include <array>
#include <vector>

#include "gnosphere/gnosphere.hpp"

namespace gnosphere::test {

using Float3 = std::array<float, 3>;

/// A triangle as the device sees it: single precision, in the sensor frame, on the lattice of 2^-30 m.
struct SeenTriangle {
  Float3 a, b, c;
  uint32_t instance = 0;
  uint32_t index = 0;  ///< within the instance's mesh
  bool oneSided = false;
};

/// Transforms corners as the shaders document it: rows * (position - pivot) + offset, in single precision, from left to
/// right. The order is that of placed triangles; invalid, degenerate and unreachable ones are left out.
std::vector<SeenTriangle> seenTriangles(const Scene& scene, const Pose& pose, double rangeMax,
                                        ReflectingFaces faces = ReflectingFaces::material);

/// Directions of all beams as the shaders use them.
std::vector<Float3> seenBeams(const Sensor& sensor);

/// Returns the correctly rounded range of a beam on a triangle, 0 for a miss. The three sides must have one sign, with
/// the beam moved by e up, e^2 left and e^3 forward for an infinitesimal e; a triangle seen exactly edge-on is missed.
float exactRange(const SeenTriangle& triangle, const Float3& beam);

/// Returns the cloud of `exact`: ranges, triangles and instances of every beam, and the number of hits; no points and
/// no other counters. If given, `layers` receives the number of triangles that each beam hits within the range window.
Scan exactScan(const Scene& scene, const Sensor& sensor, const Pose& pose,
               ReflectingFaces faces = ReflectingFaces::material, std::vector<uint32_t>* layers = nullptr);

}  // namespace gnosphere::test
