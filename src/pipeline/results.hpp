// SPDX-License-Identifier: Apache-2.0
// What a device leaves of a scan -> Scan.
#pragma once

#include <array>

#include "arrays.h"
#include "effects/sensor_plan.hpp"
#include "geometry/instance_table.hpp"
#include "pipeline/resolve_words.hpp"

namespace gnosphere {

/// Of one scan, where the host reads it: the outputs, per return of every beam; null: not plan.
struct DeviceResults {
  const BeamTables& tables;
  bool exact = false;           ///< directions lie on the lattice
  const Word* words = nullptr;  ///< then these alone, for resolveWords()
  const gpu::vec4* points = nullptr;
  const std::array<uint32_t, 2>* owners = nullptr;
  const gpu::SignalRecord* signals = nullptr;
  const gpu::SurfaceRecord* surfaces = nullptr;
  const gpu::vec4* motions = nullptr;
  const gpu::vec2* barycentrics = nullptr;
  gpu::Counters counters = {};

  /// `of(array)` is the output, or null.
  template <typename Of>
  static DeviceResults from(const BeamTables& tables, bool exact, const gpu::Counters& counters, const Of& of) {
    return {tables,
            exact,
            static_cast<const Word*>(of(gpu::Array::words)),
            static_cast<const gpu::vec4*>(of(gpu::Array::points)),
            static_cast<const std::array<uint32_t, 2>*>(of(gpu::Array::owners)),
            static_cast<const gpu::SignalRecord*>(of(gpu::Array::signals)),
            static_cast<const gpu::SurfaceRecord*>(of(gpu::Array::surfaces)),
            static_cast<const gpu::vec4*>(of(gpu::Array::motions)),
            static_cast<const gpu::vec2*>(of(gpu::Array::barycentrics)),
            counters};
  }
};

/// What does not come from the device, and room for what does. Arrays keep theirs.
void clearResult(const SensorPlan& plan, const InstanceTable& instances, Scan& scan);

/// Arrays and counters of a shot.
void readResults(const SensorPlan& plan, const DeviceResults& device, const InstanceTable& instances, const Shot& shot,
                 Scan& scan);

}  // namespace gnosphere
