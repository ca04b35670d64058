// SPDX-License-Identifier: Apache-2.0
// What the options of a simulator mean for the kernels of a scan, on whatever device.
#pragma once

#include <cstddef>
#include <vector>

#include "effects/sensor_plan.hpp"
#include "gnosphere/simulator.hpp"
#include "shared.h"

namespace gnosphere {

Exactness exactnessOf(const SimulatorOptions& options);
/// gpu::kCull... bits.
uint32_t cullingBits(const SimulatorOptions& options);
/// gpu::kWay...: how the options, the device and what is planned bin.
uint32_t chooseBinning(const SimulatorOptions& options, bool int64Atomics, bool cpu, const SensorPlan& plan);
/// Whether words are all that is read back, for the host to resolve: 8 bytes per beam, where nothing but geometry is
/// planned.
bool leavesWords(uint32_t binning, const SensorPlan& plan);
/// As Plan::binning names it.
const char* nameOfBinning(uint32_t binning);
/// Metres, the last one infinity: shell by shell is binned, and hides what lies behind it. One shell is everything.
std::vector<float> shellEnds(const SimulatorOptions& options, uint32_t binning, const gpu::Frame& frame,
                             uint64_t triangles);
/// Metres: instances farther away need not be looked at.
double reachOf(const SimulatorOptions& options, const gpu::Frame& frame);
/// Counters from visibleGroups on: set back for each chunk of a shell, and for each shell.
constexpr uint64_t kPerChunkBytes = offsetof(gpu::Counters, laterRowsDown) - offsetof(gpu::Counters, visibleGroups);
constexpr uint64_t kPerShellBytes = offsetof(gpu::Counters, causes) - offsetof(gpu::Counters, visibleGroups);
/// Entries of the table of what hides, of both levels.
uint64_t farthestEntries(const gpu::Frame& frame);
/// Triangles that a scan has projected, or would have with more room.
uint64_t projectedCount(const gpu::Counters& counters);
/// Room for projected triangles to begin with; growth makes room for what a scan turns out to need.
uint64_t projectedGuess(uint64_t beams, uint64_t triangles);
/// Room for tiles to begin with, by the way of binning, and the size of their array: with slabs each projected triangle
/// has one beside them.
uint64_t tileGuess(uint32_t binning, uint64_t projected);
uint64_t tileBytes(uint32_t binning, uint64_t projected, uint64_t tiles);
/// Slabs of columns that a sensor has.
uint64_t slabCount(const gpu::Frame& frame);
/// Room for `needed` entries of a list and some more, within a limit.
uint64_t grown(uint64_t needed, uint64_t limit);

}  // namespace gnosphere
