// SPDX-License-Identifier: Apache-2.0
// Kernels as shader objects on disk: used if the driver accepts them, and never a reason to fail.
#include <algorithm>
#include <chrono>
#include <iterator>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "folder.hpp"
#include "support.hpp"
#include "town/town.hpp"
#include "vulkan/device_functions.hpp"
#include "vulkan/kernel.hpp"
#include "vulkan/pipeline_cache.hpp"
#include "vulkan/ready_device.hpp"

namespace gnosphere::test {
namespace {

struct Created {
  VkShaderCodeTypeEXT type;
  VkFlags flags;
  std::vector<uint32_t> constants;
};
std::vector<Created> created;  // by the driver, without the binaries that it rejected
PFN_vkCreateShadersEXT realCreate = nullptr;

VKAPI_ATTR VkResult VKAPI_CALL create(VkDevice device, uint32_t count, const VkShaderCreateInfoEXT* infos,
                                      const VkAllocationCallbacks* with, VkShaderEXT* shaders) {
  const VkResult result = realCreate(device, count, infos, with, shaders);
  Created one = {infos[0].codeType, infos[0].flags, {}};
  if (const VkSpecializationInfo* info = infos[0].pSpecializationInfo) {
    const auto* values = static_cast<const uint32_t*>(info->pData);
    one.constants.assign(values, values + info->mapEntryCount);
  }
  if (result == VK_SUCCESS) created.push_back(one);
  return result;
}

Variant variantOf(Kernel kernel) {
  Variant variant;
  variant.kernel = kernel;
  return variant;
}

// A device as of a new process, whose kernels are kept in a folder.
struct Process {
  vulkan::Device device{{}, false};
  std::optional<vulkan::PipelineCache> cache;
  std::optional<vulkan::Kernels> kernels;

