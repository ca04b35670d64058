// SPDX-License-Identifier: Apache-2.0
// The types and functions of GLSL that the shaders use. With these and glsl.sed, shader text compiles as C++ and CUDA.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstdlib>

#ifdef __CUDACC__
#define GNO_DEVICE __device__ __forceinline__
#define GNO_DONT_UNROLL _Pragma("unroll 1")
#define GNO_UNROLL _Pragma("unroll")
#else
#define GNO_DEVICE inline
#define GNO_DONT_UNROLL
#define GNO_UNROLL
#endif

namespace gnosphere::cuda {

using uint = uint32_t;

// --- Vectors ---------------------------------------------------------------------------------------------------------

template <typename T>
struct alignas(2 * sizeof(T)) Vec2 {
  T x, y;
  using Scalar = T;
  Vec2() = default;
  GNO_DEVICE constexpr explicit Vec2(T s) : x(s), y(s) {}
  GNO_DEVICE constexpr Vec2(T a, T b) : x(a), y(b) {}
  template <typename U>
  GNO_DEVICE constexpr explicit Vec2(Vec2<U> v) : x(T(v.x)), y(T(v.y)) {}
  template <typename F>
  GNO_DEVICE static auto zip(F f, Vec2 a, auto... others) {
    return Vec2<decltype(f(a.x, others.x...))>(f(a.x, others.x...), f(a.y, others.y...));
  }
  GNO_DEVICE T sum() const { return x + y; }
  GNO_DEVICE T operator[](uint i) const { return i == 0 ? x : y; }
};

template <typename T>
struct Vec3 {
  T x, y, z;
  using Scalar = T;
  Vec3() = default;
  GNO_DEVICE constexpr explicit Vec3(T s) : x(s), y(s), z(s) {}
  GNO_DEVICE constexpr Vec3(T a, T b, T c) : x(a), y(b), z(c) {}
  GNO_DEVICE constexpr Vec3(Vec2<T> a, T b) : x(a.x), y(a.y), z(b) {}
  template <typename U>
  GNO_DEVICE constexpr explicit Vec3(Vec3<U> v) : x(T(v.x)), y(T(v.y)), z(T(v.z)) {}
  template <typename F>
  GNO_DEVICE static auto zip(F f, Vec3 a, auto... others) {
    return Vec3<decltype(f(a.x, others.x...))>(f(a.x, others.x...), f(a.y, others.y...), f(a.z, others.z...));
  }
  GNO_DEVICE T sum() const { return x + y + z; }
  GNO_DEVICE T operator[](uint i) const { return i == 0 ? x : i == 1 ? y : z; }
  GNO_DEVICE Vec2<T> xy() const { return {x, y}; }
  GNO_DEVICE Vec3 yzx() const { return {y, z, x}; }
  GNO_DEVICE Vec3 zxy() const { return {z, x, y}; }
};

template <typename T>
struct alignas(sizeof(T) < 4 ? 4 : 16) Vec4 {
  T x, y, z, w;
  using Scalar = T;
  Vec4() = default;
  GNO_DEVICE constexpr explicit Vec4(T s) : x(s), y(s), z(s), w(s) {}
  GNO_DEVICE constexpr Vec4(T a, T b, T c, T d) : x(a), y(b), z(c), w(d) {}
  GNO_DEVICE constexpr Vec4(Vec3<T> a, T b) : x(a.x), y(a.y), z(a.z), w(b) {}
  GNO_DEVICE constexpr Vec4(T a, Vec3<T> b) : x(a), y(b.x), z(b.y), w(b.z) {}
  GNO_DEVICE constexpr Vec4(Vec2<T> a, Vec2<T> b) : x(a.x), y(a.y), z(b.x), w(b.y) {}
  GNO_DEVICE constexpr Vec4(Vec2<T> a, T b, T c) : x(a.x), y(a.y), z(b), w(c) {}
  template <typename U>
  GNO_DEVICE constexpr explicit Vec4(Vec4<U> v) : x(T(v.x)), y(T(v.y)), z(T(v.z)), w(T(v.w)) {}
  template <typename F>
  GNO_DEVICE static auto zip(F f, Vec4 a, auto... others) {
    return Vec4<decltype(f(a.x, others.x...))>(f(a.x, others.x...), f(a.y, others.y...), f(a.z, others.z...),
                                               f(a.w, others.w...));
  }
  GNO_DEVICE T sum() const { return x + y + z + w; }
  GNO_DEVICE T operator[](uint i) const { return i == 0 ? x : i == 1 ? y : i == 2 ? z : w; }
  GNO_DEVICE Vec2<T> xy() const { return {x, y}; }
  GNO_DEVICE Vec2<T> zw() const { return {z, w}; }
  GNO_DEVICE Vec3<T> xyz() const { return {x, y, z}; }
};

using vec2 = Vec2<float>;
using vec3 = Vec3<float>;
using vec4 = Vec4<float>;
using dvec3 = Vec3<double>;
using ivec3 = Vec3<int>;
using uvec2 = Vec2<uint>;
using uvec3 = Vec3<uint>;
using bvec3 = Vec3<bool>;
using uvec4 = Vec4<uint>;

struct mat3 {
  vec3 columns[3];
  mat3() = default;
  GNO_DEVICE explicit mat3(float) : columns{vec3(0), vec3(0), vec3(0)} {}  // used with 0 only
  GNO_DEVICE mat3(vec3 a, vec3 b, vec3 c) : columns{a, b, c} {}
  GNO_DEVICE vec3 operator[](uint i) const { return columns[i]; }
};

GNO_DEVICE mat3 transpose(const mat3& m) {
  return {vec3(m[0].x, m[1].x, m[2].x), vec3(m[0].y, m[1].y, m[2].y), vec3(m[0].z, m[1].z, m[2].z)};
}

template <typename V>
concept Vector = requires {
  typename V::Scalar;
};

