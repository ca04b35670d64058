// SPDX-License-Identifier: Apache-2.0
// The C interface to a device of the caller: its scans against those of C++, and an error for every wrong argument.
#include <gnosphere_vulkan.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include "c/wall.hpp"
#include "engine/vulkan_app.hpp"

namespace gnosphere::test {
namespace {

/// Whether a call failed with GNO_INVALID_ARGUMENT, and its sentence has the words.
bool refused(gno_status status, const char* words) {
  INFO(status << ": " << gno_last_error());
  CHECK(status == GNO_INVALID_ARGUMENT);
  CHECK(std::strstr(gno_last_error(), words) != nullptr);
  return status == GNO_INVALID_ARGUMENT && std::strstr(gno_last_error(), words);
}

/// The application's device as C has it, with an allocator of the application that counts.
struct AdoptedInC {
  explicit AdoptedInC(const VulkanApp& application) : app(application) {
    const vulkan::AdoptedDevice& from = app.adopted();
    REQUIRE(gno_vulkan_get_requirements(app.loader(), from.instance, from.physicalDevice, &enabled) == GNO_OK);
    device.get_instance_proc_addr = app.loader();
    device.instance = from.instance;
    device.physical_device = from.physicalDevice;
    device.device = from.device;
    device.queue_family = from.queueFamily;
    device.enabled = &enabled;
    device.allocate = allocate;
    device.release = release;
    device.user = this;
  }

  static void allocate(const VkMemoryRequirements* requirements, uint32_t type, gno_vulkan_allocation* to, void* user) {
    auto& self = *static_cast<AdoptedInC*>(user);
    VkMemoryAllocateFlagsInfo flags = {VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO};
    flags.flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT;
    VkMemoryAllocateInfo info = {VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, &flags};
    info.allocationSize = requirements->size;
    info.memoryTypeIndex = type;
    const auto& vk = self.app.vk();
    if (vk.vkAllocateMemory(self.device.device, &info, nullptr, &to->memory) != VK_SUCCESS) return;
    if (self.app.isHostVisible(type)) vk.vkMapMemory(self.device.device, to->memory, 0, VK_WHOLE_SIZE, 0, &to->mapped);
    to->allocation = &self;
    ++self.alive;
    ++self.made;
  }
  static void release(const gno_vulkan_allocation* allocation, void* user) {
    auto& self = *static_cast<AdoptedInC*>(user);
    CHECK(allocation->allocation == user);
    self.app.vk().vkFreeMemory(self.device.device, allocation->memory, nullptr);
    --self.alive;
  }

