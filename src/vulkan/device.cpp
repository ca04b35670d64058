// SPDX-License-Identifier: Apache-2.0
#include "vulkan/device.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cstdio>
#include <cstring>

#include "base/text.hpp"
#include "pipeline/backend.hpp"
#include "shared.h"

namespace gnosphere::vulkan {
namespace {

constexpr uint32_t kWorkgroupSize = 64;  // invocations per workgroup of every shader

const char* resultName(VkResult result) {
  switch (result) {
    case VK_SUCCESS: return "VK_SUCCESS";
    case VK_TIMEOUT: return "VK_TIMEOUT";
    case VK_ERROR_OUT_OF_HOST_MEMORY: return "VK_ERROR_OUT_OF_HOST_MEMORY";
    case VK_ERROR_OUT_OF_DEVICE_MEMORY: return "VK_ERROR_OUT_OF_DEVICE_MEMORY";
    case VK_ERROR_INITIALIZATION_FAILED: return "VK_ERROR_INITIALIZATION_FAILED";
    case VK_ERROR_DEVICE_LOST: return "VK_ERROR_DEVICE_LOST";
    case VK_ERROR_LAYER_NOT_PRESENT: return "VK_ERROR_LAYER_NOT_PRESENT";
    case VK_ERROR_EXTENSION_NOT_PRESENT: return "VK_ERROR_EXTENSION_NOT_PRESENT";
    case VK_ERROR_FEATURE_NOT_PRESENT: return "VK_ERROR_FEATURE_NOT_PRESENT";
    case VK_ERROR_INCOMPATIBLE_DRIVER: return "VK_ERROR_INCOMPATIBLE_DRIVER";
    case VK_ERROR_TOO_MANY_OBJECTS: return "VK_ERROR_TOO_MANY_OBJECTS";
    case VK_ERROR_OUT_OF_POOL_MEMORY: return "VK_ERROR_OUT_OF_POOL_MEMORY";
    default: return "VkResult";
  }
}

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

// Returns the first queue family with compute support, or -1.
int computeFamily(VkPhysicalDevice physical, uint32_t& timestampBits) {
  uint32_t count = 0;
  vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, nullptr);
  std::vector<VkQueueFamilyProperties> families(count);
  vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, families.data());
  for (uint32_t i = 0; i < count; ++i)
    if (families[i].queueFlags & VK_QUEUE_COMPUTE_BIT) {
      timestampBits = families[i].timestampValidBits;
      return static_cast<int>(i);
    }
  return -1;
}

int preference(const DeviceInfo& info) {
  const char* order[] = {"discrete", "integrated", "virtual", "other", "cpu"};
  return static_cast<int>(std::find(std::begin(order), std::end(order), info.type) - std::begin(order));
}

// Volk keeps its pointers to Vulkan's functions in global variables. They are written once, before any other use, and
// serve all instances in all threads. The instance from which they are loaded lives until the process ends, so drivers
// stay loaded too: some (NVIDIA's) can be loaded only about ten times, because they never free thread-local storage.
VkResult loadVulkan(const VkApplicationInfo& application) {
  static std::mutex mutex;
  static VkInstance kept = VK_NULL_HANDLE;
  const std::lock_guard lock(mutex);
  if (kept) return VK_SUCCESS;
  if (volkInitialize() != VK_SUCCESS)
    throw Error(ErrorCode::device,
                "no Vulkan loader (libvulkan.so.1) was found; install libvulkan1 and a driver, "
                "for instance mesa-vulkan-drivers");
  VkInstanceCreateInfo create = {VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO};
  create.pApplicationInfo = &application;
  const VkResult result = vkCreateInstance(&create, nullptr, &kept);
  if (result == VK_SUCCESS) volkLoadInstanceOnly(kept);
  return result;
}

VKAPI_ATTR VkBool32 VKAPI_CALL onMessage(VkDebugUtilsMessageSeverityFlagBitsEXT, VkDebugUtilsMessageTypeFlagsEXT,
                                         const VkDebugUtilsMessengerCallbackDataEXT* data, void* user) {
  static_cast<Messages*>(user)->add(data->pMessage);
  return VK_FALSE;
}

