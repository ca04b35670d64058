// SPDX-License-Identifier: Apache-2.0
#include "rivals/cuda.hpp"

#include <algorithm>

#include "gnosphere/error.hpp"

namespace gnosphere::bench {
namespace {

bool same(const DeviceInfo& vulkan, const DeviceInfo& cuda) {
  constexpr decltype(DeviceInfo::uuid) kUntold = {};
  if (vulkan.uuid != kUntold && cuda.uuid != kUntold) return vulkan.uuid == cuda.uuid;
  return cuda.name.ends_with(" " + vulkan.name);  // CUDA names begin with "cuda:0"
}

}  // namespace

size_t sameCard(const DeviceInfo& vulkan, const std::vector<DeviceInfo>& cuda, const std::string& problem) {
  const auto refuse = [](const std::string& why) { throw Error(ErrorCode::device, "cuda: " + why); };
  if (cuda.empty()) refuse(problem);
  const auto found = std::find_if(cuda.begin(), cuda.end(), [&](const DeviceInfo& card) { return same(vulkan, card); });
  if (found == cuda.end()) refuse("no CUDA device is the card '" + vulkan.name + "'");
  if (!found->usable) refuse(found->name + " cannot be used: " + found->reason);
  return static_cast<size_t>(found - cuda.begin());
}

}  // namespace gnosphere::bench
