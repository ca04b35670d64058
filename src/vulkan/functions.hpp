// SPDX-License-Identifier: Apache-2.0
// The functions of Vulkan that this library calls, in tables: one per instance and one per device. A device that a
// caller has made brings its own, so nothing here is global.
#pragma once

#include <vulkan/vulkan_core.h>

#include "vulkan/shader_object.hpp"

namespace gnosphere::vulkan {

// clang-format off
#define GNO_INSTANCE_FUNCTIONS(FUNCTION) \
  FUNCTION(vkCreateDevice) \
  FUNCTION(vkDestroyInstance) \
  FUNCTION(vkEnumerateDeviceExtensionProperties) \
  FUNCTION(vkEnumeratePhysicalDevices) \
  FUNCTION(vkGetDeviceProcAddr) \
  FUNCTION(vkGetPhysicalDeviceExternalBufferProperties) \
  FUNCTION(vkGetPhysicalDeviceFeatures2) \
  FUNCTION(vkGetPhysicalDeviceMemoryProperties) \
  FUNCTION(vkGetPhysicalDeviceProperties) \
  FUNCTION(vkGetPhysicalDeviceProperties2) \
  FUNCTION(vkGetPhysicalDeviceQueueFamilyProperties)

#define GNO_DEVICE_FUNCTIONS(FUNCTION) \
  FUNCTION(vkAllocateCommandBuffers) \
  FUNCTION(vkAllocateMemory) \
  FUNCTION(vkBeginCommandBuffer) \
  FUNCTION(vkBindBufferMemory) \
  FUNCTION(vkCmdBeginDebugUtilsLabelEXT) \
  FUNCTION(vkCmdBindPipeline) \
  FUNCTION(vkCmdBindShadersEXT) \
  FUNCTION(vkCmdCopyBuffer) \
  FUNCTION(vkCmdDispatch) \
  FUNCTION(vkCmdDispatchIndirect) \
  FUNCTION(vkCmdEndDebugUtilsLabelEXT) \
  FUNCTION(vkCmdFillBuffer) \
  FUNCTION(vkCmdPipelineBarrier) \
  FUNCTION(vkCmdPushConstants) \
  FUNCTION(vkCmdResetQueryPool) \
  FUNCTION(vkCmdWriteTimestamp) \
  FUNCTION(vkCreateBuffer) \
  FUNCTION(vkCreateCommandPool) \
  FUNCTION(vkCreateComputePipelines) \
  FUNCTION(vkCreateFence) \
  FUNCTION(vkCreatePipelineCache) \
  FUNCTION(vkCreatePipelineLayout) \
  FUNCTION(vkCreateQueryPool) \
  FUNCTION(vkCreateShaderModule) \
  FUNCTION(vkCreateShadersEXT) \
  FUNCTION(vkDestroyBuffer) \
  FUNCTION(vkDestroyCommandPool) \
  FUNCTION(vkDestroyDevice) \
  FUNCTION(vkDestroyFence) \
  FUNCTION(vkDestroyPipeline) \
  FUNCTION(vkDestroyPipelineCache) \
  FUNCTION(vkDestroyPipelineLayout) \
  FUNCTION(vkDestroyQueryPool) \
  FUNCTION(vkDestroyShaderEXT) \
  FUNCTION(vkDestroyShaderModule) \
  FUNCTION(vkEndCommandBuffer) \
  FUNCTION(vkFlushMappedMemoryRanges) \
  FUNCTION(vkFreeCommandBuffers) \
  FUNCTION(vkFreeMemory) \
  FUNCTION(vkGetBufferDeviceAddress) \
  FUNCTION(vkGetBufferMemoryRequirements) \
  FUNCTION(vkGetDeviceQueue) \
  FUNCTION(vkGetMemoryFdKHR) \
  FUNCTION(vkGetPipelineCacheData) \
  FUNCTION(vkGetPipelineExecutablePropertiesKHR) \
  FUNCTION(vkGetPipelineExecutableStatisticsKHR) \
  FUNCTION(vkGetQueryPoolResults) \
  FUNCTION(vkGetShaderBinaryDataEXT) \
  FUNCTION(vkInvalidateMappedMemoryRanges) \
  FUNCTION(vkMapMemory) \
  FUNCTION(vkQueueSubmit) \
  FUNCTION(vkQueueWaitIdle) \
  FUNCTION(vkResetCommandBuffer) \
  FUNCTION(vkResetFences) \
  FUNCTION(vkSetDebugUtilsObjectNameEXT) \
  FUNCTION(vkWaitForFences)
// clang-format on

#define GNO_MEMBER(name_) PFN_##name_ name_ = nullptr;
struct InstanceFunctions {
  GNO_INSTANCE_FUNCTIONS(GNO_MEMBER)
};
struct DeviceFunctions {
  GNO_DEVICE_FUNCTIONS(GNO_MEMBER)
};
#undef GNO_MEMBER

/// Looks up the functions of an instance, all of them core in Vulkan 1.1. One that is missing is null.
InstanceFunctions functionsOf(PFN_vkGetInstanceProcAddr lookUp, VkInstance instance);
/// Looks up the functions of a device, core in Vulkan 1.2 but for those with a suffix, which are null without their
/// extension.
DeviceFunctions functionsOf(PFN_vkGetDeviceProcAddr lookUp, VkDevice device);

}  // namespace gnosphere::vulkan
