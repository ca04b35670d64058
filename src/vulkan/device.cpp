// SPDX-License-Identifier: Apache-2.0
#include "vulkan/device.hpp"

#include <algorithm>
#include <charconv>

#include "base/text.hpp"
#include "gnosphere/error.hpp"
#include "pipeline/backend.hpp"
#include "vulkan/driver_advice.hpp"

namespace gnosphere::vulkan {
namespace {

int preference(const DeviceInfo& info) {
  const char* order[] = {"discrete", "integrated", "virtual", "other", "cpu"};
  return static_cast<int>(std::find(std::begin(order), std::end(order), info.type) - std::begin(order));
}

/// Returns whether a text has these digits as a number, which is not a part of a longer one.
bool containsNumber(const std::string& text, const std::string& digits) {
  const auto isDigit = [&](size_t at) { return at < text.size() && text[at] >= '0' && text[at] <= '9'; };
  for (size_t at = text.find(digits); at != text.npos; at = text.find(digits, at + 1))
    if (!(at > 0 && isDigit(at - 1)) && !isDigit(at + digits.size())) return true;
  return false;
}

}  // namespace

size_t chooseDevice(const std::vector<DeviceInfo>& devices, const DeviceChoice& choice) {
  const std::string& name = choice.name;
  const bool any = name.empty(), byUuid = choice.uuid != DeviceChoice().uuid;
  const bool anyCard = !byUuid && sameWord(name, "gpu");
  size_t index = devices.size();
  const char* end = name.data() + name.size();
  const bool isNumber = !name.empty() && std::from_chars(name.data(), end, index).ptr == end;
  const bool isIndex = isNumber && index < devices.size();
  const auto named = [&](size_t i) {
    if (isIndex) return index == i;
    return isNumber ? containsNumber(devices[i].name, name) : containsWord(devices[i].name, name);
  };
  std::string seen;
  std::vector<size_t> matches;
  for (size_t i = 0; i < devices.size(); ++i) {
    const DeviceInfo& info = devices[i];
    seen += "; " + std::to_string(i) + ": " + info.name + (info.usable ? "" : " (" + info.reason + ")");
    if (byUuid ? info.uuid == choice.uuid : any ? info.usable : anyCard ? info.type != "cpu" : named(i))
      matches.push_back(i);
  }
  if (devices.empty())
    throw Error(ErrorCode::device, "no Vulkan device was found; " + driverRemedy() + "; or use the device 'reference'");
  if (matches.empty() && byUuid)
    throw Error(ErrorCode::device, "the device with the chosen UUID is no longer there" + seen);
  if (matches.empty() && anyCard)
    throw Error(ErrorCode::device, "no graphics card was found" + seen +
                                       "; does this process see the card, and is a Vulkan driver for it installed? The "
                                       "device 'auto' takes a CPU, too");
  if (matches.empty() && any) throw Error(ErrorCode::device, "no Vulkan device can be used" + seen);
  if (matches.empty())
    throw Error(ErrorCode::invalidArgument,
                "there is no device '" + name + "'" +
                    (isNumber ? ", neither with this number nor with this number in its name" : "") + seen +
                    "; reference: the CPU in double");
  const size_t best = *std::min_element(matches.begin(), matches.end(), [&](size_t a, size_t b) {
    return std::pair(!devices[a].usable, preference(devices[a])) <
           std::pair(!devices[b].usable, preference(devices[b]));
  });
  if (!devices[best].usable)
    throw Error(ErrorCode::device, "the device '" + devices[best].name + "' cannot be used: " + devices[best].reason);
  return best;
}

VkPhysicalDevice chooseDevice(const ApiInstance& instance, const DeviceChoice& choice) {
  const std::vector<VkPhysicalDevice> devices = instance.physicalDevices();
  std::vector<DeviceInfo> infos;
  for (VkPhysicalDevice device : devices) infos.push_back(capabilitiesOf(instance.functions(), device).info);
  return devices[chooseDevice(infos, choice)];
}

Device::Device(const DeviceChoice& choice, bool validation, bool statistics) : adopted_(choice.adopted) {
  if (adopted_) {
    instanceFunctions_ = functionsOf(adopted_->getInstanceProcAddr, adopted_->instance);
    physical_ = adopted_->physicalDevice;
    capabilities_ = capabilitiesOf(instanceFunctions_, physical_);
    capabilities_.queueFamily = adopted_->queueFamily;
    capabilities_.exportsMemory = capabilities_.keepsShaders = false;
    const Requirements& enabled = adopted_->enabled;
    capabilities_.int64Atomics = enabled.features.shaderInt64 && enabled.features12.shaderBufferInt64Atomics;
    capabilities_.float64 = enabled.features.shaderFloat64;
    capabilities_.uniformControlFlow = adopted_->uniformControlFlow;
    vk_ = functionsOf(instanceFunctions_.vkGetDeviceProcAddr, adopted_->device);
  } else {
    instance_ = std::make_unique<ApiInstance>(validation);
    instanceFunctions_ = instance_->functions();
    physical_ = chooseDevice(*instance_, choice);
    capabilities_ = capabilitiesOf(instanceFunctions_, physical_);
    statistics_ =
        statistics && offers(instanceFunctions_, physical_, VK_KHR_PIPELINE_EXECUTABLE_PROPERTIES_EXTENSION_NAME);
    // Layers older than the extension would take a shader object for a missing pipeline.
    if (validation || statistics_) capabilities_.keepsShaders = false;
    makeOwn();
  }
  instanceFunctions_.vkGetPhysicalDeviceMemoryProperties(physical_, &memory_);
  blocks_ = std::make_unique<MemoryBlocks>(handle(), vk_, capabilities_.mostAllocations, hangs_);
}

Device::~Device() {
  if (hangs_ > 0) (void)instance_.release();  // an instance outlives its devices
}

VkResult Device::submit(const VkSubmitInfo& info, VkFence fence, uint64_t& number) const {
  const std::lock_guard lock(queueMutex_);
  const VkResult result = vk_.vkQueueSubmit(queue_, 1, &info, fence);
  if (result == VK_SUCCESS)
    number = ++submissions_;
  else
    noteFailure();
  return result;
}

void Device::noteEnd(uint64_t number) const {
  const std::lock_guard lock(queueMutex_);
  ended_ = std::max<uint64_t>(ended_, number);
}

void Device::makeOwn() {
  const float priority = 1;
  VkDeviceQueueCreateInfo queue = {VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO};
  queue.queueFamilyIndex = capabilities_.queueFamily;
  queue.queueCount = 1;
  queue.pQueuePriorities = &priority;
  Requirements needed = requirementsFor(capabilities_);
  VkPhysicalDeviceFeatures2 features = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, &needed.features12,
                                        needed.features};
  needed.features12.pNext = &needed.subgroupSizeControl;
  VkPhysicalDevicePipelineExecutablePropertiesFeaturesKHR executables = {
      VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PIPELINE_EXECUTABLE_PROPERTIES_FEATURES_KHR, nullptr, VK_TRUE};
  VkPhysicalDeviceShaderSubgroupUniformControlFlowFeaturesKHR uniform = {
      VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SHADER_SUBGROUP_UNIFORM_CONTROL_FLOW_FEATURES_KHR};
  if (offers(instanceFunctions_, physical_, VK_KHR_SHADER_SUBGROUP_UNIFORM_CONTROL_FLOW_EXTENSION_NAME)) {
    VkPhysicalDeviceFeatures2 offered = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, &uniform, {}};
    instanceFunctions_.vkGetPhysicalDeviceFeatures2(physical_, &offered);
    capabilities_.uniformControlFlow = uniform.shaderSubgroupUniformControlFlow;
    needed.extensions.push_back(VK_KHR_SHADER_SUBGROUP_UNIFORM_CONTROL_FLOW_EXTENSION_NAME);
    needed.subgroupSizeControl.pNext = &uniform;
  }
  if (capabilities_.exportsMemory) needed.extensions.push_back(VK_KHR_EXTERNAL_MEMORY_FD_EXTENSION_NAME);
  if (statistics_) {
    executables.pNext = needed.subgroupSizeControl.pNext;
    needed.extensions.push_back(VK_KHR_PIPELINE_EXECUTABLE_PROPERTIES_EXTENSION_NAME);
    needed.subgroupSizeControl.pNext = &executables;
  }
  VkPhysicalDeviceShaderObjectFeaturesEXT objects = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SHADER_OBJECT_FEATURES_EXT,
                                                     needed.subgroupSizeControl.pNext, VK_TRUE};
  if (capabilities_.keepsShaders) {
    needed.extensions.insert(needed.extensions.end(),
                             {VK_EXT_SHADER_OBJECT_EXTENSION_NAME, VK_KHR_DYNAMIC_RENDERING_EXTENSION_NAME});
    needed.subgroupSizeControl.pNext = &objects;
  }
  VkDeviceCreateInfo info = {VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO, &features};
  info.queueCreateInfoCount = 1;
  info.pQueueCreateInfos = &queue;
  info.enabledExtensionCount = static_cast<uint32_t>(needed.extensions.size());
  info.ppEnabledExtensionNames = needed.extensions.data();
  VkDevice device = VK_NULL_HANDLE;
  VkResult made = VK_SUCCESS;
  try {
    made = instanceFunctions_.vkCreateDevice(physical_, &info, nullptr, &device);
  } catch (...) {  // Mesa's compiler throws std::bad_alloc through the loader, whose lock then stays taken for ever
    (void)instance_.release();
    throw Error(ErrorCode::outOfMemory, "there is too little memory for the driver of '" + capabilities_.info.name +
                                            "'; limits such as ulimit -v count, too");
  }
  if (made == VK_ERROR_UNKNOWN)  // what Mesa gives if it cannot start its threads
    throw Error(ErrorCode::device, "the driver cannot make the device '" + capabilities_.info.name +
                                       "'; may this process start threads (ulimit -u, pids.max)?");
  check(made, "vkCreateDevice");
  vk_ = functionsOf(instanceFunctions_.vkGetDeviceProcAddr, device);
  device_ = {device, vk_.vkDestroyDevice, &hangs_};
  vk_.vkGetDeviceQueue(device, capabilities_.queueFamily, 0, &queue_);
}

