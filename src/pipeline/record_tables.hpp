// SPDX-License-Identifier: Apache-2.0
// Tables for the results that stay on the device: the layout, and values of the beams that no kernel computes.
#pragma once

#include <vector>

#include "effects/sensor_plan.hpp"
#include "pipeline/beam_tables.hpp"

namespace gnosphere {

struct RecordTables {
  /// Bits of the values, kWholeWords if every value is a whole word and occurs once, and kFromWords.
  uint32_t held = 0;
  std::vector<gpu::RecordStream> streams;
  std::vector<gpu::RecordValue> values;
  std::vector<gpu::RecordPlace> places, gaps;  ///< if every value is a whole word
};
/// Returns the layout as the kernel reads it.
RecordTables recordTables(const RecordLayout& layout);

/// Returns the index of each beam by its number; kNone for a beam that never fires.
std::vector<uint32_t> beamPlaces(const SensorPlan& plan, const BeamTables& tables);

/// Returns the bits of time, azimuth and elevation, and the ring, of every beam of a pattern; empty if the layout has
/// none of them.
std::vector<gpu::uvec4> beamFacts(const SensorPlan& plan, size_t pattern);

/// Returns the directions of the beams of a pattern; empty if the kernel finds them from the points.
std::vector<gpu::vec4> beamDirections(const SensorPlan& plan, size_t pattern);

/// Throws Error(invalidArgument) if the layout has a value that a scan of this sensor has only on the host.
void checkLayout(const SensorPlan& plan);

}  // namespace gnosphere
