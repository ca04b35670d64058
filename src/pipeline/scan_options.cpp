// SPDX-License-Identifier: Apache-2.0
#include "pipeline/scan_options.hpp"

#include <limits>

namespace gnosphere {
namespace {

// The enumerations of the public API have the values of the constants in options.h.
static_assert(static_cast<uint32_t>(AccuracyParts::Bounds::exact) == gpu::kBoundsExact);
static_assert(static_cast<uint32_t>(AccuracyParts::Cull::nearestPoint) == gpu::kCullNearestPoint);
static_assert(static_cast<uint32_t>(AccuracyParts::Inside::exact) == gpu::kInsideExact);
static_assert(static_cast<uint32_t>(AccuracyParts::Range::exact) == gpu::kRangeExact);
static_assert(static_cast<uint32_t>(ReflectingFaces::both) == gpu::kFacesBoth);

}  // namespace

// With the paper's bounds only single triangles are culled, as in the paper. Otherwise either cull of triangles goes
// with that of clusters, since a cluster that is out of range, hidden, between beams or turned away has no hits.
uint32_t cullingBits(const SimulatorOptions& options) {
  if (accuracyPartsOf(options).bounds == AccuracyParts::Bounds::paper) return 0;
  const Culling& culling = options.tuning.culling;
  return (culling.range ? gpu::kCullRange : 0) | (culling.rows ? gpu::kCullRows : 0) |
         (culling.columns ? gpu::kCullColumns : 0) | (culling.cones ? gpu::kCullCones : 0) |
         (culling.occlusion != Culling::Occlusion::never ? gpu::kCullOccluded : 0);
}

Options kernelOptions(const SimulatorOptions& options, const SensorPlan& plan) {
  const AccuracyParts parts = accuracyPartsOf(options);
  Options result;
  result.BOUNDS = static_cast<uint32_t>(parts.bounds);
  result.CULL = static_cast<uint32_t>(parts.cull);
  result.INSIDE = static_cast<uint32_t>(parts.inside);
  result.RANGE = static_cast<uint32_t>(parts.range);
  result.FACES = static_cast<uint32_t>(options.faces);
  result.CULLING = cullingBits(options);
  result.EFFECTS = plan.bits;
  result.FIELDS = plan.fields;
  result.LAYERS = plan.layers();
  result.RETURNS = plan.returns;
  return result;
}

double reachOf(const SimulatorOptions& options, double rangeMax) {
  return cullingBits(options) & gpu::kCullRange ? rangeMax : std::numeric_limits<double>::infinity();
}

bool leavesWords(uint32_t binning, const SensorPlan& plan) {
  if (plan.computesReturns()) return (plan.returns == 1 || plan.layout.empty()) && plan.pointsOnAxes();
  return binning != gpu::kBinningLists;
}

// Kernels that compute returns from surfaces need the transforms of still instances as well, which a scan that reuses
// the image does not place. Beams that deviate do so anew in each scan, and panes and candidates of footprints are not
// part of the image.
bool keepsStill(const SimulatorOptions& options, uint32_t binning, const SensorPlan& plan) {
  return options.tuning.keepStill && binning != gpu::kBinningLists &&
         accuracyPartsOf(options).bounds != AccuracyParts::Bounds::paper &&
         !(plan.computesReturns() && (plan.surfaces() || plan.speeds())) && !plan.panes() && !plan.footprint() &&
         !plan.has(gpu::kStrays) && plan.sensor.patterns.size() <= 1;
}

const char* nameOfBinning(uint32_t binning) {
  constexpr const char* kNames[] = {"nearest", "lists", "slabs"};
  static_assert(gpu::kBinningNearest == 0 && gpu::kBinningLists == 1 && gpu::kBinningSlabs == 2);
  return kNames[binning];
}

}  // namespace gnosphere
