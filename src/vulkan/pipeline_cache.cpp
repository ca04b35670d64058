// SPDX-License-Identifier: Apache-2.0
#include "vulkan/pipeline_cache.hpp"

#include <cstddef>
#include <cstring>
#include <iterator>
#include <system_error>
#include <utility>

#include "base/file.hpp"
#include "base/hash.hpp"
#include "base/os.hpp"
#include "base/path.hpp"
#include "base/text.hpp"

namespace gnosphere::vulkan {
namespace {

// Larger than any pipeline cache seen so far; a larger file is not a pipeline cache.
constexpr uint64_t kMostBytes = 256 << 20;

}  // namespace

std::filesystem::path cacheFolder(const std::string& setting) {
  if (setting == "off") return {};
  if (!setting.empty()) return pathOf(setting);
  const std::filesystem::path folder = os::cacheFolder();
  return folder.empty() ? folder : folder / "gnosphere";
}

// A file begins with the hash of the rest: drivers do not check the data after the header for damage.
std::string pipelinesIn(const std::string& file, const VkPhysicalDeviceProperties& properties) {
  using Header = VkPipelineCacheHeaderVersionOne;
  const size_t seal = hashOf({}).size();
  if (file.size() < seal + sizeof(Header)) return {};
  const std::string bytes = file.substr(seal);
  // The version is read as a number, since the enumeration cannot hold every value that a damaged file has.
  struct {
    uint32_t size, version, vendor, device;
  } header;
  static_assert(sizeof header == offsetof(Header, pipelineCacheUUID));
  std::memcpy(&header, bytes.data(), sizeof header);
  const bool ours = header.size == sizeof(Header) && header.version == uint32_t{VK_PIPELINE_CACHE_HEADER_VERSION_ONE} &&
                    header.vendor == properties.vendorID && header.device == properties.deviceID &&
                    std::memcmp(bytes.data() + sizeof header, properties.pipelineCacheUUID, VK_UUID_SIZE) == 0;
  return ours && file.compare(0, seal, hashOf(bytes)) == 0 ? bytes : std::string();
}

PipelineCache::PipelineCache(const Device& device, const std::string& setting)
    : device_(device), lacksFolder_(setting.empty() && cacheFolder(setting).empty()) {
  VkPhysicalDeviceIDProperties id = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ID_PROPERTIES};
  VkPhysicalDeviceProperties2 properties = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, &id, {}};
  device.instanceFunctions().vkGetPhysicalDeviceProperties2(device.physical(), &properties);
  if (const std::filesystem::path folder = cacheFolder(setting); !folder.empty()) {
    if (device.capabilities().keepsShaders) shaders_.emplace(device, folder);
    const std::string uuid(std::begin(id.deviceUUID), std::end(id.deviceUUID));
    file_ = folder / (hexText(uuid) + "-" + std::to_string(properties.properties.driverVersion));
    try {
      stored_ = pipelinesIn(readWholeFile(file_, kMostBytes), properties.properties);
    } catch (const Error&) {  // there is no file yet
    }
  }
  VkPipelineCacheCreateInfo create = {VK_STRUCTURE_TYPE_PIPELINE_CACHE_CREATE_INFO};
  create.initialDataSize = stored_.size();
  create.pInitialData = stored_.data();
  const auto make = [&] {
    return device.make(device.vk().vkCreatePipelineCache, device.vk().vkDestroyPipelineCache, create);
  };
  try {
    cache_ = make();
  } catch (const Error&) {  // the driver rejects the stored data
    stored_.clear();
    create.initialDataSize = 0;
    cache_ = make();
  }
}

void PipelineCache::save(const std::function<void(const std::string&)>& warn) {
  const std::lock_guard lock(mutex_);
  const auto fail = [&](const std::string& reason) {
    file_.clear();
    if (warn) warn("compiled kernels are not kept, each start compiles them again: " + reason);
  };
  if (std::exchange(lacksFolder_, false))
    return fail("neither XDG_CACHE_HOME nor HOME is an absolute path; name a folder by the option 'cache'");
  if (file_.empty()) return;
  if (const std::string problem = shaders_ ? shaders_->problem() : ""; !problem.empty()) return fail(problem);
  size_t size = 0;
  VK(device_.vk().vkGetPipelineCacheData(device_.handle(), cache_.get(), &size, nullptr));
  std::string bytes(size, '\0');
  const VkResult result = device_.vk().vkGetPipelineCacheData(device_.handle(), cache_.get(), &size, bytes.data());
  if (result == VK_INCOMPLETE) return;  // another thread has added a pipeline meanwhile, and saves the cache after it
  check(result, "vkGetPipelineCacheData");
  bytes.resize(size);
  // lavapipe of Mesa 26 gives less than a header.
  if (bytes == stored_ || bytes.size() < sizeof(VkPipelineCacheHeaderVersionOne)) return;
  std::error_code ignored;
  std::filesystem::create_directories(file_.parent_path(), ignored);
  try {
    AtomicFile file(file_);
    file.write(hashOf(bytes));
    file.write(bytes);
    file.commit();
    stored_ = bytes;
  } catch (const Error& error) {
    fail(error.what());
  }
}

}  // namespace gnosphere::vulkan
