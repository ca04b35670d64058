// SPDX-License-Identifier: Apache-2.0
#include "vulkan/shader_files.hpp"

#include <algorithm>
#include <chrono>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "base/file.hpp"
#include "base/hash.hpp"

namespace gnosphere::vulkan {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kMostBinaryBytes = 16 << 20;      // of a binary; larger than any seen so far
constexpr size_t kMostFiles = 1024;                  // some 60 MB; a sensor with its effects has about 15
constexpr auto kRefreshed = std::chrono::hours(24);  // how often the time of a file that is in use is written

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

// Returns the hash with which a file begins, of its name and the binary. Drivers may crash on the binary of another
// kernel.
std::string sealOf(const std::string& name, const std::string& binary) {
  Hasher hasher;
  hasher.add(std::string_view(name));
  hasher.add(std::string_view(binary));
  return hasher.hex();
}

// Reads the binary of a file. Throws an Error if there is none, or another one than its name says.
std::string readBinary(const fs::path& file) {
  const std::string content = readWholeFile(file, kMostBinaryBytes);
  const size_t seal = std::min(content.size(), sealOf({}, {}).size());
  std::string binary = content.substr(seal);
  if (binary.size() < VK_UUID_SIZE || content.compare(0, seal, sealOf(file.filename().string(), binary)) != 0)
    throw Error(ErrorCode::format, "this is not the binary of the kernel");
  return binary;
}

// Gives a file that is in use the time of now, because removeOldest() removes files that were not used for long.
void refresh(const fs::path& file) {
  std::error_code failed;
  const auto now = fs::file_time_type::clock::now();
  if (const auto time = fs::last_write_time(file, failed); !failed && now - time > kRefreshed)
    fs::last_write_time(file, now, failed);
}

}  // namespace

ShaderFiles::ShaderFiles(const Device& device, const fs::path& parent)
    : device_(device), folder_(parent / ("shaders-" + driverName(device))) {}

DeviceHandle<VkShaderEXT> ShaderFiles::make(const std::string& digest, const VkShaderCreateInfoEXT& create) const {
  const DeviceFunctions& vk = device_.vk();
  const auto made = [&](const VkShaderCreateInfoEXT& info) {
    VkShaderEXT shader = VK_NULL_HANDLE;
    VK(vk.vkCreateShadersEXT(device_.handle(), 1, &info, nullptr, &shader));
    return DeviceHandle<VkShaderEXT>(shader, vk.vkDestroyShaderEXT, device_.handle(), &device_.hangs());
  };
  try {
    // Vulkan wants it aligned to 16 bytes, which memory of the heap is.
    const std::string binary = readBinary(folder_ / digest);
    VkShaderCreateInfoEXT kept = create;
    kept.codeType = VK_SHADER_CODE_TYPE_BINARY_EXT;
    kept.codeSize = binary.size();
    kept.pCode = binary.data();
    DeviceHandle<VkShaderEXT> shader = made(kept);
    refresh(folder_ / digest);
    return shader;
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
    file.write(sealOf(digest, binary));
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
  // An error ends the list; a loop over the folder would throw it.
  for (fs::directory_iterator entry(folder, ignored), end; entry != end; entry.increment(ignored))
    files.emplace_back(entry->last_write_time(ignored), entry->path());
  if (files.size() <= most) return;
  std::sort(files.begin(), files.end());
  for (size_t i = 0; i < files.size() - most * 3 / 4; ++i) fs::remove(files[i].second, ignored);
}

}  // namespace gnosphere::vulkan
