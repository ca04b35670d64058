// SPDX-License-Identifier: Apache-2.0
// One Vulkan device with a compute queue.
#pragma once

#include <volk.h>

#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "gnosphere/error.hpp"
#include "gnosphere/simulator.hpp"
#include "vulkan/handle.hpp"

namespace gnosphere::vulkan {

/// Throws Error with the call's text, the result's name and the place, which is that of the caller: clang 14 has no
/// std::source_location. Use through VK().
void check(VkResult result, const char* call, const char* file = __builtin_FILE(), uint32_t line = __builtin_LINE());
#define VK(call) ::gnosphere::vulkan::check(call, #call)

/// What the validation layer has said.
class Messages {
 public:
  void add(const char* text);
  /// Throws Error(device) with what was said since the last call.
  void throwIfAny();

 private:
  std::mutex mutex_;
  std::vector<std::string> texts_;
};

/// A Vulkan instance, with the validation layer if asked for.
class ApiInstance {
 public:
  explicit ApiInstance(bool validation);

  VkInstance handle() const { return instance_.get(); }
  std::vector<VkPhysicalDevice> physicalDevices() const;
  void throwOnMessages() { messages_->throwIfAny(); }
  /// Whoever shares them learns what is said when the instance and its devices are destroyed; else nobody does.
  const std::shared_ptr<Messages>& messages() const { return messages_; }

 private:
  std::shared_ptr<Messages> messages_ = std::make_shared<Messages>();
  Handle<VkInstance> instance_;
  Handle<VkDebugUtilsMessengerEXT, VkInstance> messenger_;
};

/// What a driver says of a device that decides whether it is used. The members' pNext count for nothing.
struct Offer {
  bool compute = false;  ///< there is a queue for it
  VkPhysicalDeviceVulkan12Features features12 = {};
  VkPhysicalDeviceSubgroupProperties subgroup = {};
  /// These two are zeros without VK_EXT_subgroup_size_control.
  VkPhysicalDeviceSubgroupSizeControlPropertiesEXT sizes = {};
  VkPhysicalDeviceSubgroupSizeControlFeaturesEXT sizeControl = {};
  VkPhysicalDeviceDriverProperties driver = {};
};
/// Why such a device cannot be used; empty if it can.
std::string reasonAgainst(const Offer& offer);

/// Whether the device has such an extension.
bool offers(VkPhysicalDevice physical, const char* extension);

/// The subgroup size that every pipeline gets in full. The stages divide their work by gl_SubgroupSize: if fewer lanes
/// ran than it says, work would be lost without a word.
struct FullSubgroups {
  uint32_t size = 0;      ///< 0: the device cannot promise any
  bool required = false;  ///< pipelines have to ask for this size, it is not what the device chooses
};
FullSubgroups fullSubgroupsOf(const Offer& offer);

/// What a physical device offers, and whether we can use it.
struct Capabilities {
  DeviceInfo info;
  FullSubgroups subgroups;
  bool int64Atomics = false;
  bool float64 = false;
  uint32_t timestampBits = 0;  ///< of a timestamp, the lowest; the others say nothing. 0: there are no timestamps
  double timestampMs = 0;      ///< milliseconds per tick
  bool cpu = false;            ///< a software device: threads, not lanes
  uint32_t queueFamily = 0;

  /// Milliseconds between two timestamps, which may have run over once; 0 where there are none.
  double elapsedMs(uint64_t from, uint64_t to) const;
};
Capabilities capabilitiesOf(VkPhysicalDevice physical);

/// Which of the devices is meant by `name`: auto, an index, or part of a device's name, which a number that is no index
/// may be, too. Throws Error(invalidArgument) or Error(device) with every device seen and why it was refused.
size_t chooseDevice(const std::vector<DeviceInfo>& devices, const DeviceChoice& choice);
VkPhysicalDevice chooseDevice(const ApiInstance& instance, const DeviceChoice& choice);

class Device {
 public:
  Device(const DeviceChoice& choice, bool validation, uint64_t maxBufferBytes);
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  VkDevice handle() const { return device_.get(); }
  /// The functions of this device; volk's global pointers to them are null.
  const VolkDeviceTable& vk() const { return vk_; }
  /// The object that a function of vk() creates as `info` says. Throws Error that names the place of the call.
  template <typename T, typename Info>
  DeviceHandle<T> make(VkResult(VKAPI_PTR* create)(VkDevice, const Info*, const VkAllocationCallbacks*, T*),
                       typename DeviceHandle<T>::Destroy destroy, const Info& info, const char* file = __builtin_FILE(),
                       uint32_t line = __builtin_LINE()) const {
    T object = VK_NULL_HANDLE;
    check(create(handle(), &info, nullptr, &object), "making a Vulkan object", file, line);
    return {object, destroy, handle()};
  }
  VkPhysicalDevice physical() const { return physical_; }
  VkQueue queue() const { return queue_; }
  const Capabilities& capabilities() const { return capabilities_; }
  uint64_t maxBufferBytes() const { return capabilities_.info.maxBufferBytes; }
  void throwOnMessages() { instance_.throwOnMessages(); }
  const std::shared_ptr<Messages>& messages() const { return instance_.messages(); }

  /// Index of a memory type among `typeBits` with all of `wanted`; -1 if there is none.
  int memoryType(uint32_t typeBits, VkMemoryPropertyFlags wanted) const;
  bool isHostVisible(int memoryType) const;
  bool isCoherent(int memoryType) const;
  /// Bytes of the largest device-local heap.
  uint64_t heapBytes() const;
  /// Device memory is host memory: copying it to the host side first would be waste.
  bool unifiedMemory() const;

 private:
  ApiInstance instance_;
  VkPhysicalDevice physical_ = VK_NULL_HANDLE;
  Capabilities capabilities_;
  VkPhysicalDeviceMemoryProperties memory_ = {};
  Handle<VkDevice> device_;
  VolkDeviceTable vk_ = {};
  VkQueue queue_ = VK_NULL_HANDLE;
};

}  // namespace gnosphere::vulkan
