// SPDX-License-Identifier: Apache-2.0
// Random numbers of one scan. The generator and its counters are defined to be the device's; distributions are computed
// here, in double.
#pragma once

#include <array>
#include <numbers>

#include "common/effects/random.h"
#include "effects/sensor_plan.hpp"
#include "reference/bounded.hpp"

namespace gnosphere::reference {

class Draws {
 public:
  Draws(const SensorPlan& plan, const Shot& shot) {
    key_.seedLow = static_cast<uint32_t>(plan.effects.seed);
    key_.seedHigh = static_cast<uint32_t>(plan.effects.seed >> 32);
    key_.sensor = static_cast<uint32_t>(shot.sensor);
    key_.frame = keyOfFrame(shot.frame);
  }

  /// `effect` is a bit of effects/bits.h; `number` counts the random numbers that the effect draws for one beam.
  std::array<uint32_t, 4> words(size_t beam, uint32_t number, uint32_t effect) const {
    const gpu::uvec4 words = gpu::draw(key_, static_cast<uint32_t>(beam), number, effect);
    return {words.x, words.y, words.z, words.w};
  }
  /// 0 <= u < 1.
  double uniform(size_t beam, uint32_t number, uint32_t effect) const {
    return (words(beam, number, effect)[0] >> 8) * 0x1p-24;
  }
  /// Two independent standard normal variables: Box and Muller (1958).
  std::array<Bounded, 2> normals(size_t beam, uint32_t number, uint32_t effect) const {
    const std::array<uint32_t, 4> words = this->words(beam, number, effect);
    const Bounded radius = sqrt(Bounded(-2) * log(aboveZero(words[0])));
    const double angle = 2 * std::numbers::pi * (words[1] >> 8) * 0x1p-24;
    constexpr double kCircleError = 2e-7;  // error of the device's cosines and sines
    return {radius * Bounded(std::cos(angle), kCircleError), radius * Bounded(std::sin(angle), kCircleError)};
  }
  /// 0 < u <= 1, so that its logarithm is finite.
  static double aboveZero(uint32_t word) { return ((word >> 8) + 1) * 0x1p-24; }

 private:
  gpu::EffectParameters key_ = {};  // only its fields that seed the generator are used
};

}  // namespace gnosphere::reference
