// SPDX-License-Identifier: Apache-2.0
// Compiled pipelines, kept on disk from one process to the next.
#pragma once

#include <filesystem>
#include <functional>

#include "vulkan/device.hpp"

namespace gnosphere::vulkan {

/// What a driver wrote, out of a file's content; empty unless it is whole and was made by this driver on this device.
std::string pipelinesIn(const std::string& file, const VkPhysicalDeviceProperties& properties);

/// One file per device and driver version. A file that is damaged, or of another device, counts as none; a folder that
/// cannot be read or written is no error either: the pipelines are compiled again.
class PipelineCache {
 public:
  /// `setting`: SimulatorOptions::cache.
  PipelineCache(const Device& device, const std::string& setting);

  VkPipelineCache handle() const { return cache_.get(); }
  /// Writes what has been compiled since; nothing if the file has it all. Where that fails it is told once.
  void save(const std::function<void(const std::string& message)>& warn);

 private:
  const Device& device_;
  std::filesystem::path file_;  // empty: nothing is kept
  std::string stored_;          // Vulkan's bytes of the file
  DeviceHandle<VkPipelineCache> cache_;
};

}  // namespace gnosphere::vulkan
