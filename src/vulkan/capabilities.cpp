// SPDX-License-Identifier: Apache-2.0
#include "vulkan/capabilities.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>
#include <optional>
#include <utility>
#include <vector>

#include "common/shared.h"
#include "pipeline/machine.hpp"
#include "vulkan/instance.hpp"

namespace gnosphere::vulkan {
namespace {

constexpr uint32_t kWorkgroupSize = 64;  // invocations per workgroup of every shader
constexpr uint32_t kLeastSubgroup = 4;   // fit_clusters has room for the results of 16 subgroups

// Vulkan's headers define this name only with VK_ENABLE_BETA_EXTENSIONS.
constexpr const char* kPortabilitySubset = "VK_KHR_portability_subset";

std::string versionText(uint32_t version) {
  return std::to_string(VK_API_VERSION_MAJOR(version)) + "." + std::to_string(VK_API_VERSION_MINOR(version)) + "." +
         std::to_string(VK_API_VERSION_PATCH(version));
}

const char* typeName(VkPhysicalDeviceType type) {
  switch (type) {
    case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU: return "discrete";
    case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU: return "integrated";
    case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU: return "virtual";
    case VK_PHYSICAL_DEVICE_TYPE_CPU: return "cpu";
    default: return "other";
  }
}

// Returns the queue family for scans, or -1. A family for compute alone comes first: a desktop draws with the others,
// and waits while a long scan has their queue.
int computeFamily(const InstanceFunctions& vk, VkPhysicalDevice physical, uint32_t& timestampBits) {
  uint32_t count = 0;
  vk.vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, nullptr);
  std::vector<VkQueueFamilyProperties> families(count);
  vk.vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, families.data());
  const int family = queueFamilyOf(families);
  if (family >= 0) timestampBits = families[static_cast<size_t>(family)].timestampValidBits;
  return family;
}

}  // namespace

int queueFamilyOf(std::span<const VkQueueFamilyProperties> families) {
  for (const bool alone : {true, false})
    for (size_t i = 0; i < families.size(); ++i) {
      const VkQueueFlags flags = families[i].queueFlags;
      if ((flags & VK_QUEUE_COMPUTE_BIT) && families[i].queueCount > 0 && !(alone && (flags & VK_QUEUE_GRAPHICS_BIT)))
        return static_cast<int>(i);
    }
  return -1;
}

bool offers(const InstanceFunctions& vk, VkPhysicalDevice physical, const char* extension) {
  uint32_t count = 0;
  VK(vk.vkEnumerateDeviceExtensionProperties(physical, nullptr, &count, nullptr));
  std::vector<VkExtensionProperties> extensions(count);
  VK(vk.vkEnumerateDeviceExtensionProperties(physical, nullptr, &count, extensions.data()));
  return std::any_of(extensions.begin(), extensions.end(), [&](const VkExtensionProperties& offered) {
    return std::strcmp(offered.extensionName, extension) == 0;
  });
}

// The size that a vendor's compiler is best with, by the table in docs/gpus.md; 0 for the driver's own choice. If
// Intel's is given no size but must make full subgroups, it makes the largest ones, of 32 lanes, for which it has too
// few registers. A lane of a subgroup of 8 has twice as many as one of 16, if the chip can make such subgroups.
struct BestSizes {
  uint32_t most, few;
};
BestSizes bestSizes(uint32_t vendor) {
  constexpr uint32_t kIntel = 0x8086;
  return vendor == kIntel ? BestSizes{16, 8} : BestSizes{};
}

FullSubgroups fullSubgroupsOf(const Offer& offer) {
  if (!offer.sizeControl.computeFullSubgroups) return {};
  const BestSizes best = bestSizes(offer.vendor);
  const bool mayChoose =
      offer.sizeControl.subgroupSizeControl && (offer.sizes.requiredSubgroupSizeStages & VK_SHADER_STAGE_COMPUTE_BIT);
  const auto can = [&](uint32_t size) {
    return mayChoose && size > 0 && size >= offer.sizes.minSubgroupSize && size <= offer.sizes.maxSubgroupSize;
  };
  if (can(best.most)) return {best.most, true, can(best.few) ? best.few : 0};
  if (kWorkgroupSize % offer.subgroup.subgroupSize == 0) return {offer.subgroup.subgroupSize, false};
  // Some devices by default use subgroups larger than our workgroups, but also support smaller ones.
  const bool choice = mayChoose && offer.sizes.minSubgroupSize <= kWorkgroupSize;
  return choice ? FullSubgroups{kWorkgroupSize, true} : FullSubgroups{};
}

