// SPDX-License-Identifier: Apache-2.0
#include "floor.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <memory>

#include "console.hpp"
#include "rivals/vulkan_copy.hpp"
#include "rivals/workers.hpp"

namespace gnosphere::bench {
namespace {

/// Least traffic per beam: a word of 8 bytes is written and read, 24 bytes of results are written.
constexpr double kBeamBytes = 8 + 8 + 24;
/// Operations per triangle: three corners are transformed (9 multiplications, 9 additions, 3 subtractions each), and
/// the facing side is determined (8, Table 1 of the paper).
constexpr double kTriangleOperations = 3 * 21 + 8;
/// Operations per hit: one inside test (15) and one range (9), of Table 1.
constexpr double kHitOperations = 15 + 9;

constexpr int kRounds = 5;

double copyRate(Workers& workers) {
  constexpr size_t kBlock = size_t{4} << 20, kBlocks = 64;
  const auto from = std::make_unique<char[]>(kBlock * kBlocks), to = std::make_unique<char[]>(kBlock * kBlocks);
  double best = 0;
  for (int round = 0; round <= kRounds; ++round) {  // the first round also allocates the memory
    const double start = cli::nowMs();
    workers.run(kBlocks,
                [&](size_t block) { std::memcpy(to.get() + block * kBlock, from.get() + block * kBlock, kBlock); });
    best = std::max(best, 2.0 * kBlock * kBlocks / (cli::nowMs() - start));
  }
  return best;
}

/// A vector as wide as the widest vector units; narrower ones process it in parts.
using Wide = float __attribute__((vector_size(64)));
constexpr size_t kChains = 8;  ///< independent sums, so that no unit waits for a result

float multiplyAndAdd(size_t steps, float seed) {
  const Wide factor = Wide{} + 0.999f, term = Wide{} + seed;
  Wide chains[kChains] = {};
  for (size_t step = 0; step < steps; ++step)
    for (Wide& chain : chains) chain = chain * factor + term;
  Wide sum = {};
  for (const Wide& chain : chains) sum += chain;
  return sum[0];
}

double operationRate(Workers& workers) {
  constexpr size_t kTasks = 64, kSteps = 50'000;
  std::array<float, kTasks> sums;
  double best = 0;
  for (int round = 0; round < kRounds; ++round) {
    const double start = cli::nowMs();
    workers.run(kTasks, [&](size_t task) { sums[task] = multiplyAndAdd(kSteps, static_cast<float>(task)); });
    constexpr double kOperations = 2.0 * sizeof(Wide) / sizeof(float) * kChains * kSteps * kTasks;
    best = std::max(best, kOperations / (cli::nowMs() - start));
  }
  volatile float seen = sums[0];  // keeps the compiler from removing the computation
  static_cast<void>(seen);
  return best;
}

}  // namespace

Rates ratesOf(const DeviceInfo& device, const std::string& name) {
  if (device.type != "cpu") return {vulkanCopyRate(name), 0};
  Workers workers;
  return {copyRate(workers), operationRate(workers)};
}

Floor floorOf(const Counters& counters, const MemoryUse& memory, uint64_t uniqueTriangles, const Rates& rates) {
  Floor floor;
  const double visible = static_cast<double>(counters.triangles - counters.culledByCluster - counters.reused);
  const double unique = static_cast<double>(uniqueTriangles);
  const double triangleBytes = unique > 0 ? static_cast<double>(memory.scene) / unique : 0;
  floor.bytes = std::min(visible, unique) * triangleBytes + kBeamBytes * static_cast<double>(counters.beams);
  floor.operations = visible * kTriangleOperations + static_cast<double>(counters.hits) * kHitOperations;
  if (rates.bytesPerMs > 0) floor.ms = floor.bytes / rates.bytesPerMs;
  if (rates.operationsPerMs > 0) floor.ms = std::max(floor.ms, floor.operations / rates.operationsPerMs);
  return floor;
}

}  // namespace gnosphere::bench
