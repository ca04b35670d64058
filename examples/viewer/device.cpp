// SPDX-License-Identifier: Apache-2.0
#include "device.hpp"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <stdexcept>

namespace viewer {
namespace {

constexpr const char* kLayer = "VK_LAYER_KHRONOS_validation";

VKAPI_ATTR VkBool32 VKAPI_CALL onMessage(VkDebugUtilsMessageSeverityFlagBitsEXT, VkDebugUtilsMessageTypeFlagsEXT,
                                         const VkDebugUtilsMessengerCallbackDataEXT* data, void*) {
  std::fprintf(stderr, "validation: %s\n", data->pMessage);
  return VK_FALSE;
}

bool hasLayer() {
  uint32_t count = 0;
  vkEnumerateInstanceLayerProperties(&count, nullptr);
  std::vector<VkLayerProperties> layers(count);
  vkEnumerateInstanceLayerProperties(&count, layers.data());
  return std::any_of(layers.begin(), layers.end(),
                     [](const VkLayerProperties& layer) { return std::strcmp(layer.layerName, kLayer) == 0; });
}

}  // namespace

void require(VkResult result, const char* what) {
  if (result != VK_SUCCESS)
    throw std::runtime_error(std::string(what) + " failed with VkResult " + std::to_string(result));
}

Device::Device(GLFWwindow* window, bool validate) {
  createInstance(validate);
  require(glfwCreateWindowSurface(instance, window, nullptr, &surface), "glfwCreateWindowSurface");
  uint32_t count = 0;
  vkEnumeratePhysicalDevices(instance, &count, nullptr);
  std::vector<VkPhysicalDevice> all(count);
  vkEnumeratePhysicalDevices(instance, &count, all.data());
  if (std::none_of(all.begin(), all.end(), [this](VkPhysicalDevice each) { return choose(each); }))
    throw std::runtime_error("there is no Vulkan device that draws into a window and has what GnoSphere needs");
  createDevice();
}

Device::~Device() {
  vkDestroyDevice(device, nullptr);
  vkDestroySurfaceKHR(instance, surface, nullptr);
  if (messenger_)
    reinterpret_cast<PFN_vkDestroyDebugUtilsMessengerEXT>(
        vkGetInstanceProcAddr(instance, "vkDestroyDebugUtilsMessengerEXT"))(instance, messenger_, nullptr);
  vkDestroyInstance(instance, nullptr);
}

void Device::createInstance(bool validate) {
  const bool validates = validate && hasLayer();
  if (validate && !validates) std::fprintf(stderr, "viewer: the validation layer is not installed\n");
  uint32_t count = 0;
  const char** const needed = glfwGetRequiredInstanceExtensions(&count);
  if (!needed) throw std::runtime_error("there is no Vulkan that can draw into a window here");
  std::vector<const char*> extensions(needed, needed + count);
  VkApplicationInfo application = {VK_STRUCTURE_TYPE_APPLICATION_INFO};
  application.pApplicationName = "viewer";
  application.apiVersion = VK_API_VERSION_1_2;
  VkInstanceCreateInfo create = {VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO};
  create.pApplicationInfo = &application;
  VkDebugUtilsMessengerCreateInfoEXT messenger = {VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT};
  messenger.messageSeverity =
      VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
  messenger.messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT;
  messenger.pfnUserCallback = onMessage;
  const VkValidationFeatureEnableEXT synchronization = VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT;
  VkValidationFeaturesEXT features = {VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT, &messenger, 1, &synchronization};
  if (validates) {
    extensions.push_back(VK_EXT_DEBUG_UTILS_EXTENSION_NAME);
    create.pNext = &features;
    create.enabledLayerCount = 1;
    create.ppEnabledLayerNames = &kLayer;
  }
  create.enabledExtensionCount = static_cast<uint32_t>(extensions.size());
  create.ppEnabledExtensionNames = extensions.data();
  require(vkCreateInstance(&create, nullptr, &instance), "vkCreateInstance");
  if (validates)
    require(reinterpret_cast<PFN_vkCreateDebugUtilsMessengerEXT>(vkGetInstanceProcAddr(
                instance, "vkCreateDebugUtilsMessengerEXT"))(instance, &messenger, nullptr, &messenger_),
            "vkCreateDebugUtilsMessengerEXT");
}

// Takes the device if it meets GnoSphere's requirements and has a queue that draws, computes and presents.
bool Device::choose(VkPhysicalDevice candidate) {
  requirements_ = gnosphere::vulkan::requirementsOf(vkGetInstanceProcAddr, instance, candidate);
  for (const std::string& sentence : requirements_.missing) std::fprintf(stderr, "viewer: %s\n", sentence.c_str());
  if (!requirements_.missing.empty()) return false;
  uint32_t count = 0;
  vkGetPhysicalDeviceQueueFamilyProperties(candidate, &count, nullptr);
  std::vector<VkQueueFamilyProperties> families(count);
  vkGetPhysicalDeviceQueueFamilyProperties(candidate, &count, families.data());
  constexpr VkQueueFlags kBoth = VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT;
  for (family = 0; family < count; ++family) {
    VkBool32 presents = VK_FALSE;
    vkGetPhysicalDeviceSurfaceSupportKHR(candidate, family, surface, &presents);
    if ((families[family].queueFlags & kBoth) == kBoth && presents) {
      physical = candidate;
      return true;
    }
  }
  return false;
}

void Device::createDevice() {
  const float priority = 1;
  VkDeviceQueueCreateInfo queues = {VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO};
  queues.queueFamilyIndex = family;
  queues.queueCount = 1;
  queues.pQueuePriorities = &priority;
  VkPhysicalDeviceSubgroupSizeControlFeaturesEXT sizes = {
      VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_SIZE_CONTROL_FEATURES_EXT};
  VkPhysicalDeviceVulkan12Features features12 = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES, &sizes};
  VkPhysicalDeviceFeatures2 features = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, &features12, {}};
  requirements_.addTo(&features.features, &features12, &sizes);
  // The viewer's own wishes: points larger than a pixel.
  VkPhysicalDeviceFeatures offered;
  vkGetPhysicalDeviceFeatures(physical, &offered);
  features.features.largePoints = offered.largePoints;
  VkPhysicalDeviceProperties properties;
  vkGetPhysicalDeviceProperties(physical, &properties);
  if (offered.largePoints) largestPoint = properties.limits.pointSizeRange[1];
  std::vector<const char*> extensions = requirements_.extensions;
  extensions.push_back(VK_KHR_SWAPCHAIN_EXTENSION_NAME);
  VkDeviceCreateInfo create = {VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO, &features};
  create.queueCreateInfoCount = 1;
  create.pQueueCreateInfos = &queues;
  create.enabledExtensionCount = static_cast<uint32_t>(extensions.size());
  create.ppEnabledExtensionNames = extensions.data();
  require(vkCreateDevice(physical, &create, nullptr, &device), "vkCreateDevice");
  vkGetDeviceQueue(device, family, 0, &queue);
}