  const VulkanApp& app;
  gno_vulkan_requirements enabled = gno_vulkan_requirements_init();
  gno_vulkan_adopted_device device = gno_vulkan_adopted_device_init();
  int alive = 0, made = 0;
};

/// A square in front of the sensor, in C and in C++.
const float kCorners[] = {5, -4, -3, 5, 4, -3, 6, 4, 3, 6, -4, 3};

gno_scene squareInC() {
  gno_scene scene = sceneWithSquare(kCorners);
  const gno_instance instance = gno_instance_init();
  REQUIRE(gno_scene_add_instance(scene, &instance, nullptr) == GNO_OK);
  return scene;
}

Scene square() {
  Mesh mesh;
  mesh.positions.assign(std::begin(kCorners), std::end(kCorners));
  mesh.indices.assign(std::begin(kSquare), std::end(kSquare));
  mesh.parts = {{0, 2, 0}};
  Scene scene;
  scene.materials = {{}};
  scene.meshes = {mesh};
  scene.instances = {{"", 0, {}, 0}};
  return scene;
}

gno_sensor sensorOf(const Sensor& from) {
  gno_sensor sensor = nullptr;
  REQUIRE(gno_sensor_from_json(toJson(from).c_str(), &sensor) == GNO_OK);
  return sensor;
}

gno_options optionsOn(const AdoptedInC& adopted) {
  gno_options options = gno_options_init();
  options.adopted = &adopted.device;
  options.cache = "off";
  return options;
}

gno_vulkan_range rangeOf(const VulkanApp::Buffer& buffer) {
  return {buffer.range().address, buffer.range().bytes};
}

/// A simulator of the square on the application's device, and its recorder.
struct RecorderInC {
  struct Scanner {
    Sensor sensor;
    const gno_layout* layout;
  };
  RecorderInC(const VulkanApp& app, const std::vector<Scanner>& scanners, size_t framesInFlight) : adopted(app) {
    for (const Scanner& scanner : scanners) {
      gno_request& request = requests.emplace_back(gno_request_init());
      request.layout = scanner.layout;
      request.sensor = sensorOf(scanner.sensor);
      REQUIRE(gno_effects_preset("clean", &request.effects) == GNO_OK);
    }
    const gno_options options = optionsOn(adopted);
    REQUIRE(gno_simulator_create(scene, requests.data(), requests.size(), &options, &simulator) == GNO_OK);
    CHECK(adopted.made > 20);
    REQUIRE(gno_vulkan_recorder_create(simulator, framesInFlight, &recorder) == GNO_OK);
  }
  ~RecorderInC() {
    CHECK(gno_vulkan_recorder_destroy(recorder) == GNO_OK);
    CHECK(gno_simulator_destroy(simulator) == GNO_OK);
    CHECK(adopted.alive == 0);
    for (const gno_request& request : requests) {
      CHECK(gno_sensor_destroy(request.sensor) == GNO_OK);
      CHECK(gno_effects_destroy(request.effects) == GNO_OK);
    }
    CHECK(gno_scene_destroy(scene) == GNO_OK);
  }
  RecorderInC(const RecorderInC&) = delete;
  RecorderInC& operator=(const RecorderInC&) = delete;

