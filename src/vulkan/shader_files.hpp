// SPDX-License-Identifier: Apache-2.0
// Compiled shader objects on disk, for drivers whose pipeline cache keeps nothing.
#pragma once

#include <filesystem>
#include <mutex>
#include <string>

#include "vulkan/device.hpp"

namespace gnosphere::vulkan {

/// Keeps the binary of each kernel in a file of its own, which begins with a hash of its name and the binary. A file
/// that cannot be read or written, or has another hash, is no error: its kernel is then compiled again. Several threads
/// and processes may use a folder at once.
class ShaderFiles {
 public:
  /// Keeps the binaries of the device's driver in a folder below `parent`.
  ShaderFiles(const Device& device, const std::filesystem::path& parent);

  /// Makes the shader object that `create` describes by its SPIR-V, from the binary of this digest if there is one that
  /// the driver accepts.
  DeviceHandle<VkShaderEXT> make(const std::string& digest, const VkShaderCreateInfoEXT& create) const;
  /// Returns why a file could not be written; empty if all could.
  std::string problem() const;

 private:
  void keep(const std::string& digest, VkShaderEXT shader) const;

  const Device& device_;
  std::filesystem::path folder_;
  mutable std::mutex mutex_;  ///< guards the problem
  mutable std::string problem_;
};

/// If a folder has more than `most` files, removes those that were not used for the longest time, to a day, until it
/// has three quarters of them.
void removeOldest(const std::filesystem::path& folder, size_t most);

}  // namespace gnosphere::vulkan