gnosphere::vulkan::AdoptedDevice Device::adopted() const {
  gnosphere::vulkan::AdoptedDevice result;
  result.getInstanceProcAddr = vkGetInstanceProcAddr;
  result.instance = instance;
  result.physicalDevice = physical;
  result.device = device;
  result.queueFamily = family;
  result.enabled = requirements_;
  return result;
}

uint32_t Device::memoryType(uint32_t allowed, VkMemoryPropertyFlags properties) const {
  VkPhysicalDeviceMemoryProperties memory;
  vkGetPhysicalDeviceMemoryProperties(physical, &memory);
  for (uint32_t i = 0; i < memory.memoryTypeCount; ++i)
    if ((allowed >> i & 1) && (memory.memoryTypes[i].propertyFlags & properties) == properties) return i;
  return VK_MAX_MEMORY_TYPES;
}

Buffer::Buffer(const Device& on, VkDeviceSize size, VkBufferUsageFlags usage, Memory where)
    : device_(on.device), bytes_(size) {
  VkBufferCreateInfo create = {VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
  create.size = size;
  create.usage = usage;
  require(vkCreateBuffer(device_, &create, nullptr, &buffer), "vkCreateBuffer");
  VkMemoryRequirements needs;
  vkGetBufferMemoryRequirements(device_, buffer, &needs);
  constexpr VkMemoryPropertyFlags kHost = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
  VkMemoryAllocateFlagsInfo flags = {VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO};
  flags.flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT;
  VkMemoryAllocateInfo allocate = {VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, &flags, needs.size};
  allocate.memoryTypeIndex =
      on.memoryType(needs.memoryTypeBits, where == Memory::host ? kHost : VkFlags{VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT});
  require(vkAllocateMemory(device_, &allocate, nullptr, &memory_), "vkAllocateMemory");
  require(vkBindBufferMemory(device_, buffer, memory_, 0), "vkBindBufferMemory");
  if (where == Memory::host) require(vkMapMemory(device_, memory_, 0, VK_WHOLE_SIZE, 0, &mapped), "vkMapMemory");
}

Buffer::Buffer(const Device& on, const void* data, VkDeviceSize size, VkBufferUsageFlags usage)
    : Buffer(on, std::max<VkDeviceSize>(size, 4), usage, Memory::host) {
  std::memcpy(mapped, data, size);
}

Buffer::~Buffer() {
  vkDestroyBuffer(device_, buffer, nullptr);
  vkFreeMemory(device_, memory_, nullptr);
}

gnosphere::vulkan::DeviceRange Buffer::range() const {
  const VkBufferDeviceAddressInfo where = {VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO, nullptr, buffer};
  return {vkGetBufferDeviceAddress(device_, &where), bytes_};
}

}  // namespace viewer
