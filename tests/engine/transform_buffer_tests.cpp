// SPDX-License-Identifier: Apache-2.0
// Instances whose transforms lie in a buffer of an application, against scans of the same instances with
// setTransform().
#include <catch2/matchers/catch_matchers.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <limits>

#include "deformable.hpp"
#include "engine/both_scans.hpp"
#include "lists/list_sensors.hpp"

namespace gnosphere::test {
namespace {

using Catch::Matchers::ContainsSubstring;

constexpr uint32_t kWalls = 0, kMovedBall = 1;
constexpr size_t kFirst = 1, kBalls = 6;  // the instances of the balls
const Transform kOutOfRange = translation(0, 0, 900);

/// A room around a place, whose instance stays where the host has put it, and balls that the host has put out of range.
Scene roomOfBalls(const Vec3& place = {}, const Vec3& meshOrigin = {1.1, -0.7, 0.3}) {
  Scene scene;
  scene.materials = {material(true), material(false)};
  MeshBuilder walls;
  walls.box({-20, -20, -3}, {20, 20, 12}, 4);
  scene.meshes = {walls.take(), ball(12, 18, 1.5)};
  scene.meshes[kMovedBall].origin = meshOrigin;
  scene.instances = {{"", kWalls, translation(place.x, place.y, place.z)}};
  for (size_t i = 0; i < kBalls; ++i)
    scene.instances.push_back({"", kMovedBall, kOutOfRange, static_cast<uint16_t>(i)});
  return scene;
}

/// Turned, stretched, mirrored, sheared, flat and tiny balls around the place to which transforms are relative; other
/// ones in every frame. The numbers are those that single precision has.
std::vector<Transform> placed(int frame) {
  Transform sheared = translation(0.3, -4.1, 0.2);
  sheared.rows[1] = 0.4;
  sheared.rows[6] = -0.3;
  std::vector<Transform> transforms = {translation(5.3, 0.7 + 0.3 * frame, 0.4) * rotationZ(0.7 + frame),
                                       translation(-4.7, 1.9, 0.6) * rotationZ(-0.4 * frame) * scaling(2, 1.3, 0.8),
                                       translation(-2.2, -5.3 + 0.2 * frame, -0.3) * scaling(1.1, -0.9, 1),
                                       sheared,
                                       translation(3.1, 3.3, 0.1) * rotationZ(0.3 + 0.1 * frame) * scaling(1, 0, 1.4),
                                       translation(0.21, 0.17, 0.04 * frame) * scaling(0.03, 0.03, 0.05)};
  for (Transform& transform : transforms)
    for (double& value : transform.rows) value = static_cast<float>(value);
  return transforms;
}

/// The same relative to the origin of the world.
Transform moved(Transform transform, const Vec3& origin) {
  transform.rows[3] += origin.x;
  transform.rows[7] += origin.y;
  transform.rows[11] += origin.z;
  return transform;
}

/// Transforms as an engine keeps them, from instance kFirst on.
class Transforms {
 public:
  Transforms(const VulkanApp& app, vulkan::TransformFormat format = vulkan::TransformFormat::rows3x4,
             uint32_t stride = 48, Vec3 origin = {})
      : format_(format), stride_(stride), origin_(origin), memory_(app, stride * (kBalls - 1) + bytesOf(format)) {}

  void set(const std::vector<Transform>& transforms) {
    const bool columns = format_ == vulkan::TransformFormat::columns4x4;
    for (size_t i = 0; i < transforms.size(); ++i)
      for (size_t row = 0; row < 3; ++row)
        for (size_t column = 0; column < 4; ++column)
          put(i, columns ? 4 * column + row : 4 * row + column,
              static_cast<float>(transforms[i].rows[4 * row + column]));
  }
  /// Writes the number at `place` among the numbers of a transform into the buffer.
  void put(size_t transform, size_t place, float value) {
    std::memcpy(memory_.bytes().data() + transform * stride_ + 4 * place, &value, sizeof value);
  }
  vulkan::TransformBuffer described() const {
    const vulkan::DeviceRange range = memory_.range();
    return {range.address, range.bytes, stride_, format_, origin_, kFirst, kBalls};
  }
  VulkanApp::Buffer& memory() { return memory_; }

