// SPDX-License-Identifier: Apache-2.0
// Random numbers of one scan. The generator and its counters are the device's by definition; what is made of its words
// is computed here, in double.
#pragma once

#include <array>
#include <numbers>

#include "effects/random.h"
#include "effects/sensor_plan.hpp"
#include "reference/bounded.hpp"

namespace gnosphere::reference {

class Draws {
 public:
  Draws(const SensorPlan& plan, const Shot& shot) {
    key_.seedLow = static_cast<uint32_t>(plan.effects.seed);
    key_.seedHigh = static_cast<uint32_t>(plan.effects.seed >> 32);
    key_.sensor = static_cast<uint32_t>(shot.sensor);
    key_.frame = static_cast<uint32_t>(shot.frame);
  }

  /// `effect` is a bit of effects/bits.h; `number` counts the draws of an effect for one beam.
  std::array<uint32_t, 4> words(size_t beam, uint32_t number, uint32_t effect) const {
    const gpu::uvec4 words = gpu::draw(key_, static_cast<uint32_t>(beam), number, effect);
    return {words.x, words.y, words.z, words.w};
  }
  /// 0 <= u < 1.
  double uniform(size_t beam, uint32_t number, uint32_t effect) const {
    return (words(beam, number, effect)[0] >> 8) * 0x1p-24;
  }
  /// Two independent normal variables, mean 0 and variance 1: Box and Muller (1958).
  std::array<Bounded, 2> normals(size_t beam, uint32_t number, uint32_t effect) const {
    const std::array<uint32_t, 4> words = this->words(beam, number, effect);
    const Bounded radius = sqrt(Bounded(-2) * log(aboveZero(words[0])));
    const double angle = 2 * std::numbers::pi * (words[1] >> 8) * 0x1p-24;
    constexpr double kCircleError = 2e-7;  // of the device's cosines and sines
    return {radius * Bounded(std::cos(angle), kCircleError), radius * Bounded(std::sin(angle), kCircleError)};
  }
  /// 0 < u <= 1, of which a logarithm can be taken.
  static double aboveZero(uint32_t word) { return ((word >> 8) + 1) * 0x1p-24; }

 private:
  gpu::EffectParameters key_ = {};  // only what the generator is keyed by
};

}  // namespace gnosphere::reference