  AdoptedInC adopted;
  std::vector<gno_request> requests;
  gno_scene scene = squareInC();
  gno_simulator simulator = nullptr;
  gno_vulkan_recorder recorder = nullptr;
};

}  // namespace

TEST_CASE("C: recorded scans of two sensors have the bytes of C++'s scans, in rows and in columns") {
  needVulkan();
  const CommonApp common;
  VulkanApp& app = common.app;
  const Sensor first = gridSensor(60, 8, -20, 20), second = gridSensor(30, 4, -9, 9);

  const std::vector<gno_field> fields = {GNO_FIELD_X, GNO_FIELD_Y, GNO_FIELD_Z, GNO_FIELD_TIME, GNO_FIELD_INSTANCE};
  gno_layout rows = gno_layout_init(), columns = gno_layout_init();
  REQUIRE(gno_layout_of(fields.data(), fields.size(), &rows) == GNO_OK);
  rows.compact = 1;
  const gno_layout_value two[] = {{GNO_FIELD_RANGE, 0, 0, GNO_F32, 4}, {GNO_FIELD_BEAM, 0, 4 * 120, GNO_U32, 4}};
  columns.values = two;
  columns.value_count = 2;
  uint64_t columnBytes = 0;
  REQUIRE(gno_layout_bytes_for(&columns, 120, &columnBytes) == GNO_OK);
  CHECK(columnBytes == 8 * 120);
  const RecorderInC c(app, {{first, &rows}, {second, &columns}}, 2);
  const RecorderInC other(app, {{first, &rows}}, 1);  // with memory of its own, although the device is the same
  CHECK(c.adopted.enabled.missing_count == 0);
  CHECK(c.adopted.enabled.extension_count == app.adopted().enabled.extensions.size());

  TestOptions own = vulkanOptions();
  own.device = {DeviceChoice::Kind::vulkan, app.deviceName()};
  SensorRequest timed = {first, Effects::none(), {Field::time}};
  Simulator expected(square(), std::vector<SensorRequest>{timed, {second, Effects::none()}}, own);
  RecordLayout packed = layoutOf({Field::x, Field::y, Field::z, Field::time, Field::instance});
  packed.compact = true;

  VulkanApp::Frame frame(app);
  const VulkanApp::Buffer records(app, packed.stride * 480), firstHeader(app, sizeof(gno_vulkan_record_header)),
      ranges(app, columnBytes), secondHeader(app, sizeof(gno_vulkan_record_header));
  for (uint64_t number = 0; number < 3; ++number) {
    gno_transform place = {{1, 0, 0, 0.5 * static_cast<double>(number), 0, 1, 0, 0, 0, 0, 1, 0}};
    REQUIRE(gno_simulator_set_transform(c.simulator, 0, &place) == GNO_OK);
    Transform same;
    std::copy_n(place.rows, 12, same.rows.begin());
    expected.setTransform(0, same);
    gno_shot shots[2] = {gno_shot_init(), gno_shot_init()};
    shots[1].sensor = 1;
    shots[0].frame = shots[1].frame = 5 + number;
    const gno_vulkan_recorded_shot recorded[] = {{&shots[0], rangeOf(records), rangeOf(firstHeader)},
                                                 {&shots[1], rangeOf(ranges), rangeOf(secondHeader)}};
    const gno_vulkan_recorded_scan* before = nullptr;
    size_t count = 9;
    const VkCommandBuffer commands = frame.begin();
    REQUIRE(gno_vulkan_record(c.recorder, commands, 0, recorded, 2, &before, &count) == GNO_OK);
    frame.submit();
    frame.wait();
    REQUIRE(count == (number == 0 ? 0 : 2));
    for (size_t i = 0; i < count; ++i)
      CHECK((before[i].sensor == i && before[i].frame == 4 + number && before[i].complete));

    const Scan inRows = expected.scan({}, 0), inColumns = expected.scan({}, 1);
    std::vector<std::byte> bytes(packed.stride * 480);
    bytes.resize(packed.stride * pack(inRows, packed, bytes));
    const auto& told = *firstHeader.as<gno_vulkan_record_header>();
    REQUIRE(told.rows * packed.stride == bytes.size());
    CHECK(told.rows > 50);
    CHECK((told.incomplete == 0 && told.frame == 5 + number && told.instance_count == 1));
    CHECK(std::memcmp(records.bytes().data(), bytes.data(), bytes.size()) == 0);
    CHECK(std::memcmp(ranges.bytes().data(), inColumns.ranges.data(), 4 * 120) == 0);
    CHECK(secondHeader.as<gno_vulkan_record_header>()->hits == inColumns.counters.hits);
    for (uint32_t beam = 0; beam < 120; ++beam) REQUIRE(ranges.as<uint32_t>()[120 + beam] == beam);
    for (const auto* buffer : {&records, &firstHeader, &ranges, &secondHeader}) CHECK(buffer->guarded());
  }
}

TEST_CASE("C: recorded scans take the vertices of a mesh and the transform of an instance from buffers") {
  needVulkan();
  const CommonApp common;
  VulkanApp& app = common.app;
  gno_layout layout = gno_layout_init();
  const gno_field fields[] = {GNO_FIELD_RANGE, GNO_FIELD_BEAM};
  REQUIRE(gno_layout_of(fields, 2, &layout) == GNO_OK);
  const Sensor sensor = gridSensor(60, 8, -20, 20);
  const RecorderInC c(app, {{sensor, &layout}}, 1);

  // Integers of 16 bits, four per vertex, that place the square half as far away. The last corner is at the third.
  const std::vector<int16_t> corners = {250, -200, -150, 0, 250, 200, -150, 0, 300, 200, 150, 0, 300, 200, 150, 0};
  VulkanApp::Buffer vertices(app, 2 * corners.size());
  const VulkanApp::Buffer records(app, 8 * 480), header(app, sizeof(gno_vulkan_record_header));
  std::memcpy(vertices.bytes().data(), corners.data(), 2 * corners.size());
  gno_vulkan_vertex_buffer buffer = gno_vulkan_vertex_buffer_init();
  CHECK(refused(gno_vulkan_recorder_set_vertices(c.recorder, 0, &buffer), "address"));
  buffer.address = vertices.range().address;
  buffer.bytes = vertices.range().bytes;
  CHECK(refused(gno_vulkan_recorder_set_vertices(c.recorder, 0, nullptr), "gno_vulkan_vertex_buffer is null"));
  CHECK(refused(gno_vulkan_recorder_set_vertices(c.recorder, 7, &buffer), "mesh 7 does not exist"));
  buffer.stride = 8;
  buffer.format = VK_FORMAT_R16G16B16A16_SSCALED;
  std::fill(buffer.scale, buffer.scale + 3, 0.01f);
  REQUIRE(gno_vulkan_recorder_set_vertices(c.recorder, 0, &buffer) == GNO_OK);

  // Column by column: 1 m to the left and 0.5 m up from a place 0.25 m nearer.
  const std::array<float, 16> place = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 1, 0.5f, 1};
  VulkanApp::Buffer transforms(app, sizeof place);
  std::memcpy(transforms.bytes().data(), place.data(), sizeof place);
  gno_vulkan_transform_buffer instances = gno_vulkan_transform_buffer_init();
  CHECK(instances.stride == 48);
  instances.address = transforms.range().address;
  instances.bytes = transforms.range().bytes;
  instances.stride = 64;
  instances.format = 2;
  instances.instance_count = 1;
  instances.origin[0] = -0.25;
  CHECK(refused(gno_vulkan_recorder_set_transforms(c.recorder, &instances), "transform format is 2"));
  instances.format = GNO_VULKAN_TRANSFORM_COLUMNS_4X4;
  instances.first_instance = 1;
  CHECK(refused(gno_vulkan_recorder_set_transforms(c.recorder, &instances), "instance 1 does not exist"));
  instances.first_instance = 0;
  REQUIRE(gno_vulkan_recorder_set_transforms(c.recorder, &instances) == GNO_OK);

