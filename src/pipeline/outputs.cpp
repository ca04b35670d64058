// SPDX-License-Identifier: Apache-2.0
#include "pipeline/outputs.hpp"

#include <algorithm>

namespace gnosphere {

std::vector<Output> outputsOf(const SensorPlan& plan, bool words) {
  if (words) return {{gpu::kBindWords, 2 * sizeof(uint32_t)}};
  const uint32_t four = plan.returns * sizeof(gpu::vec4), two = plan.returns * 2 * sizeof(uint32_t);
  std::vector<Output> outputs = {{gpu::kBindPoints, four}, {gpu::kBindOwners, two}};
  if (plan.asks(gpu::kFieldSignal)) outputs.push_back({gpu::kBindSignals, four});
  if (plan.asks(gpu::kFieldSurface)) outputs.push_back({gpu::kBindSurfaces, four});
  if (plan.speeds()) outputs.push_back({gpu::kBindMotions, four});
  if (plan.asks(gpu::kFieldBarycentrics)) outputs.push_back({gpu::kBindBarycentrics, two});
  return outputs;
}

uint64_t mostBytesPerBeam(const SensorPlan& plan) {
  uint64_t most = sizeof(uint64_t);  // a word
  for (const Output& output : outputsOf(plan, false)) most = std::max<uint64_t>(most, output.bytesPerBeam);
  return plan.footprint() ? std::max<uint64_t>(most, gpu::kMaxEchoes * sizeof(gpu::vec4)) : most;
}

}  // namespace gnosphere
