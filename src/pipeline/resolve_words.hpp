// SPDX-License-Identifier: Apache-2.0
// Stage resolve on the host computes points, ranges and owners from the 8-byte words of the beams. The host must write
// every byte of the cloud anyway, so resolving on the device would only write it a second time.
#pragma once

#include "effects/sensor_plan.hpp"
#include "effects/shot_motion.hpp"
#include "geometry/instance_table.hpp"
#include "gnosphere/scan.hpp"
#include "pipeline/beam_tables.hpp"
#include "scan/places.hpp"

namespace gnosphere {

/// The nearest hit of a beam as the stage `bin` stores it, or its return as stage `effects` does: the bits of the range
/// and the number of the placed triangle. Both are kNone for no return, and the triangle for a return of the medium.
struct Word {
  uint32_t triangle, range;
};

/// The words of a scan, in order of the beams' indices.
struct Words {
  const Word* first;            ///< of the first return of each beam
  const Word* later = nullptr;  ///< of the second returns, then of the third ones; null if no beam has any
};

/// Writes the wanted ones of points, ranges and owners of rows first..end - 1 of a grid, or of beams first..end - 1 of
/// a list, with the same bytes as resolve.comp and effects.comp. `motion` is null for a scan without motion. Returns
/// the number of beams that have hit something.
uint64_t resolveWords(const SensorPlan& plan, const Words& words, const BeamTables& tables,
                      const InstanceTable& instances, const ShotMotion* motion, uint32_t first, uint32_t end,
                      const Places& to);

}  // namespace gnosphere