std::vector<uint32_t> Device::memoryTypes(uint32_t typeBits, std::span<const VkMemoryPropertyFlags> wanted) const {
  // Buffers may only lie in such memory with features that the library does not ask for, or not at all.
  constexpr VkMemoryPropertyFlags kUnusable =
      VK_MEMORY_PROPERTY_PROTECTED_BIT | VK_MEMORY_PROPERTY_LAZILY_ALLOCATED_BIT |
      VK_MEMORY_PROPERTY_DEVICE_COHERENT_BIT_AMD | VK_MEMORY_PROPERTY_DEVICE_UNCACHED_BIT_AMD |
      VK_MEMORY_PROPERTY_RDMA_CAPABLE_BIT_NV;
  std::vector<uint32_t> types;
  for (const VkMemoryPropertyFlags flags : wanted)
    for (uint32_t i = 0; i < memory_.memoryTypeCount; ++i)
      if ((typeBits >> i & 1) && (memory_.memoryTypes[i].propertyFlags & flags) == flags &&
          (memory_.memoryTypes[i].propertyFlags & kUnusable) == 0 &&
          std::find(types.begin(), types.end(), i) == types.end())
        types.push_back(i);
  return types;
}

bool Device::isHostVisible(uint32_t memoryType) const {
  return memory_.memoryTypes[memoryType].propertyFlags & VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT;
}

