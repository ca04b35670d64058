// SPDX-License-Identifier: Apache-2.0
// All that a request means for one sensor in one scene: computed once, never changed, read by every backend.
#pragma once

#include <array>
#include <memory>

#include "effects/bits.h"
#include "effects/formula_inputs.hpp"
#include "gnosphere/plan.hpp"
#include "gnosphere/simulator.hpp"

namespace gnosphere {

/// What devices read of a scene's materials.
struct MaterialArrays {
  std::vector<gpu::Optics4> optics;             ///< per material
  std::vector<std::array<uint32_t, 4>> images;  ///< width, height, first texel, wrapping of u | of v << 8
  std::vector<uint8_t> texels;                  ///< alpha of all images, padded to four bytes; empty without cut-outs
};

struct SensorPlan {
  Sensor sensor;
  Effects effects;  ///< the request
  std::vector<Plan::Decision> decisions;
  uint32_t bits = 0;              ///< of effects/bits.h: effects that are in, and kStrays
  uint32_t fields = 0;            ///< gpu::kField...
  uint32_t returns = 1;           ///< per beam
  bool origins = false;           ///< some lasers are away from the origin of their head
  bool looksAtMaterials = false;  ///< the intensity depends on the surface that is met

  // For the device's formulas; the reference has its own.
  gpu::EffectParameters parameters = {};  ///< of frame 0
  std::vector<SubRay> subRays;            ///< of every footprint; one where divergence is out
  std::vector<uint32_t> deadBeams;        ///< one bit per beam; empty where none is dead
  float footprintRadius = 0;              ///< radians that light spreads or strays from a beam's axis, at most
  std::shared_ptr<const MaterialArrays> materials;  ///< of the scene, shared by its sensors; null for the reference

  bool has(uint32_t anyOf) const { return (bits & anyOf) != 0; }
  bool asks(uint32_t anyOf) const { return (fields & anyOf) != 0; }
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
};

/// One plan per sensor. Throws Error(invalidArgument) as decide() and leaveOutUnsupported() do.
std::vector<SensorPlan> planSensors(const Scene& scene, const std::vector<Sensor>& sensors,
                                    const SimulatorOptions& options);

/// Every array that the plan asks for gets its size, the others none; `cleared`: and what says that nothing was met.
/// Ties and tolerances are the reference's own.
void resizeArrays(const SensorPlan& plan, Scan& scan, bool cleared = false);

/// Whether any of the plans has something: anyOf(plans, &SensorPlan::holes).
bool anyOf(const std::vector<SensorPlan>& plans, bool (SensorPlan::*has)() const);

}  // namespace gnosphere