  // Operators and functions that work component by component.

#define GNO_BINARY(op_)                                          \
  template <Vector V>                                            \
  GNO_DEVICE V operator op_(V a, V b) {                          \
    return V::zip([](auto p, auto q) { return p op_ q; }, a, b); \
  }                                                              \
  template <Vector V>                                            \
  GNO_DEVICE V operator op_(V a, typename V::Scalar b) {         \
    return a op_ V(b);                                           \
  }                                                              \
  template <Vector V>                                            \
  GNO_DEVICE V operator op_(typename V::Scalar a, V b) {         \
    return V(a) op_ b;                                           \
  }                                                              \
  template <Vector V>                                            \
  GNO_DEVICE V& operator op_##=(V& a, V b) {                     \
    return a = a op_ b;                                          \
  }                                                              \
  template <Vector V>                                            \
  GNO_DEVICE V& operator op_##=(V& a, typename V::Scalar b) {    \
    return a = a op_ V(b);                                       \
  }
GNO_BINARY(+)
GNO_BINARY(-)
GNO_BINARY(*)
GNO_BINARY(/)
GNO_BINARY(&)
GNO_BINARY(|)
GNO_BINARY(<<)
GNO_BINARY(>>)
#undef GNO_BINARY

#define GNO_COMPARE(name_, op_)                                  \
  template <Vector V>                                            \
  GNO_DEVICE auto name_(V a, V b) {                              \
    return V::zip([](auto p, auto q) { return p op_ q; }, a, b); \
  }
GNO_COMPARE(lessThan, <)
GNO_COMPARE(lessThanEqual, <=)
GNO_COMPARE(greaterThan, >)
GNO_COMPARE(greaterThanEqual, >=)
GNO_COMPARE(equal, ==)
#undef GNO_COMPARE

template <Vector V>
GNO_DEVICE V operator-(V a) {
  return V::zip([](auto p) { return -p; }, a);
}
GNO_DEVICE bool all(Vec2<bool> v) {
  return v.x && v.y;
}
GNO_DEVICE bool all(Vec3<bool> v) {
  return v.x && v.y && v.z;
}
GNO_DEVICE bool any(Vec3<bool> v) {
  return v.x || v.y || v.z;
}
template <Vector V>
GNO_DEVICE bool operator==(V a, V b) {
  return all(equal(a, b));
}

