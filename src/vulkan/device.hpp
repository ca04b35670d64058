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

/// Throws Error with the call, the name of its result and the place, which is that of the caller: clang 14 has no
/// std::source_location. Use it as VK().
void check(VkResult result, const char* call, const char* file = __builtin_FILE(), uint32_t line = __builtin_LINE());
#define VK(call) ::gnosphere::vulkan::check(call, #call)

/// Collects the messages of the validation layer.
class Messages {
 public:
  void add(const char* text);
  /// Throws Error(device) with the messages since the last call, if there are any.
  void throwIfAny();

 private:
  std::mutex mutex_;
  std::vector<std::string> texts_;
};

/// A Vulkan instance, with the validation layer if requested.
class ApiInstance {
 public:
  explicit ApiInstance(bool validation);

  VkInstance handle() const { return instance_.get(); }
  std::vector<VkPhysicalDevice> physicalDevices() const;
  void throwOnMessages() { messages_->throwIfAny(); }
  /// Shared, so that a caller can still read messages about the destruction of the instance and its devices.
  const std::shared_ptr<Messages>& messages() const { return messages_; }

 private:
  std::shared_ptr<Messages> messages_ = std::make_shared<Messages>();
  Handle<VkInstance> instance_;
  Handle<VkDebugUtilsMessengerEXT, VkInstance> messenger_;
};

/// The properties that decide whether a device can be used. The pNext pointers of the members are ignored.
struct Offer {
  bool compute = false;  ///< the device has a queue family for compute
  VkPhysicalDeviceVulkan12Features features12 = {};
  VkPhysicalDeviceSubgroupProperties subgroup = {};
  /// These two are zeros without VK_EXT_subgroup_size_control.
  VkPhysicalDeviceSubgroupSizeControlPropertiesEXT sizes = {};
  VkPhysicalDeviceSubgroupSizeControlFeaturesEXT sizeControl = {};
  VkPhysicalDeviceDriverProperties driver = {};
};
/// Returns why the device cannot be used; empty if it can.
std::string reasonAgainst(const Offer& offer);

/// Returns whether the device has the extension.
bool offers(VkPhysicalDevice physical, const char* extension);

/// The size of the full subgroups that every pipeline gets. The stages divide their work by gl_SubgroupSize, so results
/// would be silently incomplete if fewer invocations ran.
struct FullSubgroups {
  uint32_t size = 0;      ///< 0 if the device cannot guarantee full subgroups
  bool required = false;  ///< true if pipelines must require this size because the device would choose another
};
FullSubgroups fullSubgroupsOf(const Offer& offer);

/// The capabilities of a physical device; `info` tells whether it can be used.
struct Capabilities {
  DeviceInfo info;
  FullSubgroups subgroups;
  bool int64Atomics = false;
  bool float64 = false;
  uint32_t timestampBits = 0;  ///< number of valid low bits of a timestamp; 0 if there are no timestamps
  double timestampMs = 0;      ///< milliseconds per tick
  bool cpu = false;            ///< true for a software device
  uint32_t queueFamily = 0;

  /// Returns the milliseconds between two timestamps; the counter may have overflowed once. 0 without timestamps.
  double elapsedMs(uint64_t from, uint64_t to) const;
};
Capabilities capabilitiesOf(VkPhysicalDevice physical);

/// Returns the index of the chosen device. A name is "auto", an index or part of a device name; a number that is not an
/// index is taken as part of a name. Throws Error(invalidArgument) or Error(device) that lists every device with the
/// reason why it was refused.
size_t chooseDevice(const std::vector<DeviceInfo>& devices, const DeviceChoice& choice);
VkPhysicalDevice chooseDevice(const ApiInstance& instance, const DeviceChoice& choice);

class Device {
 public:
  Device(const DeviceChoice& choice, bool validation, uint64_t maxBufferBytes);
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  VkDevice handle() const { return device_.get(); }
  /// The function table of this device; volk's global pointers to device functions are null.
  const VolkDeviceTable& vk() const { return vk_; }
  /// Creates an object from `info` with a function of vk(). Throws Error that names the source location of the call.
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

  /// Returns the index of a memory type in `typeBits` that has all properties in `wanted`, or -1.
  int memoryType(uint32_t typeBits, VkMemoryPropertyFlags wanted) const;
  bool isHostVisible(int memoryType) const;
  bool isCoherent(int memoryType) const;
  /// Returns the size in bytes of the largest device-local heap.
  uint64_t heapBytes() const;
  /// Returns whether device memory is host memory, so that results need not be copied before they are read.
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
