// SPDX-License-Identifier: Apache-2.0
// Compiled pipelines on disk: used if valid, checked first, and never a reason to fail.
#include <algorithm>
#include <chrono>
#include <functional>
#include <string>
#include <vector>

#include "base/hash.hpp"
#include "folder.hpp"
#include "support.hpp"
#include "vulkan/pipeline_cache.hpp"
#include "vulkan/ready_device.hpp"

namespace gnosphere::test {
namespace {

// The files of a folder, without the folders of shader objects.
std::vector<fs::path> filesIn(const fs::path& path) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(path))
    if (entry.is_regular_file()) files.push_back(entry.path());
  return files;
}

// Scans as a new process would, which has compiled nothing yet.
Scan scanWith(const std::string& cache) {
  vulkan::destroyIdleDevices();
  TestOptions options = vulkanOptions();
  options.cache = cache;
  return scanOf(sceneOf(soup(5, 200, 20, 8)), gridSensor(90, 8, -30, 30), {}, options);
}

// Works with these values of XDG_CACHE_HOME and HOME, or without them if they are null. Mesa's own folder stays,
// because filling it is slow.
void inEnvironment(const char* cache, const char* home, const std::function<void()>& work) {
  const std::string oldCache = std::getenv("XDG_CACHE_HOME") ? std::getenv("XDG_CACHE_HOME") : "";
  const std::string oldHome = std::getenv("HOME") ? std::getenv("HOME") : "";
  setenv("MESA_SHADER_CACHE_DIR", (oldCache.empty() ? oldHome + "/.cache" : oldCache).c_str(), 0);
  cache ? setenv("XDG_CACHE_HOME", cache, 1) : unsetenv("XDG_CACHE_HOME");
  home ? setenv("HOME", home, 1) : unsetenv("HOME");
  work();
  oldCache.empty() ? unsetenv("XDG_CACHE_HOME") : setenv("XDG_CACHE_HOME", oldCache.c_str(), 1);
  setenv("HOME", oldHome.c_str(), 1);
}

// Returns the file of pipelines in a folder after a scan.
fs::path storedIn(const fs::path& folder) {
  if (!fs::exists(folder) || filesIn(folder).empty()) SKIP("the driver's cache has not even a header");
  REQUIRE(filesIn(folder).size() == 1);
  return filesIn(folder)[0];
}

constexpr size_t kSeal = 32;  // digits of the hash with which a file begins

// Updates the hash in a file after a change.
std::string sealed(const std::string& bytes) {
  return hashOf(bytes.substr(kSeal)) + bytes.substr(kSeal);
}

}  // namespace

TEST_CASE("pipelines are stored in the requested folder, and a valid file is not rewritten") {
  needVulkan();
  const Folder folder;
  const Scan first = scanWith(folder / "deep");
  const fs::path file = storedIn(folder / "deep");
  const std::string bytes = bytesOf(file);
  CHECK(bytes == sealed(bytes));
  const auto old = fs::last_write_time(file) - std::chrono::hours(1);
  fs::last_write_time(file, old);
  CHECK(sameBytes(scanWith(folder / "deep"), first));
  if (bytesOf(file) == bytes) CHECK(fs::last_write_time(file) == old);
}

TEST_CASE("only an intact file of the same driver and device is accepted") {
  VkPhysicalDeviceProperties properties = {};
  properties.vendorID = 0x10de;
  properties.deviceID = 0x2335;
  for (size_t i = 0; i < VK_UUID_SIZE; ++i) properties.pipelineCacheUUID[i] = static_cast<uint8_t>(3 * i + 1);
  VkPipelineCacheHeaderVersionOne header = {32, VK_PIPELINE_CACHE_HEADER_VERSION_ONE, 0x10de, 0x2335, {}};
  std::copy_n(properties.pipelineCacheUUID, VK_UUID_SIZE, header.pipelineCacheUUID);
  std::string good(kSeal + sizeof header, '\0');
  std::memcpy(good.data() + kSeal, &header, sizeof header);
  good = sealed(good + "compiled");
  CHECK(vulkan::pipelinesIn(good, properties) == good.substr(kSeal));
  for (size_t at = 0; at < good.size(); ++at) {
    INFO("byte " << at);
    std::string bad = good;
    bad[at] = static_cast<char>(bad[at] ^ 1);
    CHECK(vulkan::pipelinesIn(bad, properties).empty());
    if (at >= kSeal && at < kSeal + sizeof header) CHECK(vulkan::pipelinesIn(sealed(bad), properties).empty());
    CHECK(vulkan::pipelinesIn(good.substr(0, at), properties).empty());
  }
}

TEST_CASE("a damaged pipeline file is replaced silently") {
  needVulkan();
  const Folder folder;
  const Scan first = scanWith(folder / "deep");
  const fs::path file = storedIn(folder / "deep");
  std::string bad = bytesOf(file);
  REQUIRE(bad.size() >= 40);
  bad.back() = static_cast<char>(bad.back() ^ 1);
  put(file, bad);
  CHECK(sameBytes(scanWith(folder / "deep"), first));
  const std::string now = bytesOf(file);
  CHECK(now == sealed(now));
  CHECK(now != bad);
}

TEST_CASE("a missing or read-only folder for pipelines is not an error") {
  needVulkan();
  const Folder folder;
  const Scan first = scanWith("off");
  CHECK(sameBytes(scanWith("/proc/none/deep"), first));
  put(folder / "deep", "a file where the folder should be");
  CHECK(sameBytes(scanWith(folder / "deep"), first));
  CHECK(bytesOf(folder / "deep") == "a file where the folder should be");
}

TEST_CASE("the default folder follows the XDG specification") {
  needVulkan();
  const Folder folder;
  const std::string home = folder / "home", cache = folder / "cache";
  inEnvironment(cache.c_str(), home.c_str(), [] { scanWith(""); });
  (void)storedIn(folder / "cache" / "gnosphere");
  CHECK(!fs::exists(folder / "home" / ".cache" / "gnosphere"));
  inEnvironment("relative", home.c_str(), [] { scanWith(""); });
  CHECK(fs::exists(folder / "home" / ".cache" / "gnosphere"));
  CHECK(!fs::exists("relative/gnosphere"));
}

TEST_CASE("without a folder of the user it is told once that kernels are not kept, and how they are") {
  needVulkan();
  std::vector<std::string> warnings;
  const auto scan = [&](const std::string& cache) {
    vulkan::destroyIdleDevices();
    TestOptions options = vulkanOptions();
    options.cache = cache;
    options.warn = [&](const std::string& text) { warnings.push_back(text); };
    Simulator simulator = makeSimulator(sceneOf(soup(5, 200, 20, 8)), gridSensor(90, 8, -30, 30), options);
    for (int i = 0; i < 2; ++i) (void)simulator.scan({});
  };
  inEnvironment(nullptr, nullptr, [&] { scan("off"); });
  CHECK(warnings.empty());
  inEnvironment(nullptr, nullptr, [&] { scan(""); });
  inEnvironment("relative", "relative", [&] { scan(""); });
  REQUIRE(warnings.size() == 2);
  for (const std::string& text : warnings) {
    CHECK(text.starts_with("compiled kernels are not kept"));
    CHECK(text.find("name a folder by the option 'cache'") != std::string::npos);
  }
}

}  // namespace gnosphere::test
