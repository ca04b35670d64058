// SPDX-License-Identifier: Apache-2.0
// A cache of compiled kernels on disk.
#pragma once

#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <string>

#include "vulkan/device.hpp"
#include "vulkan/shader_files.hpp"

namespace gnosphere::vulkan {

/// Returns the folder for a text that is SimulatorOptions::cache; empty if kernels are not kept.
std::filesystem::path cacheFolder(const std::string& setting);

/// Returns the driver's data in the content of a cache file; empty if it is damaged or from another driver or device.
std::string pipelinesIn(const std::string& file, const VkPhysicalDeviceProperties& properties);

/// Uses one file per device and driver version. A damaged file, a file of another device, and a folder that cannot be
/// read or written are no errors: the pipelines are then compiled again. Several threads may use it at once.
class PipelineCache {
 public:
  /// The text `setting` is SimulatorOptions::cache.
  PipelineCache(const Device& device, const std::string& setting);

  VkPipelineCache handle() const { return cache_.get(); }
  /// The files of kernels that are shader objects; null if kernels are pipelines.
  const ShaderFiles* shaders() const { return shaders_ ? &*shaders_ : nullptr; }
  /// Writes the file if pipelines were compiled that it does not have. If writing it or the file of a shader object
  /// failed, or if this user has no folder for such files, `warn` is called once.
  void save(const std::function<void(const std::string& message)>& warn);

 private:
  const Device& device_;
  std::mutex mutex_;
  std::filesystem::path file_;  // empty if kernels are not kept
  bool lacksFolder_;            // true if no folder is known in which to keep kernels, and nobody was told yet
  std::string stored_;          // the driver's data in the file
  DeviceHandle<VkPipelineCache> cache_;
  std::optional<ShaderFiles> shaders_;
};

}  // namespace gnosphere::vulkan
