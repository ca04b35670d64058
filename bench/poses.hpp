// SPDX-License-Identifier: Apache-2.0
// Finds poses in a scene that nobody has described: above a surface, with space around them, where much detail is seen.
#pragma once

#include <cstdint>
#include <vector>

#include "gnosphere/simulator.hpp"

namespace gnosphere::bench {

/// Height of a sensor above the surface on which it stands: kFullHeight, as on a car's roof, or less in a scene below
/// 18 m across.
inline constexpr double kFullHeight = 1.8;
double standingHeight(const Scene& scene);

/// Returns `count` poses, or fewer if the scene has no more places to stand on, those with the most detail first.
/// Places are drawn near random triangles. A place counts if it lies in the scene's box as seen from above, if there is
/// a surface below it (at standingHeight(), or nearer under a ceiling), and if nothing is close around it. Its score is
/// the number of different triangles that a coarse scan sees from the front, times the share of its beams that do:
/// backs are seen from within solids. The best places are taken that are not too close to each other.
///
/// The same seed gives the same poses on every device, because scans are `exact`.
std::vector<Pose> detailedPoses(const Scene& scene, size_t count, uint64_t seed, const DeviceChoice& device);

}  // namespace gnosphere::bench
