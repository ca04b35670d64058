// SPDX-License-Identifier: Apache-2.0
// Arithmetic for the formulas of the effects, in the common subset of GLSL and C++ (and CUDA). Vulkan lets the results
// of division, roots, exponentials and the like differ between devices, but not those of additions and products,
// which all known devices round to the nearest float. Everything here uses only the latter, so the same input gives the
// same bytes everywhere. Values must be normal floats, because a device may flush denormals to zero.
#ifndef GNOSPHERE_EFFECTS_ARITHMETIC_H
#define GNOSPHERE_EFFECTS_ARITHMETIC_H

#include "../shared.h"

#ifdef __cplusplus
#include <bit>
#include <cmath>
#include <glm/vec4.hpp>
#ifdef __CUDACC__
#define GNO_INLINE __host__ __device__ inline
#else
#define GNO_INLINE inline
#endif
#define GNO_PRECISE
#define GNO_INOUT(type) type&
#define GNO_OUT(type) type&
namespace gnosphere::gpu {
using glm::uvec4;
using std::abs;
using std::floor;
template <typename T>
GNO_INLINE T min(T a, T b) {
  return b < a ? b : a;
}
template <typename T>
GNO_INLINE T max(T a, T b) {
  return a < b ? b : a;
}
GNO_INLINE uint floatBitsToUint(float value) {
  return std::bit_cast<uint>(value);
}
GNO_INLINE float uintBitsToFloat(uint bits) {
  return std::bit_cast<float>(bits);
}
GNO_INLINE uint productHigh(uint a, uint b) {
  return uint(uint64_t{a} * b >> 32);
}
#else
#define GNO_INLINE
#define GNO_PRECISE precise  // no fused multiply-add
#define GNO_INOUT(type) inout type
#define GNO_OUT(type) out type
uint productHigh(uint a, uint b) {
  uint high, low;
  umulExtended(a, b, high, low);
  return high;
}
#endif

GNO_INLINE float notANumber() {
  return uintBitsToFloat(0x7fc00000u);
}

// a / b for 1e-37 < |b| < 1e37, relative error at most 3e-7. Newton's iteration on 1 / b; its first guess subtracts
// the bits of b from a constant.
GNO_INLINE float quotient(float a, float b) {
  GNO_PRECISE float magnitude = abs(b);
  GNO_PRECISE float inverse = uintBitsToFloat(0x7ef311c7u - floatBitsToUint(magnitude));
  inverse = inverse * (2.0f - magnitude * inverse);
  inverse = inverse * (2.0f - magnitude * inverse);
  inverse = inverse * (2.0f - magnitude * inverse);
  GNO_PRECISE float result = a * inverse;
  return b < 0.0f ? -result : result;
}

// 1 / sqrt(x) for 1e-37 < x < 1e37, relative error at most 5e-7. Newton's iteration, from the guess of Lomont, "Fast
// inverse square root" (2003).
GNO_INLINE float inverseRoot(float x) {
  GNO_PRECISE float inverse = uintBitsToFloat(0x5f375a86u - (floatBitsToUint(x) >> 1));
  GNO_PRECISE float half_ = 0.5f * x;
  inverse = inverse * (1.5f - half_ * inverse * inverse);
  inverse = inverse * (1.5f - half_ * inverse * inverse);
  inverse = inverse * (1.5f - half_ * inverse * inverse);
  return inverse;
}

// Relative error at most 3e-7 for x up to 1e37; 0 for x below 1e-37. One more iteration, on the root itself.
GNO_INLINE float squareRoot(float x) {
  if (!(x > 1e-37f)) return 0.0f;
  GNO_PRECISE float inverse = inverseRoot(x);
  GNO_PRECISE float root = x * inverse;
  root = root + 0.5f * inverse * (x - root * root);
  return root;
}

// A whole number of at most 2^22 in magnitude plus this has the number in its low bits. Devices that convert numbers
// one lane after the other do this faster.
GNO_CONST float kWholeInLowBits = 12582912.0f;  // 1.5 * 2^23

// e^x, relative error at most 3e-7; 0 below -87, and never more than e^88. Taylor's series within half a power of two.
GNO_INLINE float exponential(float x) {
  if (x < -87.0f) return 0.0f;
  GNO_PRECISE float bounded = min(x, 88.0f);
  GNO_PRECISE float power = floor(bounded * 1.44269504f + 0.5f);
  GNO_PRECISE float r = bounded - power * 0.693359375f;  // ln 2 in two parts (Cody and Waite 1980)
  r = r + power * 2.12194440e-4f;
  GNO_PRECISE float sum = 1.9841270e-4f;
  sum = sum * r + 1.3888889e-3f;
  sum = sum * r + 8.3333333e-3f;
  sum = sum * r + 4.1666667e-2f;
  sum = sum * r + 0.16666667f;
  sum = sum * r + 0.5f;
  sum = sum * r + 1.0f;
  sum = sum * r + 1.0f;
  GNO_PRECISE float whole = power + kWholeInLowBits;
  GNO_PRECISE float result = sum * uintBitsToFloat((floatBitsToUint(whole) + 127u) << 23);
  return result;
}

// ln x for normal x > 0, error at most 3e-7 of the result or 1e-7. 2 artanh((m - 1) / (m + 1)) as a series.
GNO_INLINE float naturalLog(float x) {
  uint bits = floatBitsToUint(x);
  uint steps = (bits - 0x3f3504f3u) >> 23;  // sqrt(1/2): the mantissa becomes 0.707..1.414
  steps = bits < 0x3f3504f3u ? steps | 0xfffffe00u : steps;
  GNO_PRECISE float mantissa = uintBitsToFloat(bits - (steps << 23));
  GNO_PRECISE float power = float(int(steps));
  GNO_PRECISE float s = quotient(mantissa - 1.0f, mantissa + 1.0f);
  GNO_PRECISE float square = s * s;
  GNO_PRECISE float sum = 0.22222222f;
  sum = sum * square + 0.28571429f;
  sum = sum * square + 0.4f;
  sum = sum * square + 0.66666667f;
  sum = sum * square * s + 2.0f * s;
  GNO_PRECISE float result = power * 0.693359375f + (sum - power * 2.12194440e-4f);
  return result;
}

// Cosine (x) and sine (y) of `turns` full turns, error at most 2e-7 for |turns| < 64. Taylor's series within an eighth.
GNO_INLINE vec2 cosSinOfTurn(float turns) {
  GNO_PRECISE float quarter = floor(4.0f * turns + 0.5f);
  GNO_PRECISE float angle = (turns - 0.25f * quarter) * 6.28318531f;
  GNO_PRECISE float square = angle * angle;
  GNO_PRECISE float sine = 2.7557319e-6f;
  sine = sine * square - 1.9841270e-4f;
  sine = sine * square + 8.3333333e-3f;
  sine = sine * square - 0.16666667f;
  sine = sine * square * angle + angle;
  GNO_PRECISE float cosine = 2.4801587e-5f;
  cosine = cosine * square - 1.3888889e-3f;
  cosine = cosine * square + 4.1666667e-2f;
  cosine = cosine * square - 0.5f;
  cosine = cosine * square + 1.0f;
  GNO_PRECISE float whole = quarter + kWholeInLowBits;
  uint quadrant = floatBitsToUint(whole) & 3u;
  bool swapped = (quadrant & 1u) != 0u;
  vec2 result;
  result.x = swapped ? sine : cosine;
  result.y = swapped ? cosine : sine;
  if (quadrant == 1u || quadrant == 2u) result.x = -result.x;
  if (quadrant >= 2u) result.y = -result.y;
  return result;
}

#ifdef __cplusplus
}  // namespace gnosphere::gpu
#endif
#endif
