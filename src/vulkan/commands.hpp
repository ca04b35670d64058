// SPDX-License-Identifier: Apache-2.0
// One frame in flight: a command buffer with its timestamps, and the fence that says when it is done.
#pragma once

#include "gnosphere/scan.hpp"
#include "vulkan/buffer.hpp"
#include "vulkan/kernel.hpp"

namespace gnosphere::vulkan {

class Commands {
 public:
  /// Room for `stamps` timestamps.
  Commands(const Device& device, uint32_t stamps);
  ~Commands();
  Commands(const Commands&) = delete;
  Commands& operator=(const Commands&) = delete;

  /// What was submitted before must have been waited for.
  void begin();
  void dispatch(VkPipeline kernel, VkPipelineLayout layout, const PushConstants& constants, uint32_t groupsX,
                uint32_t groupsY);
  void fill(const Buffer& buffer, VkDeviceSize offset, VkDeviceSize size, uint32_t value);
  void copy(const Buffer& from, const Buffer& to);
  /// What comes after it sees everything written before. About ten per scan: no step overlaps the next anyway.
  void barrier();
  /// Timestamps: a first stage starts here, and a part of `stage` ends here. What lies before a start is not counted.
  void start() { stamp(nullptr); }
  void finished(const char* stage) { stamp(stage); }
  /// Ends the recording and hands it to the queue.
  void submit();
  /// Until the device has done what was submitted; nothing where it has been waited for.
  void wait();
  /// Adds the times of the stages of what was waited for, their parts added up. Nothing where the device has no
  /// timestamps.
  void readTimings(Timings& timings);

 private:
  void stamp(const char* stage);

  const Device& device_;
  const VolkDeviceTable& vk_;
  uint32_t stampLimit_;
  std::vector<const char*> stages_;  // that ended at each stamp
  bool pending_ = false;
  DeviceHandle<VkCommandPool> pool_;
  VkCommandBuffer commands_ = VK_NULL_HANDLE;  // the pool's
  DeviceHandle<VkQueryPool> queries_;
  DeviceHandle<VkFence> fence_;
};

}  // namespace gnosphere::vulkan