  explicit Process(const fs::path& folder, vulkan::Specialise specialise = vulkan::codeOf) {
    if (!device.capabilities().keepsShaders) SKIP("the device's kernels are pipelines");
    created.clear();
    realCreate = device.vk().vkCreateShadersEXT;
    functionsOf(device).vkCreateShadersEXT = create;
    cache.emplace(device, folder.string());
    kernels.emplace(device, *cache, specialise);
  }
  // How the driver made a kernel: from a binary, or from SPIR-V.
  VkShaderCodeTypeEXT typeOf(Kernel kernel) {
    created.clear();
    const Variant variant = variantOf(kernel);
    kernels->prepare({&variant, 1});
    CHECK(kernels->of(variant).shader != VK_NULL_HANDLE);
    CHECK(kernels->of(variant).pipeline == VK_NULL_HANDLE);
    REQUIRE(created.size() == 1);
    return created[0].type;
  }
};

std::vector<fs::path> binariesIn(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.path().parent_path() != folder && entry.is_regular_file()) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

constexpr Kernel kSome[] = {Kernel::prefix_sum, Kernel::project_groups};

}  // namespace

TEST_CASE("a kernel is compiled from SPIR-V once, and later processes take its binary") {
  needVulkan();
  const Folder folder;
  for (const auto type : {VK_SHADER_CODE_TYPE_SPIRV_EXT, VK_SHADER_CODE_TYPE_BINARY_EXT}) {
    Process process(folder / "kept");
    for (const Kernel kernel : kSome) {
      CHECK(process.typeOf(kernel) == type);
      const bool usesSubgroups = kernel == Kernel::project_groups;
      CHECK(created[0].flags == (usesSubgroups ? VK_SHADER_CREATE_REQUIRE_FULL_SUBGROUPS_BIT_EXT : 0));
      CHECK(created[0].constants.empty());
    }
    CHECK(binariesIn(folder / "kept").size() == std::size(kSome));
  }
}

TEST_CASE("a damaged binary is compiled anew and replaced") {
  needVulkan();
  const Folder folder;
  (void)Process(folder / "kept").typeOf(Kernel::prefix_sum);
  const fs::path file = binariesIn(folder / "kept").at(0);
  const std::string good = bytesOf(file);
  const auto replaces = [&](const std::string& bad) {
    put(file, bad);
    CHECK(Process(folder / "kept").typeOf(Kernel::prefix_sum) == VK_SHADER_CODE_TYPE_SPIRV_EXT);
    CHECK(bytesOf(file) == good);
  };
  for (const size_t at : {size_t{0}, size_t{20}, good.size() / 2, good.size() - 1}) {
    INFO("byte " << at);
    std::string bad = good;
    bad[at] = static_cast<char>(bad[at] ^ 1);
    replaces(bad);
    replaces(good.substr(0, at));
  }
  replaces(good + '\0');
}

TEST_CASE("the binary of another kernel is not given to the driver") {
  needVulkan();
  const Folder folder;
  Process process(folder / "kept");
  for (const Kernel kernel : kSome) (void)process.typeOf(kernel);
  const auto files = binariesIn(folder / "kept");
  REQUIRE(files.size() == 2);
  const std::string one = bytesOf(files[0]), other = bytesOf(files[1]);
  put(files[0], other);
  put(files[1], one);
  Process later(folder / "kept");
  for (const Kernel kernel : kSome) CHECK(later.typeOf(kernel) == VK_SHADER_CODE_TYPE_SPIRV_EXT);
  CHECK((bytesOf(files[0]) == one));
  CHECK((bytesOf(files[1]) == other));
}

TEST_CASE("a binary that is used gets a new time, once a day") {
  needVulkan();
  const Folder folder;
  (void)Process(folder / "kept").typeOf(Kernel::prefix_sum);
  const fs::path file = binariesIn(folder / "kept").at(0);
  const auto now = fs::file_time_type::clock::now();
  for (const int hours : {2, 48}) {
    INFO("hours " << hours);
    fs::last_write_time(file, now - std::chrono::hours(hours));
    CHECK(Process(folder / "kept").typeOf(Kernel::prefix_sum) == VK_SHADER_CODE_TYPE_BINARY_EXT);
    CHECK((fs::last_write_time(file) >= now) == (hours > 24));
  }
}

TEST_CASE("a module that cannot be specialised becomes a shader object with its constants") {
  needVulkan();
  const Folder folder;
  Process process(folder / "kept", [](std::span<const uint32_t> module, std::span<const uint32_t>, bool) {
    return vulkan::Code{{module.begin(), module.end()}, false};
  });
  (void)process.typeOf(Kernel::resolve);
  CHECK(created[0].constants == vulkan::codeOf(process.device.capabilities(), variantOf(Kernel::resolve)).constants);
}

TEST_CASE("kernels are pipelines without a folder, and with the validation layer") {
  needVulkan();
  Process process("off");
  const Variant variant = variantOf(Kernel::prefix_sum);
  process.kernels->prepare({&variant, 1});
  CHECK(process.kernels->of(variant).pipeline != VK_NULL_HANDLE);
  CHECK(created.empty());
  if (vulkanOptions().validation) CHECK_FALSE(vulkan::Device({}, true).capabilities().keepsShaders);
}

TEST_CASE("a folder for shader objects that cannot be written is told once, and is no error") {
  needVulkan();
  const Folder folder;
  put(folder / "deep", "a file where the folder should be");
  for (const fs::path& place : {fs::path("/proc/none/deep"), fs::path(folder / "deep")})
    for (int i = 0; i < 2; ++i) {
      Process process(place);
      CHECK(process.typeOf(Kernel::prefix_sum) == VK_SHADER_CODE_TYPE_SPIRV_EXT);
      std::vector<std::string> warnings;
      for (int k = 0; k < 2; ++k) process.cache->save([&](const std::string& text) { warnings.push_back(text); });
      REQUIRE(warnings.size() == 1);
      CHECK(
          warnings[0].starts_with("compiled kernels are not kept, each start compiles them again: " + place.string()));
    }
}

TEST_CASE("scans by shader objects, compiled and from disk, have the bytes of scans by pipelines") {
  needVulkan();
  const Folder folder;
  (void)Process(folder / "probe");  // skips
  const Scene town = makeTown({.triangles = 3'000u});
  const auto scanWith = [&](const char* sensor, const std::string& cache) {
    vulkan::destroyIdleDevices();
    TestOptions options = vulkanOptions();
    options.validation = false;
    options.cache = cache;
    return makeSimulator(town, builtinSensor(sensor), options).scan({{0, 0, 1.8}, {}});
  };
  for (const char* sensor : {"OS1-64", "Avia"}) {
    INFO(sensor);
    const Scan pipelines = scanWith(sensor, "off");
    REQUIRE(pipelines.counters.hits > 0);
    CHECK(sameBytes(scanWith(sensor, (folder / "kept").string()), pipelines));
    const auto binaries = binariesIn(folder / "kept").size();
    CHECK(binaries > 3);
    CHECK(sameBytes(scanWith(sensor, (folder / "kept").string()), pipelines));
    CHECK(binariesIn(folder / "kept").size() == binaries);
  }
}

TEST_CASE("the oldest files of a folder are removed when it has too many") {
  const Folder folder;
  const auto now = fs::file_time_type::clock::now();
  for (int i = 0; i < 9; ++i) {
    const fs::path file = folder / std::to_string(i);
    put(file, "binary");
    fs::last_write_time(file, now - std::chrono::hours(i == 4 ? 100 : i));
  }
  const auto count = [&] { return folder.fileCount(); };
  vulkan::removeOldest(folder.path(), 9);
  CHECK(count() == 9);
  vulkan::removeOldest(folder.path(), 8);
  CHECK(count() == 6);
  for (const char* removed : {"4", "8", "7"}) CHECK_FALSE(fs::exists(folder / removed));
  vulkan::removeOldest(folder / "absent", 0);
}

}  // namespace gnosphere::test