VkDebugUtilsMessengerCreateInfoEXT messengerOf(Messages& messages) {
  VkDebugUtilsMessengerCreateInfoEXT create = {VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT};
  create.messageSeverity =
      VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
  create.messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_TYPE_PERFORMANCE_BIT_EXT;
  create.pfnUserCallback = onMessage;
  create.pUserData = &messages;
  return create;
}

}  // namespace

void check(VkResult result, const char* call, const char* file, uint32_t line) {
  if (result == VK_SUCCESS) return;
  const char* name = std::strrchr(file, '/');
  const std::string text = std::string(call) + " gave " + resultName(result) + " (" + std::to_string(result) + ") at " +
                           (name ? name + 1 : file) + ":" + std::to_string(line);
  const bool memory = result == VK_ERROR_OUT_OF_DEVICE_MEMORY || result == VK_ERROR_OUT_OF_HOST_MEMORY;
  throw Error(memory ? ErrorCode::outOfMemory : ErrorCode::device, text);
}

bool offers(VkPhysicalDevice physical, const char* extension) {
  uint32_t count = 0;
  VK(vkEnumerateDeviceExtensionProperties(physical, nullptr, &count, nullptr));
  std::vector<VkExtensionProperties> extensions(count);
  VK(vkEnumerateDeviceExtensionProperties(physical, nullptr, &count, extensions.data()));
  return std::any_of(extensions.begin(), extensions.end(), [&](const VkExtensionProperties& offered) {
    return std::strcmp(offered.extensionName, extension) == 0;
  });
}

void Messages::add(const char* text) {
  const std::lock_guard lock(mutex_);
  texts_.emplace_back(text);
}

void Messages::throwIfAny() {
  const std::lock_guard lock(mutex_);
  if (texts_.empty()) return;
  std::string text = "Vulkan validation: " + texts_.front();
  if (texts_.size() > 1) text += " (and " + std::to_string(texts_.size() - 1) + " more)";
  texts_.clear();
  throw Error(ErrorCode::device, text);
}

ApiInstance::ApiInstance(bool validation) {
  VkApplicationInfo application = {VK_STRUCTURE_TYPE_APPLICATION_INFO};
  application.pApplicationName = "gnosphere";
  application.apiVersion = VK_API_VERSION_1_2;
  VkResult result = loadVulkan(application);
  const char* layer = "VK_LAYER_KHRONOS_validation";
  const char* extension = VK_EXT_DEBUG_UTILS_EXTENSION_NAME;
  VkDebugUtilsMessengerCreateInfoEXT messenger = messengerOf(*messages_);
  const VkValidationFeatureEnableEXT synchronization = VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT;
  VkValidationFeaturesEXT features = {VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT, &messenger};
  features.enabledValidationFeatureCount = 1;
  features.pEnabledValidationFeatures = &synchronization;
  VkInstanceCreateInfo create = {VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO};
  create.pApplicationInfo = &application;
  if (validation) {
    create.pNext = &features;
    create.enabledLayerCount = 1;
    create.ppEnabledLayerNames = &layer;
    create.enabledExtensionCount = 1;
    create.ppEnabledExtensionNames = &extension;
  }
  VkInstance instance = VK_NULL_HANDLE;
  if (result == VK_SUCCESS) result = vkCreateInstance(&create, nullptr, &instance);
  if (result == VK_ERROR_LAYER_NOT_PRESENT)
    throw Error(ErrorCode::device, "the Vulkan validation layer is not installed; install vulkan-validationlayers");
  if (result == VK_ERROR_INCOMPATIBLE_DRIVER)
    throw Error(ErrorCode::device, "no Vulkan driver was found; install one, for instance mesa-vulkan-drivers");
  check(result, "vkCreateInstance");
  instance_ = {instance, vkDestroyInstance};
  if (!validation) return;
  // Volk's pointers were loaded without extensions, so the functions of extensions are looked up here.
  const auto function = [&](const char* name) { return vkGetInstanceProcAddr(instance, name); };
  const auto make = reinterpret_cast<PFN_vkCreateDebugUtilsMessengerEXT>(function("vkCreateDebugUtilsMessengerEXT"));
  const auto destroy =
      reinterpret_cast<PFN_vkDestroyDebugUtilsMessengerEXT>(function("vkDestroyDebugUtilsMessengerEXT"));
  VkDebugUtilsMessengerEXT made = VK_NULL_HANDLE;
  VK(make(instance, &messenger, nullptr, &made));
  messenger_ = {made, destroy, instance};
}

