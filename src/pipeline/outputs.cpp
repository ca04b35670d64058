// SPDX-License-Identifier: Apache-2.0
#include "pipeline/outputs.hpp"

namespace gnosphere {

std::vector<Output> outputsOf(const SensorPlan& plan, bool words) {
  const uint32_t four = plan.returns * sizeof(gpu::vec4), two = plan.returns * 2 * sizeof(uint32_t);
  std::vector<Output> outputs;
  if (words)
    outputs = {{gpu::Array::words, 2 * sizeof(uint32_t)}};
  else
    outputs = {{gpu::Array::points, four}, {gpu::Array::owners, two}};
  if (words && plan.returns > 1 && (plan.computesReturns() || plan.panes()))
    outputs.push_back({gpu::Array::laterWords, (plan.returns - 1) * 2 * static_cast<uint32_t>(sizeof(uint32_t))});
  if (plan.asks(gpu::kFieldIntensity))
    outputs.push_back({gpu::Array::intensities, plan.returns * static_cast<uint32_t>(sizeof(float))});
  if (plan.asks(gpu::kFieldSignal))
    outputs.push_back({gpu::Array::signals, plan.returns * static_cast<uint32_t>(sizeof(gpu::SignalRecord))});
  if (plan.asks(gpu::kFieldSurface)) outputs.push_back({gpu::Array::surfaces, four});
  if (plan.speeds()) outputs.push_back({gpu::Array::motions, four});
  if (plan.asks(gpu::kFieldBarycentrics)) outputs.push_back({gpu::Array::barycentrics, two});
  return outputs;
}

}  // namespace gnosphere
