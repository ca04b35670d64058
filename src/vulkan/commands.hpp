// SPDX-License-Identifier: Apache-2.0
// One frame in flight: its submissions, each a command buffer and the fence that signals its end, and timestamps.
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "gnosphere/scan.hpp"
#include "vulkan/command_buffer.hpp"

namespace gnosphere::vulkan {

class Commands {
 public:
  explicit Commands(const Device& device);
  ~Commands();
  Commands(const Commands&) = delete;
  Commands& operator=(const Commands&) = delete;

  /// Begins the recording, which writes up to `stamps` timestamps, after wait() for the previous submission. Commands
  /// of an earlier recording that were not submitted are dropped.
  void begin(uint32_t stamps);
  CommandBuffer& buffer() { return commands_; }
  /// Both write a timestamp: start() where the first stage starts, finished() where a part of `stage` ends. Time before
  /// a start is not counted. If stages are not timed, start() is also where the last one ends, for workMs().
  void start() { stamp(nullptr); }
  void finished(const char* stage) { stamp(stage); }
  /// Writes a timestamp for readTrace() where a step ends.
  void traced(std::string step) { stamp(nullptr, std::move(step)); }
  /// Commands that follow are recorded for a submission of their own.
  void cut();
  /// Ends the recording and submits it to the queue.
  void submit();
  /// Waits until the submissions are done; returns at once if they have been waited for already. Throws Error(device)
  /// that names the last stage that ended if the device is lost, takes too long for one of them, or cannot be waited
  /// for.
  void wait();
  /// Adds the stage times of the last submission, each the sum of its parts, after wait(). Does nothing if the device
  /// has no timestamps.
  void readTimings(Timings& timings);
  /// Returns the milliseconds between the first and the last timestamp of the last submission, after wait(); 0 if the
  /// device has no timestamps.
  double workMs() const;
  /// After wait(), hands over a line for each step that was traced: its text, and the time since the timestamp before.
  void readTrace(const std::function<void(const std::string&)>& receive);

 private:
  struct Stamp {
    const char* stage;  // that ended there; null where the first one starts, and for steps
    std::string step;
  };
  struct Submission {
    DeviceHandle<VkFence> fence;
    VkCommandBuffer commands = VK_NULL_HANDLE;  // owned by the pool
    uint64_t number = 0;                        // that the device has given it
  };
  void open(size_t submission);
  void stamp(const char* stage, std::string step = {});
  std::vector<uint64_t> readTicks() const;
  void makeRoom(uint32_t stamps);
  VkResult waitForAll();
  [[noreturn]] void refuseLost() const;
  [[noreturn]] void refuse(const std::string& why, const std::string& remedy) const;
  std::string progress() const;

  const Device& device_;
  const DeviceFunctions& vk_;
  uint32_t stampLimit_ = 0;
  std::vector<Stamp> stamps_;
  bool pending_ = false, hangs_ = false;
  DeviceHandle<VkCommandPool> pool_;
  CommandBuffer commands_;  // the one that is recorded
  std::vector<Submission> submissions_;
  size_t used_ = 0;  // of them, by the last recording
  DeviceHandle<VkQueryPool> queries_;
};

}  // namespace gnosphere::vulkan