  const gno_shot shot = gno_shot_init();
  const gno_vulkan_recorded_shot recorded = {&shot, rangeOf(records), rangeOf(header)};
  VulkanApp::Frame frame(app);
  const gno_vulkan_recorded_scan* before = nullptr;
  size_t count = 0;
  for (int i = 0; i < 2; ++i) {
    REQUIRE(gno_vulkan_record(c.recorder, frame.begin(), 0, &recorded, 1, &before, &count) == GNO_OK);
    frame.submit();
    frame.wait();
  }
  REQUIRE(count == 1);
  CHECK(before[0].non_finite == 0);
  CHECK(before[0].degenerate == 1);
  CHECK(before[0].unplaced == 0);

  TestOptions reference;
  reference.device = DeviceChoice::Kind::reference;
  Scene moved = square();
  moved.meshes[0].positions.clear();
  for (size_t i = 0; i < corners.size(); ++i)
    if (i % 4 < 3) moved.meshes[0].positions.push_back(0.01f * static_cast<float>(corners[i]));
  moved.instances[0].transform = translation(-0.25, 1, 0.5);
  const Scan expected = makeSimulator(moved, sensor, reference).scan({});
  REQUIRE(expected.counters.hits > 20);
  REQUIRE(header.as<gno_vulkan_record_header>()->hits == expected.counters.hits);
  for (uint32_t row = 0; row < 480; ++row) {
    const float range = records.as<float>()[2 * row], right = expected.ranges[row];
    REQUIRE((std::isnan(right) ? std::isnan(range) : std::abs(range - right) < 1e-4f));
  }
}

