// SPDX-License-Identifier: Apache-2.0
// The arrays that the stages read and write for effects, for every kind of device.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "common/arrays.h"
#include "effects/sensor_plan.hpp"
#include "effects/shot_motion.hpp"

namespace gnosphere {

/// An array with its content, or its size alone if the stages write it.
struct ArrayContent {
  gpu::Array array;
  uint64_t bytes;
  std::vector<std::byte> content;  ///< `bytes` bytes, or empty
};

/// Tables that live as long as the sensor.
std::vector<ArrayContent> lastingTables(const SensorPlan& plan);
/// Arrays that the stages pass on to each other, with entries for each beam. `beams` is the number of beams of all
/// views together.
std::vector<ArrayContent> beamArrays(const SensorPlan& plan, uint64_t beams);
/// Arrays sized by `count` projected triangles.
std::vector<ArrayContent> projectedArrays(const SensorPlan& plan, uint64_t count);
/// Returns a range of values as the content of an array.
template <typename Values>
ArrayContent arrayOf(gpu::Array array, const Values& values) {
  const auto bytes = std::as_bytes(std::span(values));
  return {array, bytes.size(), {bytes.begin(), bytes.end()}};
}

/// The entries of a scan's instances: one for each instance or, of several views, those that the views place.
struct InstanceEntries {
  uint32_t count = 0;
  std::span<const InstanceTable::InView> inViews = {};
};

/// Arrays that are written anew for each scan; each of several shots is a view.
std::vector<ArrayContent> shotArrays(const SensorPlan& plan, std::span<const Shot> shots, ShotMotions motions,
                                     const InstanceEntries& entries);

}  // namespace gnosphere
