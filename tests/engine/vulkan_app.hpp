// SPDX-License-Identifier: Apache-2.0
// A small Vulkan application, as an engine is one: it creates the device, submits, waits, and owns the buffers.
#pragma once

#include <dlfcn.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <optional>
#include <utility>

#include "gnosphere/vulkan.hpp"
#include "support.hpp"
#include "vulkan/functions.hpp"

namespace gnosphere::test {

class VulkanApp {
 public:
  /// Uses the first device that meets the requirements and whose name contains `name`. `lookUp` replaces
  /// vkGetInstanceProcAddr() for the library, but not for the application. Of `extensions`, which the application wants
  /// for itself, the device has those that it can have; see has().
  explicit VulkanApp(const std::string& name = "", PFN_vkGetInstanceProcAddr lookUp = nullptr,
                     const std::vector<std::string>& extensions = {})
      : wanted_(extensions) {
    wanted_.push_back(VK_KHR_SHADER_SUBGROUP_UNIFORM_CONTROL_FLOW_EXTENSION_NAME);
    loader_ = dlopen("libvulkan.so.1", RTLD_NOW);
    REQUIRE(loader_);
    get_ = reinterpret_cast<PFN_vkGetInstanceProcAddr>(dlsym(loader_, "vkGetInstanceProcAddr"));
    createInstance();
    instanceFunctions_ = vulkan::functionsOf(get_, instance_);
    createDevice(name);
    adopted_.getInstanceProcAddr = lookUp ? lookUp : get_;
    adopted_.instance = instance_;
    adopted_.device = device_;
    VkCommandPoolCreateInfo pool = {VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
    pool.flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT;
    pool.queueFamilyIndex = adopted_.queueFamily;
    REQUIRE(vk_.vkCreateCommandPool(device_, &pool, nullptr, &pool_) == VK_SUCCESS);
  }
  ~VulkanApp() {
    keeper_.reset();
    waitForQueue();
    vk_.vkDestroyCommandPool(device_, pool_, nullptr);
    vk_.vkDestroyDevice(device_, nullptr);
    if (messenger_) {
      const auto destroy =
          reinterpret_cast<PFN_vkDestroyDebugUtilsMessengerEXT>(get_(instance_, "vkDestroyDebugUtilsMessengerEXT"));
      destroy(instance_, messenger_, nullptr);
    }
    instanceFunctions_.vkDestroyInstance(instance_, nullptr);
    CHECK(messages == std::vector<std::string>());
  }
  VulkanApp(const VulkanApp&) = delete;
  VulkanApp& operator=(const VulkanApp&) = delete;

  /// A buffer of the application with a guard of 64 bytes on either side; the host sees all of it.
  class Buffer {
   public:
    static constexpr size_t kGuard = 64;
    Buffer(const VulkanApp& app, size_t bytes) : app_(app), bytes_(bytes) {
      const auto& vk = app.vk_;
      VkBufferCreateInfo create = {VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
      create.size = bytes + 2 * kGuard;
      create.usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT |
                     VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
      REQUIRE(vk.vkCreateBuffer(app.device_, &create, nullptr, &buffer_) == VK_SUCCESS);
      VkMemoryRequirements requirements;
      vk.vkGetBufferMemoryRequirements(app.device_, buffer_, &requirements);
      VkMemoryAllocateFlagsInfo flags = {VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO};
      flags.flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT;
      VkMemoryAllocateInfo allocate = {VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, &flags};
      allocate.allocationSize = requirements.size;
      allocate.memoryTypeIndex = app.hostMemory(requirements.memoryTypeBits);
      REQUIRE(vk.vkAllocateMemory(app.device_, &allocate, nullptr, &memory_) == VK_SUCCESS);
      REQUIRE(vk.vkBindBufferMemory(app.device_, buffer_, memory_, 0) == VK_SUCCESS);
      void* host = nullptr;
      REQUIRE(vk.vkMapMemory(app.device_, memory_, 0, VK_WHOLE_SIZE, 0, &host) == VK_SUCCESS);
      host_ = static_cast<std::byte*>(host);
      clear();
    }
    ~Buffer() {
      app_.waitForQueue();  // kernels may still write into it
      app_.vk_.vkDestroyBuffer(app_.device_, buffer_, nullptr);
      app_.vk_.vkFreeMemory(app_.device_, memory_, nullptr);
    }
    Buffer(const Buffer&) = delete;
    Buffer& operator=(const Buffer&) = delete;

    vulkan::DeviceRange range() const {
      VkBufferDeviceAddressInfo where = {VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO};
      where.buffer = buffer_;
      return {app_.vk_.vkGetBufferDeviceAddress(app_.device_, &where) + kGuard, bytes_};
    }
    std::span<const std::byte> bytes() const { return {host_ + kGuard, bytes_}; }
    std::span<std::byte> bytes() { return {host_ + kGuard, bytes_}; }
    /// Records a copy of all of another buffer of this size to this one.
    void copyFrom(VkCommandBuffer commands, const Buffer& other) {
      const VkBufferCopy region = {kGuard, kGuard, bytes_};
      app_.vk_.vkCmdCopyBuffer(commands, other.buffer_, buffer_, 1, &region);
    }
    template <typename T>
    const T* as() const {
      return reinterpret_cast<const T*>(host_ + kGuard);
    }
    void clear() { std::fill_n(host_, bytes_ + 2 * kGuard, std::byte{0xa5}); }
    /// Returns whether only the buffer itself has been written to.
    bool guarded() const {
      const auto intact = [](std::byte value) { return value == std::byte{0xa5}; };
      return std::all_of(host_, host_ + kGuard, intact) &&
             std::all_of(host_ + kGuard + bytes_, host_ + 2 * kGuard + bytes_, intact);
    }

   private:
    const VulkanApp& app_;
    size_t bytes_;
    VkBuffer buffer_ = VK_NULL_HANDLE;
    VkDeviceMemory memory_ = VK_NULL_HANDLE;
    std::byte* host_ = nullptr;
  };

  /// A command buffer with its fence.
  class Frame {
   public:
    explicit Frame(const VulkanApp& app) : app_(app) {
      VkCommandBufferAllocateInfo allocate = {VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
      allocate.commandPool = app.pool_;
      allocate.commandBufferCount = 1;
      REQUIRE(app.vk_.vkAllocateCommandBuffers(app.device_, &allocate, &commands_) == VK_SUCCESS);
      const VkFenceCreateInfo fence = {VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
      REQUIRE(app.vk_.vkCreateFence(app.device_, &fence, nullptr, &fence_) == VK_SUCCESS);
    }
    ~Frame() {
      wait();
      app_.vk_.vkDestroyFence(app_.device_, fence_, nullptr);
    }
    Frame(const Frame&) = delete;
    Frame& operator=(const Frame&) = delete;

    VkCommandBuffer begin() {
      wait();
      VkCommandBufferBeginInfo begin = {VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
      begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
      REQUIRE(app_.vk_.vkBeginCommandBuffer(commands_, &begin) == VK_SUCCESS);
      return commands_;
    }
    /// Ends the commands, which are not submitted.
    void end() { REQUIRE(app_.vk_.vkEndCommandBuffer(commands_) == VK_SUCCESS); }
    void submit() {
      end();
      VkSubmitInfo submit = {VK_STRUCTURE_TYPE_SUBMIT_INFO};
      submit.commandBufferCount = 1;
      submit.pCommandBuffers = &commands_;
      REQUIRE(app_.vk_.vkQueueSubmit(app_.queue_, 1, &submit, fence_) == VK_SUCCESS);
      pending_ = true;
    }
    void wait() {
      if (!pending_) return;
      REQUIRE(app_.vk_.vkWaitForFences(app_.device_, 1, &fence_, VK_TRUE, UINT64_MAX) == VK_SUCCESS);
      REQUIRE(app_.vk_.vkResetFences(app_.device_, 1, &fence_) == VK_SUCCESS);
      pending_ = false;
    }

   private:
    const VulkanApp& app_;
    VkCommandBuffer commands_ = VK_NULL_HANDLE;
    VkFence fence_ = VK_NULL_HANDLE;
    bool pending_ = false;
  };

  const vulkan::AdoptedDevice& adopted() const { return adopted_; }
  void setAdopted(const vulkan::AdoptedDevice& device) {
    keeper_.reset();
    adopted_ = device;
  }
  /// The choice of this device. Simulators made with it share their kernels for as long as the application is there.
  const DeviceChoice& choice() {
    if (!keeper_) {
      SimulatorOptions options = vulkanOptions();
      options.device = choice_ = vulkan::adopt(adopted_);
      options.validation = false;
      keeper_.emplace(Scene(), std::vector<SensorRequest>(), options);
    }
    return choice_;
  }
  const std::string& deviceName() const { return name_; }
  const vulkan::DeviceFunctions& vk() const { return vk_; }
  VkQueue queue() const { return queue_; }
  void waitForQueue() const { vk_.vkQueueWaitIdle(queue_); }
  bool has(const std::string& extension) const { return std::ranges::count(extensions_, extension) > 0; }
  /// A function of the device that is not in vk().
  template <typename Function>
  Function function(const char* name) const {
    const auto found = reinterpret_cast<Function>(instanceFunctions_.vkGetDeviceProcAddr(device_, name));
    REQUIRE(found);
    return found;
  }
  /// A type of memory that the host sees.
  uint32_t hostMemory(uint32_t typeBits) const {
    const VkPhysicalDeviceMemoryProperties memory = memoryProperties();
    constexpr VkMemoryPropertyFlags kHost = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    for (uint32_t i = 0; i < memory.memoryTypeCount; ++i)
      if ((typeBits >> i & 1) && (memory.memoryTypes[i].propertyFlags & kHost) == kHost) return i;
    FAIL("the device has no memory that the host sees");
    return 0;
  }
  bool isHostVisible(uint32_t memoryType) const {
    return (memoryProperties().memoryTypes[memoryType].propertyFlags & VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT) != 0;
  }
  PFN_vkGetInstanceProcAddr loader() const { return get_; }

  std::vector<std::string> messages;  ///< of the validation layer

 private:
  VkPhysicalDeviceMemoryProperties memoryProperties() const {
    VkPhysicalDeviceMemoryProperties memory;
    instanceFunctions_.vkGetPhysicalDeviceMemoryProperties(adopted_.physicalDevice, &memory);
    return memory;
  }

  static VKAPI_ATTR VkBool32 VKAPI_CALL onMessage(VkDebugUtilsMessageSeverityFlagBitsEXT,
                                                  VkDebugUtilsMessageTypeFlagsEXT,
                                                  const VkDebugUtilsMessengerCallbackDataEXT* data, void* user) {
    static_cast<VulkanApp*>(user)->messages.emplace_back(data->pMessage);
    return VK_FALSE;
  }

  void createInstance() {
    const auto create = reinterpret_cast<PFN_vkCreateInstance>(get_(nullptr, "vkCreateInstance"));
    VkApplicationInfo application = {VK_STRUCTURE_TYPE_APPLICATION_INFO};
    application.apiVersion = VK_API_VERSION_1_2;
    VkInstanceCreateInfo info = {VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO};
    info.pApplicationInfo = &application;
    VkDebugUtilsMessengerCreateInfoEXT messenger = {VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT};
    messenger.messageSeverity =
        VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
    messenger.messageType =
        VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_TYPE_PERFORMANCE_BIT_EXT;
    messenger.pfnUserCallback = onMessage;
    messenger.pUserData = this;
    const VkValidationFeatureEnableEXT synchronization = VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT;
    VkValidationFeaturesEXT features = {VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT, &messenger};
    features.enabledValidationFeatureCount = 1;
    features.pEnabledValidationFeatures = &synchronization;
    const char* layer = "VK_LAYER_KHRONOS_validation";
    const char* extension = VK_EXT_DEBUG_UTILS_EXTENSION_NAME;
    const bool validates = vulkanOptions().validation;
    if (validates) {
      info.pNext = &features;
      info.enabledLayerCount = info.enabledExtensionCount = 1;
      info.ppEnabledLayerNames = &layer;
      info.ppEnabledExtensionNames = &extension;
    }
    REQUIRE(create(&info, nullptr, &instance_) == VK_SUCCESS);
    if (!validates) return;
    const auto make =
        reinterpret_cast<PFN_vkCreateDebugUtilsMessengerEXT>(get_(instance_, "vkCreateDebugUtilsMessengerEXT"));
    REQUIRE(make(instance_, &messenger, nullptr, &messenger_) == VK_SUCCESS);
  }

  void chooseExtensions() {
    extensions_.assign(adopted_.enabled.extensions.begin(), adopted_.enabled.extensions.end());
    uint32_t count = 0;
    const auto list = instanceFunctions_.vkEnumerateDeviceExtensionProperties;
    list(adopted_.physicalDevice, nullptr, &count, nullptr);
    std::vector<VkExtensionProperties> all(count);
    list(adopted_.physicalDevice, nullptr, &count, all.data());
    for (const std::string& extension : wanted_)
      if (std::ranges::any_of(all, [&](const auto& each) { return each.extensionName == extension; }))
        extensions_.push_back(extension);
  }

  void createDevice(const std::string& name) {
    uint32_t count = 0;
    instanceFunctions_.vkEnumeratePhysicalDevices(instance_, &count, nullptr);
    std::vector<VkPhysicalDevice> physicals(count);
    instanceFunctions_.vkEnumeratePhysicalDevices(instance_, &count, physicals.data());
    for (VkPhysicalDevice physical : physicals) {
      VkPhysicalDeviceProperties properties;
      instanceFunctions_.vkGetPhysicalDeviceProperties(physical, &properties);
      const vulkan::Requirements needed = vulkan::requirementsOf(get_, instance_, physical);
      if (!needed.missing.empty() || std::string(properties.deviceName).find(name) == std::string::npos) continue;
      adopted_.physicalDevice = physical;
      adopted_.enabled = needed;
      name_ = properties.deviceName;
      break;
    }
    REQUIRE(adopted_.physicalDevice);
    // The application has a chain of its own, to which it adds what the library needs.
    VkPhysicalDeviceSubgroupSizeControlFeaturesEXT sizes = {
        VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_SIZE_CONTROL_FEATURES_EXT};
    VkPhysicalDeviceVulkan12Features features12 = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES, &sizes};
    features12.timelineSemaphore = VK_TRUE;
    VkPhysicalDeviceFeatures2 features = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, &features12, {}};
    adopted_.enabled.addTo(&features.features, &features12, &sizes);
    VkPhysicalDeviceShaderSubgroupUniformControlFlowFeaturesKHR uniform = {
        VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SHADER_SUBGROUP_UNIFORM_CONTROL_FLOW_FEATURES_KHR};
    chooseExtensions();
    if (has(VK_KHR_SHADER_SUBGROUP_UNIFORM_CONTROL_FLOW_EXTENSION_NAME)) {
      VkPhysicalDeviceFeatures2 offered = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, &uniform, {}};
      instanceFunctions_.vkGetPhysicalDeviceFeatures2(adopted_.physicalDevice, &offered);
      adopted_.uniformControlFlow = uniform.shaderSubgroupUniformControlFlow != VK_FALSE;
      sizes.pNext = &uniform;
    }
    const float priority = 1;
    VkDeviceQueueCreateInfo queue = {VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO};
    queue.queueCount = 1;
    queue.pQueuePriorities = &priority;
    VkDeviceCreateInfo info = {VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO, &features};
    info.queueCreateInfoCount = 1;
    info.pQueueCreateInfos = &queue;
    std::vector<const char*> names;
    for (const std::string& extension : extensions_) names.push_back(extension.c_str());
    info.enabledExtensionCount = static_cast<uint32_t>(names.size());
    info.ppEnabledExtensionNames = names.data();
    REQUIRE(instanceFunctions_.vkCreateDevice(adopted_.physicalDevice, &info, nullptr, &device_) == VK_SUCCESS);
    vk_ = vulkan::functionsOf(instanceFunctions_.vkGetDeviceProcAddr, device_);
    vk_.vkGetDeviceQueue(device_, 0, 0, &queue_);
  }

  void* loader_ = nullptr;
  PFN_vkGetInstanceProcAddr get_ = nullptr;
  VkInstance instance_ = VK_NULL_HANDLE;
  VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
  vulkan::InstanceFunctions instanceFunctions_;
  VkDevice device_ = VK_NULL_HANDLE;
  vulkan::DeviceFunctions vk_;
  VkQueue queue_ = VK_NULL_HANDLE;
  VkCommandPool pool_ = VK_NULL_HANDLE;
  vulkan::AdoptedDevice adopted_;
  DeviceChoice choice_;
  std::optional<Simulator> keeper_;  // of the kernels
  std::vector<std::string> wanted_, extensions_;
  std::string name_;
};

/// The application of a test that needs no device of its own. The tests of a program have one device, on which their
/// simulators find the kernels that simulators of earlier tests have compiled.
class CommonApp {
 public:
  CommonApp() : app(common()) {}
  ~CommonApp() {
    app.waitForQueue();
    CHECK(std::exchange(app.messages, {}) == std::vector<std::string>());
  }
  CommonApp(const CommonApp&) = delete;
  CommonApp& operator=(const CommonApp&) = delete;

  VulkanApp& app;

 private:
  // The end of the process does not destroy it, because drivers may have unloaded parts of themselves before.
  static VulkanApp& common() {
    static VulkanApp& one = *new VulkanApp;
    return one;
  }
};

}  // namespace gnosphere::test
