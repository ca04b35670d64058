// SPDX-License-Identifier: Apache-2.0
// The kernels and their launch, in namespace GNO_MODE, see kernels.hpp. The included files are those of common/ and
// shaders/, translated by glsl.sed.
#include "cuda/kernels.hpp"

// The header that maps GLSL's built-ins to invocations. Tests may name another one.
#ifndef GNO_INVOCATIONS
#ifdef __CUDACC__
#define GNO_INVOCATIONS "cuda/warp.hpp"
#else
#define GNO_INVOCATIONS "cuda/one_thread.hpp"
#endif
#endif
#include GNO_INVOCATIONS

// Footprints with more than 19 sub-rays use real loops: their arrays do not fit in registers anyway. nvcc does not
// unroll the others by itself, so they are the unrolled ones of each_ray.glsl. The host compiles loops in a fraction of
// the time.
#define GNO_LOOP_OF_RAYS(do_)                             \
  GNO_DONT_UNROLL for (uint ray = 0; ray < RAYS; ++ray) { \
    do_(ray)                                              \
  }
#ifdef __CUDACC__
#define EACH_RAY(do_)                 \
  if constexpr (RAYS > 19) {          \
    GNO_LOOP_OF_RAYS(do_)             \
  } else {                            \
    do_(0u) if constexpr (RAYS > 1) { \
      RAYS_TO_2(do_) RAYS_TO_7(do_)   \
    }                                 \
    if constexpr (RAYS > 7) {         \
      RAYS_TO_19(do_)                 \
    }                                 \
  }
#else
#define EACH_RAY(do_) GNO_LOOP_OF_RAYS(do_)
#endif

// Declares an array of an invocation. An array whose index is a variable lies in memory. As a member it would force
// nvcc to keep the whole stage in memory, without a constant option and without a value in a register, so it lies
// apart.
#ifdef __CUDACC__
#define GNO_PRIVATE_ARRAY(type_, name_, count_) \
  type_* const name_ = reinterpret_cast<type_*>(takeMemory(sizeof(type_) * (count_)))
#else
#define GNO_PRIVATE_ARRAY(type_, name_, count_) type_ name_[count_]
#endif
#define INT64_ATOMICS
#define FLOAT64
#define GNO_OPTION(type_, name_) const type_ name_ = job.options.name_

namespace gnosphere::cuda::GNO_MODE {
namespace {

#include "glsl/common/shared.h"
// The formulas of beams and effects stand outside of the stages, so that each is included once.
#include "glsl/common/beam.h"
#include "glsl/common/deform.h"
#include "glsl/common/effects/arithmetic.h"
#include "glsl/common/effects/bits.h"
#include "glsl/common/effects/detection.h"
#include "glsl/common/effects/doppler.h"
#include "glsl/common/effects/intensity.h"
#include "glsl/common/effects/noise.h"
#include "glsl/common/effects/parameters.h"
#include "glsl/common/effects/random.h"
#include "glsl/common/effects/returns.h"
#include "glsl/common/effects/vector.h"
#include "glsl/common/effects/weather.h"
#include "glsl/common/laser.h"

// Options that are known when a kernel is compiled remove the code that they do not need.
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

// Lines that may deviate, pass holes and meet panes.
struct EffectLines {
  static GNO_DEVICE void fix(Options& options) {
    options.INSIDE = kInsideWatertight;
    options.RANGE = kRangeEdgeWeights;
  }
};

struct Footprints {
  static GNO_DEVICE void fix(Options& options) {
    options.EFFECTS = kFootprint | (options.EFFECTS & (kCutOuts | kStrays));
  }
};

template <uint kPass, uint kLayers, uint kWithout = 0>
struct FootprintPass {
  static GNO_DEVICE void fix(Options& options) {
    options.PASS = kPass;
    options.LAYERS = kLayers;
    options.EFFECTS &= ~kWithout;
  }
};

#ifdef __CUDACC__

// One invocation of a stage, with the memory of its private arrays.
struct Invocation {
  static constexpr uint kPrivateBytes = 0;  // of all private arrays of the stage

  const Job& job;
  char* memory;     // that no array has yet
  const char* end;  // of the memory

