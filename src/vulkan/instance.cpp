// SPDX-License-Identifier: Apache-2.0
#include "vulkan/instance.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>
#include <utility>

#include "base/os.hpp"
#include "gnosphere/error.hpp"
#include "vulkan/driver_advice.hpp"

namespace gnosphere::vulkan {
namespace {

// The functions of Vulkan's loader that need no instance.
struct Loader {
  PFN_vkGetInstanceProcAddr lookUp = nullptr;
  PFN_vkCreateInstance createInstance = nullptr;
  PFN_vkEnumerateInstanceExtensionProperties extensions = nullptr;
};

Loader openLoader() {
  const std::vector<std::string> names = os::vulkanLoaders();
  void* library = nullptr;
  for (size_t i = 0; i < names.size() && !library; ++i) library = os::openLibrary(names[i]);
  Loader loader;
  if (library)
    loader.lookUp = reinterpret_cast<PFN_vkGetInstanceProcAddr>(os::symbolOf(library, "vkGetInstanceProcAddr"));
  if (!loader.lookUp)
    throw Error(ErrorCode::device, "no Vulkan loader (" + names[0] + ") and driver was found; " + driverRemedy());
  loader.createInstance = reinterpret_cast<PFN_vkCreateInstance>(loader.lookUp(nullptr, "vkCreateInstance"));
  loader.extensions = reinterpret_cast<PFN_vkEnumerateInstanceExtensionProperties>(
      loader.lookUp(nullptr, "vkEnumerateInstanceExtensionProperties"));
  return loader;
}

// The loader is opened once, serves all threads, and stays open until the process ends.
const Loader& vulkanLoader() {
  static const Loader loader = openLoader();
  return loader;
}

bool instanceOffers(const char* extension) {
  uint32_t count = 0;
  if (vulkanLoader().extensions(nullptr, &count, nullptr) != VK_SUCCESS) return false;
  std::vector<VkExtensionProperties> offered(count);
  if (vulkanLoader().extensions(nullptr, &count, offered.data()) != VK_SUCCESS) return false;
  return std::any_of(offered.begin(), offered.end(),
                     [&](const VkExtensionProperties& one) { return std::strcmp(one.extensionName, extension) == 0; });
}

// The loader hides drivers that leave out parts of Vulkan, as MoltenVK does, unless an instance enumerates portability
// drivers. capabilitiesOf() finds out whether such a driver has all that scans need.
void wantEveryDriver(VkInstanceCreateInfo& create, std::vector<const char*>& extensions) {
  if (instanceOffers(VK_KHR_PORTABILITY_ENUMERATION_EXTENSION_NAME)) {
    extensions.push_back(VK_KHR_PORTABILITY_ENUMERATION_EXTENSION_NAME);
    create.flags |= VK_INSTANCE_CREATE_ENUMERATE_PORTABILITY_BIT_KHR;
  }
  create.enabledExtensionCount = static_cast<uint32_t>(extensions.size());
  create.ppEnabledExtensionNames = extensions.data();
}

// The first instance lives until the process ends, so drivers stay loaded: some (NVIDIA's) can be loaded only about ten
// times, because they never free thread-local storage.
VkResult keepDrivers(const VkApplicationInfo& application) {
  static std::mutex mutex;
  static VkInstance kept = VK_NULL_HANDLE;
  const std::lock_guard lock(mutex);
  if (kept) return VK_SUCCESS;
  VkInstanceCreateInfo create = {VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO};
  create.pApplicationInfo = &application;
  std::vector<const char*> extensions;
  wantEveryDriver(create, extensions);
  return vulkanLoader().createInstance(&create, nullptr, &kept);
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

// The loader says no more of drivers that it cannot load than a number.
void checkDrivers(VkResult result, const char* call) {
  if (result == VK_SUCCESS) return;
  throw Error(result == VK_ERROR_OUT_OF_HOST_MEMORY ? ErrorCode::outOfMemory : ErrorCode::device,
              "no Vulkan driver can be loaded: " + std::string(call) + " gave " + resultName(result) +
                  "; VK_LOADER_DEBUG=error,driver prints why, and " + driverRemedy());
}

using Uuid = std::array<uint8_t, VK_UUID_SIZE>;

// Returns the UUIDs of a device and of its driver. Before Vulkan 1.1 a device has none, and both are zeros.
std::pair<Uuid, Uuid> uuidsOf(const InstanceFunctions& vk, VkPhysicalDevice device) {
  VkPhysicalDeviceIDProperties id = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ID_PROPERTIES};
  VkPhysicalDeviceProperties2 properties = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, &id};
  vk.vkGetPhysicalDeviceProperties(device, &properties.properties);
  if (properties.properties.apiVersion < VK_API_VERSION_1_1) return {};
  vk.vkGetPhysicalDeviceProperties2(device, &properties);
  return {std::to_array(id.deviceUUID), std::to_array(id.driverUUID)};
}

}  // namespace

