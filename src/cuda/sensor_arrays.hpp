// SPDX-License-Identifier: Apache-2.0
// What one sensor has on a CUDA device: its tables and the work arrays of a scan.
#pragma once

#include <array>

#include "beam_tables.hpp"
#include "cuda/runtime.hpp"

namespace gnosphere::cuda {

using Pair = std::array<uint32_t, 2>;

class SensorArrays {
 public:
  SensorArrays(const Sensor& sensor, const SimulatorOptions& options, uint32_t way, uint64_t triangles);

  const gpu::Frame& frame() const { return tables_.frame; }
  bool azimuthOffsets() const { return tables_.azimuthOffsets; }
  double reach() const { return reach_; }
  float shellBorder() const { return shellBorder_; }

  /// Binds everything but what is placed, with nothing counted and no beam met.
  void prepare(uint32_t instanceCount, Job& job);
  gpu::Counters counters() const { return counters_.read(0, 1)[0]; }
  /// Makes room for what a scan has counted; false where there was enough.
  bool grow(const gpu::Counters& needed);
  std::vector<gpu::vec4> points() const { return points_.read(0, tables_.frame.beams); }
  std::vector<Pair> owners() const { return owners_.read(0, tables_.frame.beams); }
  void addTo(MemoryUse& use) const;

 private:
  void growProjected(uint64_t count);

  uint32_t way_;
  BeamTables tables_;
  double reach_;
  float shellBorder_;
  Array<gpu::Row> rows_;
  Array<uint32_t> rowLookup_;
  Array<float> columns_;
  Array<gpu::Frame> frame_;
  Array<gpu::Counters> counters_;
  Array<uint32_t> farthest_;
  Array<gpu::vec4> projectedA_, projectedB_, projectedC_;
  Array<gpu::vec2> projectedColumns_;
  Array<std::array<uint32_t, 4>> tiles_;
  Array<uint64_t> words_;
  Array<uint32_t> listEnds_, blockSums_, candidates_;
  Array<gpu::vec4> points_;
  Array<Pair> owners_;
};

}  // namespace gnosphere::cuda