// GLSL's min and max, with the same result for NaN.
template <typename T>
GNO_DEVICE T min(T a, T b) {
  if constexpr (Vector<T>)
    return T::zip([](auto p, auto q) { return q < p ? q : p; }, a, b);
  else
    return b < a ? b : a;
}
template <typename T>
GNO_DEVICE T max(T a, T b) {
  if constexpr (Vector<T>)
    return T::zip([](auto p, auto q) { return p < q ? q : p; }, a, b);
  else
    return a < b ? b : a;
}
GNO_DEVICE uint max(uint a, int b) {
  return max(a, uint(b));
}
GNO_DEVICE float clamp(float x, float low, float high) {
  return min(max(x, low), high);
}
GNO_DEVICE uint clamp(uint x, uint low, uint high) {
  return min(max(x, low), high);
}

template <typename T>
GNO_DEVICE T abs(T a) {
  if constexpr (Vector<T>)
    return T::zip([](auto p) { return abs(p); }, a);
  else
    return std::abs(a);
}
GNO_DEVICE vec3 mix(vec3 a, vec3 b, Vec3<bool> second) {
  return vec3::zip([](float p, float q, bool s) { return s ? q : p; }, a, b, second);
}

// --- Numbers ---------------------------------------------------------------------------------------------------------

GNO_DEVICE float floor(float x) {
  return ::floorf(x);
}
GNO_DEVICE float ceil(float x) {
  return ::ceilf(x);
}
GNO_DEVICE float sqrt(float x) {
  return ::sqrtf(x);
}
GNO_DEVICE float asin(float x) {
  return ::asinf(x);
}
GNO_DEVICE float atan(float y, float x) {
  return ::atan2f(y, x);
}
GNO_DEVICE float roundEven(float x) {
  return ::rintf(x);
}

template <Vector V>
GNO_DEVICE auto dot(V a, V b) {
  return (a * b).sum();
}
template <typename T>
GNO_DEVICE Vec3<T> cross(Vec3<T> a, Vec3<T> b) {
  return a.yzx() * b.zxy() - a.zxy() * b.yzx();
}
template <Vector V>
GNO_DEVICE float length(V v) {
  return sqrt(dot(v, v));
}
GNO_DEVICE vec3 normalize(vec3 v) {
  return v * (1.0f / length(v));
}

// --- Bits ------------------------------------------------------------------------------------------------------------

GNO_DEVICE uint floatBitsToUint(float x) {
  return __builtin_bit_cast(uint, x);
}
GNO_DEVICE int findMSB(uint x) {
  int bit = -1;
  for (; x > 0; x >>= 1) ++bit;
  return bit;
}
GNO_DEVICE uint bitCount(uint x) {
  uint count = 0;
  for (; x > 0; x &= x - 1) ++count;
  return count;
}
GNO_DEVICE uvec3 floatBitsToUint(vec3 v) {
  return vec3::zip([](float p) { return floatBitsToUint(p); }, v);
}
GNO_DEVICE float uintBitsToFloat(uint x) {
  return __builtin_bit_cast(float, x);
}
GNO_DEVICE vec3 uintBitsToFloat(uvec3 v) {
  return uvec3::zip([](uint p) { return uintBitsToFloat(p); }, v);
}
GNO_DEVICE uint64_t packUint2x32(uvec2 v) {
  return uint64_t{v.y} << 32 | v.x;
}
GNO_DEVICE uvec2 unpackDouble2x32(double x) {
  const auto bits = __builtin_bit_cast(uint64_t, x);
  return {uint(bits), uint(bits >> 32)};
}
GNO_DEVICE float halfToFloat(uint half) {
  const uint magnitude = half & 0x7fffu, sign = (half & 0x8000u) << 16;
  if (magnitude < 0x400u) return uintBitsToFloat(sign | floatBitsToUint(float(magnitude) * 0x1p-24f));
  const uint infinite = magnitude >= 0x7c00u ? 0x7f800000u : 0u;
  return uintBitsToFloat(sign | infinite | ((magnitude << 13) + ((127u - 15u) << 23)));
}
GNO_DEVICE vec2 unpackHalf2x16(uint bits) {
  return {halfToFloat(bits & 0xffffu), halfToFloat(bits >> 16)};
}

GNO_DEVICE uint uaddCarry(uint a, uint b, uint& carry) {
  const uint sum = a + b;
  carry = sum < a;
  return sum;
}
GNO_DEVICE void umulExtended(uint a, uint b, uint& high, uint& low) {
  const uint64_t product = uint64_t{a} * b;
  high = uint(product >> 32);
  low = uint(product);
}

}  // namespace gnosphere::cuda
