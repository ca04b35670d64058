// SPDX-License-Identifier: Apache-2.0
// The kernels, and how they are launched. GNO_MODE says in which namespace, see kernels.hpp. The text included below is
// that of shaders/, translated by glsl.sed.
#include "cuda/kernels.hpp"

#ifdef __CUDACC__
#include "cuda/warp.hpp"
#else
#include "cuda/one_thread.hpp"
#endif

// Long footprints are loops: their memory is not in registers anyway.
#define EACH_RAY(do_)                                     \
  GNO_UNROLL_RAYS for (uint ray = 0; ray < RAYS; ++ray) { \
    do_(ray)                                              \
  }
#define INT64_ATOMICS
#define FLOAT64
#define GNO_ARRAY(set_, binding_, type_, name_) type_* name_ = static_cast<type_*>(job.arrays[set_][binding_])
#define GNO_BLOCK(binding_, type_, name_) type_& name_ = *static_cast<type_*>(job.arrays[0][binding_])
#define GNO_PUSH(type_, name_) type_ name_ = __builtin_bit_cast(type_, job.pass)
#define GNO_OPTION(type_, name_) const type_ name_ = job.options.name_

namespace gnosphere::cuda::GNO_MODE {
namespace {

#include "glsl/shared.h"
// The formulas of the effects, outside of the stages: each is included once.
#include "glsl/effects/arithmetic.h"
#include "glsl/effects/bits.h"
#include "glsl/effects/detection.h"
#include "glsl/effects/doppler.h"
#include "glsl/effects/intensity.h"
#include "glsl/effects/noise.h"
#include "glsl/effects/parameters.h"
#include "glsl/effects/random.h"
#include "glsl/effects/returns.h"
#include "glsl/effects/vector.h"
#include "glsl/effects/weather.h"

// What is known of the options when a kernel is compiled decides how much of it there is.
struct Nothing {
  static GNO_DEVICE void fix(Options&) {}
};

template <uint kInside, uint kRange>
struct Lines {
  static GNO_DEVICE void fix(Options& options) {
    options.EFFECTS = 0;
    options.INSIDE = kInside;
    options.RANGE = kRange;
  }
};

struct Footprints {
  static GNO_DEVICE void fix(Options& options) { options.EFFECTS = kFootprintEffects; }
};

template <uint kLayers>
struct Layers {
  static GNO_DEVICE void fix(Options& options) { options.LAYERS = kLayers; }
};

#ifdef __CUDACC__

template <typename Stage, typename Known>
__global__ void __launch_bounds__(gl_WorkGroupSize.x) kernel(const __grid_constant__ Job given) {
  Job job = given;
  Known::fix(job.options);
  Stage{job}.main();
}

template <typename Stage, typename Known = Nothing>
void launch(const Job& job, uint32_t groupsX, uint32_t groupsY) {
  kernel<Stage, Known><<<dim3(groupsX, groupsY), gl_WorkGroupSize.x>>>(job);
}

#else

template <typename Stage, typename Known = Nothing>
void launch(const Job& given, uint32_t groupsX, uint32_t groupsY) {
  Job job = given;
  Known::fix(job.options);
  gl_NumWorkGroups = {groupsX, groupsY, 1};
  for (uint y = 0; y < groupsY; ++y)
    for (uint x = 0; x < groupsX; ++x) {
      gl_WorkGroupID = {x, y, 0};
      Stage{job}.main();
    }
}

#endif

struct project_occluders {
  const Job& job;
#include "glsl/project_occluders.comp"
};

struct prefix_sum {
  const Job& job;
#include "glsl/prefix_sum.comp"
};

namespace still {
#include "cuda/stages.cuh"
}

#define MOTION
namespace moving {
#include "cuda/stages.cuh"
}
#undef MOTION

}  // namespace

void launch(Kernel kernel, const Job& job, uint32_t groupsX, uint32_t groupsY) {
  if (groupsX == 0 || groupsY == 0) return;
  job.moving ? moving::launchStage(kernel, job, groupsX, groupsY) : still::launchStage(kernel, job, groupsX, groupsY);
}

}  // namespace gnosphere::cuda::GNO_MODE
