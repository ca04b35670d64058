// SPDX-License-Identifier: Apache-2.0
// The blocks of docs/engine.md, word for word and in their order, with what an engine has around them, and those of
// docs/c.md, which c/page.c has. tests/docs/check_page compares the blocks with the pages.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "c/page.h"
#include "engine/recorded.hpp"
#include "folder.hpp"

namespace gnosphere::test {
namespace {

/// Two boxes around a point: their faces are where recorded().hpp's boxes() has them, the inner one at `inner`.
double distanceToFaces(const Vec3& p, const Vec3& inner) {
  const auto toBox = [](const Vec3& at, const Vec3& low, const Vec3& high) {
    const double across[] = {std::max(low.x - at.x, at.x - high.x), std::max(low.y - at.y, at.y - high.y),
                             std::max(low.z - at.z, at.z - high.z)};
    return std::abs(*std::max_element(across, across + 3));  // near a face it is the distance from it
  };
  const Vec3 relative = {p.x - inner.x, p.y - inner.y, p.z - inner.z};
  return std::min(toBox(p, {-20, -20, -3}, {20, 20, 12}), toBox(relative, {-1, -1, -1}, {1, 1, 1}));
}

/// The returns that an engine finds in its buffers.
struct Found {
  uint32_t hits = 0, incomplete = 0;
  double farthest = 0;  ///< from the faces of the boxes
  double least = std::numeric_limits<double>::infinity();
};

/// Reads rows that begin with x, y and z, which were scanned from `sensor` without a turn.
Found lookAt(const std::byte* records, const RecordHeader& header, size_t stride, const Vec3& sensor,
             const Vec3& inner) {
  Found found = {header.hits, header.incomplete};
  CHECK(header.rows == header.hits);
  CHECK(header.wanted == header.rows);
  for (uint32_t row = 0; row < header.rows; ++row) {
    float p[3];
    std::memcpy(p, records + row * stride, sizeof p);
    const Vec3 world = {p[0] + sensor.x, p[1] + sensor.y, p[2] + sensor.z};
    found.farthest = std::max(found.farthest, distanceToFaces(world, inner));
    found.least = std::min(found.least, std::sqrt(double{p[0]} * p[0] + double{p[1]} * p[1] + double{p[2]} * p[2]));
  }
  return found;
}

/// A vertex of an engine.
struct Vertex {
  float normal[3], position[3], uv[2];
};

/// A folder that is the current one, in which compiled kernels are kept, too.
class CurrentFolder {
 public:
  CurrentFolder() : before_(fs::current_path()) {
    if (const char* cache = std::getenv("XDG_CACHE_HOME")) cache_ = cache;
    fs::current_path(folder_.path());
    setenv("XDG_CACHE_HOME", folder_.path().c_str(), 1);
  }
  ~CurrentFolder() {
    fs::current_path(before_);
    if (cache_) {
      setenv("XDG_CACHE_HOME", cache_->c_str(), 1);
    } else {
      unsetenv("XDG_CACHE_HOME");
    }
  }
  CurrentFolder(const CurrentFolder&) = delete;
  CurrentFolder& operator=(const CurrentFolder&) = delete;

