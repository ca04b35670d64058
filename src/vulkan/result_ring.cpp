// SPDX-License-Identifier: Apache-2.0
#include "vulkan/result_ring.hpp"

#include <algorithm>

#include "gnosphere/error.hpp"

namespace gnosphere::vulkan {

VulkanRing::Slot::Slot(const Device& device, uint64_t bytes, uint64_t hostBytes)
    : results(Buffer::exported(device, kResultsName, bytes)), commands(device) {
  if (!results.mapped()) copy = Buffer::staging(device, hostBytes, true);
}

VulkanRing::VulkanRing(const Device& device, size_t buffers, uint64_t bytes, uint64_t hostBytes)
    : device_(device), hostBytes_(hostBytes) {
  while (slots_.size() < buffers) slots_.emplace_back(device, bytes, hostBytes);
}

void VulkanRing::begin(size_t buffer) {
  Slot& slot = slots_[buffer];
  slot.commands.begin(0);
  if (slot.givenAway) slot.commands.buffer().takeBack(slot.results);
}

void VulkanRing::submit(size_t buffer, uint64_t bytes) {
  Slot& slot = slots_[buffer];
  if (slot.copy.handle()) {
    slot.commands.buffer().copy(slot.results, slot.copy, {0, 0, std::min(bytes, hostBytes_)});
    slot.commands.buffer().barrier();
  }
  const bool giveAway = device_.capabilities().exportsMemory;
  if (giveAway) slot.commands.buffer().giveAway(slot.results);
  slot.commands.submit();
  slot.givenAway = giveAway;
}

void VulkanRing::wait(size_t buffer) {
  Slot& slot = slots_[buffer];
  slot.commands.wait();
  slot.onHost().invalidate();
}

const std::byte* VulkanRing::host(size_t buffer) const {
  return static_cast<const std::byte*>(slots_[buffer].onHost().mapped());
}

bool VulkanRing::hostHasAll(size_t buffer) const {
  const Slot& slot = slots_[buffer];
  return !slot.copy.handle() || hostBytes_ >= slot.results.bytes();
}

uint64_t VulkanRing::bytes() const {
  uint64_t sum = 0;
  for (const Slot& slot : slots_) sum += slot.results.bytes() + (slot.copy.handle() ? slot.copy.bytes() : 0);
  return sum;
}

std::pair<int, uint64_t> VulkanRing::fd(size_t buffer) const {
  const Capabilities& capabilities = device_.capabilities();
  if (!capabilities.exportsMemory)
    throw Error(ErrorCode::device, "the device '" + capabilities.info.name +
                                       "' does not export memory as file descriptors (VK_KHR_external_memory_fd)");
  return slots_[buffer].results.fd();
}

std::pair<uint64_t, int> VulkanRing::cudaAddress(size_t buffer) {
  Slot& slot = slots_[buffer];
  if (!slot.cuda) {
    const DeviceInfo& info = device_.capabilities().info;
    const int number = cudaNumberOf(info);
    const auto [fd, bytes] = this->fd(buffer);
    slot.cuda = std::make_unique<CudaMemory>(info, number, fd, bytes);
  }
  return {slot.cuda->address(), slot.cuda->device()};
}

}  // namespace gnosphere::vulkan
