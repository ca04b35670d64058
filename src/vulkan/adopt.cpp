// SPDX-License-Identifier: Apache-2.0
#include <memory>

#include "gnosphere/error.hpp"
#include "vulkan/capabilities.hpp"

namespace gnosphere::vulkan {
namespace {

// Sets every VkBool32 from `first` to `last` that is set in `wanted`; `first` and `last` are of one structure.
void setFeatures(VkBool32* first, VkBool32* last, const VkBool32* wanted) {
  for (; first <= last; ++first, ++wanted) *first |= *wanted;
}

[[noreturn]] void refuse(const std::string& why) {
  throw Error(ErrorCode::invalidArgument, "the adopted device " + why);
}

}  // namespace

void Requirements::addTo(VkPhysicalDeviceFeatures* toFeatures, VkPhysicalDeviceVulkan12Features* to12,
                         VkPhysicalDeviceSubgroupSizeControlFeaturesEXT* toSizes) const {
  if (toFeatures)
    setFeatures(&toFeatures->robustBufferAccess, &toFeatures->inheritedQueries, &features.robustBufferAccess);
  if (to12)
    setFeatures(&to12->samplerMirrorClampToEdge, &to12->subgroupBroadcastDynamicId,
                &features12.samplerMirrorClampToEdge);
  if (toSizes)
    setFeatures(&toSizes->subgroupSizeControl, &toSizes->computeFullSubgroups,
                &subgroupSizeControl.subgroupSizeControl);
}

#ifdef VK_VERSION_1_3
void Requirements::addTo(VkPhysicalDeviceFeatures* toFeatures, VkPhysicalDeviceVulkan12Features* to12,
                         VkPhysicalDeviceVulkan13Features* to13) const {
  addTo(toFeatures, to12, static_cast<VkPhysicalDeviceSubgroupSizeControlFeaturesEXT*>(nullptr));
  if (!to13) return;
  to13->subgroupSizeControl |= subgroupSizeControl.subgroupSizeControl;
  to13->computeFullSubgroups |= subgroupSizeControl.computeFullSubgroups;
}
#endif

Requirements requirementsOf(PFN_vkGetInstanceProcAddr getInstanceProcAddr, VkInstance instance,
                            VkPhysicalDevice physical) {
  if (!getInstanceProcAddr || !instance || !physical)
    throw Error(ErrorCode::invalidArgument, "requirementsOf() needs vkGetInstanceProcAddr, an instance and a device");
  return requirementsFor(capabilitiesOf(functionsOf(getInstanceProcAddr, instance), physical));
}

DeviceChoice adopt(const AdoptedDevice& device) {
  if (!device.getInstanceProcAddr) refuse("comes without vkGetInstanceProcAddr");
  if (!device.instance || !device.physicalDevice || !device.device)
    refuse("comes without its instance, physical device or device");
  const Requirements needed = requirementsOf(device.getInstanceProcAddr, device.instance, device.physicalDevice);
  if (!needed.missing.empty()) refuse("does not meet the requirements: " + needed.missing.front());
  const Requirements& enabled = device.enabled;
  const auto need = [](VkBool32 wanted, VkBool32 has, const char* feature) {
    if (wanted && !has)
      refuse(std::string("was created without the feature ") + feature + ", or AdoptedDevice::enabled does not say so");
  };
  need(needed.features12.scalarBlockLayout, enabled.features12.scalarBlockLayout, "scalarBlockLayout");
  need(needed.features12.bufferDeviceAddress, enabled.features12.bufferDeviceAddress, "bufferDeviceAddress");
  need(needed.subgroupSizeControl.computeFullSubgroups, enabled.subgroupSizeControl.computeFullSubgroups,
       "computeFullSubgroups");
  need(needed.subgroupSizeControl.subgroupSizeControl, enabled.subgroupSizeControl.subgroupSizeControl,
       "subgroupSizeControl");
  const InstanceFunctions vk = functionsOf(device.getInstanceProcAddr, device.instance);
  if (device.uniformControlFlow &&
      !offers(vk, device.physicalDevice, VK_KHR_SHADER_SUBGROUP_UNIFORM_CONTROL_FLOW_EXTENSION_NAME))
    refuse(
        "cannot have AdoptedDevice::uniformControlFlow, because its physical device "
        "lacks " VK_KHR_SHADER_SUBGROUP_UNIFORM_CONTROL_FLOW_EXTENSION_NAME);
  uint32_t count = 0;
  vk.vkGetPhysicalDeviceQueueFamilyProperties(device.physicalDevice, &count, nullptr);
  std::vector<VkQueueFamilyProperties> families(count);
  vk.vkGetPhysicalDeviceQueueFamilyProperties(device.physicalDevice, &count, families.data());
  if (device.queueFamily >= count || !(families[device.queueFamily].queueFlags & VK_QUEUE_COMPUTE_BIT))
    refuse("has no queue family " + std::to_string(device.queueFamily) + " that supports compute");
  if (static_cast<bool>(device.allocator.allocate) != static_cast<bool>(device.allocator.release))
    refuse("has an allocator with only one of its two functions");
  DeviceChoice choice;
  choice.adopted = std::make_shared<AdoptedDevice>(device);
  return choice;
}

}  // namespace gnosphere::vulkan
