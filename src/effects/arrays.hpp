// SPDX-License-Identifier: Apache-2.0
// The arrays that stage effects reads and writes, on whatever device: who makes the device's memory asks here.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "effects/formula_inputs.hpp"
#include "effects/setup.hpp"
#include "effects/shot_motion.hpp"

namespace gnosphere {

/// One of gpu::kBind..., with what it holds, or room for what the stages write.
struct EffectsArray {
  uint32_t binding;
  const char* name;
  uint64_t bytes;
  std::vector<std::byte> content;  ///< of so many bytes, or empty
};

/// What is read back beside the counters, with its size per beam.
struct Output {
  uint32_t binding;
  uint32_t bytesPerBeam;
};

/// Everything that is read back: points and owners first, or, see leavesWords(), `words` alone.
std::vector<Output> outputsOf(const PlannedEffects& planned, bool words = false);
/// The most that one array holds of a beam.
uint64_t bytesPerBeam(const PlannedEffects& planned);

/// Of one sensor, or of a part of it.
class EffectsArrays {
 public:
  /// Of a part of the sensor with these rows, whose beams begin at `firstBeam`.
  EffectsArrays(const EffectsSetup& setup, std::span<const gpu::Row> rows, const Sensor& part, uint64_t firstBeam);

  const EffectsSetup& setup() const { return setup_; }
  /// Radians: how far a beam spreads or strays from its axis, at most.
  float footprint() const;
  /// Those that stay, outputs apart.
  std::vector<EffectsArray> lasting() const;
  /// What is read back, beside points and owners.
  std::vector<EffectsArray> outputs() const;
  /// Of so many projected triangles.
  std::vector<EffectsArray> projected(uint64_t count) const;
  /// Those that each scan has anew; `motion` where it is in motion.
  std::vector<EffectsArray> ofShot(const Shot& shot, const ShotMotion* motion) const;

 private:
  EffectsSetup setup_;
  gpu::EffectParameters parameters_;
  std::vector<SubRay> subRays_;
  std::vector<gpu::vec4> rowOrigins_;
  uint64_t beams_;
};

}  // namespace gnosphere
