// SPDX-License-Identifier: Apache-2.0
// One call that records scans into a command buffer of the caller or of a stream of batches.
#pragma once

#include <functional>
#include <vector>

#include "gnosphere/simulator.hpp"
#include "pipeline/result_ring.hpp"
#include "scan/class_table.hpp"

namespace gnosphere {

struct Recording {
  /// Device memory of the caller, or of a result buffer.
  struct Range {
    uint64_t address = 0, bytes = 0;
  };
  struct Item {
    const Shot* shot;
    Range records, header;
  };
  /// Outcome of a scan that was recorded before.
  struct Result {
    size_t sensor;
    uint64_t frame;
    bool complete;
    uint32_t nonFinite, degenerate;  // triangles that were left out of meshes with vertices of the caller
    uint32_t unplaced;               // instances whose transforms in a buffer of the caller are not finite
  };

  /// The command buffer of the caller, or the buffers of a BatchStream; both null: nothing is recorded, only checked
  /// whether the simulator can record at all.
  void* commands = nullptr;
  ResultRing* ring = nullptr;
  size_t frame = 0;  ///< in flight
  std::vector<Item> scans;
  const ClassTable* classes = nullptr;
  /// Set if the lists of a sensor may be too small, because no scans of so many views, or none in motion, have found
  /// them large enough since they were made.
  bool mayOverflow = false;
  std::vector<Result> results;  ///< of the scans recorded for this frame in flight the last time
  /// If given, makes room for so many results before anything is recorded. If it throws, the results are not lost.
  std::function<void(size_t count)> makeRoom;
};

}  // namespace gnosphere
