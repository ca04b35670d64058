// SPDX-License-Identifier: Apache-2.0
// The kernels, and how they are launched. GNO_MODE says in which namespace, see kernels.hpp. The text included below is
// that of shaders/, translated by glsl.sed.
#include "cuda/kernels.hpp"

#ifdef __CUDACC__
#include "cuda/warp.hpp"
#else
#include "cuda/one_thread.hpp"
#endif

#define INT64_ATOMICS
#define FLOAT64
#define GNO_ARRAY(set_, binding_, type_, name_) type_* name_ = static_cast<type_*>(job.arrays[set_][binding_])
#define GNO_BLOCK(binding_, type_, name_) type_& name_ = *static_cast<type_*>(job.arrays[0][binding_])
#define GNO_PUSH(type_, name_) type_ name_ = __builtin_bit_cast(type_, job.pass)
#define GNO_OPTION(type_, name_) const type_ name_ = job.options.name_

namespace gnosphere::cuda::GNO_MODE {
namespace {

#include "glsl/effects/arithmetic.h"
#include "glsl/effects/parameters.h"
#include "glsl/effects/plan.h"
#include "glsl/shared.h"

struct project_groups {
  const Job& job;
#include "glsl/project_groups.comp"
};

struct project_clusters {
  const Job& job;
#include "glsl/project_clusters.comp"
};

struct project_occluders {
  const Job& job;
#include "glsl/project_occluders.comp"
};

struct project_triangles {
  const Job& job;
#include "glsl/project_triangles.comp"
};

struct bin {
  const Job& job;
#include "glsl/bin.comp"
};

struct scan {
  const Job& job;
#include "glsl/scan.comp"
};

struct resolve {
  const Job& job;
#include "glsl/resolve.comp"
};

#ifdef __CUDACC__

// What is known when a kernel is compiled decides how much of it there is. Of effects: nothing, so far.
template <typename Stage>
__global__ void __launch_bounds__(gl_WorkGroupSize.x) kernel(const __grid_constant__ Job given) {
  Job job = given;
  job.options.EFFECTS = job.options.FIELDS = 0;
  job.options.LAYERS = job.options.RETURNS = 1;
  Stage{job}.main();
}

template <typename Stage, uint kInside, uint kRange>
__global__ void __launch_bounds__(gl_WorkGroupSize.x) kernelOf(const __grid_constant__ Job given) {
  Job job = given;
  job.options.EFFECTS = job.options.FIELDS = 0;
  job.options.LAYERS = job.options.RETURNS = 1;
  job.options.INSIDE = kInside;
  job.options.RANGE = kRange;
  Stage{job}.main();
}

template <typename Stage>
void launch(const Job& job, uint32_t groupsX, uint32_t groupsY) {
  kernel<Stage><<<dim3(groupsX, groupsY), gl_WorkGroupSize.x>>>(job);
}

// Every pair that exactnessOf() and validate(Exactness) allow.
template <typename Stage>
void launchMeeting(const Job& job, uint32_t groupsX, uint32_t groupsY) {
  const bool plane = job.options.RANGE == kRangePlane;
  auto* chosen =
      job.options.INSIDE == kInsideExact ? kernelOf<Stage, kInsideExact, kRangeExact>
      : job.options.INSIDE == kInsidePlain
          ? (plane ? kernelOf<Stage, kInsidePlain, kRangePlane> : kernelOf<Stage, kInsidePlain, kRangeEdgeWeights>)
          : (plane ? kernelOf<Stage, kInsideWatertight, kRangePlane>
                   : kernelOf<Stage, kInsideWatertight, kRangeEdgeWeights>);
  chosen<<<dim3(groupsX, groupsY), gl_WorkGroupSize.x>>>(job);
}

#else

template <typename Stage>
void launch(const Job& job, uint32_t groupsX, uint32_t groupsY) {
  gl_NumWorkGroups = {groupsX, groupsY, 1};
  for (uint y = 0; y < groupsY; ++y)
    for (uint x = 0; x < groupsX; ++x) {
      gl_WorkGroupID = {x, y, 0};
      Stage{job}.main();
    }
}

template <typename Stage>
void launchMeeting(const Job& job, uint32_t groupsX, uint32_t groupsY) {
  launch<Stage>(job, groupsX, groupsY);
}

#endif

}  // namespace

void launch(Kernel kernel, const Job& job, uint32_t groupsX, uint32_t groupsY) {
  if (groupsX == 0 || groupsY == 0) return;
  switch (kernel) {
    case Kernel::project_groups: return launch<project_groups>(job, groupsX, groupsY);
    case Kernel::project_clusters: return launch<project_clusters>(job, groupsX, groupsY);
    case Kernel::project_occluders: return launch<project_occluders>(job, groupsX, groupsY);
    case Kernel::project_triangles: return launch<project_triangles>(job, groupsX, groupsY);
    case Kernel::bin: return launchMeeting<bin>(job, groupsX, groupsY);
    case Kernel::scan: return launch<scan>(job, groupsX, groupsY);
    case Kernel::resolve: return launchMeeting<resolve>(job, groupsX, groupsY);
  }
}

}  // namespace gnosphere::cuda::GNO_MODE
