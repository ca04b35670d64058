// SPDX-License-Identifier: Apache-2.0
// The step of a recorded scan that places instances by transforms in buffers of the caller.
#pragma once

#include <vector>

#include "geometry/instance_table.hpp"
#include "pipeline/array_table.hpp"

namespace gnosphere {

/// The arrays of this step for one run of the stages in one frame in flight.
class RecordedTransforms {
 public:
  /// Compiles the kernel `place_instances` in advance.
  static void prepare(Machine& machine);
  /// Writes and binds the arrays for a sensor at `pose`, and returns the steps. There are none, and no arrays, if no
  /// transform lies in a buffer.
  std::vector<Step> steps(Machine& machine, const InstanceTable& instances, const Pose& pose, BoundArrays& arrays);
  /// How many instances the last recorded run did not place, because their transforms are not finite; the run has
  /// completed.
  uint32_t unplaced();
  uint64_t bytes() const { return arrays_.bytes(); }

 private:
  ArrayTable arrays_;
  bool recorded_ = false;
};

}  // namespace gnosphere