std::vector<VkPhysicalDevice> ApiInstance::physicalDevices() const {
  uint32_t count = 0;
  VK(vkEnumeratePhysicalDevices(handle(), &count, nullptr));
  std::vector<VkPhysicalDevice> devices(count);
  if (count > 0) VK(vkEnumeratePhysicalDevices(handle(), &count, devices.data()));
  return devices;
}

FullSubgroups fullSubgroupsOf(const Offer& offer) {
  if (!offer.sizeControl.computeFullSubgroups) return {};
  if (kWorkgroupSize % offer.subgroup.subgroupSize == 0) return {offer.subgroup.subgroupSize, false};
  // Some devices by default use subgroups larger than our workgroups, but also support smaller ones.
  const bool choice = offer.sizeControl.subgroupSizeControl &&
                      (offer.sizes.requiredSubgroupSizeStages & VK_SHADER_STAGE_COMPUTE_BIT) &&
                      offer.sizes.minSubgroupSize <= kWorkgroupSize;
  return choice ? FullSubgroups{kWorkgroupSize, true} : FullSubgroups{};
}

// Older versions of lavapipe leave all loops of an invocation as soon as these have gone round 65535 times in all, and
// the rest of its work is lost without a word. Mesa 25.0.7 is the oldest that is known not to. lavapipe's driverVersion
// is 1 in every Mesa, so the version is read from the text, "Mesa 22.3.6 (LLVM 15.0.6)".
constexpr std::array<unsigned, 3> kLeastMesa = {25, 0, 7};

bool losesLoops(const VkPhysicalDeviceDriverProperties& driver) {
  if (driver.driverID != VK_DRIVER_ID_MESA_LLVMPIPE) return false;
  std::array<unsigned, 3> mesa = {};
  std::sscanf(driver.driverInfo, "Mesa %u.%u.%u", &mesa[0], &mesa[1], &mesa[2]);
  return mesa < kLeastMesa;
}

// Limits that Vulkan 1.2 guarantees are not checked: workgroups of 128 invocations with 16 KiB of shared memory, 65535
// workgroups per dispatch, and 128 bytes of push constants.
static_assert(kWorkgroupSize <= 128 && sizeof(gpu::Pass) <= 128);

std::string reasonAgainst(const Offer& offer) {
  constexpr VkSubgroupFeatureFlags kSubgroup = VK_SUBGROUP_FEATURE_BASIC_BIT | VK_SUBGROUP_FEATURE_BALLOT_BIT |
                                               VK_SUBGROUP_FEATURE_VOTE_BIT | VK_SUBGROUP_FEATURE_ARITHMETIC_BIT |
                                               VK_SUBGROUP_FEATURE_SHUFFLE_BIT;
  if (!offer.compute) return "it has no compute queue";
  if (!(offer.subgroup.supportedStages & VK_SHADER_STAGE_COMPUTE_BIT) ||
      (offer.subgroup.supportedOperations & kSubgroup) != kSubgroup)
    return "it lacks subgroup ballot, vote, shuffle or arithmetic in compute shaders";
  if (fullSubgroupsOf(offer).size == 0)
    return "it cannot promise full subgroups, of at most " + std::to_string(kWorkgroupSize) +
           " lanes, by " VK_EXT_SUBGROUP_SIZE_CONTROL_EXTENSION_NAME "; a newer driver may";
  if (!offer.features12.scalarBlockLayout) return "it lacks the scalar block layout";
  if (!offer.features12.bufferDeviceAddress) return "its shaders cannot find buffers by address";
  if (losesLoops(offer.driver))
    return "this lavapipe, " + std::string(offer.driver.driverInfo) +
           ", ends long loops early and would lose hits; Mesa 25.0.7 or newer is needed, on Debian 12 "
           "mesa-vulkan-drivers from bookworm-backports";
  return {};
}

