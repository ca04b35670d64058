// SPDX-License-Identifier: Apache-2.0
// Recorded scans over many frames: what they allocate, lists that grow, changes while frames are in flight, and misuse.
#include <catch2/generators/catch_generators.hpp>
#include <catch2/matchers/catch_matchers.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <numeric>
#include <optional>
#include <thread>

#include "deformable.hpp"
#include "effects/scan_support.hpp"
#include "engine/counted_calls.hpp"
#include "engine/recorded.hpp"
#include "lists/list_sensors.hpp"
#include "problem.hpp"
#include "vulkan/device_functions.hpp"
#include "vulkan/ready_device.hpp"

namespace gnosphere::test {
namespace {

using Catch::Matchers::ContainsSubstring;

RecordLayout pointLayout(bool compact = true) {
  RecordLayout layout = layoutOf({Field::x, Field::y, Field::z, Field::instance});
  layout.compact = compact;
  return layout;
}

SimulatorOptions plainOptions() {
  SimulatorOptions options;
  options.cache = "off";
  return options;
}

/// With slabs every device cuts wide triangles into tiles.
SimulatorOptions slabOptions() {
  SimulatorOptions options = plainOptions();
  options.tuning.binning = Binning::slabs;
  return options;
}

}  // namespace

TEST_CASE("in a steady state recorded scans allocate nothing, submit nothing and wait for nothing", "[combinations]") {
  needVulkan();
  VulkanApp app("", countingLookUp());
  const int frames = everyCombination() ? 1000 : 60;
  const bool far = GENERATE(false, true);  // heads far apart, and deformed meshes
  Random random(3);
  Scene scene = boxes();
  if (far) {
    scene.meshes.push_back(limb(random, 7, 4, 1, {}));
    scene.instances.push_back({"", 2, translation(-6, 0, 0), 0});
  }
  // Another box, whose transform the engine writes, in turns to one of two buffers.
  scene.instances.push_back({"", 1, {}});
  const size_t last = scene.instances.size() - 1;
  std::array<VulkanApp::Buffer, 2> transforms = {VulkanApp::Buffer(app, 48), VulkanApp::Buffer(app, 48)};
  const Sensor rig = listSensor("rig", headsAt({{0, 0, 0}, {0, 2, 0}, {-1, 0, 0}}, rosette(300, 0.9)));
  // The engine writes the vertices of the second mesh, in turns to one of two buffers.
  const std::vector<float> inner = boxes().meshes[1].positions;
  std::array<VulkanApp::Buffer, 2> vertices = {VulkanApp::Buffer(app, 4 * inner.size()),
                                               VulkanApp::Buffer(app, 4 * inner.size())};
  Recorded recorded(app, scene, {far ? rig : gridSensor(180, 16, -20, 20), Effects::none()}, plainOptions(),
                    pointLayout());
  CHECK(callsOf(kCostlyCalls) > 20);
  Shot shot;
  const auto next = [&] {
    ++shot.frame;
    const size_t inFlight = (shot.frame - 1) % 2;
    recorded.frame(inFlight).wait();
    VulkanApp::Buffer& buffer = vertices[inFlight];
    std::memcpy(buffer.bytes().data(), inner.data(), 4 * inner.size());
    recorded.recorder().setVertices(1, {buffer.range().address, buffer.range().bytes});
    const std::array<float, 12> place = {1, 0, 0, 0, 0, 1, 0, 0.01f * static_cast<float>(shot.frame % 100) - 6,
                                         0, 0, 1, 0};
    std::memcpy(transforms[inFlight].bytes().data(), place.data(), sizeof place);
    const vulkan::DeviceRange range = transforms[inFlight].range();
    recorded.recorder().setTransforms({range.address, range.bytes, 48, {}, {}, last, 1});
    shot.pose.position = {0.01 * static_cast<double>(shot.frame % 100), 0.2, 0.1};
    recorded.simulator().setTransform(1, translation(6, 0.02 * static_cast<double>(shot.frame % 100), 0));
    if (far) recorded.simulator().setDeformation(2, bend(random, scene.meshes[2]));
    for (const vulkan::RecordedScan& before : recorded.submit(shot)) CHECK(before.frame + 2 == shot.frame);
  };
  for (int i = 0; i < 8; ++i) next();
  forgetCalls();
  for (int i = 0; i < frames; ++i) next();
  CHECK(callsOf(kCostlyCalls) == 0);
  // The count sees an allocation: a second sensor needs memory.
  recorded.simulator().addSensor({gridSensor(90, 4, -9, 9), Effects::none()});
  CHECK(callsOf(kCostlyCalls) > 0);
}

TEST_CASE("a list that is too small is reported, grows before the next scan, and no buffer is overrun") {
  needVulkan();
  const CommonApp common;
  VulkanApp& app = common.app;
  // Nearly all triangles are wider than a slab, which the first capacity of the tiles does not expect.
  const SensorRequest request = {listSensor("rosette", rosette(3000, 1.5)), Effects::none()};
  Scene scene = boxes();
  for (int i = 1; i < 16; ++i) scene.instances.push_back({"", 0, scaling(1 + 0.01 * i, 1 + 0.01 * i, 1)});
  const SimulatorOptions options = slabOptions();
  Recorded recorded(app, scene, request, options, pointLayout());
  Shot shot;
  const std::vector<std::byte> rows = recorded.scan(shot);
  // With lists, the candidates are counted only once the triangles have room.
  CHECK((recorded.incomplete == 1 || recorded.incomplete == 2));
  CHECK(rows.size() == 3000 * pointLayout().stride);
  const auto results = recorded.submit(shot);
  for (const vulkan::RecordedScan& result : results) CHECK(result.complete);
  recorded.submit(shot);

  Recorded small(app, scene, request, options, pointLayout(), 777);
  const std::vector<std::byte> first = small.scan(shot);
  CHECK(small.header.rows == 777);
  CHECK(small.header.wanted == 3000);
  CHECK(small.header.hits == 3000);
  REQUIRE(first.size() == 777 * pointLayout().stride);
  CHECK(std::equal(first.begin(), first.end(), rows.begin()));

  // Returns count for which there is no room, also if every beam has a record.
  Recorded organised(app, scene, request, options, pointLayout(false), 777);
  organised.scan(shot);
  CHECK(organised.header.rows == 777);
  CHECK(organised.header.hits == 3000);
}

TEST_CASE("a list that is too small for the first of several heads is reported, too") {
  needVulkan();
  const CommonApp common;
  VulkanApp& app = common.app;
  // The head with fewer beams comes first. The other one sees little of the walls.
  Sensor rig = listSensor("rig", headsAt({{-2, 0, 0}}, rosette(1000, 1.5)));
  BeamList& beams = rig.patterns[0];
  const BeamList narrow = headsAt({{2, 0, 0}}, rosette(2500, 0.02));
  beams.directions.insert(beams.directions.end(), narrow.directions.begin(), narrow.directions.end());
  beams.origins.insert(beams.origins.end(), narrow.origins.begin(), narrow.origins.end());
  Scene scene = boxes();
  for (int i = 1; i < 16; ++i) scene.instances.push_back({"", 0, scaling(1 + 0.01 * i, 1 + 0.01 * i, 1)});
  const SimulatorOptions options = slabOptions();
  Recorded recorded(app, scene, {rig, Effects::none()}, options, pointLayout());
  const std::vector<std::byte> rows = recorded.scan({});
  CHECK((recorded.incomplete == 1 || recorded.incomplete == 2));
  CHECK(rows.size() == 3500 * pointLayout().stride);

  // A scan that is incomplete lacks hits. The rows of those that it has must lie where the complete scan has them.
  RecordLayout layout = layoutOf({Field::range, Field::beam});
  layout.compact = true;
  Recorded first(app, scene, {rig, Effects::none()}, options, layout);
  first.submit({});
  first.frame(0).wait();
  const RecordHeader& header = first.headerOf(0);
  REQUIRE(header.incomplete == 1);
  REQUIRE(header.rows > 0);
  int64_t before = -1;
  for (uint32_t row = 0; row < header.rows; ++row) {
    float range;
    uint32_t beam;
    std::memcpy(&range, first.bytes(0) + 8 * row, 4);
    std::memcpy(&beam, first.bytes(0) + 8 * row + 4, 4);
    REQUIRE(range > 1);
    REQUIRE(int64_t{beam} > before);
    before = beam;
  }
  // The recorder says so, too, when this frame in flight comes again.
  first.submit({});
  const std::vector<vulkan::RecordedScan> told = first.submit({});
  REQUIRE(told.size() == 1);
  CHECK_FALSE(told[0].complete);
}

// The last beams have numbers of 21 bits, as many as the high word of a double has for them.
TEST_CASE("values become doubles without loss, also not a number and numbers of a million beams") {
  needVulkan();
  const CommonApp common;
  RecordLayout layout;
  layout.stride = 24;
  layout.values = {
      {Field::range, 0, 0, ValueType::f64}, {Field::beam, 0, 8, ValueType::f64}, {Field::range, 0, 16, ValueType::f32}};
  Scene scene;
  scene.materials = {material(true)};
  MeshBuilder wall;
  wall.quad({5, -3, -3}, {0, 6, 0}, {0, 0, 6});
  scene.meshes = {wall.take()};
  scene.instances = {{"", 0, {}}};
  const Sensor sensor = gridSensor(2056, 514, -30, 30);
  REQUIRE(sensor.beamCount() > 1 << 20);
  Recorded recorded(common.app, scene, {sensor, Effects::none()}, plainOptions(), layout, sensor.beamCount());
  const std::vector<std::byte> rows = recorded.scan({});
  REQUIRE(rows.size() == layout.stride * sensor.beamCount());
  size_t wrong = 0;
  uint64_t hits = 0;
  for (size_t beam = 0; beam < sensor.beamCount(); ++beam) {
    double range, number;
    float single;
    std::memcpy(&range, &rows[layout.stride * beam], sizeof range);
    std::memcpy(&number, &rows[layout.stride * beam + 8], sizeof number);
    std::memcpy(&single, &rows[layout.stride * beam + 16], sizeof single);
    wrong += number != static_cast<double>(beam) ||
             (std::isnan(range) ? !std::isnan(single) : range != double{single} || range < 4.9 || range > 9);
    hits += !std::isnan(range);
  }
  CHECK(wrong == 0);
  CHECK(hits > 0);
  CHECK(hits == recorded.header.hits);
}

TEST_CASE("columns and rows share one buffer") {
  needVulkan();
  const CommonApp common;
  VulkanApp& app = common.app;
  const Sensor sensor = gridSensor(90, 8, -18, 9);
  const auto count = static_cast<size_t>(sensor.beamCount());
  RecordLayout layout;
  layout.stride = 12;
  layout.values = {
      {Field::x, 0, 0, ValueType::f32}, {Field::y, 0, 4, ValueType::f32}, {Field::z, 0, 8, ValueType::f32}};
  const size_t ranges = 12 * count, rings = ranges + 4 * count, causes = rings + 2 * count;
  layout.values.push_back({Field::range, 0, ranges, ValueType::f32, 4});
  layout.values.push_back({Field::ring, 0, rings, ValueType::u16, 2});
  layout.values.push_back({Field::returnNumber, 0, causes, ValueType::u8, 1});
  CHECK(layout.bytesFor(count) == causes + count);
  Recorded recorded(app, boxes(), {sensor, Effects::none()}, plainOptions(), layout, count);
  Shot shot;
  recorded.scan(shot);
  const std::byte* bytes = recorded.bytes(0);
  const Scan scan = scanOf(boxes(), sensor, {}, vulkanOptions());
  CHECK(std::memcmp(bytes, scan.points.data(), 12 * count) == 0);
  CHECK(std::memcmp(bytes + ranges, scan.ranges.data(), 4 * count) == 0);
  for (size_t i = 0; i < count; ++i) {
    uint16_t ring;
    std::memcpy(&ring, bytes + rings + 2 * i, 2);
    REQUIRE(ring == i / 90);
    REQUIRE(static_cast<uint8_t>(bytes[causes + i]) == (scan.returned(i) ? 1 : 0));
  }
}

TEST_CASE("meshes, instances and sensors come and go while frames are in flight", "[combinations]") {
  needVulkan();
  const CommonApp common;
  VulkanApp& app = common.app;
  const int rounds = everyCombination() ? 2000 : 12;
  const Sensor sensor = gridSensor(90, 8, -18, 9);
  Recorded recorded(app, boxes(), {sensor, Effects::none()}, plainOptions(), pointLayout());
  Simulator& simulator = recorded.simulator();
  TestOptions own = vulkanOptions();
  own.device = {DeviceChoice::Kind::vulkan, app.deviceName()};
  Simulator expected = makeSimulator(boxes(), sensor, own);
  MeshBuilder builder;
  builder.box({-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}, 4);
  const Mesh box = builder.take();
  std::vector<float> moved = box.positions;
  uint64_t bytes = 0;
  for (int round = 0; round < rounds; ++round) {
    for (Simulator* each : {&simulator, &expected}) {
      const auto mesh = static_cast<uint32_t>(each->addMesh(box));
      const size_t instance = each->addInstance(mesh, translation(3, 0.01 * (round % 100), 0));
      REQUIRE(mesh == 2);
      REQUIRE(instance == 2);
      each->setTransform(1, translation(-6, 0.1 * (round % 10), 0));
    }
    Shot shot;
    shot.frame = static_cast<uint64_t>(round);
    recorded.submit(shot);
    recorded.submit(shot);
    for (size_t i = 2; i < moved.size(); i += 3) moved[i] = box.positions[i] + 0.01f * static_cast<float>(round % 7);
    for (Simulator* each : {&simulator, &expected}) each->setPositions(2, moved);
    recorded.submit(shot);
    if (round % (rounds / 6) == 0) {
      Scan scan;
      expected.scanInto(shot, scan);
      const std::vector<std::byte> found = recorded.scan(shot);
      INFO("round " << round);
      REQUIRE(found == rowsOf(scan, pointLayout()));
    }
    const size_t second = simulator.addSensor({gridSensor(30 + round % 9, 4, -9, 9), Effects::none(), {}});
    recorded.submit(shot);
    simulator.removeSensor(second);
    for (Simulator* each : {&simulator, &expected}) {
      each->removeInstance(2);
      each->removeMesh(2);
    }
    recorded.submit(shot);
    const MemoryUse use = simulator.memory();
    if (round == 2) bytes = use.scene + use.sensor + use.work;
    if (round > 2) REQUIRE(use.scene + use.sensor + use.work <= bytes);
  }
}

TEST_CASE("scans in flight are told of though the scene changes the plan of their sensor, whose lists stay large") {
  needVulkan();
  const CommonApp common;
  Scene scene = boxes();
  Material glass;
  glass.transmission = 0.9f;
  scene.materials.push_back(glass);
  MeshBuilder pane;
  pane.quad({0, -1, -1}, {0, 2, 0}, {0, 0, 2}, 2);
  scene.meshes.push_back(pane.take());
  scene.meshes.back().parts[0].material = static_cast<uint32_t>(scene.materials.size() - 1);
  const auto mesh = static_cast<uint32_t>(scene.meshes.size() - 1);
  // So many boxes before each other do not fit into the first lists, so the first scans make the lists grow.
  for (int i = 1; i < 16; ++i) scene.instances.push_back({"", 0, scaling(1 + 0.01 * i, 1 + 0.01 * i, 1)});
  Recorded recorded(common.app, scene, {listSensor("rosette", rosette(3000, 1.5)), Effects()}, slabOptions(),
                    pointLayout());
  Simulator& simulator = recorded.simulator();
  std::vector<uint64_t> told;
  size_t incomplete = 0, pieces = 0;
  std::optional<size_t> window;
  for (uint64_t frame = 0; frame < 30; ++frame) {
    if (frame < 24 ? frame % 5 == 4 : frame > 24) {  // glass comes and goes, at last twice while a scan is in flight
      if (window) simulator.removeInstance(*window);
      window = window ? std::optional<size_t>() : simulator.addInstance(mesh, translation(2, 0, 0));
      ++pieces;
    }
    Shot shot;
    shot.frame = frame;
    for (const vulkan::RecordedScan& scan : recorded.submit(shot)) {
      told.push_back(scan.frame);
      if (frame > 8 && frame <= 24) incomplete += !scan.complete;  // both plans have had time to grow
    }
  }
  std::vector<uint64_t> all(told.size());
  std::iota(all.begin(), all.end(), uint64_t{0});
  CHECK(told == all);
  CHECK(told.size() >= 20);
  CHECK(pieces == 9);
  CHECK(incomplete == 0);
}

TEST_CASE("a mesh changes and another one comes before one recording") {
  needVulkan();
  const CommonApp common;
  VulkanApp& app = common.app;
  const Sensor sensor = gridSensor(90, 8, -18, 9);
  Recorded recorded(app, boxes(), {sensor, Effects::none()}, plainOptions(), pointLayout());
  recorded.scan({});
  // The new mesh makes the arrays grow, so that all of them is copied, and then a part once more.
  std::vector<float> positions = boxes().meshes[1].positions;
  for (float& value : positions) value *= 1.5f;
  TestOptions own = vulkanOptions();
  own.device = {DeviceChoice::Kind::vulkan, app.deviceName()};
  Simulator expected = makeSimulator(boxes(), sensor, own);
  for (Simulator* each : {&recorded.simulator(), &expected}) {
    each->setPositions(1, positions);
    const auto mesh = static_cast<uint32_t>(each->addMesh(ball(40, 60, 1)));
    each->addInstance(mesh, translation(-4, 4, 1));
    each->setPositions(1, positions);
  }
  Scan scan;
  expected.scanInto({}, scan);
  std::vector<std::byte> rows(pointLayout().stride * scan.ranges.size());
  rows.resize(pointLayout().stride * pack(scan, pointLayout(), rows));
  CHECK(recorded.scan({}) == rows);
}

namespace {

/// A table between the library and the loader: no memory of the device is coherent, and its atoms have 64 bytes.
struct Incoherent {
  static constexpr VkDeviceSize kAtom = 64;
  PFN_vkGetInstanceProcAddr instance = nullptr;
  PFN_vkGetDeviceProcAddr device = nullptr;
  PFN_vkGetPhysicalDeviceMemoryProperties memory = nullptr;
  PFN_vkFlushMappedMemoryRanges flush = nullptr;
  int flushed = 0;
} incoherent;

VKAPI_ATTR VkResult VKAPI_CALL checkedFlush(VkDevice device, uint32_t count, const VkMappedMemoryRange* ranges) {
  for (uint32_t i = 0; i < count; ++i) {
    CHECK(ranges[i].offset % Incoherent::kAtom == 0);
    CHECK(ranges[i].size % Incoherent::kAtom == 0);
  }
  ++incoherent.flushed;
  return incoherent.flush(device, count, ranges);
}

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL incoherentDevice(VkDevice device, const char* name) {
  const PFN_vkVoidFunction real = incoherent.device(device, name);
  if (std::string(name) != "vkFlushMappedMemoryRanges") return real;
  incoherent.flush = reinterpret_cast<PFN_vkFlushMappedMemoryRanges>(real);
  return reinterpret_cast<PFN_vkVoidFunction>(checkedFlush);
}

VKAPI_ATTR void VKAPI_CALL incoherentMemory(VkPhysicalDevice physical, VkPhysicalDeviceMemoryProperties* to) {
  incoherent.memory(physical, to);
  for (VkMemoryType& type : to->memoryTypes)
    type.propertyFlags &= ~VkMemoryPropertyFlags{VK_MEMORY_PROPERTY_HOST_COHERENT_BIT};
}

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL incoherentInstance(VkInstance instance, const char* name) {
  const PFN_vkVoidFunction real = incoherent.instance(instance, name);
  if (std::string(name) == "vkGetDeviceProcAddr") {
    incoherent.device = reinterpret_cast<PFN_vkGetDeviceProcAddr>(real);
    return reinterpret_cast<PFN_vkVoidFunction>(incoherentDevice);
  }
  if (std::string(name) != "vkGetPhysicalDeviceMemoryProperties") return real;
  incoherent.memory = reinterpret_cast<PFN_vkGetPhysicalDeviceMemoryProperties>(real);
  return reinterpret_cast<PFN_vkVoidFunction>(incoherentMemory);
}

}  // namespace

TEST_CASE("all memory comes from the caller's allocator, is flushed in whole atoms, and goes back") {
  needVulkan();
  incoherent = {};
  incoherent.instance = loaderLookUp();
  VulkanApp app("", incoherentInstance);
  vulkan::AdoptedDevice device = app.adopted();
  std::vector<std::unique_ptr<int>> given;
  size_t alive = 0;
  device.allocator.allocate = [&](const VkMemoryRequirements& requirements, uint32_t type) {
    VkMemoryAllocateFlagsInfo flags = {VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO};
    flags.flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT;
    VkMemoryAllocateInfo allocate = {VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, &flags};
    // Part of a larger block, as allocators give it.
    const VkDeviceSize offset = 4 * requirements.alignment;
    allocate.allocationSize = requirements.size + offset;
    allocate.memoryTypeIndex = type;
    vulkan::Allocation allocation;
    allocation.offset = offset;
    if (app.vk().vkAllocateMemory(device.device, &allocate, nullptr, &allocation.memory) != VK_SUCCESS)
      return allocation;
    ++alive;
    if (!app.isHostVisible(type)) return allocation;
    void* mapped = nullptr;
    REQUIRE(app.vk().vkMapMemory(device.device, allocation.memory, 0, VK_WHOLE_SIZE, 0, &mapped) == VK_SUCCESS);
    allocation.mapped = static_cast<std::byte*>(mapped) + offset;
    return allocation;
  };
  device.allocator.release = [&](const vulkan::Allocation& allocation) {
    app.vk().vkFreeMemory(device.device, allocation.memory, nullptr);
    --alive;
  };
  app.setAdopted(device);
  {
    Recorded recorded(app, boxes(), {gridSensor(90, 8, -18, 9), Effects::none()}, plainOptions(), pointLayout());
    CHECK(alive > 20);
    CHECK(recorded.scan({}).size() == 720 * pointLayout().stride);
    CHECK(incoherent.flushed > 0);
  }
  app.setAdopted(device);  // ends what the application holds of the library
  CHECK(alive == 0);
}

TEST_CASE("simulators whose choices of an adopted device are copies share kernels as long as one of them lives") {
  needVulkan();
  const CommonApp common;
  SimulatorOptions options = plainOptions(), other = options;
  options.device = vulkan::adopt(common.app.adopted());
  other.device = vulkan::adopt(common.app.adopted());
  Variant variant;
  variant.kernel = Kernel::prefix_sum;
  {
    const vulkan::LentDevice first = vulkan::lendDevice(options), second = vulkan::lendDevice(options);
    first->kernels.prepare({&variant, 1});
    CHECK(second->kernels.count() == 1);
    vulkan::LentDevice ofThread;
    std::thread([&] { ofThread = vulkan::lendDevice(options); }).join();
    CHECK(ofThread->kernels.count() == 1);
    CHECK(vulkan::lendDevice(other)->kernels.count() == 0);
  }
  CHECK(vulkan::lendDevice(options)->kernels.count() == 0);
}

TEST_CASE("a limit of buffers holds for those that carry the host's data, and only for its simulator") {
  needVulkan();
  const CommonApp common;
  TestOptions limited = vulkanOptions();
  limited.tuning.maxBufferBytes = 2 << 20;
  SimulatorOptions options = plainOptions();
  options.device = common.app.choice();
  const vulkan::LentDevice device = vulkan::lendDevice(options);
  vulkan::DeviceFunctions& vk = functionsOf(device->device);
  static PFN_vkCreateBuffer createBuffer;
  static VkDeviceSize largest;
  createBuffer = vk.vkCreateBuffer;
  vk.vkCreateBuffer = [](VkDevice on, const VkBufferCreateInfo* info, const VkAllocationCallbacks* with, VkBuffer* to) {
    largest = std::max(largest, info->size);
    return createBuffer(on, info, with, to);
  };
  const auto scanWith = [&](const SimulatorOptions& with) {
    largest = 0;
    Recorded recorded(common.app, sceneOf(soup(5, 40'000, 40, 0.5)), {gridSensor(90, 8, -18, 9), Effects::none()}, with,
                      pointLayout());
    return recorded.scan({});
  };
  const std::vector<std::byte> expected = scanWith(options);
  CHECK(largest > limited.tuning.maxBufferBytes);
  CHECK(scanWith(limited) == expected);
  CHECK(largest <= limited.tuning.maxBufferBytes);
  vk.vkCreateBuffer = createBuffer;
}

#ifdef VK_VERSION_1_3
TEST_CASE("required features go into the structure of Vulkan 1.3 as into those of the extension") {
  vulkan::Requirements needed;
  needed.features12.scalarBlockLayout = needed.subgroupSizeControl.computeFullSubgroups = VK_TRUE;
  VkPhysicalDeviceVulkan12Features features12 = {};
  VkPhysicalDeviceVulkan13Features features13 = {};
  features13.synchronization2 = VK_TRUE;
  needed.addTo(nullptr, &features12, &features13);
  CHECK(features12.scalarBlockLayout);
  CHECK(features13.computeFullSubgroups);
  CHECK(!features13.subgroupSizeControl);
  CHECK(features13.synchronization2);
}
#endif

TEST_CASE("misuse of adopted devices and recorders gets a sentence") {
  needVulkan();
  VulkanApp app;
  const auto refused = [&](auto change) {
    vulkan::AdoptedDevice device = app.adopted();
    change(device);
    return problemOf([&] { vulkan::adopt(device); });
  };
  CHECK(refused([](vulkan::AdoptedDevice&) {}) == "nothing was wrong");
  CHECK_THAT(refused([](auto& device) { device.getInstanceProcAddr = nullptr; }),
             ContainsSubstring("without vkGetInstanceProcAddr"));
  CHECK_THAT(refused([](auto& device) { device.device = VK_NULL_HANDLE; }), ContainsSubstring("without its instance"));
  CHECK_THAT(refused([](auto& device) { device.queueFamily = 99; }), ContainsSubstring("no queue family 99"));
  CHECK_THAT(refused([](auto& device) { device.enabled.features12.bufferDeviceAddress = VK_FALSE; }),
             ContainsSubstring("without the feature bufferDeviceAddress"));
  CHECK_THAT(refused([](auto& device) { device.enabled = {}; }),
             ContainsSubstring("without the feature scalarBlockLayout"));

  const Sensor sensor = gridSensor(90, 8, -18, 9);
  SensorRequest request = {sensor, Effects::none()};
  Simulator own(boxes(), request, plainOptions());
  CHECK_THROWS_WITH(vulkan::Recorder(own), ContainsSubstring("not on a device of the caller"));
  request.layout = pointLayout();
  CHECK_THROWS_WITH(own.addSensor(request), ContainsSubstring("stay on a device, see vulkan::adopt()"));

  Recorded recorded(app, boxes(), {sensor, Effects::none()}, plainOptions(), pointLayout());
  CHECK_THROWS_WITH(recorded.simulator().scan({}), ContainsSubstring("recorded by vulkan::Recorder"));
  SensorRequest broken = request;
  broken.layout.values[0].offset = 15;
  CHECK_THROWS_WITH(recorded.simulator().addSensor(broken), ContainsSubstring("beyond the stride of 16"));
  broken.layout.values[0] = {Field::tie, 0, 0, ValueType::u8};
  CHECK_THROWS_WITH(recorded.simulator().addSensor(broken), ContainsSubstring("only the device 'reference'"));
  broken.layout = layoutOf({Field::incidence});
  broken.sensor.rotationPeriod = 0.1;
  broken.effects.sensorMotion.use = EffectUse::on;
  broken.effects.sensorMotion.deskew = true;
  CHECK_THROWS_WITH(recorded.simulator().addSensor(broken),
                    ContainsSubstring("with deskew the incidence is known only on the host"));
  broken.effects.sensorMotion.deskew = false;
  broken.sensor.channels.clear();
  CHECK_THROWS_WITH(recorded.simulator().addSensor(broken), ContainsSubstring("has no beams"));
  CHECK_THROWS_WITH(vulkan::Recorder(recorded.simulator(), 0), ContainsSubstring("1 to 16 frames"));
  CHECK_THROWS_WITH(vulkan::Recorder(recorded.simulator()), ContainsSubstring("has a recorder already"));

  const size_t plain = recorded.simulator().addSensor({sensor, Effects::none()});
  const VulkanApp::Buffer records(app, 1 << 16), header(app, sizeof(RecordHeader));
  VulkanApp::Frame& frame = recorded.frame(0);
  const VkCommandBuffer commands = frame.begin();
  const vulkan::RecordedShot good = {{}, records.range(), header.range()};
  const auto attempt = [&](auto change, size_t number = 0) {
    vulkan::RecordedShot shot = good;
    change(shot);
    recorded.recorder().record(commands, number, {&shot, 1});
  };
  const auto same = [](vulkan::RecordedShot&) {};
  CHECK_THROWS_WITH(recorded.recorder().record(VK_NULL_HANDLE, 0, {}), ContainsSubstring("needs a command buffer"));
  CHECK_THROWS_WITH(attempt(same, 2), ContainsSubstring("no frame in flight 2"));
  CHECK_THROWS_WITH(attempt([](auto& shot) { shot.shot.sensor = 7; }), ContainsSubstring("sensor 7 does not exist"));
  CHECK_THROWS_WITH(attempt([&](auto& shot) { shot.shot.sensor = plain; }), ContainsSubstring("has no layout"));
  CHECK_THROWS_WITH(attempt([](auto& shot) { shot.records.address += 4; }), ContainsSubstring("multiple of 16"));
  CHECK_THROWS_WITH(attempt([](auto& shot) { shot.header.address = 0; }), ContainsSubstring("for the header needs"));
  CHECK_THROWS_WITH(attempt([](auto& shot) { shot.header.bytes = 16; }), ContainsSubstring("it needs 32"));
  frame.submit();
}

}  // namespace gnosphere::test