// Older versions of lavapipe leave all loops of an invocation as soon as these have gone round 65535 times in all, and
// the rest of its work is lost without a word. Mesa 25.0.7 is the oldest that is known not to. lavapipe's driverVersion
// is 1 in every Mesa, so the version is read from the text, "Mesa 22.3.6 (LLVM 15.0.6)".
constexpr std::array<unsigned, 3> kLeastMesa = {25, 0, 7};

// Returns the version of Mesa that a lavapipe is of; none for other drivers.
std::optional<std::array<unsigned, 3>> lavapipeOf(const VkPhysicalDeviceDriverProperties& driver) {
  if (driver.driverID != VK_DRIVER_ID_MESA_LLVMPIPE) return {};
  std::array<unsigned, 3> mesa = {};
  std::sscanf(driver.driverInfo, "Mesa %u.%u.%u", &mesa[0], &mesa[1], &mesa[2]);
  return mesa;
}

bool losesLoops(const VkPhysicalDeviceDriverProperties& driver) {
  const auto mesa = lavapipeOf(driver);
  return mesa && *mesa < kLeastMesa;
}

// Newer versions of lavapipe load once from an address that all lanes share, without a look at whether any lane runs:
// in a branch that none takes, and in the rest of a loop that all have left. An index from such a load is garbage, and
// a load by this index ends the process. Mesa 25.0.7 does not; 26.1.6 and 26.2.6 do, those between are not known.
bool loadsUntaken(const VkPhysicalDeviceDriverProperties& driver) {
  const auto mesa = lavapipeOf(driver);
  return mesa && *mesa >= std::array<unsigned, 3>{25, 1, 0};
}

// Limits that Vulkan 1.2 guarantees are not checked: workgroups of 128 invocations with 16 KiB of shared memory, 65535
// workgroups per dispatch, and 128 bytes of push constants. Dispatches of more workgroups are divided.
static_assert(kWorkgroupSize <= 128);

// Returns the operations of subgroups that the device lacks in compute shaders, as in "vote, arithmetic".
std::string missingOperations(const VkPhysicalDeviceSubgroupProperties& subgroup) {
  constexpr std::pair<VkSubgroupFeatureFlags, const char*> kNeeded[] = {
      {VK_SUBGROUP_FEATURE_BASIC_BIT, "basic"},
      {VK_SUBGROUP_FEATURE_BALLOT_BIT, "ballot"},
      {VK_SUBGROUP_FEATURE_VOTE_BIT, "vote"},
      {VK_SUBGROUP_FEATURE_SHUFFLE_BIT, "shuffle"},
      {VK_SUBGROUP_FEATURE_ARITHMETIC_BIT, "arithmetic"}};
  const bool inCompute = subgroup.supportedStages & VK_SHADER_STAGE_COMPUTE_BIT;
  std::string missing;
  for (const auto& [bit, name] : kNeeded)
    if (!inCompute || !(subgroup.supportedOperations & bit))
      missing += (missing.empty() ? "" : ", ") + std::string(name);
  return missing;
}

std::vector<std::string> reasonsAgainst(const Offer& offer) {
  std::vector<std::string> reasons;
  if (!offer.compute) reasons.push_back("it has no compute queue");
  if (const std::string missing = missingOperations(offer.subgroup); !missing.empty())
    reasons.push_back("its compute shaders lack operations of subgroups: " + missing);
  if (fullSubgroupsOf(offer).size == 0)
    reasons.push_back("it cannot promise full subgroups, of at most " + std::to_string(kWorkgroupSize) +
                      " lanes, by " VK_EXT_SUBGROUP_SIZE_CONTROL_EXTENSION_NAME "; a newer driver may");
  else if (fullSubgroupsOf(offer).size < kLeastSubgroup)
    reasons.push_back("its subgroups have " + std::to_string(fullSubgroupsOf(offer).size) + " lanes, and " +
                      std::to_string(kLeastSubgroup) + " are needed");
  if (!offer.features12.scalarBlockLayout) reasons.push_back("it lacks the scalar block layout");
  if (!offer.features12.bufferDeviceAddress) reasons.push_back("its shaders cannot find buffers by address");
  if (losesLoops(offer.driver))
    reasons.push_back("this lavapipe, " + std::string(offer.driver.driverInfo) +
                      ", ends long loops early and would lose hits; Mesa 25.0.7 or newer is needed, on Debian 12 "
                      "mesa-vulkan-drivers from bookworm-backports");
  return reasons;
}

