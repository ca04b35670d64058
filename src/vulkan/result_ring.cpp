// SPDX-License-Identifier: Apache-2.0
#include "vulkan/result_ring.hpp"

#include "gnosphere/error.hpp"

namespace gnosphere::vulkan {

VulkanRing::Slot::Slot(const Device& device, uint64_t bytes, uint64_t hostBytes)
    : results(Buffer::exported(device, kResultsName, bytes)), commands(device) {
  if (!results.mapped()) copy = Buffer::staging(device, hostBytes, true);
}

VulkanRing::VulkanRing(const Device& device, std::atomic<bool>& failed, size_t buffers, uint64_t bytes,
                       uint64_t hostBytes)
    : device_(device), failed_(failed), hostBytes_(hostBytes) {
  while (slots_.size() < buffers) slots_.emplace_back(device, bytes, hostBytes);
}

template <typename Call>
void VulkanRing::watched(const Call& call) {
  try {
    call();
  } catch (...) {
    failed_ = true;
    throw;
  }
}

void* VulkanRing::begin(size_t buffer) {
  Commands& commands = slots_[buffer].commands;
  watched([&] { commands.begin(0); });
  return commands.buffer().handle();
}

void VulkanRing::submit(size_t buffer) {
  Slot& slot = slots_[buffer];
  if (slot.copy.handle()) {
    slot.commands.buffer().copy(slot.results, slot.copy, {0, 0, hostBytes_});
    slot.commands.buffer().barrier();
  }
  watched([&] { slot.commands.submit(); });
}

void VulkanRing::wait(size_t buffer) {
  Slot& slot = slots_[buffer];
  watched([&] { slot.commands.wait(); });
  slot.onHost().invalidate();
}

const std::byte* VulkanRing::host(size_t buffer) const {
  return static_cast<const std::byte*>(slots_[buffer].onHost().mapped());
}

bool VulkanRing::hostHasAll() const {
  const Slot& slot = slots_.front();
  return !slot.copy.handle() || hostBytes_ >= slot.results.bytes();
}

std::pair<int, uint64_t> VulkanRing::fd(size_t buffer) const {
  if (!device_.capabilities().exportsMemory)
    throw Error(ErrorCode::device, "the device '" + device_.capabilities().info.name +
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
