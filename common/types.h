// SPDX-License-Identifier: Apache-2.0
// Types that mean the same in GLSL, C++ and CUDA. GLSL uses the scalar layout rules for structs, so all three agree.
#ifndef GNOSPHERE_COMMON_TYPES_H
#define GNOSPHERE_COMMON_TYPES_H

#ifdef __cplusplus
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
namespace gnosphere::gpu {
using uint = uint32_t;
using glm::vec2;
using glm::vec3;
struct alignas(16) vec4 {
  float x, y, z, w;
};
/// Memory of the caller by its address. Only Vulkan's bindings have these structs in GLSL.
struct CallerBuffer {
  uint64_t memory;
};
/// The caller's memory for the records of a shot, and for their RecordHeader.
struct RecordBuffers {
  uint64_t records, header;
};
}  // namespace gnosphere::gpu
#define GNO_CONST inline constexpr
#else
#define GNO_CONST const
#endif
#endif