std::string reasonAgainst(const Offer& offer) {
  const std::vector<std::string> reasons = reasonsAgainst(offer);
  return reasons.empty() ? std::string() : reasons.front();
}

// Returns the size of the largest buffer; a device that does not tell allows what it can allocate.
uint64_t largestBuffer(const InstanceFunctions& vk, VkPhysicalDevice physical) {
  if (!offers(vk, physical, VK_KHR_MAINTENANCE_4_EXTENSION_NAME)) return UINT64_MAX;
  VkPhysicalDeviceMaintenance4Properties limits = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MAINTENANCE_4_PROPERTIES};
  VkPhysicalDeviceProperties2 properties = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, &limits, {}};
  vk.vkGetPhysicalDeviceProperties2(physical, &properties);
  return limits.maxBufferSize > 0 ? limits.maxBufferSize : UINT64_MAX;
}

// Returns whether buffers can be handed out as file descriptors, in memory that is not reserved for one of them.
bool exportsBuffers(const InstanceFunctions& vk, VkPhysicalDevice physical) {
  if (!offers(vk, physical, VK_KHR_EXTERNAL_MEMORY_FD_EXTENSION_NAME)) return false;
  VkPhysicalDeviceExternalBufferInfo info = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_EXTERNAL_BUFFER_INFO};
  info.usage = kBufferUsage;
  info.handleType = kExportedAs;
  VkExternalBufferProperties properties = {VK_STRUCTURE_TYPE_EXTERNAL_BUFFER_PROPERTIES};
  vk.vkGetPhysicalDeviceExternalBufferProperties(physical, &info, &properties);
  const VkExternalMemoryFeatureFlags features = properties.externalMemoryProperties.externalMemoryFeatures;
  return (features & VK_EXTERNAL_MEMORY_FEATURE_EXPORTABLE_BIT) &&
         !(features & VK_EXTERNAL_MEMORY_FEATURE_DEDICATED_ONLY_BIT);
}

