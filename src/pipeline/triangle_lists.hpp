// SPDX-License-Identifier: Apache-2.0
// The lists of triangles that the stages of a sensor's scans fill.
#pragma once

#include "common/shared.h"
#include "effects/sensor_plan.hpp"
#include "pipeline/array_table.hpp"
#include "pipeline/tuning.hpp"

namespace gnosphere {

/// Lists of projected triangles, of tiles and of candidates. A scan counts the entries that it needs; if a list is too
/// small, it grows, and the scan runs again. No submission may be running while the lists change.
class TriangleLists {
 public:
  /// Allocates the lists for a sensor with so many beams and a scene with so many triangles.
  TriangleLists(Machine& machine, const SensorPlan& plan, uint32_t binning, uint32_t beams, uint64_t triangles);

  const Capacities& capacities() const { return capacities_; }
  const ArrayTable& arrays() const { return arrays_; }
  /// Returns the size of lists with these capacities.
  uint64_t bytesOf(const Capacities& room) const;

  /// Makes room by estimate for a submission of so many views.
  void makeRoomForViews(uint32_t views);
  /// Makes the array with the view of each projected triangle, if it is not there or too small.
  void numberViews();
  /// Returns whether one of the lists, which had these capacities, was too small for a scan.
  static bool cutShort(const gpu::Counters& needed, const Capacities& had);
  /// Grows the lists that were too small for a scan.
  void grow(gpu::Counters needed);
  /// Grows the lists to those of a sensor with another plan of the same scene, whose scans they have held.
  void growAs(const TriangleLists& other);
  /// Tells that lists of these capacities were large enough for a submission of so many views, in which sensor or
  /// instances moved or none did.
  void noteEnough(const Capacities& had, size_t views, bool moved);
  /// Whether the lists, as they are now, were large enough for a submission like this one.
  bool hadEnough(size_t views, bool moves) const { return views <= (moves ? movingViewsThatFit_ : viewsThatFit_); }

 private:
  uint64_t limit(uint64_t entryBytes) const;
  uint64_t mostProjected() const;
  uint64_t candidateBytes() const;
  uint64_t mostCandidates() const;
  uint64_t tilesBehind(const Capacities& room) const;
  void resize(const Capacities& room);

  Machine& machine_;
  const SensorPlan& plan_;
  uint32_t binning_, beams_;
  Capacities first_;  // of a scan of one view
  Capacities capacities_;
  ArrayTable arrays_;
  size_t viewsThatFit_ = 0, movingViewsThatFit_ = 0;  // see hadEnough()
};

}  // namespace gnosphere
