// SPDX-License-Identifier: Apache-2.0
#include "pipeline/outputs.hpp"

namespace gnosphere {

std::vector<Output> outputsOf(const SensorPlan& plan, bool words) {
  std::vector<Output> outputs;
  if (words) outputs.push_back({gpu::Array::words, 2 * sizeof(uint32_t)});
  if (plan.panes()) outputs.push_back({gpu::Array::hardBeams, sizeof(uint32_t)});
  if (words && !plan.panes()) return outputs;
  const uint32_t four = plan.returns * sizeof(gpu::vec4), two = plan.returns * 2 * sizeof(uint32_t);
  outputs.insert(outputs.end(), {{gpu::Array::points, four}, {gpu::Array::owners, two}});
  if (plan.asks(gpu::kFieldSignal)) outputs.push_back({gpu::Array::signals, four});
  if (plan.asks(gpu::kFieldSurface)) outputs.push_back({gpu::Array::surfaces, four});
  if (plan.speeds()) outputs.push_back({gpu::Array::motions, four});
  if (plan.asks(gpu::kFieldBarycentrics)) outputs.push_back({gpu::Array::barycentrics, two});
  return outputs;
}

}  // namespace gnosphere
