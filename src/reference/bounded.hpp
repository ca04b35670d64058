// SPDX-License-Identifier: Apache-2.0
// Numbers in double with a bound on their error in single precision: running error analysis (Higham, Accuracy and
// Stability of Numerical Algorithms, 2002, 3.3). Results of arithmetic carry a bound, too, and a comparison reports if
// the bounds do not decide it.
#pragma once

#include <algorithm>
#include <cmath>

#include "reference/doubt.hpp"

namespace gnosphere::reference {

/// Relative error that the device's quotients, roots, exponentials and logarithms may have: its arithmetic promises
/// 3e-7.
inline constexpr double kFunctionError = 3e-7;

struct Bounded {
  double value = 0;
  double error = 0;

  Bounded() = default;
  /// For values that are exact in single precision: whole numbers, random multiples of 2^-24.
  Bounded(double exact) : value(exact) {}  // NOLINT: implicit on purpose
  Bounded(double of, double bound) : value(of), error(bound) {}

  double low() const { return value - error; }
  double high() const { return value + error; }
};

/// A number of the request, which single precision rounds.
inline Bounded given(double value) {
  return {value, kUnitRoundoff * std::abs(value)};
}
inline Bounded rounded(double value, double error, double relative = kUnitRoundoff) {
  return {value, error + relative * std::abs(value)};
}
/// Applies an increasing function to a bounded value.
template <typename Function>
Bounded increasing(const Function& f, const Bounded& x) {
  const double value = f(x.value);
  return {value, std::max(std::abs(f(x.high()) - value), std::abs(value - f(x.low())))};
}

inline Bounded operator-(const Bounded& a) {
  return {-a.value, a.error};
}
inline Bounded operator+(const Bounded& a, const Bounded& b) {
  return rounded(a.value + b.value, a.error + b.error);
}
inline Bounded operator-(const Bounded& a, const Bounded& b) {
  return rounded(a.value - b.value, a.error + b.error);
}
inline Bounded operator*(const Bounded& a, const Bounded& b) {
  return rounded(a.value * b.value, std::abs(a.value) * b.error + std::abs(b.value) * a.error + a.error * b.error);
}
/// The divisor must be far from 0.
inline Bounded operator/(const Bounded& a, const Bounded& b) {
  const double result = a.value / b.value, least = std::max(std::abs(b.value) - b.error, 1e-300);
  return rounded(result, (a.error + std::abs(result) * b.error) / least, kFunctionError);
}
inline Bounded exp(const Bounded& x) {
  const Bounded result = increasing([](double v) { return std::exp(v); }, x);
  return rounded(result.value, result.error, kFunctionError);
}
inline Bounded log(const Bounded& x) {
  const Bounded result = increasing([](double v) { return std::log(std::max(v, 1e-37)); }, x);
  return rounded(result.value, result.error + 1e-7, kFunctionError);
}
inline Bounded sqrt(const Bounded& x) {
  const Bounded result = increasing([](double v) { return std::sqrt(std::max(v, 0.0)); }, x);
  return rounded(result.value, result.error, kFunctionError);
}
inline Bounded min(const Bounded& a, const Bounded& b) {
  const double value = std::min(a.value, b.value);
  return {value, std::max(std::min(a.high(), b.high()) - value, value - std::min(a.low(), b.low()))};
}
inline Bounded max(const Bounded& a, const Bounded& b) {
  return -min(-a, -b);
}
/// The nearest whole number; its error covers the next one if the bound does not decide.
inline Bounded nearestWhole(const Bounded& x) {
  return increasing([](double v) { return std::floor(v + 0.5); },
                    {x.value, x.error + kUnitRoundoff * std::abs(x.value)});
}

/// Comparisons set `doubt` if single precision may decide otherwise.
inline bool less(const Bounded& a, const Bounded& b, bool& doubt) {
  const double error = a.error + b.error;
  doubt = doubt || (error > 0 && std::abs(a.value - b.value) <= error);
  return a.value < b.value;
}

}  // namespace gnosphere::reference
