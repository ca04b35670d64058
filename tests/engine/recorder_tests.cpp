// SPDX-License-Identifier: Apache-2.0
// Scans recorded on a device of the caller, against scans on a device of our own.
#include <catch2/matchers/catch_matchers.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>

#include "base/threads.hpp"
#include "classified_fences.hpp"
#include "engine/counted_calls.hpp"
#include "engine/record_layouts.hpp"
#include "engine/recorded.hpp"
#include "lists/list_sensors.hpp"
#include "pipeline/origin_groups.hpp"

namespace gnosphere::test {
namespace {

using Catch::Matchers::ContainsSubstring;

/// Requires that recorded rows have the bytes of a scan, for every shot.
void requireSameRows(VulkanApp& app, const Scene& scene, const SensorRequest& request, const TestOptions& options,
                     const RecordLayout& layout, const std::vector<Shot>& shots) {
  SensorRequest onHost = request;
  for (const RecordLayout::Value& value : layout.values) onHost.fields.push_back(value.field);
  TestOptions own = options;
  own.device = {DeviceChoice::Kind::vulkan, app.deviceName()};
  Simulator simulator(scene, onHost, own);
  Recorded recorded(app, scene, request, options, layout);
  for (const Shot& shot : shots) {
    Scan scan;
    simulator.scanInto(shot, scan);
    INFO("frame " << shot.frame);
    const std::vector<std::byte> found = recorded.scan(shot);
    REQUIRE(found.size() > 0);
    requireRows(found, scan, layout);
    CHECK(recorded.header.wanted == recorded.header.rows);
    CHECK(recorded.header.frame == shot.frame);
  }
}

/// A table between the library and the loader: the device allows few workgroups in a dispatch.
struct FewWorkgroups {
  static constexpr uint32_t kMost = 600;
  PFN_vkGetInstanceProcAddr instance = nullptr;
  PFN_vkGetDeviceProcAddr device = nullptr;
  PFN_vkGetPhysicalDeviceProperties properties = nullptr;
  PFN_vkCmdDispatch dispatch = nullptr;
  int full = 0;  // dispatches of as many workgroups as are allowed
} few;

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL fewOfDevice(VkDevice device, const char* name) {
  const PFN_vkVoidFunction real = few.device(device, name);
  if (std::string(name) != "vkCmdDispatch") return real;
  few.dispatch = reinterpret_cast<PFN_vkCmdDispatch>(real);
  const PFN_vkCmdDispatch counting = [](VkCommandBuffer commands, uint32_t workgroupsX, uint32_t workgroupsY,
                                        uint32_t workgroupsZ) {
    few.full += workgroupsX == FewWorkgroups::kMost;
    CHECK(workgroupsX <= FewWorkgroups::kMost);
    few.dispatch(commands, workgroupsX, workgroupsY, workgroupsZ);
  };
  return reinterpret_cast<PFN_vkVoidFunction>(counting);
}

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL fewOfInstance(VkInstance instance, const char* name) {
  const PFN_vkVoidFunction real = few.instance(instance, name);
  if (std::string(name) == "vkGetDeviceProcAddr") {
    few.device = reinterpret_cast<PFN_vkGetDeviceProcAddr>(real);
    return reinterpret_cast<PFN_vkVoidFunction>(fewOfDevice);
  }
  if (std::string(name) != "vkGetPhysicalDeviceProperties") return real;
  few.properties = reinterpret_cast<PFN_vkGetPhysicalDeviceProperties>(real);
  const PFN_vkGetPhysicalDeviceProperties limited = [](VkPhysicalDevice physical, VkPhysicalDeviceProperties* to) {
    few.properties(physical, to);
    to->limits.maxComputeWorkGroupCount[0] = FewWorkgroups::kMost;
  };
  return reinterpret_cast<PFN_vkVoidFunction>(limited);
}

}  // namespace

TEST_CASE("a list of more beams than a dispatch has workgroups for loses none") {
  needVulkan();
  few = {};
  few.instance = loaderLookUp();
  VulkanApp app("", fewOfInstance);
  VkPhysicalDeviceProperties properties;
  reinterpret_cast<PFN_vkGetPhysicalDeviceProperties>(
      few.instance(app.adopted().instance, "vkGetPhysicalDeviceProperties"))(app.adopted().physicalDevice, &properties);
  if (properties.deviceType != VK_PHYSICAL_DEVICE_TYPE_CPU || threadCount() > 8)
    SKIP("kernels that loop have as many workgroups here");
  RecordLayout layout = layoutOf({Field::x, Field::y, Field::z, Field::triangle});
  layout.compact = true;
  const Sensor sensor = listSensor("rosette", rosette(FewWorkgroups::kMost * 1024 + 70'000, 0.35));
  TestOptions options = vulkanOptions();
  options.tuning.binning = Binning::lists;
  requireSameRows(app, classifiedRoom(), {sensor, Effects::none()}, options, layout, {shotOf(false)});
  CHECK(few.full > 0);
}

TEST_CASE("recorded scans have the bytes of scan(), for grids, lists and every accuracy", "[second-driver]") {
  needVulkan();
  const CommonApp common;
  VulkanApp& app = common.app;
  const Scene scene = classifiedRoom();
  for (const Accuracy accuracy : {Accuracy::standard, Accuracy::exact}) {
    TestOptions options = vulkanOptions();
    options.accuracy = accuracy;
    Shot moved = shotOf(false);
    moved.pose.position.x += 0.7;
    moved.frame = 4;
    for (const bool compact : {false, true}) {
      INFO(nameOf(accuracy) << (compact ? ", compact" : ", organised"));
      const Sensor sensor = compact ? listSensor("rosette", rosette(3000, 0.35)) : gridSensor(90, 8, -18, 9, 15);
      requireSameRows(app, scene, {sensor, Effects::none()}, options, oddLayout(kPlainFields, compact),
                      {shotOf(false), moved});
    }
  }
}

TEST_CASE("on the device, too, a point has the class of its surface's material, and else that of its instance") {
  needVulkan();
  const CommonApp common;
  VulkanApp& app = common.app;
  RecordLayout layout = layoutOf({Field::x, Field::y, Field::z, Field::classId});
  layout.compact = true;
  Recorded recorded(app, classifiedFences(), {fenceSensor(), Effects::none()}, vulkanOptions(), layout);
  const std::vector<std::byte> rows = recorded.scan({});
  std::map<int, int> counts;
  for (size_t at = 0; at < rows.size(); at += layout.stride) {
    float point[3];
    uint16_t classId;
    std::memcpy(point, &rows[at], sizeof(point));
    std::memcpy(&classId, &rows[at + 12], sizeof(classId));
    checkClass(point[0], point[1], point[2], classId, counts);
  }
  checkCounts(counts);
}

TEST_CASE("recorded scans have the bytes of scan(), for heads far apart in one list", "[second-driver]") {
  needVulkan();
  const CommonApp common;
  VulkanApp& app = common.app;
  const BeamList head = rosette(600, 1.2);
  Sensor rig = listSensor("rig", headsAt({{0, 0, 0}, {-1.5, 1.5, 0.5}, {1, -0.9, -0.3}}, head));
  REQUIRE(originGroups(rig, 0).size() == 3);
  rig.patterns.push_back(headsAt({{0.1, 0, 0}, {0, 0.1, 0}, {0, 0, 0.1}}, head));
  REQUIRE(originGroups(rig, 1).size() == 1);
  rig.maskedBeams = {4, 5, 6};
  std::vector<Shot> shots(3, shotOf(false));
  for (size_t i = 0; i < shots.size(); ++i) shots[i].frame = i;
  requireSameRows(app, classifiedRoom(), {rig, Effects::none()}, vulkanOptions(), oddLayout(kPlainFields, false),
                  shots);
}

TEST_CASE("recorded scans have the bytes of scan(), for heads far apart with all effects and in motion") {
  needVulkan();
  const CommonApp common;
  VulkanApp& app = common.app;
  const Sensor rig = listSensor("rig", headsAt({{0, 0, 0}, {-1.5, 1.5, 0.5}}, rosette(400, 1.2)));
  requireSameRows(app, classifiedRoom(), {rig, loud()}, vulkanOptions(), oddLayout(kAllFields, true),
                  {shotOf(false), shotOf(true)});
}

TEST_CASE("recorded scans have the bytes of scan(), with all effects and in motion") {
  needVulkan();
  const CommonApp common;
  VulkanApp& app = common.app;
  requireSameRows(app, classifiedRoom(), {smallSensor(), loud()}, vulkanOptions(), oddLayout(kAllFields, true),
                  {shotOf(false), shotOf(true)});
}

TEST_CASE("recorded scans have the bytes of scan(), with the effects of lines and in motion", "[second-driver]") {
  needVulkan();
  const CommonApp common;
  VulkanApp& app = common.app;
  SensorRequest request = {smallSensor(), loud()};
  request.effects.divergence.use = EffectUse::off;
  requireSameRows(app, classifiedRoom(), request, vulkanOptions(), oddLayout(kAllFields, true),
                  {shotOf(false), shotOf(true)});
}

}  // namespace gnosphere::test