 private:
  static size_t bytesOf(vulkan::TransformFormat format) {
    return format == vulkan::TransformFormat::columns4x4 ? 64 : 48;
  }
  vulkan::TransformFormat format_;
  uint32_t stride_;
  Vec3 origin_;
  VulkanApp::Buffer memory_;
};

void setOnHost(Simulator& simulator, const std::vector<Transform>& transforms, const Vec3& origin = {}) {
  for (size_t i = 0; i < transforms.size(); ++i) simulator.setTransform(kFirst + i, moved(transforms[i], origin));
}

const std::vector<Sensor> kPlacingSensors = {gridSensor(180, 17, -20, 20), listSensor("rosette", rosette(2000, 1.2))};

}  // namespace

TEST_CASE("scans of transforms in the caller's buffers have the bytes of setTransform()", "[second-driver]") {
  needVulkan();
  const CommonApp common;
  VulkanApp& app = common.app;
  struct Case {
    Accuracy accuracy;
    vulkan::TransformFormat format;
    uint32_t stride;
    Vec3 origin;  // to which the transforms are relative
    Vec3 place, meshOrigin;
  };
  // A place on the earth, from its middle. The host adds these numbers without rounding, as the device does.
  const Vec3 far = {-4'612'345.5, 512'345.25, 4'354'321.75}, few = {1.125, -0.75, 0.25}, many = {1.1, -0.7, 0.3};
  for (const Case& one : {Case{Accuracy::standard, vulkan::TransformFormat::rows3x4, 48, {}, {}, many},
                          Case{Accuracy::exact, vulkan::TransformFormat::columns4x4, 64, {0.3, 0.1, -0.2}, {}, many},
                          Case{Accuracy::standard, vulkan::TransformFormat::rows3x4, 64, far, far, few}}) {
    INFO(nameOf(one.accuracy) << ", " << one.stride << " bytes apart, at " << one.place.x);
    TestOptions options = vulkanOptions();
    options.accuracy = one.accuracy;
    BothScans scans(app, roomOfBalls(one.place, one.meshOrigin), kPlacingSensors, options);
    Transforms buffer(app, one.format, one.stride, one.origin);
    scans.recorder().setTransforms(buffer.described());
    for (int frame = 0; frame < 3; ++frame) {
      INFO("frame " << frame);
      buffer.set(placed(frame));  // the recorder is not told
      setOnHost(scans.expected(), placed(frame), one.origin);
      Shot shot;
      shot.frame = static_cast<uint64_t>(frame);
      shot.pose.position = {one.place.x + 0.2 * frame, one.place.y - 0.1, one.place.z + 0.125};
      shot.pose.orientation = {0, 0.1, std::sin(0.3 * frame), std::cos(0.3 * frame)};
      scans.requireSame(shot);
    }
    CHECK(buffer.memory().guarded());
  }
}

TEST_CASE("mirrored instances of a tiny scale show their fronts also from the caller's buffers") {
  needVulkan();
  const CommonApp common;
  Scene scene = roomOfBalls();
  scene.meshes[kMovedBall] = ball(12, 18, 1e8);
  TestOptions options = vulkanOptions();
  options.faces = ReflectingFaces::front;
  BothScans scans(common.app, scene, kPlacingSensors, options);
  Transforms buffer(common.app);
  scans.recorder().setTransforms(buffer.described());
  const double scale = 0x1p-34;  // the balls have a radius of 6 mm
  std::vector<Transform> transforms;
  for (size_t i = 0; i < kBalls; ++i) {
    const double angle = static_cast<double>(i);
    transforms.push_back(
        translation(static_cast<float>(0.02 * std::cos(angle)), static_cast<float>(0.02 * std::sin(angle)), 0) *
        scaling(scale, i % 2 ? scale : -scale, scale));
  }
  buffer.set(transforms);
  setOnHost(scans.expected(), transforms);
  scans.requireSame(Shot());
}

TEST_CASE("a command that writes transforms needs no barrier of the caller, and the sensor may move") {
  needVulkan();
  const CommonApp common;
  VulkanApp& app = common.app;
  Sensor sensor = gridSensor(90, 8, -18, 12);
  sensor.rotationPeriod = 0.1;
  BothScans scans(app, roomOfBalls(), {sensor}, vulkanOptions());
  Transforms staging(app), buffer(app);
  scans.recorder().setTransforms(buffer.described());
  for (int frame = 0; frame < 2; ++frame) {
    staging.set(placed(frame));
    setOnHost(scans.expected(), placed(frame));
    Shot shot;
    shot.motion.stamps = {{0, {{0, 0, 0.1}, {}}}, {0.1, {{0.8, 0.1, 0.1}, {0, 0, 0.05, 1}}}};
    scans.requireSame(shot, [&](VkCommandBuffer commands) { buffer.memory().copyFrom(commands, staging.memory()); });
  }
}

TEST_CASE("the host takes instances back, and they come and go beside transforms in buffers") {
  needVulkan();
  const CommonApp common;
  VulkanApp& app = common.app;
  Scene scene = roomOfBalls();
  Random random(5);
  scene.meshes.push_back(limb(random, 7, 4, 1, {}));
  BothScans scans(app, scene, {kPlacingSensors[0]}, vulkanOptions());
  Transforms buffer(app), other(app);
  buffer.set(placed(0));
  setOnHost(scans.expected(), placed(0));
  scans.recorder().setTransforms(buffer.described());
  scans.requireSame();

  // The host sets a transform as it was before, and one instance goes.
  scans.change([&](Simulator& simulator) {
    simulator.setTransform(kFirst, kOutOfRange);
    simulator.removeInstance(kFirst + 1);
  });
  scans.requireSame();

  // A deformable mesh takes its place, first where the host says. Then all are in another buffer.
  const Deformation bent = bend(random, scene.meshes[2]);
  scans.change([&](Simulator& simulator) {
    simulator.addInstance(2, translation(-4, 2, 0.5));
    simulator.setDeformation(2, bent);
  });
  scans.requireSame();
  other.set(placed(1));
  setOnHost(scans.expected(), placed(1));
  scans.recorder().setTransforms(other.described());
  scans.requireSame();

  // The arrays of the instances grow; velocities and surfaces are asked for.
  scans.change([&](Simulator& simulator) {
    for (int i = 0; i < 20; ++i) simulator.addInstance(kMovedBall, translation(-8, i, 1) * scaling(0.3, 0.3, 0.3));
  });
  scans.add({kPlacingSensors[0], Effects::none()},
            layoutWith({Field::x, Field::normal, Field::velocity, Field::classId, Field::triangle, Field::instance}));
  scans.requireSame();
}

TEST_CASE("instances whose transforms are not finite are left out and counted") {
  needVulkan();
  const CommonApp common;
  VulkanApp& app = common.app;
  BothScans scans(app, roomOfBalls(), {kPlacingSensors[0]}, vulkanOptions());
  Transforms buffer(app, vulkan::TransformFormat::columns4x4, 64);
  buffer.set(placed(0));
  setOnHost(scans.expected(), placed(0));
  // The fourth row is not looked at.
  buffer.put(2, 3, std::numeric_limits<float>::quiet_NaN());
  scans.recorder().setTransforms(buffer.described());
  scans.requireSame();
  CHECK(scans.results().at(0).unplaced == 0);
  buffer.put(0, 5, std::numeric_limits<float>::quiet_NaN());
  buffer.put(1, 12, -std::numeric_limits<float>::infinity());
  buffer.put(4, 14, 1.5e9f);
  for (const size_t left : {0, 1, 4}) scans.expected().setTransform(kFirst + left, kOutOfRange);
  scans.requireSame();
  CHECK(scans.results().at(0).unplaced == 3);
}

TEST_CASE("bad transform buffers get a sentence, and so does motion of their instances") {
  needVulkan();
  const CommonApp common;
  VulkanApp& app = common.app;
  Scene scene = roomOfBalls();
  scene.meshes[kMovedBall].morphTargets = {scene.meshes[kMovedBall].positions};
  BothScans scans(app, scene, {kPlacingSensors[0]}, vulkanOptions());
  const Transforms transforms(app);
  const auto attempt = [&](auto change) {
    vulkan::TransformBuffer buffer = transforms.described();
    change(buffer);
    scans.recorder().setTransforms(buffer);
  };
  CHECK_THROWS_WITH(attempt([](auto& buffer) { buffer.address = 0; }), ContainsSubstring("a multiple of 4 and not 0"));
  CHECK_THROWS_WITH(attempt([](auto& buffer) { buffer.address += 2; }), ContainsSubstring("a multiple of 4 and not 0"));
  CHECK_THROWS_WITH(attempt([](auto& buffer) { buffer.stride = 44; }), ContainsSubstring("they take 48 or more"));
  CHECK_THROWS_WITH(attempt([](auto& buffer) { buffer.stride = 50; }), ContainsSubstring("in multiples of 4"));
  CHECK_THROWS_WITH(attempt([](auto& buffer) { buffer.bytes -= 1; }), ContainsSubstring("48 bytes apart, need 288"));
  CHECK_THROWS_WITH(attempt([](auto& buffer) { buffer.format = vulkan::TransformFormat::columns4x4; }),
                    ContainsSubstring("they take 64"));
  CHECK_THROWS_WITH(attempt([](auto& buffer) { buffer.stride = 1 << 30, buffer.bytes = uint64_t{1} << 40; }),
                    ContainsSubstring("takes more than 4 GiB"));
  CHECK_THROWS_WITH(attempt([](auto& buffer) { buffer.instances = 0; }), ContainsSubstring("say how many"));
  CHECK_THROWS_WITH(attempt([](auto& buffer) { buffer.firstInstance = 2; }),
                    ContainsSubstring("instance 7 does not exist, there are 7"));
  CHECK_THROWS_WITH(attempt([](auto& buffer) { buffer.origin.y = std::numeric_limits<double>::infinity(); }),
                    ContainsSubstring("not finite"));
  CHECK_NOTHROW(attempt([](auto&) {}));

  VulkanApp::Frame frame(app);
  const VkCommandBuffer commands = frame.begin();
  const auto record = [&](const vulkan::RecordedShot& shot) { scans.recorder().record(commands, 0, {&shot, 1}); };
  vulkan::RecordedShot moving;
  moving.shot.instanceMotions = {{kFirst + 2, {}}};
  CHECK_THROWS_WITH(record(moving), ContainsSubstring("the transform of instance 3 comes from a buffer"));
  moving.shot.instanceMotions = {};
  moving.shot.meshMotions = {{kMovedBall, {{}, {0.5f}}}};
  CHECK_THROWS_WITH(record(moving), ContainsSubstring("the transform of instance 1 comes from a buffer"));
  // An instance that the host has taken back may move, and only the buffers of the results are missing.
  scans.recorded().setTransform(kFirst + 2, {});
  moving.shot.meshMotions = {};
  moving.shot.instanceMotions = {{kFirst + 2, {}}};
  CHECK_THROWS_WITH(record(moving), ContainsSubstring("the buffer for the records needs an address"));
  frame.submit();
}

}  // namespace gnosphere::test
