// SPDX-License-Identifier: Apache-2.0
#include "town/geometry.hpp"

#include <cmath>

namespace gnosphere::town {
namespace {

// sin(turns * 360 degrees) for 0 <= turns <= 1/4 by its power series, with an error below 1e-12.
double firstQuarter(double turns) {
  const double x = turns * 6.283185307179586;
  const double s = x * x;
  double term = x;
  double sum = x;
  for (int k = 1; k <= 9; ++k) {
    term = -term * s / ((2.0 * k) * (2.0 * k + 1.0));
    sum += term;
  }
  return sum;
}

uint64_t mix(uint64_t z) {  // splitmix64 (Steele, Lea, Flood 2014)
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

}  // namespace

Vec3 normalized(const Vec3& a) {
  return 1 / lengthOf(a) * a;
}

double sine(double turns) {
  turns -= std::floor(turns);
  const int quarter = static_cast<int>(turns * 4) & 3;
  const double rest = turns - 0.25 * quarter;
  if (rest == 0) return quarter == 1 ? 1 : quarter == 3 ? -1 : 0;
  const double value = quarter % 2 == 0 ? firstQuarter(rest) : firstQuarter(0.25 - rest);
  return quarter < 2 ? value : -value;
}

double cosine(double turns) {
  return sine(turns + 0.25);
}

Transform place(const Vec3& position, double turns, double scale) {
  return placeAlong(position, {cosine(turns), sine(turns), 0}, scale);
}

Transform placeAlong(const Vec3& position, const Vec3& x, double scale) {
  const double c = scale * x.x;
  const double s = scale * x.y;
  return {{c, -s, 0, position.x, s, c, 0, position.y, 0, 0, scale, position.z}};
}

Transform placeOn(const Vec3& position, const Vec3& x, const Vec3& up) {
  const Vec3 y = normalized(cross(up, x)), z = cross(x, y);
  return {{x.x, y.x, z.x, position.x, x.y, y.y, z.y, position.y, x.z, y.z, z.z, position.z}};
}

Dice::Dice(uint64_t seed, uint64_t a, uint64_t b, uint64_t c) {
  constexpr uint64_t kStep = 0x9e3779b97f4a7c15u;
  state_ = mix(mix(mix(mix(seed + kStep) ^ (a + kStep)) ^ (b + 2 * kStep)) ^ (c + 3 * kStep));
}

uint64_t Dice::next() {
  return mix(state_ += 0x9e3779b97f4a7c15u);
}

Vec3 Dice::direction() {
  for (;;) {
    const Vec3 p = {between(-1, 1), between(-1, 1), between(-1, 1)};
    const double square = dot(p, p);
    if (square > 0.01 && square <= 1) return 1 / std::sqrt(square) * p;
  }
}

}  // namespace gnosphere::town