TEST_CASE("C: misuse of adopted devices and recorders is an error that says so") {
  needVulkan();
  const CommonApp common;
  VulkanApp& app = common.app;
  AdoptedInC adopted(app);
  gno_scene scene = squareInC();
  gno_layout layout = gno_layout_init();
  const gno_field x = GNO_FIELD_X;
  REQUIRE(gno_layout_of(&x, 1, &layout) == GNO_OK);
  gno_request request = gno_request_init();
  request.sensor = sensorOf(gridSensor(60, 8, -20, 20));
  request.layout = &layout;
  gno_simulator simulator = nullptr;
  const auto created = [&](const gno_options& options) {
    return gno_simulator_create(scene, &request, 1, &options, &simulator);
  };
  const auto changed = [&](auto change) {
    AdoptedInC other(app);
    change(other);
    return created(optionsOn(other));
  };

  gno_vulkan_requirements requirements = gno_vulkan_requirements_init();
  CHECK(refused(gno_vulkan_get_requirements(nullptr, VK_NULL_HANDLE, VK_NULL_HANDLE, &requirements), "needs"));
  CHECK(
      refused(gno_vulkan_get_requirements(app.loader(), app.adopted().instance, app.adopted().physicalDevice, nullptr),
              "gno_vulkan_requirements is null"));
  requirements.struct_size = 0;
  CHECK(refused(gno_vulkan_add_features(&requirements, nullptr, nullptr, nullptr), "struct_size"));
  CHECK(refused(changed([](AdoptedInC& c) { c.device.struct_size += 8; }), "gno_vulkan_adopted_device::struct_size"));
  CHECK(refused(changed([](AdoptedInC& c) { c.device.enabled = nullptr; }), "gno_vulkan_requirements is null"));
  CHECK(refused(changed([](AdoptedInC& c) { c.enabled.features12.bufferDeviceAddress = VK_FALSE; }),
                "without the feature bufferDeviceAddress"));
  CHECK(refused(changed([](AdoptedInC& c) { c.device.device = VK_NULL_HANDLE; }), "without its instance"));
  CHECK(refused(changed([](AdoptedInC& c) { c.device.release = nullptr; }), "only one of its two functions"));
  gno_options reference = gno_options_init();
  reference.device = "reference";
  CHECK(refused(created(reference), "stay on a device, see vulkan::adopt()"));
  request.layout = nullptr;
  gno_vulkan_recorder recorder = nullptr;
  REQUIRE(created(reference) == GNO_OK);
  CHECK(refused(gno_vulkan_recorder_create(simulator, 2, &recorder), "not on a device of the caller"));
  CHECK(gno_simulator_destroy(simulator) == GNO_OK);
  request.layout = &layout;

  REQUIRE(created(optionsOn(adopted)) == GNO_OK);
  gno_shot shot = gno_shot_init();
  gno_scan scan = nullptr;
  CHECK(refused(gno_simulator_scan(simulator, &shot, &scan), "recorded by"));
  CHECK(refused(gno_vulkan_recorder_create(nullptr, 2, &recorder), "the handle of the simulator is null"));
  CHECK(refused(gno_vulkan_recorder_create(simulator, 99, &recorder), "1 to 16 frames"));
  CHECK(refused(gno_vulkan_recorder_create(simulator, 1, nullptr), "recorder is null"));
  REQUIRE(gno_vulkan_recorder_create(simulator, 1, &recorder) == GNO_OK);
  gno_vulkan_recorder second = nullptr;
  CHECK(refused(gno_vulkan_recorder_create(simulator, 1, &second), "has a recorder already"));
  VulkanApp::Frame frame(app);
  const VkCommandBuffer commands = frame.begin();
  const VulkanApp::Buffer records(app, 4096), header(app, sizeof(gno_vulkan_record_header));
  gno_vulkan_recorded_shot recorded = {&shot, rangeOf(records), rangeOf(header)};
  const auto record = [&](VkCommandBuffer to) {
    return gno_vulkan_record(recorder, to, 0, &recorded, 1, nullptr, nullptr);
  };
  CHECK(refused(record(VK_NULL_HANDLE), "needs a command buffer"));
  CHECK(refused(gno_vulkan_record(recorder, commands, 1, &recorded, 1, nullptr, nullptr), "no frame in flight 1"));
  CHECK(refused(gno_vulkan_record(recorder, commands, 0, nullptr, 1, nullptr, nullptr), "shots is null"));
  recorded.shot = nullptr;
  CHECK(refused(record(commands), "gno_shot is null"));
  recorded.shot = &shot;
  recorded.records.address += 4;
  CHECK(refused(record(commands), "multiple of 16"));
  recorded.records.address -= 4;
  CHECK(record(commands) == GNO_OK);
  frame.submit();
  frame.wait();
  CHECK(gno_simulator_destroy(simulator) == GNO_OK);
  CHECK(refused(record(frame.begin()), "there is no simulator of this handle"));
  frame.submit();
  CHECK(gno_vulkan_recorder_destroy(recorder) == GNO_OK);
  CHECK(refused(record(commands), "there is no recorder of this handle"));
  CHECK(gno_sensor_destroy(request.sensor) == GNO_OK);
  CHECK(gno_scene_destroy(scene) == GNO_OK);
}

}  // namespace gnosphere::test