Capabilities capabilitiesOf(VkPhysicalDevice physical) {
  Capabilities result;
  Offer offer;
  offer.driver = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES};
  VkPhysicalDeviceIDProperties id = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ID_PROPERTIES, &offer.driver};
  VkPhysicalDeviceMaintenance3Properties allocations = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MAINTENANCE_3_PROPERTIES,
                                                        &id};
  offer.subgroup = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES, &allocations};
  offer.sizes = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_SIZE_CONTROL_PROPERTIES_EXT, &offer.subgroup};
  offer.features12 = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES};
  offer.sizeControl = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_SIZE_CONTROL_FEATURES_EXT, &offer.features12};
  const bool sizeControl = offers(physical, VK_EXT_SUBGROUP_SIZE_CONTROL_EXTENSION_NAME);
  VkPhysicalDeviceProperties2 properties = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, &offer.subgroup, {}};
  VkPhysicalDeviceFeatures2 features = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, &offer.features12, {}};
  if (sizeControl) {
    properties.pNext = &offer.sizes;
    features.pNext = &offer.sizeControl;
  }
  VkPhysicalDeviceProperties basic;
  vkGetPhysicalDeviceProperties(physical, &basic);
  DeviceInfo& info = result.info;
  info.name = basic.deviceName;
  info.type = typeName(basic.deviceType);
  info.apiVersion = versionText(basic.apiVersion);
  result.cpu = basic.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU;
  if (basic.apiVersion < VK_API_VERSION_1_2) {
    info.reason = "it offers Vulkan " + info.apiVersion + ", 1.2 is needed";
    return result;
  }
  vkGetPhysicalDeviceProperties2(physical, &properties);
  vkGetPhysicalDeviceFeatures2(physical, &features);
  info.driver = std::string(offer.driver.driverName) + " " + offer.driver.driverInfo;
  info.maxBufferBytes = allocations.maxMemoryAllocationSize;
  std::copy(std::begin(id.deviceUUID), std::end(id.deviceUUID), info.uuid.begin());
  uint32_t timestampBits = 0;
  const int family = computeFamily(physical, timestampBits);
  result.queueFamily = static_cast<uint32_t>(std::max(family, 0));
  offer.compute = family >= 0;
  result.subgroups = fullSubgroupsOf(offer);
  info.subgroupSize = result.subgroups.size ? result.subgroups.size : offer.subgroup.subgroupSize;
  result.int64Atomics = features.features.shaderInt64 && offer.features12.shaderBufferInt64Atomics;
  result.float64 = features.features.shaderFloat64;
  result.timestampBits = basic.limits.timestampPeriod > 0 ? timestampBits : 0;
  result.timestampMs = basic.limits.timestampPeriod * 1e-6;
  info.reason = reasonAgainst(offer);
  info.usable = info.reason.empty();
  return result;
}

double Capabilities::elapsedMs(uint64_t from, uint64_t to) const {
  if (timestampBits == 0) return 0;
  return static_cast<double>((to - from) & (~uint64_t{0} >> (64 - timestampBits))) * timestampMs;
}

