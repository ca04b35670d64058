// SPDX-License-Identifier: Apache-2.0
// The beams of a sensor in sets of tables. A submission scans views with tables of one set.
#pragma once

#include <span>
#include <vector>

#include "effects/arrays.hpp"
#include "effects/sensor_plan.hpp"
#include "pipeline/beam_tables.hpp"
#include "pipeline/origin_groups.hpp"

namespace gnosphere {

/// Beams that are projected together, and the table that has them.
struct BeamGroup {
  OriginBounds lasers;
  uint32_t set, table;  ///< the number of the set of tables, and of the table in it
};

/// A view of a submission: a group of the beams of a shot.
struct View {
  size_t shot;
  const BeamGroup* group;
};

struct BeamSets {
  /// Sets of tables with the same rows, columns and number of beams. Groups of about as many beams, within a factor of
  /// two, are in one set, so that no table is much larger than its beams need.
  std::vector<std::vector<BeamTables>> sets;
  /// Each pattern has groups of beams, set by set. Only a list has several patterns, which its scans fire in turn.
  std::vector<std::vector<BeamGroup>> patterns;
};

BeamSets makeBeamSets(const SensorPlan& plan);

/// Returns a set of tables as arrays of a device, in which one table follows the other. Throws Error(outOfMemory) if an
/// array has more entries than kernels can address.
std::vector<ArrayContent> arraysOf(const SensorPlan& plan, std::span<const BeamTables> set);

/// Returns the table and the shot of each view; shots are counted from that of the first view on.
ArrayContent viewTables(std::span<const View> views);

/// Returns the farthest-range table of each view before anything is hit.
ArrayContent startFarthest(std::span<const BeamTables* const> views);

}  // namespace gnosphere
