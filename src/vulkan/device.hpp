// SPDX-License-Identifier: Apache-2.0
// One Vulkan device with a compute queue, which several threads may use at once.
#pragma once

#include <algorithm>
#include <atomic>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "gnosphere/error.hpp"
#include "gnosphere/vulkan.hpp"
#include "vulkan/capabilities.hpp"
#include "vulkan/instance.hpp"
#include "vulkan/memory_blocks.hpp"

namespace gnosphere::vulkan {

/// Returns the index of the device that DeviceChoice::name or its UUID chooses. A number that is not an index is taken
/// as part of a name. Throws Error(invalidArgument) or Error(device) that lists every device with the reason why it was
/// refused.
size_t chooseDevice(const std::vector<DeviceInfo>& devices, const DeviceChoice& choice);
VkPhysicalDevice chooseDevice(const ApiInstance& instance, const DeviceChoice& choice);

class Device {
 public:
  /// Creates a device, or takes the caller's if `choice` holds an adopted one. With `statistics` its pipelines tell
  /// what the compiler has made of them, if the driver can.
  Device(const DeviceChoice& choice, bool validation, bool statistics = false);
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;
  ~Device();

  VkDevice handle() const { return adopted_ ? adopted_->device : device_.get(); }
  const DeviceFunctions& vk() const { return vk_; }
  const InstanceFunctions& instanceFunctions() const { return instanceFunctions_; }
  /// The caller's device that this is; null if it is our own.
  const AdoptedDevice* adopted() const { return adopted_.get(); }
  /// Creates an object from `info` with a function of vk(). Throws Error that names the source location of the call.
  template <typename T, typename Info>
  DeviceHandle<T> make(VkResult(VKAPI_PTR* create)(VkDevice, const Info*, const VkAllocationCallbacks*, T*),
                       typename DeviceHandle<T>::Destroy destroy, const Info& info, const char* file = __builtin_FILE(),
                       uint32_t line = __builtin_LINE()) const {
    T object = VK_NULL_HANDLE;
    check(create(handle(), &info, nullptr, &object), "making a Vulkan object", file, line);
    return {object, destroy, handle(), &hangs_};
  }
  VkPhysicalDevice physical() const { return physical_; }
  /// Submits to the queue of our own device. `number` gets that of the submission, which counts from 1.
  VkResult submit(const VkSubmitInfo& info, VkFence fence, uint64_t& number) const;
  /// Notes that a submission has ended, and with it all before it, because fences are signalled in order.
  void noteEnd(uint64_t number) const;
  /// Returns the number of submissions, up to this one, that are not known to have ended, and at least 1.
  uint64_t unendedUpTo(uint64_t number) const { return std::max<uint64_t>(number, ended_ + 1) - ended_; }
  /// Notes that a submission has failed, or the wait for one.
  void noteFailure() const { failed_ = true; }
  bool failed() const { return failed_; }
  /// The submissions that hang, see HangCount.
  HangCount& hangs() const { return hangs_; }
  const Capabilities& capabilities() const { return capabilities_; }
  uint64_t maxBufferBytes() const { return capabilities_.info.maxBufferBytes; }
  /// Whether pipelines are made with the statistics of the driver's compiler, such as registers and code size.
  bool statistics() const { return statistics_; }
  void throwOnMessages() const {
    if (instance_) instance_->throwOnMessages();
  }
  /// The validation messages of our own device.
  const std::shared_ptr<Messages>& messages() const { return instance_->messages(); }

  /// Returns the memory types in `typeBits`, best first: those with all properties of the first entry of `wanted`, then
  /// those with all of the second, and so on.
  std::vector<uint32_t> memoryTypes(uint32_t typeBits, std::span<const VkMemoryPropertyFlags> wanted) const;
  /// Returns the types of memory, and the heaps that they take it from.
  const VkPhysicalDeviceMemoryProperties& memory() const { return memory_; }
  bool isHostVisible(uint32_t memoryType) const;
  bool isLocal(uint32_t memoryType) const;
  bool isCoherent(uint32_t memoryType) const;
  /// The memory of all buffers on our own device, and of those on the caller's without an allocator.
  MemoryBlocks& blocks() const { return *blocks_; }
  /// Names an object for tools such as RenderDoc, if the device has VK_EXT_debug_utils.
  void name(VkObjectType type, uint64_t object, const char* name) const;
  /// Returns the size in bytes of the largest device-local heap.
  uint64_t heapBytes() const;
  /// Returns whether device memory is host memory, so that results need not be copied before they are read.
  bool unifiedMemory() const;

 private:
  void makeOwn();

  mutable HangCount hangs_ = 0;  // first member, because the handles of the others read it
  bool statistics_ = false;
  std::shared_ptr<const AdoptedDevice> adopted_;
  std::unique_ptr<ApiInstance> instance_;  // null with an adopted device
  InstanceFunctions instanceFunctions_;
  VkPhysicalDevice physical_ = VK_NULL_HANDLE;
  Capabilities capabilities_;
  VkPhysicalDeviceMemoryProperties memory_ = {};
  Handle<VkDevice> device_;
  DeviceFunctions vk_;
  VkQueue queue_ = VK_NULL_HANDLE;
  mutable std::mutex queueMutex_;     // one thread at a time may use a queue
  mutable uint64_t submissions_ = 0;  // guarded by queueMutex_
  mutable std::atomic<uint64_t> ended_ = 0;
  mutable std::atomic<bool> failed_ = false;
  std::unique_ptr<MemoryBlocks> blocks_;
};

}  // namespace gnosphere::vulkan
