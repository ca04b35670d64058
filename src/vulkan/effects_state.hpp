// SPDX-License-Identifier: Apache-2.0
// What the planned effects of one sensor, or of a part of it, have on the device.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "effects/device_parameters.hpp"
#include "effects/motion_tables.hpp"
#include "effects/planned.hpp"
#include "shared.h"
#include "vulkan/buffer.hpp"

namespace gnosphere::vulkan {

/// What is read back beside the counters, with its size per beam.
struct Output {
  uint32_t binding;
  uint32_t bytesPerBeam;
};

/// What effects need to know of the simulator.
struct EffectsSetup {
  PlannedEffects planned;
  Effects effects;
  std::vector<gpu::Optics4> optics;     ///< per material
  std::vector<AlphaImage> alphaImages;  ///< only where holes are planned
  Sensor sensor;                        ///< the whole of it
  uint32_t sensorIndex = 0;
};

/// What the device has of each material.
std::vector<gpu::Optics4> packedOptics(const Scene& scene, const SimulatorOptions& options);

/// Everything that is read back: points and owners first.
std::vector<Output> outputsOf(const PlannedEffects& planned);
/// The most that one buffer holds of a beam.
uint64_t bytesPerBeam(const PlannedEffects& planned);

/// What a frame in flight has of its own, written by the host.
struct EffectsFrame {
  Buffer parameters, volumes, instanceMotions, columnMotions, motionBounds;
};

/// A shot in motion.
struct ShotMotion {
  MotionTables tables;
  std::vector<gpu::InstanceMotion> instances;  ///< of all; empty: none moves
  double farthest = 0;                         ///< metres that any of their points goes
};

class EffectsState {
 public:
  using Bindings = std::array<const Buffer*, gpu::kWorkBindingCountEffects>;

  /// Of a part of the sensor, whose beams begin at `firstBeam`. `copied`: outputs are not read in place.
  EffectsState(const Device& device, const EffectsSetup& setup, std::span<const gpu::Row> rows, const Sensor& part,
               uint64_t firstBeam, bool copied);

  const PlannedEffects& planned() const { return setup_.planned; }
  const EffectsSetup& setup() const { return setup_; }
  /// Radians: how far a beam spreads or strays from its axis, at most.
  float footprint() const;
  /// Room for so many projected triangles.
  void growProjected(uint64_t count);
  EffectsFrame makeFrame() const;
  /// What a scan needs beyond what every scan does; `motion` where it is in motion.
  void prepare(EffectsFrame& frame, const Shot& shot, const ShotMotion* motion) const;
  /// The buffers under their binding numbers.
  void bind(const EffectsFrame& frame, Bindings& bindings) const;
  const Buffer& buffer(uint32_t binding) const { return buffers_[binding]; }
  uint64_t bytes() const;
  void list(std::vector<Plan::Buffer>& to) const;

 private:
  void make(uint32_t binding, const char* name, uint64_t bytes);

  const Device& device_;
  EffectsSetup setup_;
  gpu::EffectParameters parameters_;
  std::vector<SubRay> subRays_;
  std::array<Buffer, gpu::kWorkBindingCountEffects> buffers_;  // empty where nothing is planned for it
  std::array<const char*, gpu::kWorkBindingCountEffects> names_ = {};
};

}  // namespace gnosphere::vulkan
