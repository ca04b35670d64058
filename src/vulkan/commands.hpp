// SPDX-License-Identifier: Apache-2.0
// One frame in flight: a command buffer with its timestamps, and the fence that signals its end.
#pragma once

#include "gnosphere/scan.hpp"
#include "vulkan/command_buffer.hpp"

namespace gnosphere::vulkan {

class Commands {
 public:
  /// Makes room for `stamps` timestamps.
  Commands(const Device& device, uint32_t stamps);
  ~Commands();
  Commands(const Commands&) = delete;
  Commands& operator=(const Commands&) = delete;

  /// Begins the recording; wait() must have been called for the previous submission.
  void begin();
  CommandBuffer& buffer() { return commands_; }
  /// Write timestamps: start() where the first stage starts, finish() where a part of `stage` ends. Time before a start
  /// is not counted.
  void start() { stamp(nullptr); }
  void finished(const char* stage) { stamp(stage); }
  /// Ends the recording and submits it to the queue.
  void submit();
  /// Waits until the submission is done; returns at once if it has been waited for already.
  void wait();
  /// Adds the stage times of the last submission, each the sum of its parts, after wait(). Does nothing if the device
  /// has no timestamps.
  void readTimings(Timings& timings);

 private:
  void stamp(const char* stage);

  const Device& device_;
  const DeviceFunctions& vk_;
  uint32_t stampLimit_;
  std::vector<const char*> stages_;  // by timestamp: the stage that ended there
  bool pending_ = false;
  DeviceHandle<VkCommandPool> pool_;
  CommandBuffer commands_;  // owned by the pool
  DeviceHandle<VkQueryPool> queries_;
  DeviceHandle<VkFence> fence_;
};

}  // namespace gnosphere::vulkan
