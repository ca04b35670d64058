// SPDX-License-Identifier: Apache-2.0
// The viewer's own Vulkan instance, device and buffers. GnoSphere adopts the viewer's device.
#pragma once

#include <vulkan/vulkan.h>

#include <cstdint>
#include <gnosphere/vulkan.hpp>
#include <string>
#include <vector>

struct GLFWwindow;

namespace viewer {

/// Throws if a call of Vulkan failed.
void require(VkResult result, const char* what);

/// A device that draws into a window, with what GnoSphere needs of it.
class Device {
 public:
  /// With `validate` the validation layer is on, if it is installed; its messages go to stderr.
  Device(GLFWwindow* window, bool validate);
  ~Device();
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  gnosphere::vulkan::AdoptedDevice adopted() const;
  /// Returns the number of the first memory type of `allowed` that has the properties, or VK_MAX_MEMORY_TYPES.
  uint32_t memoryType(uint32_t allowed, VkMemoryPropertyFlags properties) const;

  VkInstance instance = VK_NULL_HANDLE;
  VkSurfaceKHR surface = VK_NULL_HANDLE;
  VkPhysicalDevice physical = VK_NULL_HANDLE;
  VkDevice device = VK_NULL_HANDLE;
  VkQueue queue = VK_NULL_HANDLE;
  uint32_t family = 0;     ///< of the queue, which draws, computes and presents
  float largestPoint = 1;  ///< pixels

 private:
  void createInstance(bool validate);
  bool choose(VkPhysicalDevice candidate);
  void createDevice();

  gnosphere::vulkan::Requirements requirements_;
  VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
};

/// A buffer with memory of its own.
class Buffer {
 public:
  /// `mapped` is null unless the host is to see the buffer.
  enum class Memory { device, host };
  Buffer(const Device& on, VkDeviceSize size, VkBufferUsageFlags usage, Memory where);
  /// A buffer that holds a copy of the host's bytes.
  Buffer(const Device& on, const void* data, VkDeviceSize size, VkBufferUsageFlags usage);
  ~Buffer();
  Buffer(const Buffer&) = delete;
  Buffer& operator=(const Buffer&) = delete;

  gnosphere::vulkan::DeviceRange range() const;  ///< of a buffer with VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT

  VkBuffer buffer = VK_NULL_HANDLE;
  void* mapped = nullptr;

 private:
  VkDevice device_;
  VkDeviceMemory memory_ = VK_NULL_HANDLE;
  VkDeviceSize bytes_;
};

}  // namespace viewer