Capabilities capabilitiesOf(const InstanceFunctions& vk, VkPhysicalDevice physical) {
  Capabilities result;
  Offer offer;
  offer.driver = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES};
  VkPhysicalDeviceIDProperties id = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ID_PROPERTIES, &offer.driver};
  VkPhysicalDeviceMaintenance3Properties allocations = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MAINTENANCE_3_PROPERTIES,
                                                        &id};
  VkPhysicalDeviceFloatControlsProperties floats = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FLOAT_CONTROLS_PROPERTIES,
                                                    &allocations};
  offer.subgroup = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES, &floats};
  offer.sizes = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_SIZE_CONTROL_PROPERTIES_EXT, &offer.subgroup};
  offer.features12 = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES};
  offer.sizeControl = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_SIZE_CONTROL_FEATURES_EXT, &offer.features12};
  const bool sizeControl = offers(vk, physical, VK_EXT_SUBGROUP_SIZE_CONTROL_EXTENSION_NAME);
  VkPhysicalDeviceProperties2 properties = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, &offer.subgroup, {}};
  VkPhysicalDeviceFeatures2 features = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, &offer.features12, {}};
  if (sizeControl) {
    properties.pNext = &offer.sizes;
    features.pNext = &offer.sizeControl;
  }
  VkPhysicalDeviceProperties basic;
  vk.vkGetPhysicalDeviceProperties(physical, &basic);
  DeviceInfo& info = result.info;
  info.name = basic.deviceName;
  info.type = typeName(basic.deviceType);
  info.apiVersion = versionText(basic.apiVersion);
  offer.vendor = basic.vendorID;
  result.cpu = basic.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU;
  if (basic.apiVersion < VK_API_VERSION_1_2) {
    info.reason = "it offers Vulkan " + info.apiVersion + ", 1.2 is needed";
    result.reasons = {info.reason};
    return result;
  }
  vk.vkGetPhysicalDeviceProperties2(physical, &properties);
  vk.vkGetPhysicalDeviceFeatures2(physical, &features);
  info.driver = std::string(offer.driver.driverName) + " " + offer.driver.driverInfo;
  info.maxBufferBytes = std::min<uint64_t>(allocations.maxMemoryAllocationSize, largestBuffer(vk, physical));
  result.mostGroups = basic.limits.maxComputeWorkGroupCount[0];
  result.mostAllocations = basic.limits.maxMemoryAllocationCount;
  std::copy(std::begin(id.deviceUUID), std::end(id.deviceUUID), info.uuid.begin());
  uint32_t timestampBits = 0;
  const int family = computeFamily(vk, physical, timestampBits);
  result.queueFamily = static_cast<uint32_t>(std::max(family, 0));
  offer.compute = family >= 0;
  // For a footprint of 19 sub-rays in unrolled loops, SwiftShader's compiler takes more than 8 GB; in loops, 0.1 GB.
  result.unrolls = offer.driver.driverID != VK_DRIVER_ID_GOOGLE_SWIFTSHADER;
  result.loadsUntaken = loadsUntaken(offer.driver);
  result.keepsVectors = lavapipeOf(offer.driver).has_value();
  result.keepsShaders = result.cpu && lavapipeOf(offer.driver) &&
                        offers(vk, physical, VK_EXT_SHADER_OBJECT_EXTENSION_NAME) &&
                        offers(vk, physical, VK_KHR_DYNAMIC_RENDERING_EXTENSION_NAME);
  result.subgroups = fullSubgroupsOf(offer);
  info.subgroupSize = result.subgroups.size ? result.subgroups.size : offer.subgroup.subgroupSize;
  result.int64Atomics = features.features.shaderInt64 && offer.features12.shaderBufferInt64Atomics;
  result.float64 = features.features.shaderFloat64;
  result.portabilitySubset = offers(vk, physical, kPortabilitySubset);
  // Mesa's lavapipe pays for this with three more instructions in every min() and max(), a tenth of a scan, and keeps
  // these values in any case.
  result.keepsSpecialFloats = !result.cpu && floats.shaderSignedZeroInfNanPreserveFloat32;
  result.exportsMemory = exportsBuffers(vk, physical);
  result.timestampBits = basic.limits.timestampPeriod > 0 ? timestampBits : 0;
  result.timestampMs = basic.limits.timestampPeriod * 1e-6;
  result.reasons = reasonsAgainst(offer);
  info.reason = reasonAgainst(offer);
  info.usable = info.reason.empty();
  return result;
}

Traits traitsOf(const Capabilities& capabilities, const Tuning& tuning) {
  Traits traits = {capabilities.info, capabilities.cpu, capabilities.int64Atomics, capabilities.float64};
  traits.spreadsRays = true;
  if (tuning.maxBufferBytes > 0)
    traits.info.maxBufferBytes = std::min(traits.info.maxBufferBytes, tuning.maxBufferBytes);
  return traits;
}

double Capabilities::elapsedMs(uint64_t from, uint64_t to) const {
  if (timestampBits == 0) return 0;
  return static_cast<double>((to - from) & (~uint64_t{0} >> (64 - timestampBits))) * timestampMs;
}

Requirements requirementsFor(const Capabilities& capabilities) {
  Requirements needed;
  needed.extensions = {VK_EXT_SUBGROUP_SIZE_CONTROL_EXTENSION_NAME};
  if (capabilities.portabilitySubset) needed.extensions.push_back(kPortabilitySubset);
  needed.features.shaderInt64 = capabilities.int64Atomics;
  needed.features.shaderFloat64 = capabilities.float64;
  needed.features12.shaderBufferInt64Atomics = capabilities.int64Atomics;
  needed.features12.scalarBlockLayout = VK_TRUE;
  needed.features12.bufferDeviceAddress = VK_TRUE;
  needed.subgroupSizeControl.subgroupSizeControl = capabilities.subgroups.required;
  needed.subgroupSizeControl.computeFullSubgroups = VK_TRUE;
  for (const std::string& reason : capabilities.reasons)
    needed.missing.push_back("the device '" + capabilities.info.name + "' cannot be used: " + reason);
  return needed;
}

}  // namespace gnosphere::vulkan
