// SPDX-License-Identifier: Apache-2.0
// A Vulkan device with ray tracing: its memory, and commands that are run and timed.
#pragma once

#include <volk.h>

#include <functional>
#include <string>
#include <vector>

#include "rivals/vulkan.hpp"
#include "vulkan/buffer.hpp"

namespace gnosphere::bench {

class RayDevice;

/// A buffer that shaders and builds access by address. Memory that the host sees is coherent.
class RayBuffer {
 public:
  RayBuffer() = default;
  /// Text `name` describes the content. Throws Error(outOfMemory) if there is no memory.
  RayBuffer(const RayDevice& device, const char* name, uint64_t bytes, MemoryKind memory);
  ~RayBuffer();
  RayBuffer(RayBuffer&& other) noexcept { swap(other); }
  RayBuffer& operator=(RayBuffer&& other) noexcept {
    swap(other);
    return *this;
  }

  VkBuffer handle() const { return buffer_; }
  uint64_t bytes() const { return bytes_; }
  VkDeviceAddress address() const { return address_; }
  void* mapped() const { return mapped_; }  ///< null if the memory is not host-visible

 private:
  void swap(RayBuffer& other) noexcept;

  VkDevice device_ = VK_NULL_HANDLE;
  VkBuffer buffer_ = VK_NULL_HANDLE;
  VkDeviceMemory memory_ = VK_NULL_HANDLE;
  VkDeviceAddress address_ = 0;
  void* mapped_ = nullptr;
  uint64_t bytes_ = 0;
};

/// A part of a buffer.
struct Slice {
  const RayBuffer* buffer = nullptr;
  uint64_t offset = 0, bytes = 0;
  VkDeviceAddress address() const { return buffer->address() + offset; }
};

/// Many slices in few allocations, because a device supports only some thousands of allocations.
class Arena {
 public:
  Arena(const RayDevice& device, const char* name) : device_(device), name_(name) {}
  /// Returns a slice at a multiple of 256 bytes, which acceleration structures require.
  Slice take(uint64_t bytes);
  uint64_t bytes() const { return bytes_; }  ///< bytes taken

 private:
  const RayDevice& device_;
  const char* name_;
  std::vector<std::unique_ptr<RayBuffer>> blocks_;
  uint64_t used_ = 0;  // bytes used in the last block
  uint64_t bytes_ = 0;
};

using Record = std::function<void(VkCommandBuffer)>;

class RayDevice {
 public:
  /// Opens the device that the library would choose, with acceleration structures and `extension` (ray query or
  /// ray-tracing pipeline). Throws Error(device) with the feature that it lacks.
  RayDevice(const VulkanOptions& options, const char* extension);
  ~RayDevice();
  RayDevice(const RayDevice&) = delete;
  RayDevice& operator=(const RayDevice&) = delete;

  VkDevice handle() const { return device_; }
  VkPhysicalDevice physical() const { return physical_; }
  const vulkan::Capabilities& capabilities() const { return capabilities_; }
  bool hasPipeline() const { return pipeline_; }
  uint64_t maxAllocationBytes() const { return maxAllocationBytes_; }
  uint64_t scratchAlignment() const { return scratchAlignment_; }
  const VkPhysicalDeviceMemoryProperties& memory() const { return memory_; }

  /// Runs `timed`, then `rest`, and waits. Returns the milliseconds of `timed` by the device's clock, 0 if it has none.
  double run(const Record& timed, const Record& rest = {});
  void write(const Slice& to, const void* data, uint64_t bytes);
  /// Throws Error(device) with the messages of the validation layer.
  void throwOnMessages() { instance_.throwOnMessages(); }

 private:
  void createDevice(const char* extension);
  void createCommands();

  vulkan::ApiInstance instance_;
  VkPhysicalDevice physical_ = VK_NULL_HANDLE;
  vulkan::Capabilities capabilities_;
  VkPhysicalDeviceMemoryProperties memory_ = {};
  uint64_t maxAllocationBytes_ = 0, scratchAlignment_ = 0;
  bool pipeline_ = false;
  VkDevice device_ = VK_NULL_HANDLE;
  VkQueue queue_ = VK_NULL_HANDLE;
  VkCommandPool pool_ = VK_NULL_HANDLE;
  VkCommandBuffer commands_ = VK_NULL_HANDLE;
  VkQueryPool queries_ = VK_NULL_HANDLE;
  RayBuffer staging_;
};

/// A full barrier: later commands wait for earlier ones and see their writes.
void barrier(VkCommandBuffer commands);

}  // namespace gnosphere::bench
