// SPDX-License-Identifier: Apache-2.0
// Abilities that a physical device offers, and those that the library needs.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "gnosphere/vulkan.hpp"
#include "vulkan/functions.hpp"

namespace gnosphere {
struct Traits;
}

namespace gnosphere::vulkan {

/// The properties that decide whether a device can be used. The pNext pointers of the members are ignored.
struct Offer {
  bool compute = false;  ///< the device has a queue family for compute
  uint32_t vendor = 0;   ///< VkPhysicalDeviceProperties::vendorID
  VkPhysicalDeviceVulkan12Features features12 = {};
  VkPhysicalDeviceSubgroupProperties subgroup = {};
  /// These two are zeros without VK_EXT_subgroup_size_control.
  VkPhysicalDeviceSubgroupSizeControlPropertiesEXT sizes = {};
  VkPhysicalDeviceSubgroupSizeControlFeaturesEXT sizeControl = {};
  VkPhysicalDeviceDriverProperties driver = {};
};
/// Returns why the device cannot be used, each reason as the rest of a sentence about it; empty if it can be used.
std::vector<std::string> reasonsAgainst(const Offer& offer);
/// Returns the first of these reasons; empty if there is none.
std::string reasonAgainst(const Offer& offer);

/// The buffers that are shared with other devices and processes, and the usages of all buffers of the library.
inline constexpr auto kExportedAs = VK_EXTERNAL_MEMORY_HANDLE_TYPE_OPAQUE_FD_BIT;
inline constexpr VkBufferUsageFlags kBufferUsage =
    VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT |
    VK_BUFFER_USAGE_TRANSFER_DST_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT;

/// Returns whether the device has the extension.
bool offers(const InstanceFunctions& vk, VkPhysicalDevice physical, const char* extension);

/// Returns the index of the queue family on which scans run, or -1 if no family can compute.
int queueFamilyOf(std::span<const VkQueueFamilyProperties> families);

/// The size of the full subgroups that every pipeline gets whose kernel uses them. The stages divide their work by
/// gl_SubgroupSize, so results would be silently incomplete if fewer invocations ran.
struct FullSubgroups {
  uint32_t size = 0;      ///< 0 if the device cannot guarantee full subgroups
  bool required = false;  ///< true if pipelines must require this size because the device would choose another
  uint32_t few = 0;       ///< what kernels of many registers must require instead; 0 for the same size
};
FullSubgroups fullSubgroupsOf(const Offer& offer);

/// The capabilities of a physical device; `info` tells whether it can be used.
struct Capabilities {
  DeviceInfo info;
  std::vector<std::string> reasons;  ///< why it cannot be used, see reasonsAgainst()
  FullSubgroups subgroups;
  bool int64Atomics = false;
  bool float64 = false;
  bool portabilitySubset = false;  ///< the device leaves out parts of Vulkan, and must be told that this is known
  /// Lanes that have parted meet again as soon as the source says so: VK_KHR_shader_subgroup_uniform_control_flow. Of a
  /// device of the caller AdoptedDevice::uniformControlFlow tells it. Without it the kernels rely on what every driver
  /// so far has done.
  bool uniformControlFlow = false;
  bool exportsMemory = false;       ///< storage buffers can be handed out as file descriptors
  bool keepsSpecialFloats = false;  ///< shaders may ask that -0, NaN and infinity keep their meaning
  uint32_t timestampBits = 0;       ///< number of valid low bits of a timestamp; 0 if there are no timestamps
  double timestampMs = 0;           ///< milliseconds per tick
  bool cpu = false;                 ///< true for a software device
  bool unrolls = true;              ///< false if the driver's compiler cannot cope with long unrolled loops
  bool loadsUntaken = false;        ///< true if the driver's compiler loads in branches that no lane takes
  bool keepsVectors = false;        ///< true if the driver's compiler keeps variables of several scalars whole
  /// Kernels are shader objects, whose binaries are kept on disk, rather than pipelines: lavapipe's pipeline cache
  /// keeps nothing. On a device of the caller, and with the validation layer or statistics, they are pipelines.
  bool keepsShaders = false;
  uint32_t queueFamily = 0;
  uint32_t mostGroups = 65535;      ///< workgroups along the first axis of a dispatch; more are divided
  uint32_t mostAllocations = 4096;  ///< of memory, of all users of the device together

  /// Returns the milliseconds between two timestamps; the counter may have overflowed once; 0 without timestamps.
  double elapsedMs(uint64_t from, uint64_t to) const;
};
Capabilities capabilitiesOf(const InstanceFunctions& vk, VkPhysicalDevice physical);

/// Returns what the pipeline asks of the device, within Tuning::maxBufferBytes.
Traits traitsOf(const Capabilities& capabilities, const Tuning& tuning);

/// Returns the extensions and features that a device with these capabilities is created with.
Requirements requirementsFor(const Capabilities& capabilities);

}  // namespace gnosphere::vulkan
