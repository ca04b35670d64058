// SPDX-License-Identifier: Apache-2.0
#include "vulkan/shader_files.hpp"

#include <algorithm>
#include <string_view>
#include <utility>
#include <vector>

#include "base/file.hpp"
#include "base/hash.hpp"

namespace gnosphere::vulkan {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kMostBinaryBytes = 16 << 20;  // of a binary; larger than any seen so far
constexpr size_t kMostFiles = 1024;              // some 60 MB; a sensor with its effects has about 15

// Returns a name that differs between drivers, their versions and the widths for which they compile.
std::string driverName(const Device& device) {
  VkPhysicalDeviceShaderObjectPropertiesEXT objects = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SHADER_OBJECT_PROPERTIES_EXT};
  VkPhysicalDeviceProperties2 properties = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, &objects, {}};
  device.instanceFunctions().vkGetPhysicalDeviceProperties2(device.physical(), &properties);
  Hasher hasher;
  hasher.add(objects.shaderBinaryUUID, VK_UUID_SIZE);
  hasher.add(&objects.shaderBinaryVersion, sizeof objects.shaderBinaryVersion);
  hasher.add(std::string_view(properties.properties.deviceName));
  hasher.add(std::string_view(device.capabilities().info.driver));
  return hasher.hex();
}

}  // namespace

ShaderFiles::ShaderFiles(const Device& device, const fs::path& parent)
    : device_(device), folder_(parent / ("shaders-" + driverName(device))) {}

DeviceHandle<VkShaderEXT> ShaderFiles::make(const std::string& digest, const VkShaderCreateInfoEXT& create) const {
  const DeviceFunctions& vk = device_.vk();
  const auto made = [&](const VkShaderCreateInfoEXT& info) {
    VkShaderEXT shader = VK_NULL_HANDLE;
    VK(vk.vkCreateShadersEXT(device_.handle(), 1, &info, nullptr, &shader));
    return DeviceHandle<VkShaderEXT>(shader, vk.vkDestroyShaderEXT, device_.handle());
  };
  try {
    // Vulkan wants it aligned to 16 bytes, which memory of the heap is.
    const std::string binary = readWholeFile(folder_ / digest, kMostBinaryBytes);
    if (binary.size() < VK_UUID_SIZE) throw Error(ErrorCode::format, "no binary is so short");
    VkShaderCreateInfoEXT kept = create;
    kept.codeType = VK_SHADER_CODE_TYPE_BINARY_EXT;
    kept.codeSize = binary.size();
    kept.pCode = binary.data();
    return made(kept);
  } catch (const Error&) {  // there is no file yet, or the driver rejects it
  }
  DeviceHandle<VkShaderEXT> shader = made(create);
  keep(digest, shader.get());
  return shader;
}

void ShaderFiles::keep(const std::string& digest, VkShaderEXT shader) const {
  size_t size = 0;
  VK(device_.vk().vkGetShaderBinaryDataEXT(device_.handle(), shader, &size, nullptr));
  std::string binary(size, '\0');
  VK(device_.vk().vkGetShaderBinaryDataEXT(device_.handle(), shader, &size, binary.data()));
  std::error_code ignored;
  fs::create_directories(folder_, ignored);
  try {
    AtomicFile file(folder_ / digest);
    file.write(binary);
    file.commit();
  } catch (const Error& error) {
    const std::lock_guard lock(mutex_);
    problem_ = error.what();
  }
  removeOldest(folder_, kMostFiles);
}

std::string ShaderFiles::problem() const {
  const std::lock_guard lock(mutex_);
  return problem_;
}

void removeOldest(const fs::path& folder, size_t most) {
  std::error_code ignored;
  std::vector<std::pair<fs::file_time_type, fs::path>> files;
  for (const auto& entry : fs::directory_iterator(folder, ignored))
    files.emplace_back(entry.last_write_time(ignored), entry.path());
  if (files.size() <= most) return;
  std::sort(files.begin(), files.end());
  for (size_t i = 0; i < files.size() - most * 3 / 4; ++i) fs::remove(files[i].second, ignored);
}

}  // namespace gnosphere::vulkan