bool Device::isLocal(uint32_t memoryType) const {
  return memory_.memoryTypes[memoryType].propertyFlags & VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT;
}

void Device::name(VkObjectType type, uint64_t object, const char* name) const {
  if (!vk_.vkSetDebugUtilsObjectNameEXT) return;
  VkDebugUtilsObjectNameInfoEXT info = {VK_STRUCTURE_TYPE_DEBUG_UTILS_OBJECT_NAME_INFO_EXT};
  info.objectType = type;
  info.objectHandle = object;
  info.pObjectName = name;
  vk_.vkSetDebugUtilsObjectNameEXT(handle(), &info);
}

bool Device::isCoherent(uint32_t memoryType) const {
  return memory_.memoryTypes[memoryType].propertyFlags & VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
}

uint64_t Device::heapBytes() const {
  uint64_t bytes = 0;
  for (uint32_t i = 0; i < memory_.memoryHeapCount; ++i)
    if (memory_.memoryHeaps[i].flags & VK_MEMORY_HEAP_DEVICE_LOCAL_BIT)
      bytes = std::max(bytes, memory_.memoryHeaps[i].size);
  return bytes;
}

bool Device::unifiedMemory() const {
  return capabilities_.info.type == "cpu" || capabilities_.info.type == "integrated";
}

}  // namespace gnosphere::vulkan

namespace gnosphere {

std::vector<DeviceInfo> listVulkanDevices(std::string* problem) {
  std::vector<DeviceInfo> devices;
  try {
    const vulkan::ApiInstance instance(false);
    for (VkPhysicalDevice physical : instance.physicalDevices())
      devices.push_back(vulkan::capabilitiesOf(instance.functions(), physical).info);
    if (devices.empty() && problem) *problem = "no Vulkan device was found; " + vulkan::driverRemedy();
  } catch (const Error& error) {
    if (problem) *problem = error.what();
  }
  return devices;
}

}  // namespace gnosphere
