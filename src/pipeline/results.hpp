// SPDX-License-Identifier: Apache-2.0
// Copies the results of a scan from device arrays to a Scan.
#pragma once

#include <array>
#include <span>

#include "base/workers.hpp"
#include "common/arrays.h"
#include "effects/sensor_plan.hpp"
#include "effects/shot_motion.hpp"
#include "geometry/instance_table.hpp"
#include "pipeline/resolve_words.hpp"
#include "scan/places.hpp"

namespace gnosphere {

/// The outputs of one scan in host-readable memory, with an entry per return of every beam; null if not planned.
struct DeviceResults {
  std::span<const BeamTables* const> tables;  ///< of each view
  const Word* words = nullptr;                ///< see resolveWords(); if given, there are no points and no owners
  const Word* laterWords = nullptr;
  const gpu::vec4* points = nullptr;
  const std::array<uint32_t, 2>* owners = nullptr;
  const float* intensities = nullptr;
  const gpu::SignalRecord* signals = nullptr;
  const gpu::SurfaceRecord* surfaces = nullptr;
  const gpu::vec4* motions = nullptr;
  const gpu::vec2* barycentrics = nullptr;
  gpu::Counters counters = {};
  std::span<const InstanceTable::InView> inViews = {};  ///< with several views, `owners` have these entries

  /// Collects the outputs; `of(array)` returns the address of an output or null.
  template <typename Of>
  static DeviceResults from(std::span<const BeamTables* const> tables, const gpu::Counters& counters, const Of& of) {
    return {tables,
            static_cast<const Word*>(of(gpu::Array::words)),
            static_cast<const Word*>(of(gpu::Array::laterWords)),
            static_cast<const gpu::vec4*>(of(gpu::Array::points)),
            static_cast<const std::array<uint32_t, 2>*>(of(gpu::Array::owners)),
            static_cast<const float*>(of(gpu::Array::intensities)),
            static_cast<const gpu::SignalRecord*>(of(gpu::Array::signals)),
            static_cast<const gpu::SurfaceRecord*>(of(gpu::Array::surfaces)),
            static_cast<const gpu::vec4*>(of(gpu::Array::motions)),
            static_cast<const gpu::vec2*>(of(gpu::Array::barycentrics)),
            counters};
  }
};

/// Sets the parts of a `scan` of a world that do not come from the device, and resizes its arrays for the others;
/// memory is reused.
void clearResult(const SensorPlan& plan, const InstanceTable& instances, uint32_t world, Scan& scan);

/// Counts the triangles that a view of a world is computed from.
void countPlaced(const InstanceTable& instances, uint32_t world, Counters& counters);

/// Takes the share of a view out of the counters that several views have in common: in proportion to the triangles of
/// its world, of which all views whose shares have not been taken yet have `all` together.
gpu::Counters takeShare(gpu::Counters& counters, uint64_t triangles, uint64_t all);

/// Fills the arrays of `scan` from the outputs of a view and adds to its counters. If the view has a part of the beams,
/// only their entries are written. `motion` is null for a scan without motion.
void readResults(Workers& workers, const SensorPlan& plan, const DeviceResults& device, const InstanceTable& instances,
                 const Shot& shot, const ShotMotion* motion, Scan& scan);

/// Resolves the words of shots that were submitted together, each as one view, to places in which the entries of one
/// scan follow those of the other, and adds their counters and the time to `sum`. The sensor leaves its hits alone.
/// `motions` has the motion of each shot; it is empty for scans without motion.
void readHits(Workers& workers, const SensorPlan& plan, const DeviceResults& device, const InstanceTable& instances,
              std::span<const Shot> shots, ShotMotions motions, const Places& to, Scan& sum);

}  // namespace gnosphere
