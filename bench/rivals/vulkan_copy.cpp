// SPDX-License-Identifier: Apache-2.0
#include "rivals/vulkan_copy.hpp"

#include <algorithm>

#include "rivals/vulkan.hpp"
#include "rivals/vulkan_device.hpp"

namespace gnosphere::bench {

double vulkanCopyRate(const std::string& name) try {
  constexpr uint64_t kBytes = uint64_t{256} << 20;
  RayDevice device({deviceByName(name)}, VK_KHR_RAY_QUERY_EXTENSION_NAME);
  const RayBuffer from(device, "copies", kBytes, MemoryKind::device);
  const RayBuffer to(device, "copies", kBytes, MemoryKind::device);
  const VkBufferCopy copy = {0, 0, kBytes};
  double best = 0;
  for (int round = 0; round < 10; ++round) {
    const double ms =
        device.run([&](VkCommandBuffer commands) { vkCmdCopyBuffer(commands, from.handle(), to.handle(), 1, &copy); });
    if (ms > 0) best = std::max(best, 2.0 * kBytes / ms);
  }
  return best;
} catch (const Error&) {
  return 0;
}

}  // namespace gnosphere::bench
