// SPDX-License-Identifier: Apache-2.0
// What a device leaves of a scan -> Scan.
#pragma once

#include <array>

#include "effects/sensor_plan.hpp"
#include "geometry/instance_table.hpp"
#include "pipeline/resolve_words.hpp"

namespace gnosphere {

/// Of one part of a sensor, where the host reads it: the outputs, per return of every beam; null: not planned.
struct DeviceResults {
  const BeamTables& tables;
  bool exact = false;           ///< directions lie on the lattice
  const Word* words = nullptr;  ///< then these alone, for resolveWords()
  const gpu::vec4* points = nullptr;
  const std::array<uint32_t, 2>* owners = nullptr;
  const gpu::vec4* signals = nullptr;
  const gpu::vec4* surfaces = nullptr;
  const gpu::vec4* motions = nullptr;
  const gpu::vec2* barycentrics = nullptr;
  gpu::Counters counters = {};

  /// `of(binding)` is the output, or null.
  template <typename Of>
  static DeviceResults from(const BeamTables& tables, bool exact, const gpu::Counters& counters, const Of& of) {
    return {tables,
            exact,
            static_cast<const Word*>(of(gpu::kBindWords)),
            static_cast<const gpu::vec4*>(of(gpu::kBindPoints)),
            static_cast<const std::array<uint32_t, 2>*>(of(gpu::kBindOwners)),
            static_cast<const gpu::vec4*>(of(gpu::kBindSignals)),
            static_cast<const gpu::vec4*>(of(gpu::kBindSurfaces)),
            static_cast<const gpu::vec4*>(of(gpu::kBindMotions)),
            static_cast<const gpu::vec2*>(of(gpu::kBindBarycentrics)),
            counters};
  }
};

/// What does not come from the device, and room for what does, of all parts of a sensor. Arrays keep theirs.
void clearResult(const SensorPlan& plan, size_t parts, const InstanceTable& instances, Scan& scan);

/// Arrays and counters of one part of a shot's sensor, whose beams begin at `firstBeam`.
void readResults(const SensorPlan& plan, const DeviceResults& device, const InstanceTable& instances, const Shot& shot,
                 uint64_t firstBeam, Scan& scan);

}  // namespace gnosphere
