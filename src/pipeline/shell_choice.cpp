// SPDX-License-Identifier: Apache-2.0
#include "pipeline/shell_choice.hpp"

#include <algorithm>

#include "pipeline/machine.hpp"
#include "pipeline/scan_options.hpp"

namespace gnosphere {
namespace {

// The occlusion test reads every beam; that pays from this many triangles per beam and in all.
constexpr double kTrianglesPerBeam = 0.125;
constexpr uint64_t kShellTriangles = 30'000;
// The first shell has so many clusters. The farthest-range table that follows a shell costs time per beam, yet sensors
// of more beams gain nothing from a larger first shell, which has no table: with 18,000 clusters, scans of 4.6 million
// beams took 0.98 to 1.07 of the time in four scenes. With an HDL-64E, twice and half as many took the same time within
// 3 %. Of a small scene the first shell holds at most one cluster in kFirstShare. Without that limit it would hold most
// of the scene, and scans took 1.25 of the time in scenes of 50,000 to 500,000 triangles.
constexpr uint64_t kFirstShellClusters = 1024, kFirstShare = 16;
// Shells cost several views no more than one, so the first shell may be small. With 128 clusters per view in a town of
// 300,000 triangles and 5,760 beams per view the scans took 0.93 of the time that they took with 590, a sixteenth of
// all clusters.
constexpr uint32_t kFirstShellClustersOfView = 128;
// Each shell is four dispatches that wait for one another, and on a graphics card a scan is little but their latency.
// On an H100 scans of an OS1-64 and an Alpha-Prime with two shells took 0.89 and 0.91 of the time with three in a town
// of 300,000 triangles, and 0.92 and 0.90 in a street of 1.8 million, where four shells took 1.11 and 1.06 of it.
constexpr uint32_t kShellsOfGpu = 2;
// A CPU device has so many shells that the last one has room for a whole scene whose clusters are half full. One more
// shell is spare, because the range of the last scan's returns ends one shell early. With 14 shells in place of 8 scans
// of a forest of 300 million triangles took 0.54 of the time by an OS1-64 with its effects, and 0.67 without effects.
constexpr uint32_t kLeastShells = 2;
constexpr uint64_t kLeastTrianglesOfCluster = gpu::kClusterTriangles / 2;
// In a smaller scene a CPU device looks at the boxes that the beams of one shell lie in. Walls of 6 m that stood across
// each other in a room had 7 to 700 boxes per beam, and scans of 108 to 28,800 beams took 0.2 to 0.9 of the time with
// three shells from these limits on; below them, and in towns, which had 1 to 4 boxes per beam, up to 2.4 of it. Five
// shells took 0.9 to 1.2 of the time of three. Where shells leave few boxes, there may be few without shells, too.
constexpr double kOverlapThatPays = 12, kOverlapInAll = 400'000, kOverlapOfShells = 2;
constexpr uint32_t kShellsOfOverlap = 3;

}  // namespace

// With lists every hit of a beam is needed, so no triangle may be skipped as hidden.
ShellChoice::ShellChoice(const SimulatorOptions& options, const Traits& traits, uint32_t binning, uint64_t beams)
    : beams_(beams),
      cpu_(traits.cpu),
      possible_(binning != gpu::kBinningLists && (cullingBits(options) & gpu::kCullOccluded) != 0),
      always_(options.tuning.culling.occlusion == Culling::Occlusion::always),
      learns_(possible_ && cpu_ && binning == gpu::kBinningSlabs) {}

void ShellChoice::setTriangles(uint64_t triangles) {
  triangles_ = triangles;
  choose();
}

void ShellChoice::learn(const gpu::Counters& counters, size_t views, uint32_t shells) {
  if (!learns_) return;
  const double boxed = counters.boxedBeams,
               overlap = boxed / (static_cast<double>(beams_) * static_cast<double>(views));
  const bool pays = overlap >= kOverlapThatPays && boxed * overlap >= kOverlapInAll;
  if (shells == 1 && pays)
    overlaps_ = true;
  else if (shells > 1 && overlap <= kOverlapOfShells)
    overlaps_ = false;
  choose();
}

// The two shells of a graphics card do not grow from one cluster to a whole scene.
void ShellChoice::choose() {
  const bool many = triangles_ >= kShellTriangles &&
                    static_cast<double>(triangles_) >= kTrianglesPerBeam * static_cast<double>(beams_);
  firstClusters_ = always_ && cpu_ ? 1
                                   : static_cast<uint32_t>(std::clamp<uint64_t>(
                                         triangles_ / gpu::kClusterTriangles / kFirstShare, 1, kFirstShellClusters));
  if (!possible_ || !(many || overlaps_ || always_)) {
    count_ = 1;
  } else if (!cpu_) {
    count_ = kShellsOfGpu;
  } else if (!(many || always_)) {
    count_ = kShellsOfOverlap;
  } else {
    count_ = kLeastShells;
    for (uint64_t clusters = firstClusters_;
         clusters * kLeastTrianglesOfCluster < triangles_ && count_ < gpu::kMostShells; ++count_)
      clusters *= gpu::kShellGrowth;
  }
}

uint32_t ShellChoice::firstClusters(uint32_t views) const {
  return views > 1 ? views * std::min(firstClusters_, kFirstShellClustersOfView) : firstClusters_;
}

}  // namespace gnosphere