 private:
  Folder folder_;
  fs::path before_;
  std::optional<std::string> cache_;
};

/// The boxes, of which a clip takes the inner one 4 m to the left within a second and its corners 2 m forward.
Scene walkingBoxes() {
  Scene scene = boxes();
  std::vector<float> forward(scene.meshes[1].positions.size());
  for (size_t i = 0; i < forward.size(); i += 3) forward[i] = 2;
  scene.meshes[1].morphTargets = {forward};
  Node node;
  node.translation = {6, 0, 0};
  node.morphWeights = {0};
  const auto linear = Track::Interpolation::linear;
  const Track left = {0, Track::Property::translation, linear, {0, 1}, {6, 0, 0, 6, 4, 0}};
  const Track ahead = {0, Track::Property::morphWeights, linear, {0, 1}, {0, 1}};
  scene.animation.nodes = {node};
  scene.animation.clips = {{"walk", 1, {left, ahead}}};
  scene.animation.instances = {{1, 0, kNoSkin, {}}};
  return scene;
}

}  // namespace

TEST_CASE("the blocks of docs/engine.md record scans on the device of an engine", "[.page]") {
  needVulkan();
  const CommonApp common;
  VulkanApp& app = common.app;
  const PFN_vkGetInstanceProcAddr vkGetInstanceProcAddr = app.loader();
  const VkInstance instance = app.adopted().instance;
  const VkPhysicalDevice physical = app.adopted().physicalDevice;
  const VkDevice device = app.adopted().device;
  const uint32_t family = app.adopted().queueFamily;
  std::vector<std::string> logged;
  const auto log = [&](const std::string& sentence) { logged.push_back(sentence); };
  VkPhysicalDeviceFeatures features = {};
  VkPhysicalDeviceVulkan12Features features12 = {};
  VkPhysicalDeviceSubgroupSizeControlFeaturesEXT subgroupSizeControl = {};
  std::vector<const char*> extensions = {"VK_MY_own"};

  const vulkan::Requirements needed = vulkan::requirementsOf(vkGetInstanceProcAddr, instance, physical);
  for (const std::string& sentence : needed.missing) log(sentence);  // empty: the device can be used
  needed.addTo(&features, &features12, &subgroupSizeControl);        // the structures of your own chain
  extensions.insert(extensions.end(), needed.extensions.begin(), needed.extensions.end());

  CHECK(logged.empty());
  CHECK((features12.bufferDeviceAddress && features12.scalarBlockLayout && subgroupSizeControl.computeFullSubgroups));
  CHECK(extensions.size() == 1 + needed.extensions.size());

  vulkan::AdoptedDevice adopted;
  adopted.getInstanceProcAddr = vkGetInstanceProcAddr;
  adopted.instance = instance;
  adopted.physicalDevice = physical;
  adopted.device = device;
  adopted.queueFamily = family;  // of the queue to which you submit
  adopted.enabled = needed;      // clear what you have left off
  SimulatorOptions options;
  options.device = vulkan::adopt(adopted);

  options.cache = "off";
  const Scene scene = boxes();
  const size_t framesInFlight = 2;

  SensorRequest request(builtinSensor("OS1-128"));
  request.layout = layoutOf({Field::x, Field::y, Field::z, Field::intensity, Field::ring, Field::time});
  request.layout.compact = true;  // only returns, without gaps and in order; otherwise a row per beam and return
  Simulator simulator(scene, request, options);
  vulkan::Recorder recorder(simulator, framesInFlight);

  const size_t stride = request.layout.stride, beams = request.sensor.beamCount();
  VulkanApp::Frame frames[] = {VulkanApp::Frame(app), VulkanApp::Frame(app)};
  const size_t robots = 3, bytesPerShot = (request.layout.bytesFor(2 * beams) + 15) / 16 * 16;
  VulkanApp::Buffer records(app, robots * bytesPerShot), headers(app, robots * sizeof(RecordHeader));
  const VkDeviceAddress addressOfRecords = records.range().address, addressOfHeader = headers.range().address;
  const VkDeviceSize bytesOfRecords = bytesPerShot;
  const Vec3 at = {1, 2, 0.5}, atRest = {6, 0, 0};
  const Pose poseOfSensor = {at, {}};
  const uint64_t frameNumber = 7;
  size_t frameInFlight = 0;
  VkCommandBuffer commandBuffer = frames[0].begin();

  vulkan::RecordedShot shot;
  shot.shot.pose = poseOfSensor;
  shot.shot.frame = frameNumber;
  shot.records = {addressOfRecords, bytesOfRecords};  // RecordLayout::bytesFor() says how many bytes rows need
  shot.header = {addressOfHeader, sizeof(RecordHeader)};
  recorder.record(commandBuffer, frameInFlight, {&shot, 1});

  // The lists of each frame in flight have room after a recording that says they were too small.
  const auto submitAndWait = [&] {
    frames[frameInFlight].submit();
    frames[frameInFlight].wait();
  };
  const auto isComplete = [&](size_t count) {
    const auto* header = headers.as<RecordHeader>();
    return std::all_of(header, header + count, [](const RecordHeader& each) { return each.incomplete == 0; });
  };
  const auto untilComplete = [&] {
    for (int attempt = 0; attempt < 6 && !isComplete(1); ++attempt) {
      commandBuffer = frames[frameInFlight].begin();
      recorder.record(commandBuffer, frameInFlight, {&shot, 1});
      submitAndWait();
    }
  };
  const auto look = [&](size_t view, const Vec3& from, const Vec3& inner) {
    return lookAt(records.bytes().data() + view * bytesPerShot, headers.as<RecordHeader>()[view], stride, from, inner);
  };
  submitAndWait();
  untilComplete();
  const Found first = look(0, at, atRest);
  CHECK(headers.as<RecordHeader>()->frame == frameNumber);
  CHECK(first.incomplete == 0);
  CHECK(first.hits > beams / 2);
  CHECK(first.farthest < 0.05);

  commandBuffer = frames[0].begin();
  recorder.record(commandBuffer, frameInFlight, {&shot, 1});
  frames[0].end();

  recorder.abandon(frameInFlight);

  const VkDeviceAddress addressOfHeaders = addressOfHeader;
  const std::vector<Pose> poses = {{{0, 0, 0}, {}}, {{0, 5, 1}, {}}, {{-3, -5, 2}, {}}};
  for (int attempt = 0; attempt < 6 && (attempt == 0 || !isComplete(robots)); ++attempt) {
    commandBuffer = frames[0].begin();

    std::vector<vulkan::RecordedShot> shots(robots);
    for (size_t i = 0; i < robots; ++i) {
      shots[i].shot.pose = poses[i];
      shots[i].shot.world = static_cast<uint32_t>(i + 1);
      shots[i].records = {addressOfRecords + i * bytesPerShot, bytesPerShot};  // a multiple of 16 bytes
      shots[i].header = {addressOfHeaders + i * sizeof(RecordHeader), sizeof(RecordHeader)};
    }
    recorder.record(commandBuffer, frameInFlight, shots);

    submitAndWait();
  }
  for (size_t i = 0; i < robots; ++i) {
    const Found view = look(i, poses[i].position, atRest);
    CHECK(view.incomplete == 0);
    CHECK(view.hits > beams / 2);
    CHECK(view.farthest < 0.05);
  }

  // The fences of the frames stand for the semaphore: frame n has signalled when its fence has.
  constexpr int timeline = 0;
  const VkQueue queue = app.queue();
  std::vector<uint64_t> waited;
  const auto waitFor = [&](int, uint64_t count) {
    waited.push_back(count);
    frames[count % framesInFlight].wait();
  };
  const auto submit = [&](VkQueue to, VkCommandBuffer, int, uint64_t count) {
    CHECK(to == app.queue());
    frames[count % framesInFlight].submit();
  };
  for (uint64_t n = 1; n <= 6; ++n) {
    commandBuffer = frames[n % framesInFlight].begin();

    if (n > framesInFlight) waitFor(timeline, n - framesInFlight);  // vkWaitSemaphores
    recorder.record(commandBuffer, n % framesInFlight, {&shot, 1});
    submit(queue, commandBuffer, /* signals */ timeline, n);  // VkTimelineSemaphoreSubmitInfo
  }
  CHECK(waited == std::vector<uint64_t>{1, 2, 3, 4});
  for (VulkanApp::Frame& frame : frames) frame.wait();
  CHECK(look(0, at, atRest).hits == first.hits);

  // A pane at y = 4 in the buffer, which is beyond the wall in the bind pose.
  const std::vector<float> bindPose = {-2, 30, -1, 2, 30, -1, 2, 30, 1, -2, 30, 1};
  const std::vector<uint16_t> indices16 = {0, 1, 2, 0, 2, 3};
  const uint32_t material = 0;
  const Transform transformOfCharacter;
  VulkanApp::Buffer vertexBuffer(app, 4 * sizeof(Vertex));
  const VkDeviceAddress addressOfVertexBuffer = vertexBuffer.range().address;
  const VkDeviceSize bytesOfVertexBuffer = vertexBuffer.range().bytes;
  const auto skin = [&](VkCommandBuffer) {
    for (size_t i = 0; i < 4; ++i) {
      const Vertex vertex = {{}, {bindPose[3 * i], 4, bindPose[3 * i + 2]}, {}};
      std::memcpy(vertexBuffer.bytes().data() + i * sizeof vertex, &vertex, sizeof vertex);
    }
  };
  commandBuffer = frames[0].begin();

  Mesh mesh;                  // clusters are made of these positions: best those of the bind pose
  mesh.positions = bindPose;  // relative to Mesh::origin, as those in the buffer
  mesh.indices.assign(indices16.begin(), indices16.end());
  mesh.parts = {{0, static_cast<uint32_t>(mesh.triangleCount()), material}};
  const size_t skinned = simulator.addMesh(mesh);
  simulator.addInstance(static_cast<uint32_t>(skinned), transformOfCharacter);

  // In every frame in which the mesh has moved, before or after you record the skinning:
  vulkan::VertexBuffer vertices;
  vertices.address = addressOfVertexBuffer + offsetof(Vertex, position);
  vertices.bytes = bytesOfVertexBuffer - offsetof(Vertex, position);
  vertices.stride = sizeof(Vertex);
  recorder.setVertices(skinned, vertices);
  skin(commandBuffer);  // no barrier is needed between your dispatch and the scans
  recorder.record(commandBuffer, frameInFlight, {&shot, 1});

  submitAndWait();
  untilComplete();
  CHECK(look(0, at, atRest).incomplete == 0);
  CHECK(std::abs(look(0, at, atRest).least - 2) < 0.05);  // the pane is 2 m to the left of the sensor
  CHECK(first.least > 3);

  // The small box is 2 m farther in the buffer, relative to an origin.
  const Vec3 originOfYourFloats = {3, 0, 0}, movedBox = {8, 0, 0};
  const size_t firstMoved = 1, moved = 1;
  VulkanApp::Buffer transformBuffer(app, 48);
  const float rows[12] = {1, 0, 0, 5, 0, 1, 0, 0, 0, 0, 1, 0};
  std::memcpy(transformBuffer.bytes().data(), rows, sizeof rows);
  const VkDeviceAddress addressOfTransforms = transformBuffer.range().address;
  const VkDeviceSize bytesOfTransforms = transformBuffer.range().bytes;
  simulator.setTransform(2, translation(0, 30, 0));  // the pane leaves the room

  vulkan::TransformBuffer transforms;
  transforms.address = addressOfTransforms;  // three rows of four floats each, as VkTransformMatrixKHR
  transforms.bytes = bytesOfTransforms;
  transforms.origin = originOfYourFloats;  // in the world, in double: a place not too far from the sensor
  transforms.firstInstance = firstMoved;   // the first transform is that of this instance; others follow
  transforms.instances = moved;
  recorder.setTransforms(transforms);

  commandBuffer = frames[0].begin();
  recorder.record(commandBuffer, frameInFlight, {&shot, 1});
  submitAndWait();
  untilComplete();
  CHECK(look(0, at, movedBox).hits > beams / 2);
  CHECK(look(0, at, movedBox).farthest < 0.05);
  CHECK(look(0, at, atRest).farthest > 0.5);
}

TEST_CASE("the blocks of docs/c.md, compiled as C99, scan, and record on the device of an engine", "[.page]") {
  needVulkan();
  const CurrentFolder current;
  writeGlb(walkingBoxes(), "town.glb");
  const size_t beams = builtinSensor("HDL-64E").beamCount();

  // The nearest corners of the inner box are 5 m ahead and 0.8 m below the sensor; half way of the clip, 6 m and 1 m to
  // the left.
  const page_scans scans = scan_as_the_page_says(0.5);
  CHECK(scans.still.entries == beams);
  CHECK(scans.still.hits > beams / 2);
  CHECK((scans.still.nearest > 5.06 - 0.05 && scans.still.nearest < 5.06 + 0.1));
  CHECK((scans.moved.nearest > 6.13 - 0.05 && scans.moved.nearest < 6.13 + 0.1));
  CHECK(scans.views == 3);
  for (const size_t hits : scans.hits_of_views) CHECK(hits == scans.still.hits);
  CHECK(scans.bytes_per_view == 4 * beams);
  CHECK(std::round(double(scans.bytes_of_results) / 1e6) == 74);

  const CommonApp common;
  VulkanApp& app = common.app;
  VulkanApp::Frame frame(app);
  page_engine engine = {app.loader(),
                        app.adopted().instance,
                        app.adopted().physicalDevice,
                        app.adopted().device,
                        app.adopted().queueFamily,
                        frame.begin(),
                        gno_layout_init(),
                        {},
                        {},
                        nullptr,
                        &frame};
  const gno_field fields[] = {GNO_FIELD_X, GNO_FIELD_Y, GNO_FIELD_Z};
  REQUIRE(gno_layout_of(fields, 3, &engine.layout) == GNO_OK);
  engine.layout.compact = 1;
  VulkanApp::Buffer records(app, beams * engine.layout.stride), header(app, sizeof(gno_record_header));
  engine.records = {records.range().address, records.range().bytes};
  engine.header = {header.range().address, header.range().bytes};
  engine.submit = [](void* user) {
    static_cast<VulkanApp::Frame*>(user)->submit();
    static_cast<VulkanApp::Frame*>(user)->wait();
  };
  record_as_the_page_says(&engine);
  const Found found =
      lookAt(records.bytes().data(), *header.as<RecordHeader>(), engine.layout.stride, {0, 0, 1.8}, {6, 0, 0});
  CHECK(found.incomplete == 0);
  CHECK(found.hits == scans.still.hits);
  CHECK(found.farthest < 0.05);
}

}  // namespace gnosphere::test
