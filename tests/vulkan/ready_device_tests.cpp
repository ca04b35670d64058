// SPDX-License-Identifier: Apache-2.0
// Devices of simulators: that later ones in the same process take them over, and what tools see of them.
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/matchers/catch_matchers.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <thread>

#include "support.hpp"
#include "vulkan/device_functions.hpp"
#include "vulkan/ready_device.hpp"

namespace gnosphere::test {
namespace {

using Catch::Matchers::ContainsSubstring;

PFN_vkWaitForFences waitForFences = nullptr;  // the driver's

/// From now on the device that this thread's simulators share says that it is lost when its work is waited for.
void loseDevice() {
  const vulkan::LentDevice device = vulkan::lendDevice(vulkanOptions());
  vulkan::DeviceFunctions& vk = functionsOf(device->device);
  waitForFences = vk.vkWaitForFences;
  vk.vkWaitForFences = [](VkDevice handle, uint32_t count, const VkFence* fences, VkBool32 all, uint64_t timeout) {
    waitForFences(handle, count, fences, all, timeout);
    return VK_ERROR_DEVICE_LOST;
  };
}

}  // namespace

TEST_CASE(
    "simulators of one thread share a device, and take over that of the one before, if its settings are the same") {
  needVulkan();
  vulkan::destroyIdleDevices();
  // The messages that a device shares tell which device it is, as long as the test holds them.
  const auto lent = [](const SimulatorOptions& options, bool failed = false) {
    const vulkan::LentDevice device = vulkan::lendDevice(options);
    if (failed) device->device.noteFailure();
    return device->device.messages();
  };
  SimulatorOptions options = vulkanOptions(), named = options, kept = options, limited = options;
  named.device.name = "0";
  limited.tuning.maxBufferBytes = 1 << 20;
  kept.cache = "/nonexistent";
  auto first = lent(options);
  CHECK(lent(options) == first);
  CHECK(lent(named) != first);
  CHECK(lent(options) == first);
  CHECK(lent(limited) == first);
  {
    const vulkan::LentDevice used = vulkan::lendDevice(options);
    CHECK(used->device.messages() == first);
    CHECK(lent(options) == first);
    CHECK(lent(named) != first);
    CHECK(lent(kept) != first);
    CHECK(lent(options) == first);
    std::shared_ptr<vulkan::Messages> ofOtherThread;
    std::thread([&] { ofOtherThread = lent(options); }).join();
    CHECK(ofOtherThread != first);
    CHECK(lent(options, true) == first);
    CHECK(lent(options) != first);
    CHECK(used->device.messages() == first);
  }
  // The two that were given back last are kept.
  first = lent(options);
  const auto second = lent(named);
  CHECK(lent(options) == first);
  CHECK(lent(kept) != first);
  CHECK(lent(options) == first);
  CHECK(lent(named) != second);
  vulkan::destroyIdleDevices();
}

TEST_CASE("a device that fails is not taken over, whether a scan or a change of the scene meets the failure") {
  needVulkan();
  vulkan::destroyIdleDevices();
  const auto make = [] { return makeSimulator(sceneOf(ball(9, 14, 5)), gridSensor(40, 5, -10, 10), vulkanOptions()); };
  const std::function<void(Simulator&)> calls[] = {
      [](Simulator& simulator) { simulator.scan({}); },
      [](Simulator& simulator) { simulator.addMesh(soup(9, 60'000, 1, 0.1)); }};  // arrays grow by copies on the device
  for (const auto& call : calls) {
    Simulator simulator = make();
    loseDevice();
    CHECK_THROWS_WITH(call(simulator), ContainsSubstring("a new one may be"));
    simulator = make();
    simulator = make();
    CHECK(simulator.scan({}).counters.hits == 200);
  }
}

TEST_CASE("a simulator whose device hangs ends at once, and leaves to the device what this may still use") {
  needVulkan();
  vulkan::destroyIdleDevices();
  static const vulkan::LentDevice& device = *new vulkan::LentDevice(vulkan::lendDevice(vulkanOptions()));
  static std::vector<uint64_t> waits;
  static int destroyed;
  waits.clear();
  vulkan::DeviceFunctions& vk = functionsOf(device->device);
  waitForFences = vk.vkWaitForFences;
  vk.vkWaitForFences = [](VkDevice handle, uint32_t count, const VkFence* fences, VkBool32 all, uint64_t timeout) {
    waits.push_back(timeout);
    waitForFences(handle, count, fences, all, UINT64_MAX);
    return VK_TIMEOUT;
  };
  vk.vkDestroyBuffer = [](VkDevice, VkBuffer, const VkAllocationCallbacks*) { ++destroyed; };
  vk.vkFreeMemory = [](VkDevice, VkDeviceMemory, const VkAllocationCallbacks*) { ++destroyed; };
  {
    Simulator simulator = makeSimulator(sceneOf(ball(9, 14, 5)), gridSensor(40, 5, -10, 10), vulkanOptions());
    destroyed = 0;
    CHECK_THROWS_WITH(simulator.scan({}), ContainsSubstring("did not end its work in time"));
  }
  CHECK(destroyed == 0);
  REQUIRE(waits.size() > 1);
  CHECK(std::count(waits.begin() + 1, waits.end(), 0) == static_cast<ptrdiff_t>(waits.size()) - 1);
}

TEST_CASE("a simulator that was moved to another variable says so, and can get a new one") {
  TestOptions options;
  options.device = DeviceChoice::Kind::reference;
  const auto make = [&] { return makeSimulator(sceneOf(ball(9, 14, 5)), gridSensor(40, 5, -10, 10), options); };
  Simulator simulator = make();
  Simulator other(std::move(simulator));
  Scan scan;
  const std::function<void()> calls[] = {[&] { simulator.scanInto({}, scan); },  [&] { (void)simulator.plan(); },
                                         [&] { (void)simulator.memory(); },      [&] { simulator.removeInstance(0); },
                                         [&] { simulator.removeInstances({}); }, [&] { simulator.removeSensor(0); }};
  for (const auto& call : calls) CHECK_THROWS_WITH(call(), ContainsSubstring("was moved to another variable"));
  CHECK(other.scan({}).counters.hits == 200);
  simulator = make();
  CHECK(simulator.scan({}).counters.hits == 200);
}

TEST_CASE("a process that was forked makes simulators, also in place of those of its parent") {
  needVulkan();
  const auto make = [] {
    return makeSimulator(sceneOf(ball(9, 14, 5)), gridSensor(1800, 32, -10, 10), vulkanOptions());
  };
  const auto hits = [](Simulator& simulator) { return simulator.scan({}).counters.hits; };
  SensorRequest request{gridSensor(40, 5, -10, 10), Effects::none()};
  request.layout = layoutOf({Field::range});
  TestOptions options = vulkanOptions();
  options.resultsOnDevice = true;
  Simulator streaming(sceneOf(ball(9, 14, 5)), request, options);
  BatchStreamOptions ofStream;
  ofStream.views = 1;
  std::optional<BatchStream> stream(std::in_place, streaming, ofStream);
  stream->submit(std::vector<Shot>(1));
  std::optional<Simulator> gone = make();
  Simulator simulator = make();
  REQUIRE(hits(*gone) == 1800 * 32);
  REQUIRE(hits(simulator) == 1800 * 32);
  const pid_t child = fork();
  if (child == 0) {
    alarm(100);
    int wrong = 0;
    const auto refused = [&](const std::function<void()>& call) {
      try {
        call();
        ++wrong;
      } catch (const Error& error) {
        wrong += std::string(error.what()).find("made by another process") == std::string::npos;
      }
    };
    refused([&] { gone->scan({}); });
    refused([&] { gone->scanBatch(std::vector<Shot>(2)); });
    refused([&] { gone->removeInstance(0); });
    refused([&] { stream->submit(std::vector<Shot>(1)); });
    refused([&] { stream->wait(0); });
    gone.reset();
    stream.reset();
    simulator = make();
    _exit(hits(simulator) == 1800 * 32 ? wrong : 100);
  }
  int status = -1;
  REQUIRE(waitpid(child, &status, 0) == child);
  CHECK(status == 0);
}

TEST_CASE("arrays have names, and the steps of each stage a label, for tools that look at a device") {
  needVulkan();
  vulkan::destroyIdleDevices();
  static std::set<std::string> names;
  static std::vector<std::string> labels;
  names.clear(), labels.clear();
  {
    const vulkan::LentDevice device = vulkan::lendDevice(vulkanOptions());
    auto& vk = functionsOf(device->device);
    vk.vkSetDebugUtilsObjectNameEXT = [](VkDevice, const VkDebugUtilsObjectNameInfoEXT* info) {
      names.insert(info->pObjectName);
      return VK_SUCCESS;
    };
    vk.vkCmdBeginDebugUtilsLabelEXT = [](VkCommandBuffer, const VkDebugUtilsLabelEXT* label) {
      labels.push_back(label->pLabelName);
    };
    vk.vkCmdEndDebugUtilsLabelEXT = [](VkCommandBuffer) { labels.push_back("end"); };
  }
  {
    TestOptions options = vulkanOptions();
    options.tuning.binning = Binning::lists;
    Simulator simulator = makeSimulator(sceneOf(ball(9, 14, 5)), gridSensor(40, 5, -10, 10), options);
    CHECK(simulator.scan({}).counters.hits == 200);
  }
  for (const char* name : {"positions", "clusters", "counters", "listEnds", "addresses"}) CHECK(names.contains(name));
  CHECK(labels == std::vector<std::string>{"project", "end", "bin", "end", "resolve", "end"});
  vulkan::destroyIdleDevices();
}

TEST_CASE("a device that reports scans as done and runs nothing is an error") {
  needVulkan();
  vulkan::destroyIdleDevices();
  const SimulatorOptions options = vulkanOptions();
  {
    const vulkan::LentDevice device = vulkan::lendDevice(options);
    functionsOf(device->device).vkCmdDispatch = [](VkCommandBuffer, uint32_t, uint32_t, uint32_t) {};
    functionsOf(device->device).vkCmdDispatchIndirect = [](VkCommandBuffer, VkBuffer, VkDeviceSize) {};
  }
  {
    Simulator simulator = makeSimulator(sceneOf(ball(9, 14, 5)), gridSensor(40, 5, -10, 10), vulkanOptions());
    CHECK_THROWS_WITH(simulator.scan({}), ContainsSubstring("has run no kernel of it"));
  }
  vulkan::destroyIdleDevices();
}

}  // namespace gnosphere::test
