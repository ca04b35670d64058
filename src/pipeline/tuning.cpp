// SPDX-License-Identifier: Apache-2.0
#include "pipeline/tuning.hpp"

#include <algorithm>

#include "base/threads.hpp"
#include "pipeline/machine.hpp"
#include "pipeline/scan_options.hpp"

namespace gnosphere {
namespace {

// EACH_RAY of each_ray.glsl has code for one and for two places, and then for seven.
constexpr uint32_t kMostRaysPerLane = 2;
// Measured on town scenes: one projected triangle per 8 beams of an HDL-64E; sensors with more beams have fewer per
// beam.
constexpr uint64_t kBeamsPerProjected = 8, kLeastProjected = 1 << 14, kMostProjected = 1 << 18;
// Footprints reach triangles between the beams, too. In ten scenes an OS1-64 projected 0.2 to 7 triangles per beam and
// an Alpha-Prime 0.03 to 2.5; in a town they projected 1.1 and 0.5. A triangle had 0.7 to 8 links, and one of 200 to
// one of 2 triangles was cut into tiles.
constexpr uint64_t kProjectedPerBeam = 2, kMostProjectedPerBeam = 7, kLinksPerProjected = 3, kProjectedPerTile = 2;
// A moving triangle may have several boxes, one for each interval of the scan. A list that holds this many boxes rarely
// makes the first moving scan of a few dozen triangles run twice.
constexpr uint64_t kLeastBoxes = 1024;
// Most triangles of small views need no room, because stage project tries them at once; and views share the room.
constexpr uint64_t kLeastProjectedOfView = 32;
constexpr uint32_t kFirstTiles = 1 << 12;
constexpr uint64_t kCandidatesPerBeam = 2, kBeamsPerPane = 8, kLinksPerBeam = 4;
// Beams that one submission scans together. Measured on two CPU cores in a town of 300,000 triangles with 5,760 beams
// per view: 8, 16, 45 and 180 views together took 1.8, 1.3, 1.3 and 1.3 ms per view, and single scans 6.9 ms.
constexpr uint64_t kBeamsTogetherOnCpu = 1 << 18, kBeamsTogether = 1 << 23, kMostViews = 4096;
// Bytes of the lists of instances, groups and clusters of one submission.
constexpr uint64_t kListBytesOnCpu = uint64_t{256} << 20, kListBytes = uint64_t{1} << 30;
// Work of one submission of a device that draws a desktop, too. Not measured on a card: slow ones are thought to do a
// hundred million lines of light a second, and drivers to wait for some seconds.
constexpr uint64_t kMostWork = 1 << 26;
// Measured on town scenes with two threads: slabs of 64 columns take 1.03 and slabs of 32 take 1.07 of the time of
// slabs of 128; 256 are no faster. kSlabsPerThread slabs per thread balance the work well enough.
constexpr uint32_t kLargestSlabShift = 7, kLeastSlabShift = 4, kSlabsPerThread = 8;

}  // namespace

// A software device runs neighbouring workgroups on one thread: eight groups per thread, with shares from all parts of
// the work (see dealt.glsl), spread uneven work over the threads, and four times as many took 1.05 of the time. Boxes
// and entries of a table are alike, so few groups are balanced: 64 of them on two threads took 1.04 of all of
// `project`. Where subgroups take work from a shared counter until it is empty, one workgroup per thread is enough, and
// more only poll.
DispatchSizes dispatchSizesOf(const Traits& traits) {
  if (!traits.cpu) return {traits.workgroups, traits.workgroups, traits.workgroups, 8 * traits.workgroups};
  const uint32_t threads = threadCount(), groups = std::max(64u, 8 * threads);
  return {groups, 4 * threads, threads, 8 * groups};
}

uint32_t chooseBinning(const SimulatorOptions& options, const Traits& traits, bool footprint) {
  if (!traits.int64Atomics) return gpu::kBinningLists;
  bool slabs = traits.cpu;
  switch (options.tuning.binning) {
    case Binning::lists: return gpu::kBinningLists;
    case Binning::automatic:
      // The paper collects candidates per beam in lists.
      if (accuracyPartsOf(options).bounds == AccuracyParts::Bounds::paper) return gpu::kBinningLists;
      break;
    case Binning::slabs: slabs = true; break;
    case Binning::nearest: slabs = false; break;
  }
  // Footprints are chained with atomics anyway, and most of their boxes are too small for a subgroup.
  return slabs && !footprint ? gpu::kBinningSlabs : gpu::kBinningNearest;
}

uint32_t raysPerLane(const SimulatorOptions& options, const Traits& traits, uint32_t rays) {
  const uint32_t lanes = traits.info.subgroupSize;
  const SubRays choice = options.tuning.subRays;
  const bool wanted = choice == SubRays::lanes || (choice == SubRays::automatic && !traits.cpu);
  if (!wanted || !traits.spreadsRays || rays <= 1 || rays > kMostRaysPerLane * lanes) return 0;
  return (rays + lanes - 1) / lanes;
}

uint32_t slabShift(uint32_t columns) {
  const uint32_t threads = threadCount();
  uint32_t shift = kLargestSlabShift;
  while (shift > kLeastSlabShift && columns >> shift < kSlabsPerThread * threads) --shift;
  return shift;
}

uint32_t slabShiftOfViews() {
  return kLargestSlabShift;
}

uint64_t mostListBytes(const SimulatorOptions& options, const Traits& traits) {
  if (options.tuning.maxBatchBytes > 0) return options.tuning.maxBatchBytes;
  return traits.cpu ? kListBytesOnCpu : kListBytes;
}

uint32_t mostViews(const Traits& traits, uint64_t beams) {
  const uint64_t together = traits.cpu ? kBeamsTogetherOnCpu : kBeamsTogether;
  return static_cast<uint32_t>(std::clamp<uint64_t>(together / std::max<uint64_t>(beams, 1), 1, kMostViews));
}

uint32_t firstProjectedOfView(uint64_t beams) {
  return static_cast<uint32_t>(std::clamp<uint64_t>(beams / kBeamsPerProjected, kLeastProjectedOfView, kMostProjected));
}

uint64_t mostWork(const SimulatorOptions& options, const Traits& traits) {
  if (options.tuning.maxSubmissionWork > 0) return options.tuning.maxSubmissionWork;
  return traits.cpu ? 0 : kMostWork;
}

// Only large boxes are cut into tiles; with slabs also those that lie in more than one slab.
Capacities firstCapacities(uint32_t binning, bool panes, bool footprint, uint64_t beams, uint64_t triangles) {
  const uint64_t ofBeams = footprint ? beams * kProjectedPerBeam : beams / kBeamsPerProjected;
  const auto projected = static_cast<uint32_t>(
      std::min(std::max(triangles, kLeastBoxes), std::clamp(ofBeams, kLeastProjected, kMostProjected)));
  const uint64_t candidates = binning == gpu::kBinningLists ? beams * kCandidatesPerBeam
                              : footprint                   ? beams * kLinksPerBeam
                              : panes                       ? beams / kBeamsPerPane
                                                            : 0;
  const uint32_t tiles = footprint ? projected / kProjectedPerTile : kFirstTiles;
  return {projected, std::max(binning == gpu::kBinningSlabs ? projected / 2 : tiles, kFirstTiles),
          static_cast<uint32_t>(std::min<uint64_t>(candidates, 0xffffffff))};
}

Capacities mostOfFootprints(uint64_t beams) {
  return leastWithFootprints(beams * kMostProjectedPerBeam);
}

Capacities leastWithFootprints(uint64_t projected) {
  const auto within = [](uint64_t count) { return static_cast<uint32_t>(std::min<uint64_t>(count, 0xffffffff)); };
  return {within(projected), within(projected / kProjectedPerTile), within(projected * kLinksPerProjected)};
}

}  // namespace gnosphere