size_t chooseDevice(const std::vector<DeviceInfo>& devices, const DeviceChoice& choice) {
  const std::string& name = choice.name;
  const bool any = name.empty(), byUuid = choice.uuid != DeviceChoice().uuid;
  size_t index = devices.size();
  const char* end = name.data() + name.size();
  const bool isNumber = !name.empty() && std::from_chars(name.data(), end, index).ptr == end;
  const bool isIndex = isNumber && index < devices.size();
  std::string seen;
  std::vector<size_t> matches;
  for (size_t i = 0; i < devices.size(); ++i) {
    const DeviceInfo& info = devices[i];
    seen += "; " + std::to_string(i) + ": " + info.name + (info.usable ? "" : " (" + info.reason + ")");
    if (byUuid ? info.uuid == choice.uuid : any ? info.usable : isIndex ? index == i : containsWord(info.name, name))
      matches.push_back(i);
  }
  if (devices.empty())
    throw Error(ErrorCode::device,
                "no Vulkan device was found; install a driver (mesa-vulkan-drivers has a software "
                "one) or use the device 'reference'");
  if (matches.empty() && byUuid)
    throw Error(ErrorCode::device, "the device with the chosen UUID is no longer there" + seen);
  if (matches.empty() && any) throw Error(ErrorCode::device, "no Vulkan device can be used" + seen);
  if (matches.empty())
    throw Error(ErrorCode::invalidArgument,
                "there is no device '" + name + "'" +
                    (isNumber ? ", neither with this number nor with these digits in its name" : "") + seen +
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
  for (VkPhysicalDevice device : devices) infos.push_back(capabilitiesOf(device).info);
  return devices[chooseDevice(infos, choice)];
}

Device::Device(const DeviceChoice& choice, bool validation, uint64_t maxBufferBytes) : instance_(validation) {
  physical_ = chooseDevice(instance_, choice);
  capabilities_ = capabilitiesOf(physical_);
  if (maxBufferBytes > 0)
    capabilities_.info.maxBufferBytes = std::min(maxBufferBytes, capabilities_.info.maxBufferBytes);
  vkGetPhysicalDeviceMemoryProperties(physical_, &memory_);
  const float priority = 1;
  VkDeviceQueueCreateInfo queue = {VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO};
  queue.queueFamilyIndex = capabilities_.queueFamily;
  queue.queueCount = 1;
  queue.pQueuePriorities = &priority;
  VkPhysicalDeviceVulkan12Features features12 = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES};
  features12.shaderBufferInt64Atomics = capabilities_.int64Atomics;
  features12.scalarBlockLayout = VK_TRUE;
  features12.bufferDeviceAddress = VK_TRUE;
  VkPhysicalDeviceSubgroupSizeControlFeaturesEXT sizeControl = {
      VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_SIZE_CONTROL_FEATURES_EXT, &features12};
  sizeControl.subgroupSizeControl = capabilities_.subgroups.required;
  sizeControl.computeFullSubgroups = VK_TRUE;
  const char* extension = VK_EXT_SUBGROUP_SIZE_CONTROL_EXTENSION_NAME;
  VkPhysicalDeviceFeatures2 features = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, &sizeControl, {}};
  features.features.shaderInt64 = capabilities_.int64Atomics;
  features.features.shaderFloat64 = capabilities_.float64;
  VkDeviceCreateInfo create = {VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO, &features};
  create.queueCreateInfoCount = 1;
  create.pQueueCreateInfos = &queue;
  create.enabledExtensionCount = 1;
  create.ppEnabledExtensionNames = &extension;
  VkDevice device = VK_NULL_HANDLE;
  VK(vkCreateDevice(physical_, &create, nullptr, &device));
  volkLoadDeviceTable(&vk_, device);
  device_ = {device, vk_.vkDestroyDevice};
  vk_.vkGetDeviceQueue(device, capabilities_.queueFamily, 0, &queue_);
}

int Device::memoryType(uint32_t typeBits, VkMemoryPropertyFlags wanted) const {
  for (uint32_t i = 0; i < memory_.memoryTypeCount; ++i)
    if ((typeBits >> i & 1) && (memory_.memoryTypes[i].propertyFlags & wanted) == wanted) return static_cast<int>(i);
  return -1;
}

bool Device::isHostVisible(int memoryType) const {
  return memory_.memoryTypes[memoryType].propertyFlags & VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT;
}

bool Device::isCoherent(int memoryType) const {
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
      devices.push_back(vulkan::capabilitiesOf(physical).info);
    if (devices.empty() && problem) *problem = "no Vulkan device was found";
  } catch (const Error& error) {
    if (problem) *problem = error.what();
  }
  return devices;
}

}  // namespace gnosphere
