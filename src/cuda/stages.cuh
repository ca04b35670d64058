// SPDX-License-Identifier: Apache-2.0
// The stages that motion within a scan changes, each the body of a struct. Included by kernels.cuh, once without MOTION
// and once with it.

struct project_groups {
  const Job& job;
#include "glsl/project_groups.comp"
};

struct project_clusters {
  const Job& job;
#include "glsl/project_clusters.comp"
};

struct project_triangles {
  const Job& job;
#include "glsl/project_triangles.comp"
};

#define FOOTPRINT
struct project_triangles_footprint {
  const Job& job;
#include "glsl/project_triangles.comp"
};
#undef FOOTPRINT

struct bin {
  const Job& job;
#include "glsl/bin.comp"
};

struct resolve {
  const Job& job;
#include "glsl/resolve.comp"
};

template <uint RAYS>
struct effects_footprint {
  const Job& job;
  GNO_DEVICE explicit effects_footprint(const Job& given) : job(given) {}  // nothing of what a beam meets is zeroed
#include "glsl/effects_footprint.comp"
};

struct effects_surfaces {
  const Job& job;
#include "glsl/effects_surfaces.comp"
};

struct effects {
  const Job& job;
#include "glsl/effects.comp"
};

// Every pair that exactnessOf() and validate(Exactness) allow.
template <typename Stage>
void launchMeeting(const Job& job, uint32_t groupsX, uint32_t groupsY) {
  const bool plane = job.options.RANGE == kRangePlane;
  if (job.options.INSIDE == kInsideExact)
    launch<Stage, Lines<kInsideExact, kRangeExact>>(job, groupsX, groupsY);
  else if (job.options.INSIDE == kInsidePlain)
    plane ? launch<Stage, Lines<kInsidePlain, kRangePlane>>(job, groupsX, groupsY)
          : launch<Stage, Lines<kInsidePlain, kRangeEdgeWeights>>(job, groupsX, groupsY);
  else
    plane ? launch<Stage, Lines<kInsideWatertight, kRangePlane>>(job, groupsX, groupsY)
          : launch<Stage, Lines<kInsideWatertight, kRangeEdgeWeights>>(job, groupsX, groupsY);
}

// With so many sub-rays, or room for some more.
template <uint kRays>
void launchFootprint(const Job& job, uint32_t groupsX, uint32_t groupsY) {
  job.options.LAYERS == 1 ? launch<effects_footprint<kRays>, Layers<1>>(job, groupsX, groupsY)
                          : launch<effects_footprint<kRays>, Layers<kMaxLayers>>(job, groupsX, groupsY);
}

void launchStage(Kernel kernel, const Job& job, uint32_t groupsX, uint32_t groupsY) {
  const bool footprint = (job.options.EFFECTS & kFootprintEffects) != 0;
  switch (kernel) {
    case Kernel::project_groups: return launch<project_groups>(job, groupsX, groupsY);
    case Kernel::project_clusters: return launch<project_clusters>(job, groupsX, groupsY);
    case Kernel::project_occluders: return launch<project_occluders>(job, groupsX, groupsY);
    case Kernel::project_triangles:
      return footprint ? launch<project_triangles_footprint>(job, groupsX, groupsY)
                       : launch<project_triangles>(job, groupsX, groupsY);
    case Kernel::bin:
      return footprint ? launch<bin, Footprints>(job, groupsX, groupsY) : launchMeeting<bin>(job, groupsX, groupsY);
    case Kernel::prefix_sum: return launch<prefix_sum>(job, groupsX, groupsY);
    case Kernel::resolve: return launchMeeting<resolve>(job, groupsX, groupsY);
    case Kernel::effects_footprint:
      return job.subRays <= 1    ? launchFootprint<1>(job, groupsX, groupsY)
             : job.subRays <= 7  ? launchFootprint<7>(job, groupsX, groupsY)
             : job.subRays <= 19 ? launchFootprint<19>(job, groupsX, groupsY)
                                 : launchFootprint<61>(job, groupsX, groupsY);
    case Kernel::effects_surfaces: return launch<effects_surfaces>(job, groupsX, groupsY);
    case Kernel::effects: return launch<effects>(job, groupsX, groupsY);
  }
}
