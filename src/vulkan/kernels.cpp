// SPDX-License-Identifier: Apache-2.0
#include "vulkan/kernels.hpp"

#include "bin.spv.h"
#include "bin_float64.spv.h"
#include "bin_int64.spv.h"
#include "bin_int64_float64.spv.h"
#include "bin_int64_motion.spv.h"
#include "bin_motion.spv.h"
#include "effects.spv.h"
#include "effects_footprint1.spv.h"
#include "effects_footprint19.spv.h"
#include "effects_footprint19_motion.spv.h"
#include "effects_footprint1_motion.spv.h"
#include "effects_footprint37.spv.h"
#include "effects_footprint37_motion.spv.h"
#include "effects_footprint61.spv.h"
#include "effects_footprint61_motion.spv.h"
#include "effects_footprint7.spv.h"
#include "effects_footprint7_motion.spv.h"
#include "effects_motion.spv.h"
#include "effects_surfaces.spv.h"
#include "effects_surfaces_motion.spv.h"
#include "pipeline/scan_options.hpp"
#include "prefix_sum.spv.h"
#include "project_clusters.spv.h"
#include "project_clusters_motion.spv.h"
#include "project_groups.spv.h"
#include "project_groups_motion.spv.h"
#include "project_occluders.spv.h"
#include "project_triangles.spv.h"
#include "project_triangles_footprint.spv.h"
#include "project_triangles_footprint_motion.spv.h"
#include "project_triangles_motion.spv.h"
#include "resolve.spv.h"
#include "resolve_float64.spv.h"
#include "resolve_motion.spv.h"
namespace gnosphere::vulkan {
namespace {

using Words = std::span<const uint32_t>;

// The module that is built for so many sub-rays, or some more.
Words footprintOf(uint32_t subRays, bool moving) {
  if (subRays <= 1) return moving ? Words(effects_footprint1_motion) : Words(effects_footprint1);
  if (subRays <= 7) return moving ? Words(effects_footprint7_motion) : Words(effects_footprint7);
  if (subRays <= 19) return moving ? Words(effects_footprint19_motion) : Words(effects_footprint19);
  if (subRays <= 37) return moving ? Words(effects_footprint37_motion) : Words(effects_footprint37);
  return moving ? Words(effects_footprint61_motion) : Words(effects_footprint61);
}

Words projectTrianglesOf(bool footprint, bool moving) {
  if (footprint) return moving ? Words(project_triangles_footprint_motion) : Words(project_triangles_footprint);
  return moving ? Words(project_triangles_motion) : Words(project_triangles);
}

// Motion is never exact.
Words binOf(bool int64, bool float64, bool moving) {
  if (int64) return moving ? Words(bin_int64_motion) : float64 ? Words(bin_int64_float64) : Words(bin_int64);
  return moving ? Words(bin_motion) : float64 ? Words(bin_float64) : Words(::bin);
}

Words resolveOf(bool float64, bool moving) {
  return moving ? Words(resolve_motion) : float64 ? Words(resolve_float64) : Words(::resolve);
}

}  // namespace

Kernels::Kernels(const Device& device, const Layout& layout, const Options& options, uint32_t binning, bool float64,
                 bool moving, const SensorPlan& plan)
    : projectGroups(device, layout, "project_groups", moving ? Words(project_groups_motion) : Words(project_groups),
                    options),
      projectClusters(device, layout, "project_clusters",
                      moving ? Words(project_clusters_motion) : Words(project_clusters), options),
      projectOccluders(device, layout, "project_occluders", project_occluders, options),
      projectTriangles(device, layout, "project_triangles", projectTrianglesOf(plan.footprint(), moving), options,
                       binning == gpu::kBinningSlabs ? gpu::kPassSlabs : 0) {
  const auto addBin = [&](bool int64, uint32_t pass) {
    bin.emplace_back(device, layout, "bin", binOf(int64, float64, moving), options, pass);
  };
  if (binning == gpu::kBinningNearest || binning == gpu::kBinningSlabs) {
    addBin(true, binning == gpu::kBinningSlabs ? gpu::kPassSlabs : gpu::kPassNearest);
  } else if (binning == gpu::kBinningNearest32) {
    addBin(false, gpu::kPassRange);
    addBin(false, gpu::kPassOwner);
  } else {
    addBin(false, gpu::kPassCount);
    addBin(false, gpu::kPassFill);
    for (uint32_t pass : {gpu::kPrefixReduce, gpu::kPrefixBlocks, gpu::kPrefixApply})
      prefixSum.emplace_back(device, layout, "prefix_sum", ::prefix_sum, options, pass);
  }
  if (plan.footprint())
    for (uint32_t pass : {0, 1})
      footprint.emplace_back(device, layout, "effects_footprint",
                             footprintOf(static_cast<uint32_t>(plan.subRays.size()), moving), options, pass);
  else if (!leavesWords(binning, plan))
    resolve.emplace(device, layout, "resolve", resolveOf(float64, moving), options, binning);
  if (plan.surfaces() && !plan.footprint())
    surfaces.emplace(device, layout, "effects_surfaces",
                     moving ? Words(effects_surfaces_motion) : Words(effects_surfaces), options);
  if (plan.signals() || plan.speeds())
    effects.emplace(device, layout, "effects", moving ? Words(effects_motion) : Words(::effects), options);
}

}  // namespace gnosphere::vulkan
