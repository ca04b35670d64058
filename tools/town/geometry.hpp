// SPDX-License-Identifier: Apache-2.0
// Placements and random numbers that have the same bits on every machine: they use only + - * / sqrt and integers.
#pragma once

#include <cstdint>

#include "base/vector.hpp"

namespace gnosphere::town {

Vec3 normalized(const Vec3& a);

/// Sine and cosine of an angle in turns (1 = 360 degrees); exact at quarter turns.
double sine(double turns);
double cosine(double turns);

/// Scales, then rotates about z, then translates.
Transform place(const Vec3& position, double turns = 0, double scale = 1);

/// As place(), with the direction of the x axis (a level unit vector) instead of an angle.
Transform placeAlong(const Vec3& position, const Vec3& x, double scale = 1);

/// As placeAlong() on inclined ground: x is any unit vector, and z as upright on it as `up` allows.
Transform placeOn(const Vec3& position, const Vec3& x, const Vec3& up);

/// A stream of random numbers. Streams with different keys are independent.
class Dice {
 public:
  explicit Dice(uint64_t seed, uint64_t a = 0, uint64_t b = 0, uint64_t c = 0);
  uint64_t next();
  double uniform() { return static_cast<double>(next() >> 11) * 0x1p-53; }  ///< [0, 1)
  double between(double low, double high) { return low + (high - low) * uniform(); }
  int below(int count) { return static_cast<int>((next() >> 33) * static_cast<uint64_t>(count) >> 31); }
  bool chance(int percent) { return below(100) < percent; }
  Vec3 direction();  ///< a unit vector, uniform over all directions

 private:
  uint64_t state_;
};

}  // namespace gnosphere::town
