// SPDX-License-Identifier: Apache-2.0
// Declares the arrays of arrays.h for a kernel, by the buffer addresses in its push constants. In CUDA they are plain pointers.
#include "common/arrays.h"
#include "common/effects/parameters.h"

#ifdef VULKAN

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer CallerMemory { uint at[]; };
// The address of a CallerMemory is two words, because glslang loads a reference with the alignment of the memory behind
// it, and that of words is too little for an address.
struct CallerBuffer {
  uvec2 memory;
};
layout(buffer_reference, scalar, buffer_reference_align = 16) buffer RecordMemory { uint at[]; };
struct RecordBuffers {
  RecordMemory records, header;
};

// A kernel that runs outside of scans may write every array.
#ifdef OUTSIDE_OF_SCANS
#define ARRAY(access_, type_, name_) \
  layout(buffer_reference, scalar, buffer_reference_align = 16) buffer name_##Array { type_ at[]; };
#else
#define ARRAY(access_, type_, name_) \
  layout(buffer_reference, scalar, buffer_reference_align = 16) access_ buffer name_##Array { type_ at[]; };
#endif
GNO_ARRAYS(ARRAY, ARRAY)
#undef ARRAY

#define ARRAY(access_, type_, name_) name_##Array name_##At;
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer Job { GNO_ARRAYS(ARRAY, ARRAY) };
#undef ARRAY

layout(push_constant, scalar) uniform PushBlock {
  Job job;
  Pass pass;
};

#define BLOCK(access_, type_, name_) name_##Array name_##At = job.name_##At;
#define ARRAY(access_, type_, name_) name_##Array name_ = job.name_##At;
GNO_ARRAYS(BLOCK, ARRAY)
#undef ARRAY
#undef BLOCK

// True if the driver's compiler loads from an address that all lanes share also in branches that no lane takes, where
// an index may be anything. The constant follows from the driver.
layout(constant_id = 25) const bool kOwnAddresses = false;

// Gives each lane addresses of its own, where the driver needs it. Every kernel calls this first.
void useOwnAddresses() {
  if (kOwnAddresses) {
    // No address has the highest bit, so this is 0, but no compiler knows it.
    uvec2 zero = uvec2(gl_LocalInvocationID.x & uvec2(job).y >> 31);
#define BLOCK(access_, type_, name_) name_##At = name_##Array(uvec2(name_##At) | zero);
#define ARRAY(access_, type_, name_) name_ = name_##Array(uvec2(name_) | zero);
    GNO_ARRAYS(BLOCK, ARRAY)
#undef ARRAY
#undef BLOCK
  }
}

#ifndef OUTSIDE_OF_SCANS
// The frame is copied once because it is read often: a compiler must reload memory after each store that may alias it.
Frame frame = frameAt.at[0];
#endif
MotionBounds motion;  // copied by loadMotion() for the same reason; a scan without motion has no such array
void loadMotion() {
  if (APART) motion = motionAt.at[0];
}
void loadMotionOf(uint view_) { motion = motionAt.at[view_]; }
#define counters countersAt.at[0]
#define shells shellsAt.at[0]
#define parameters parametersAt.at[0]
#define parametersOf(view_) parametersAt.at[view_]

#else

// A block that a kernel does not use has no address, so blocks are pointers here and not references. Each stage is
// included after another one, which has left its macros.
#undef counters
#undef shells
#undef parameters
#undef parametersOf
#undef motion
using CallerMemory = const uint*;
struct CallerBuffer {
  CallerMemory memory;
};
using RecordMemory = uint*;
struct RecordBuffers {
  RecordMemory records, header;
};
#define ARRAY(access_, type_, name_) type_* name_ = reinterpret_cast<type_*>(job.addresses.name_);
#define BLOCK(access_, type_, name_) type_* name_##At = reinterpret_cast<type_*>(job.addresses.name_);
GNO_ARRAYS(BLOCK, ARRAY)
#undef ARRAY
#undef BLOCK
Frame& frame = *frameAt;
#define counters (*countersAt)
#define shells (*shellsAt)
#define parameters (*parametersAt)
#define parametersOf(view_) parametersAt[view_]
#define motion (motionAt[frame.moments != 0 ? view : 0])
GNO_DEVICE void useOwnAddresses() {}
GNO_DEVICE void loadMotion() {}
GNO_DEVICE void loadMotionOf(uint) {}
Pass pass = __builtin_bit_cast(Pass, job.pass);

#endif

#include "wide_loads.glsl"