  GNO_DEVICE char* takeMemory(uint bytes) {
    memory += bytes;
    if (memory > end) __trap();  // kPrivateBytes is too small; otherwise the compiler removes this line
    return memory - bytes;
  }
};

template <typename Stage, typename Known>
__global__ void __launch_bounds__(gl_WorkGroupSize.x) kernel(const __grid_constant__ Job given) {
  Job job = given;
  Known::fix(job.options);
  alignas(16) char memory[Stage::kPrivateBytes + 1];
  Stage{{job, memory, memory + Stage::kPrivateBytes}}.main();
}

template <typename Stage, typename Known>
void launchAs(const Job& job, uint32_t workgroupsX, uint32_t workgroupsY) {
  kernel<Stage, Known><<<dim3(workgroupsX, workgroupsY), gl_WorkGroupSize.x>>>(job);
}

#else

struct Invocation {
  const Job& job;
};

// The host compiles each stage once, and reads the options that are known as it reads the others.
template <typename Stage>
void run(const Job& job, uint32_t workgroupsX, uint32_t workgroupsY) {
  runWorkgroups(workgroupsX, workgroupsY, [&job] { Stage{{job}}.main(); });
}

template <typename Stage, typename Known>
void launchAs(const Job& given, uint32_t workgroupsX, uint32_t workgroupsY) {
  Job job = given;
  Known::fix(job.options);
  run<Stage>(job, workgroupsX, workgroupsY);
}

#endif

template <typename Known, uint kMotion>
struct Moving {
  static GNO_DEVICE void fix(Options& options) {
    Known::fix(options);
    options.MOTION = kMotion;
  }
};

template <typename Stage, typename Known = Nothing>
void launch(const Job& job, uint32_t workgroupsX, uint32_t workgroupsY) {
  job.options.MOTION ? launchAs<Stage, Moving<Known, 1>>(job, workgroupsX, workgroupsY)
                     : launchAs<Stage, Moving<Known, 0>>(job, workgroupsX, workgroupsY);
}

struct beam_frames : Invocation {
#include "glsl/beam_frames.comp"
};

struct project_groups : Invocation {
#include "glsl/project_groups.comp"
};

struct project_clusters : Invocation {
#include "glsl/project_clusters.comp"
};

struct project_triangles : Invocation {
#include "glsl/project_triangles.comp"
};

template <uint RAYS>
struct bin : Invocation {
  static constexpr uint kPrivateBytes = 8 * RAYS;
  GNO_DEVICE explicit bin(const Invocation& given) : Invocation(given) {}
#include "glsl/bin.comp"
};

struct prefix_sum : Invocation {
#include "glsl/prefix_sum.comp"
};

struct resolve : Invocation {
#include "glsl/resolve.comp"
};

struct effects_strays : Invocation {
#include "glsl/effects_strays.comp"
};

// CUDA leaves all sub-rays of a beam to one thread, so it has no SPREAD_RAYS. tools/gpus asks for it, and the tests by
// GNO_SPREAD_RAYS, the number of sub-rays of footprints whose lanes have two places each.
template <uint RAYS, uint SPREAD_RAYS = 0>
struct effects_footprint : Invocation {
  static constexpr uint kPrivateBytes = 4 * (13 + 5 * kMaxLayers) * RAYS;
  GNO_DEVICE explicit effects_footprint(const Invocation& given)
      : Invocation(given) {}  // the arrays of hits stay unset
#include "glsl/effects_footprint.comp"
};

struct effects_panes : Invocation {
  static constexpr uint kPrivateBytes = 4 * (4 * kMaxLayers + 1);
#include "glsl/effects_panes.comp"
};

struct effects : Invocation {
#include "glsl/effects.comp"
};

// Only Vulkan devices read and write buffers of the caller; the tests run these kernels on the host.
#ifdef GNO_CALLERS_BUFFERS
struct records : Invocation {
#include "glsl/records.comp"
};
#define OUTSIDE_OF_SCANS
struct fit_clusters : Invocation {
#include "glsl/fit_clusters.comp"
};

struct place_instances : Invocation {
#include "glsl/place_instances.comp"
};
#undef OUTSIDE_OF_SCANS
#endif

// Handles every pair of INSIDE and RANGE that accuracyPartsOf() and validate(AccuracyParts) allow. Effects of lines are
// planned for the standard pair alone.
template <typename Stage>
void launchMeeting(const Job& job, uint32_t workgroupsX, uint32_t workgroupsY) {
  if ((job.options.EFFECTS & kFootprintEffects) != 0) return launch<Stage, EffectLines>(job, workgroupsX, workgroupsY);
  const bool plane = job.options.RANGE == kRangePlane;
  if (job.options.INSIDE == kInsideExact)
    launch<Stage, Lines<kInsideExact, kRangeExact>>(job, workgroupsX, workgroupsY);
  else if (job.options.INSIDE == kInsidePlain)
    plane ? launch<Stage, Lines<kInsidePlain, kRangePlane>>(job, workgroupsX, workgroupsY)
          : launch<Stage, Lines<kInsidePlain, kRangeEdgeWeights>>(job, workgroupsX, workgroupsY);
  else
    plane ? launch<Stage, Lines<kInsideWatertight, kRangePlane>>(job, workgroupsX, workgroupsY)
          : launch<Stage, Lines<kInsideWatertight, kRangeEdgeWeights>>(job, workgroupsX, workgroupsY);
}

// Launches the kernel for kRays sub-rays. Each pass is a kernel of its own, because the first and the others have
// little in common, and together they have too few registers. With strays the others have too few of them even alone.
template <uint kRays, uint kSpread = 0>
void launchFootprint(const Job& job, uint32_t workgroupsX, uint32_t workgroupsY) {
  using Stage = effects_footprint<kRays, kSpread>;
  switch (job.options.PASS) {
    case kPassFootprintOthers:
      (job.options.EFFECTS & kStrays) != 0
          ? launch<Stage, FootprintPass<kPassFootprintOthers, 1>>(job, workgroupsX, workgroupsY)
          : launch<Stage, FootprintPass<kPassFootprintOthers, 1, kStrays>>(job, workgroupsX, workgroupsY);
      return;
    case kPassFootprintPanesToo:
      return launch<Stage, FootprintPass<kPassFootprintPanesToo, kMaxLayers>>(job, workgroupsX, workgroupsY);
    default:
      job.options.LAYERS == 1
          ? launch<Stage, FootprintPass<kPassFootprintWithinOne, 1>>(job, workgroupsX, workgroupsY)
          : launch<Stage, FootprintPass<kPassFootprintWithinOne, kMaxLayers>>(job, workgroupsX, workgroupsY);
  }
}

}  // namespace

void launch(Kernel kernel, const Job& job, uint32_t workgroupsX, uint32_t workgroupsY) {
  if (workgroupsX == 0 || workgroupsY == 0) return;
  const bool footprint = (job.options.EFFECTS & kFootprint) != 0;
  switch (kernel) {
    case Kernel::beam_frames: return launch<beam_frames>(job, workgroupsX, workgroupsY);
    case Kernel::project_groups: return launch<project_groups>(job, workgroupsX, workgroupsY);
    case Kernel::project_clusters: return launch<project_clusters>(job, workgroupsX, workgroupsY);
    case Kernel::project_triangles: return launch<project_triangles>(job, workgroupsX, workgroupsY);
    case Kernel::bin:
      if (!footprint) return launchMeeting<bin<1>>(job, workgroupsX, workgroupsY);
      switch (job.options.RAYS) {
        case 1: return launch<bin<1>, Footprints>(job, workgroupsX, workgroupsY);
        case 7: return launch<bin<7>, Footprints>(job, workgroupsX, workgroupsY);
        case 19: return launch<bin<19>, Footprints>(job, workgroupsX, workgroupsY);
        default: return launch<bin<61>, Footprints>(job, workgroupsX, workgroupsY);
      }
    case Kernel::prefix_sum: return launch<prefix_sum>(job, workgroupsX, workgroupsY);
    case Kernel::resolve: return launchMeeting<resolve>(job, workgroupsX, workgroupsY);
    case Kernel::effects_strays: return launch<effects_strays>(job, workgroupsX, workgroupsY);
    case Kernel::effects_footprint:
#ifdef GNO_SPREAD_RAYS
      if (job.options.SPREAD_RAYS > 0) return launchFootprint<2, GNO_SPREAD_RAYS>(job, workgroupsX, workgroupsY);
#endif
      switch (job.options.RAYS) {
        case 1: return launchFootprint<1>(job, workgroupsX, workgroupsY);
        case 7: return launchFootprint<7>(job, workgroupsX, workgroupsY);
        case 19: return launchFootprint<19>(job, workgroupsX, workgroupsY);
        default: return launchFootprint<61>(job, workgroupsX, workgroupsY);
      }
    case Kernel::effects_panes: return launch<effects_panes>(job, workgroupsX, workgroupsY);
    case Kernel::effects: return launch<effects>(job, workgroupsX, workgroupsY);
#ifdef GNO_CALLERS_BUFFERS
    case Kernel::fit_clusters: return launch<fit_clusters>(job, workgroupsX, workgroupsY);
    case Kernel::place_instances: return launch<place_instances>(job, workgroupsX, workgroupsY);
    case Kernel::records: return launch<records>(job, workgroupsX, workgroupsY);
#else
    case Kernel::fit_clusters:
    case Kernel::place_instances:
    case Kernel::records: return;
#endif  // only Vulkan devices read and write buffers of the caller
  }
}

}  // namespace gnosphere::cuda::GNO_MODE
