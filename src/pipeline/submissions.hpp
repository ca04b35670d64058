// SPDX-License-Identifier: Apache-2.0
// Divides shots into submissions, each of which scans many views together, and places what their views see.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "pipeline/scene_arrays.hpp"
#include "pipeline/sensor_arrays.hpp"

namespace gnosphere {

/// A submission: views of some shots. A shot of a sensor whose beams start far apart has several views. If the views of
/// a shot are in several parts, these parts have no views of other shots.
struct Part {
  std::span<const Shot> shots;
  size_t index;  ///< of the first shot
  std::vector<View> views;
  bool first, last;  ///< of the parts of these shots
};

constexpr size_t kAnyViews = std::numeric_limits<size_t>::max();

/// The most that a part of a submission may have.
struct PartLimits {
  const SceneArrays& scene;
  uint64_t listBytes;  ///< on the device, of lists of the scene's instances and clusters
  size_t views;
};

/// Divides shots into parts within the limits. `sensors` has the arrays by sensor. The parts refer to the shots and the
/// sensors.
std::vector<Part> partsOf(std::span<const Shot> shots, std::span<SensorArrays* const> sensors,
                          const PartLimits& limits);

/// Returns the shot of each view of a part. If a shot has several views, `copies` holds them.
std::span<const Shot> shotsOfViews(const Part& part, std::vector<Shot>& copies);

/// Returns the motions of views of which the first one tells whether anything moves. `shots` has the shot of each view.
std::vector<ShotMotion> motionsOf(const SensorPlan& plan, std::span<const View> views, std::span<const Shot> shots,
                                  const SceneArrays& scene);

/// Places the instances that the views of a submission see. `shots` has the shot of each view; `selection` chooses
/// among the instances by which of them move, if there is one view. The result refers to `to`.
InstanceEntries placeViews(SceneArrays& scene, const SensorArrays& sensor, std::span<const Shot> shots,
                           ShotMotions motions, Selection selection, PlacedArrays& to);

}  // namespace gnosphere
