// SPDX-License-Identifier: Apache-2.0
#include "pipeline/scan_options.hpp"

#include <algorithm>
#include <limits>
#include <span>

namespace gnosphere {
namespace {

// Where shells end, as shares of the range. Measured on towns: from 0.3 on more hides little more. One more shell took
// 0.95 of the time of a CPU with 0.6 million beams and more, 1.0 with an HDL-64E, and 1.07 with a VLP-16.
constexpr float kTwoShells[] = {0.35f}, kThreeShells[] = {0.2f, 0.45f};
constexpr uint32_t kThreeShellsBeams = 500'000;
// What hides costs a look at every beam; that pays from so many triangles per beam on, and so many in all.
constexpr double kTrianglesPerBeam = 0.125;
constexpr uint64_t kShellTriangles = 100'000;
// Measured on towns: one projected triangle for 8 beams of an HDL-64E, and fewer for more.
constexpr uint64_t kBeamsPerProjected = 8, kLeastProjected = 1 << 14, kMostProjected = 1 << 18;
constexpr uint64_t kFirstTiles = 1 << 12;

// The enumerations of the public API and the constants of shared.h count alike.
static_assert(static_cast<uint32_t>(Exactness::Bounds::exact) == gpu::kBoundsExact);
static_assert(static_cast<uint32_t>(Exactness::Cull::nearestPoint) == gpu::kCullNearestPoint);
static_assert(static_cast<uint32_t>(Exactness::Inside::exact) == gpu::kInsideExact);
static_assert(static_cast<uint32_t>(Exactness::Range::exact) == gpu::kRangeExact);
static_assert(static_cast<uint32_t>(Faces::both) == gpu::kFacesBoth);

}  // namespace

Exactness exactnessOf(const SimulatorOptions& options) {
  return options.exactness.value_or(exactnessOf(options.accuracy));
}

// The paper culls triangle by triangle.
uint32_t cullingBits(const SimulatorOptions& options) {
  const Exactness parts = exactnessOf(options);
  if (parts.bounds == Exactness::Bounds::paper || parts.cull == Exactness::Cull::firstCorner) return 0;
  const Culling& culling = options.culling;
  return (culling.range ? gpu::kCullRange : 0) | (culling.rows ? gpu::kCullRows : 0) |
         (culling.columns ? gpu::kCullColumns : 0) | (culling.cones ? gpu::kCullCones : 0) |
         (culling.occlusion != Culling::Occlusion::never ? gpu::kCullOccluded : 0);
}

uint32_t chooseBinning(const SimulatorOptions& options, bool int64Atomics, bool cpu, const SensorPlan& plan) {
  if (plan.footprint()) return gpu::kBinningLists;
  switch (options.binning) {
    case Binning::lists: return gpu::kBinningLists;
    case Binning::nearest32: return gpu::kBinningNearest32;
    case Binning::automatic:
      // Candidates per beam, as the paper has it.
      if (exactnessOf(options).bounds == Exactness::Bounds::paper) return gpu::kBinningLists;
      break;
    case Binning::slabs: cpu = true; break;
    case Binning::nearest: cpu = false; break;
  }
  return !int64Atomics ? gpu::kBinningNearest32 : cpu ? gpu::kBinningSlabs : gpu::kBinningNearest;
}

bool leavesWords(uint32_t binning, const SensorPlan& plan) {
  return binning != gpu::kBinningLists && plan.bare();
}

const char* nameOfBinning(uint32_t binning) {
  constexpr const char* kNames[] = {"nearest", "nearest32", "lists", "slabs"};
  static_assert(gpu::kBinningNearest == 0 && gpu::kBinningNearest32 == 1 && gpu::kBinningLists == 2 &&
                gpu::kBinningSlabs == 3);
  return kNames[binning];
}

// Where every hit of a beam counts, nothing hides anything.
std::vector<float> shellEnds(const SimulatorOptions& options, uint32_t binning, const gpu::Frame& frame,
                             uint64_t triangles) {
  const bool pays = triangles >= kShellTriangles &&
                    static_cast<double>(triangles) >= kTrianglesPerBeam * static_cast<double>(frame.beams);
  const bool possible = binning != gpu::kBinningLists && (cullingBits(options) & gpu::kCullOccluded) != 0;
  std::vector<float> ends;
  if (possible && (pays || options.culling.occlusion == Culling::Occlusion::always)) {
    const bool three = binning == gpu::kBinningSlabs && frame.beams >= kThreeShellsBeams;
    for (const float share : three ? std::span<const float>(kThreeShells) : std::span<const float>(kTwoShells))
      ends.push_back(frame.rangeMax * share);
  }
  ends.push_back(std::numeric_limits<float>::infinity());
  return ends;
}

double reachOf(const SimulatorOptions& options, const gpu::Frame& frame) {
  return cullingBits(options) & gpu::kCullRange ? frame.rangeMax : std::numeric_limits<double>::infinity();
}

uint64_t farthestEntries(const gpu::Frame& frame) {
  const auto entries = [&](uint64_t columns, uint64_t rows) {
    return (frame.columns + columns - 1) / columns * ((frame.rows + rows - 1) / rows);
  };
  return entries(gpu::kFineColumns, gpu::kFineRows) + entries(gpu::kCoarseColumns, gpu::kCoarseRows);
}

uint64_t projectedCount(const gpu::Counters& counters) {
  return uint64_t{counters.projectedSmall} + counters.projectedLarge;
}

uint64_t projectedGuess(uint64_t beams, uint64_t triangles) {
  return std::min(triangles, std::clamp(beams / kBeamsPerProjected, kLeastProjected, kMostProjected));
}

// Only large boxes are cut into tiles, and some boxes lie in more than one slab.
uint64_t tileGuess(uint32_t binning, uint64_t projected) {
  return binning == gpu::kBinningSlabs ? projected / 2 : kFirstTiles;
}

uint64_t tileBytes(uint32_t binning, uint64_t projected, uint64_t tiles) {
  return ((binning == gpu::kBinningSlabs ? projected : 0) + tiles) * 4 * sizeof(uint32_t);
}

uint64_t slabCount(const gpu::Frame& frame) {
  return ((frame.columns - 1) >> frame.slabShift) + 1;
}

uint64_t grown(uint64_t needed, uint64_t limit) {
  return std::min(needed + needed / 8, std::max(needed, limit));
}

}  // namespace gnosphere
