// SPDX-License-Identifier: Apache-2.0
// What the stages must do beside geometry for one sensor: decisions as the stages need them.
#pragma once

#include "effects/bits.h"
#include "effects/decide.hpp"
#include "gnosphere/simulator.hpp"

namespace gnosphere {

struct PlannedEffects {
  std::vector<Plan::Decision> decisions;
  uint32_t bits = 0;     ///< of effects/plan.h, kStrays among them
  uint32_t fields = 0;   ///< gpu::kField...
  uint32_t returns = 1;  ///< per beam
  uint32_t subRays = 1;  ///< of each footprint

  bool has(uint32_t effects) const { return (bits & effects) != 0; }
  bool asks(uint32_t which) const { return (fields & which) != 0; }
  /// Sub-rays, beams astray or more than one surface per beam.
  bool footprint() const { return has(gpu::kFootprintEffects); }
  /// Beams may leave from where the sensor is when they fire, or meet what is not where it was.
  bool motion() const { return has(gpu::kSensorMotion | gpu::kObjectMotion) || origins || speeds(); }
  /// The surface of each hit is looked at.
  bool surfaces() const { return looksAtMaterials || asks(gpu::kSurfaceFields); }
  bool holes() const { return has(gpu::kCutOuts); }
  bool looksAtSurfaces() const { return surfaces() || footprint(); }
  /// Returns are judged one by one.
  bool signals() const { return has(gpu::kSignalEffects) || asks(gpu::kFieldSignal); }
  bool speeds() const { return has(gpu::kRadialSpeed) || asks(gpu::kFieldMotion); }
  /// Surfaces that a sub-ray meets, at most.
  uint32_t layers() const { return has(gpu::kTransmission) ? gpu::kMaxLayers : 1; }
  /// Nothing but geometry.
  bool bare() const { return !footprint() && !motion() && !surfaces() && !signals() && !speeds(); }
  bool sameStages(const PlannedEffects& other) const {
    return bits == other.bits && fields == other.fields && returns == other.returns && subRays == other.subRays &&
           looksAtMaterials == other.looksAtMaterials && motion() == other.motion();
  }

  bool origins = false;           ///< lasers leave the head from elsewhere than its origin
  bool looksAtMaterials = false;  ///< intensity depends on what was met
};

/// Throws Error(invalidArgument) as decide() does.
PlannedEffects planEffects(const SimulatorOptions& options, const Sensor& sensor, const Scene& scene);

}  // namespace gnosphere