std::string driverRemedy() {
  for (const char* variable : {"VK_DRIVER_FILES", "VK_ICD_FILENAMES"})
    if (const char* files = std::getenv(variable))
      return "the variable " + std::string(variable) + " is '" + files +
             "' and hides all other drivers: unset it, or " + driverAdvice;
  return driverAdvice;
}

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
    case VK_ERROR_UNKNOWN: return "VK_ERROR_UNKNOWN";
    default: return "VkResult";
  }
}

void check(VkResult result, const char* call, const char* file, uint32_t line) {
  if (result == VK_SUCCESS) return;
  const char* name = std::strrchr(file, '/');
  const std::string text = std::string(call) + " gave " + resultName(result) + " (" + std::to_string(result) + ") at " +
                           (name ? name + 1 : file) + ":" + std::to_string(line);
  const bool memory = result == VK_ERROR_OUT_OF_DEVICE_MEMORY || result == VK_ERROR_OUT_OF_HOST_MEMORY;
  throw Error(memory ? ErrorCode::outOfMemory : ErrorCode::device, text);
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
  VkResult result = keepDrivers(application);
  const char* layer = "VK_LAYER_KHRONOS_validation";
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
  }
  std::vector<const char*> extensions;
  // Without validation it serves to name objects and stages for tools such as RenderDoc.
  if (validation || instanceOffers(VK_EXT_DEBUG_UTILS_EXTENSION_NAME))
    extensions.push_back(VK_EXT_DEBUG_UTILS_EXTENSION_NAME);
  wantEveryDriver(create, extensions);
  VkInstance instance = VK_NULL_HANDLE;
  if (result == VK_SUCCESS) result = vulkanLoader().createInstance(&create, nullptr, &instance);
  if (result == VK_ERROR_LAYER_NOT_PRESENT)
    throw Error(ErrorCode::device, "the Vulkan validation layer is not installed; install vulkan-validationlayers");
  if (result == VK_ERROR_INCOMPATIBLE_DRIVER)
    throw Error(ErrorCode::device, "no Vulkan driver was found; " + driverRemedy());
  checkDrivers(result, "vkCreateInstance");
  functions_ = functionsOf(vulkanLoader().lookUp, instance);
  instance_ = {instance, functions_.vkDestroyInstance, nullptr};
  if (!validation) return;

  const auto function = [&](const char* name) { return vulkanLoader().lookUp(instance, name); };
  const auto make = reinterpret_cast<PFN_vkCreateDebugUtilsMessengerEXT>(function("vkCreateDebugUtilsMessengerEXT"));
  const auto destroy =
      reinterpret_cast<PFN_vkDestroyDebugUtilsMessengerEXT>(function("vkDestroyDebugUtilsMessengerEXT"));
  VkDebugUtilsMessengerEXT made = VK_NULL_HANDLE;
  VK(make(instance, &messenger, nullptr, &made));
  messenger_ = {made, destroy, instance, nullptr};
}

// The loader lists a device once for each manifest of its driver, and containers often have two.
std::vector<VkPhysicalDevice> ApiInstance::physicalDevices() const {
  uint32_t count = 0;
  checkDrivers(functions_.vkEnumeratePhysicalDevices(handle(), &count, nullptr), "vkEnumeratePhysicalDevices");
  std::vector<VkPhysicalDevice> listed(count), devices;
  if (count > 0) VK(functions_.vkEnumeratePhysicalDevices(handle(), &count, listed.data()));
  std::vector<std::pair<Uuid, Uuid>> seen;  // of the device and of its driver
  for (VkPhysicalDevice device : listed) {
    const std::pair<Uuid, Uuid> uuids = uuidsOf(functions_, device);
    if (uuids != std::pair<Uuid, Uuid>() && std::find(seen.begin(), seen.end(), uuids) != seen.end()) continue;
    seen.push_back(uuids);
    devices.push_back(device);
  }
  return devices;
}

}  // namespace gnosphere::vulkan
