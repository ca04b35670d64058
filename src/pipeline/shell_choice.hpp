// SPDX-License-Identifier: Apache-2.0
// In how many shells the scans of a sensor run. Triangles of nearer shells are binned first, so that they can hide
// those of farther shells; but each shell costs dispatches, and a look at all beams.
#pragma once

#include <cstdint>

#include "common/shared.h"
#include "gnosphere/simulator.hpp"

namespace gnosphere {

struct Traits;

/// Chooses the number of shells for each submission of a sensor.
class ShellChoice {
 public:
  /// `binning` is a gpu::kBinning... value, and `beams` the number of beams that are projected at once.
  ShellChoice(const SimulatorOptions& options, const Traits& traits, uint32_t binning, uint64_t beams);
  /// Tells how many triangles the scene places.
  void setTriangles(uint64_t triangles);
  /// Learns from a submission of some views that it has counted, with the number of shells it ran in.
  void learn(const gpu::Counters& counters, size_t views, uint32_t shells);

  /// Number of shells of the next submission, at most kMostShells.
  uint32_t count() const { return count_; }
  /// How many clusters the first shell of a submission should hold. Each further shell should hold kShellGrowth times
  /// as many as the shell before it.
  uint32_t firstClusters(uint32_t views) const;

 private:
  void choose();

  uint64_t beams_;
  bool cpu_, possible_, always_;
  bool learns_;            // whether scans count the beams of boxes
  bool overlaps_ = false;  // whether so many boxes lie over each other that shells pay
  uint64_t triangles_ = 0;
  uint32_t count_ = 1, firstClusters_ = 1;
};

}  // namespace gnosphere
