// SPDX-License-Identifier: Apache-2.0
// Meshes whose vertices lie in buffers of an application, against scans of the same meshes with setPositions().
#include <catch2/matchers/catch_matchers.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <limits>

#include "engine/both_scans.hpp"
#include "lists/list_sensors.hpp"

namespace gnosphere::test {
namespace {

using Catch::Matchers::ContainsSubstring;

constexpr uint32_t kBall = 1, kCloth = 2, kFlag = 3;
constexpr float kFar = 500;

/// A room, a ball three times, once mirrored, and a cloth of several groups of clusters and a flag. The last two are
/// out of range, and of the cloth only the side that looks away is seen.
Scene room() {
  Scene scene;
  scene.materials = {material(true), material(false)};
  MeshBuilder walls, cloth, flag;
  walls.box({-20, -20, -3}, {20, 20, 12}, 4);
  cloth.quad({-6, 5 + kFar, -2}, {0, 2, 7}, {12, 0, 0}, 48);
  flag.triangle({4, 1 + kFar, 0}, {4, 2 + kFar, 0}, {4, 1 + kFar, 1});
  scene.meshes = {walls.take(), ball(12, 18, 1.5), cloth.take(1), flag.take()};
  scene.instances = {{"", 0, {}},
                     {"", kBall, translation(6, 1, 0.5)},
                     {"", kBall, translation(-5, -6, 0.3) * scaling(2, -1.5, 1)},
                     {"", kCloth, {}},
                     {"", kFlag, {}},
                     {"", kBall, translation(-5, 3, 0.5) * scaling(0.5, 0.5, 0.5)}};
  return scene;
}

/// Moves every vertex, by another amount in every frame, brings what is far away near, and turns the cloth round.
std::vector<float> waved(const Mesh& mesh, int frame) {
  std::vector<float> positions = mesh.positions;
  for (size_t i = 0; i < positions.size(); ++i)
    positions[i] += 0.7f * std::sin(1.3f * positions[(i + 1) % positions.size()] + static_cast<float>(frame));
  for (size_t i = 0; i < positions.size(); i += 3) {
    positions[i] = -positions[i];
    if (positions[i + 1] > kFar / 2) positions[i + 1] -= kFar;
  }
  return positions;
}

/// Puts every seventh vertex where the next one is, so that some triangles have no area.
void collapse(std::vector<float>& positions) {
  for (size_t i = 0; i + 5 < positions.size(); i += 21) std::copy_n(&positions[i + 3], 3, &positions[i]);
}

/// Vertices as an engine keeps them: the position is a part of each.
class VertexBuffer {
 public:
  VertexBuffer(const VulkanApp& app, size_t vertices, uint32_t stride, uint32_t offset, uint32_t size)
      : stride_(stride),
        offset_(offset),
        size_(size),
        memory_(app, (stride * (vertices - 1) + offset + size + 3) / 4 * 4) {}

  template <typename Number>
  void set(const std::vector<Number>& values) {
    REQUIRE(3 * sizeof(Number) == size_);
    for (size_t i = 0; i < values.size() / 3; ++i)
      std::memcpy(memory_.bytes().data() + i * stride_ + offset_, &values[3 * i], size_);
  }
  vulkan::VertexBuffer described() const {
    vulkan::VertexBuffer result;
    result.address = memory_.range().address + offset_;
    result.bytes = memory_.range().bytes - offset_;
    result.stride = stride_;
    return result;
  }
  VulkanApp::Buffer& memory() { return memory_; }

 private:
  uint32_t stride_, offset_, size_;
  VulkanApp::Buffer memory_;
};

const std::vector<Sensor> kSensors = {gridSensor(180, 17, -20, 20), listSensor("rosette", rosette(2000, 1.2))};

}  // namespace

TEST_CASE("scans of vertices in the caller's buffers have the bytes of setPositions()", "[second-driver]") {
  needVulkan();
  const CommonApp common;
  VulkanApp& app = common.app;
  const Scene scene = room();
  // Beams that lie in the flag's plane meet it when it is a line.
  const std::vector<float> line = {4, -1, 0.125f, 4, -1, 0.125f, 4, 1, 0.125f};
  for (const Accuracy accuracy : {Accuracy::standard, Accuracy::exact}) {
    INFO(nameOf(accuracy));
    TestOptions options = vulkanOptions();
    options.accuracy = accuracy;
    BothScans scans(app, scene, kSensors, options);
    std::vector<std::unique_ptr<VertexBuffer>> buffers;
    for (const uint32_t stride : {12u, 44u})
      buffers.push_back(
          std::make_unique<VertexBuffer>(app, scene.meshes[buffers.size() + 1].vertexCount(), stride, stride - 12, 12));
    VertexBuffer flag(app, 3, 12, 0, 12);
    flag.set(line);
    scans.recorder().setVertices(kFlag, flag.described());
    scans.expected().setPositions(kFlag, line);
    for (int frame = 0; frame < 3; ++frame) {
      INFO("frame " << frame);
      for (const uint32_t mesh : {kBall, kCloth}) {
        if (frame == 2 && mesh == kBall) continue;  // it keeps its vertices
        std::vector<float> positions = waved(scene.meshes[mesh], frame);
        // Some vertices cannot be used: they are no number, infinite, too far away, and at one place.
        if (frame == 1) {
          positions[0] = std::numeric_limits<float>::quiet_NaN();
          positions[62] = -std::numeric_limits<float>::infinity();
          positions[94] = 1.5e9f;
          collapse(positions);
        }
        scans.expected().setPositions(mesh, positions);
        buffers[mesh - 1]->set(positions);
        scans.recorder().setVertices(mesh, buffers[mesh - 1]->described());
      }
      scans.change([&](Simulator& simulator) { simulator.setTransform(1, translation(6, 0.3 * frame, 0.4)); });
      Shot shot;
      shot.frame = static_cast<uint64_t>(frame);
      shot.pose.position = {0.2 * frame, -0.1, 0.125};
      scans.requireSame(shot);
    }
    for (const auto& buffer : buffers) CHECK(buffer->memory().guarded());
  }
}

TEST_CASE("integers of 16 bits are positions by a scale and an offset") {
  needVulkan();
  const CommonApp common;
  VulkanApp& app = common.app;
  const Scene scene = room();
  const Mesh& mesh = scene.meshes[kBall];
  BothScans scans(app, scene, {kSensors[0]}, vulkanOptions());
  struct Case {
    VkFormat format;
    float divisor;
    int32_t low, high;
    uint32_t stride;
  };
  for (const Case& one : {Case{VK_FORMAT_R16G16B16_UNORM, 65535, 0, 65535, 6},
                          Case{VK_FORMAT_R16G16B16A16_SNORM, 32767, -32768, 32767, 8},
                          Case{VK_FORMAT_R16G16B16A16_USCALED, 1, 0, 65535, 10},
                          Case{VK_FORMAT_R16G16B16_SSCALED, 1, -32768, 32767, 14}}) {
    INFO("format " << one.format);
    VertexBuffer buffer(app, mesh.vertexCount(), one.stride, (one.stride - 6) / 4 * 4, 6);
    vulkan::VertexBuffer described = buffer.described();
    described.format = one.format;
    const float size = 3.1f * one.divisor / static_cast<float>(one.high - one.low);
    described.scale = {size, 0.9f * size, 1.1f * size};
    described.offset = {-0.2f, 0.3f, one.low == 0 ? -1.5f : 0};
    std::vector<uint16_t> integers;
    std::vector<float> positions;
    for (size_t i = 0; i < mesh.positions.size(); ++i) {
      // Both ends of the range occur: the ball has a radius of 1.5 m.
      const double share = (double{mesh.positions[i]} + 1.5) / 3;
      const auto value = static_cast<int32_t>(std::lround(one.low + share * (one.high - one.low)));
      integers.push_back(static_cast<uint16_t>(value));
      const int32_t meant = one.format == VK_FORMAT_R16G16B16A16_SNORM ? std::max(value, -32767) : value;
      const auto scale = static_cast<float>(double{described.scale[i % 3]} / one.divisor);
      positions.push_back(static_cast<float>(meant) * scale + described.offset[i % 3]);
    }
    buffer.set(integers);
    scans.recorder().setVertices(kBall, described);
    scans.expected().setPositions(kBall, positions);
    scans.requireSame();
  }
}

TEST_CASE("vertices that a command writes need no barrier of the caller") {
  needVulkan();
  const CommonApp common;
  VulkanApp& app = common.app;
  const Scene scene = room();
  const Mesh& mesh = scene.meshes[kCloth];
  BothScans scans(app, scene, {kSensors[0]}, vulkanOptions());
  VertexBuffer staging(app, mesh.vertexCount(), 16, 0, 12), vertices(app, mesh.vertexCount(), 16, 0, 12);
  for (int frame = 0; frame < 2; ++frame) {
    const std::vector<float> positions = waved(mesh, frame);
    staging.set(positions);
    scans.expected().setPositions(kCloth, positions);
    scans.recorder().setVertices(kCloth, vertices.described());
    scans.requireSame({}, [&](VkCommandBuffer commands) { vertices.memory().copyFrom(commands, staging.memory()); });
  }
}

TEST_CASE("meshes come and go beside vertices in the caller's buffers, and fields ask for surfaces") {
  needVulkan();
  const CommonApp common;
  VulkanApp& app = common.app;
  const Scene scene = room();
  const Mesh& mesh = scene.meshes[kCloth];
  BothScans scans(app, scene, {kSensors[0]}, vulkanOptions());
  VertexBuffer vertices(app, mesh.vertexCount(), 12, 0, 12);
  std::vector<float> positions = waved(mesh, 1);
  collapse(positions);
  vertices.set(positions);
  scans.recorder().setVertices(kCloth, vertices.described());
  scans.expected().setPositions(kCloth, positions);
  scans.requireSame();

  // The scene gets the arrays by which kernels find the triangle under a hit.
  scans.add({kSensors[0], Effects::none()},
            layoutWith({Field::x, Field::normal, Field::barycentrics, Field::material, Field::triangle}));
  scans.requireSame();

  // The arrays of the scene grow, for a mesh that the library deforms.
  Mesh other = ball(40, 60, 1);
  other.morphTargets = {other.positions};
  scans.change([&](Simulator& simulator) {
    const size_t added = simulator.addMesh(other);
    simulator.addInstance(static_cast<uint32_t>(added), translation(-4, 4, 1));
    simulator.setDeformation(added, {{}, {0.3f}});
  });
  scans.requireSame();

  // The host sets the positions; what the buffer has does not matter any more.
  const std::vector<float> set = waved(mesh, 2);
  scans.change([&](Simulator& simulator) { simulator.setPositions(kCloth, set); });
  vertices.set(waved(mesh, 3));
  scans.change([&](Simulator& simulator) { simulator.addMesh(ball(60, 60, 1)); });
  scans.requireSame();

  // Another mesh takes the place of one with vertices in a buffer.
  scans.recorder().setVertices(kCloth, vertices.described());
  scans.change([&](Simulator& simulator) {
    simulator.removeInstance(3);
    simulator.removeMesh(kCloth);
    simulator.addInstance(static_cast<uint32_t>(simulator.addMesh(other)), translation(3, 5, 0));
  });
  scans.requireSame();
}

TEST_CASE("a scan in motion of vertices in the caller's buffers has the bytes of setPositions()") {
  needVulkan();
  const CommonApp common;
  VulkanApp& app = common.app;
  const Scene scene = room();
  Sensor sensor = gridSensor(90, 8, -18, 12);
  sensor.rotationPeriod = 0.1;
  BothScans scans(app, scene, {sensor}, vulkanOptions());
  VertexBuffer vertices(app, scene.meshes[kBall].vertexCount(), 12, 0, 12);
  const std::vector<float> positions = waved(scene.meshes[kBall], 4);
  vertices.set(positions);
  scans.recorder().setVertices(kBall, vertices.described());
  scans.expected().setPositions(kBall, positions);
  Shot shot;
  shot.instanceMotions = {{1, translation(6.5, 1.5, 0.5) * rotationZ(0.4)}, {2, scene.instances[2].transform}};
  scans.requireSame(shot);
}

TEST_CASE("a recorded scan says how many triangles it left out") {
  needVulkan();
  const CommonApp common;
  VulkanApp& app = common.app;
  const Scene scene = room();
  const Mesh& mesh = scene.meshes[kBall];
  BothScans scans(app, scene, {kSensors[0]}, vulkanOptions());
  VertexBuffer vertices(app, mesh.vertexCount(), 12, 0, 12);
  std::vector<float> positions = mesh.positions;
  // The first vertex is the top, in 18 triangles; two neighbours on the second ring share two.
  positions[0] = std::numeric_limits<float>::quiet_NaN();
  std::copy_n(&positions[3 * 19], 3, &positions[3 * 20]);
  vertices.set(positions);
  scans.recorder().setVertices(kBall, vertices.described());
  scans.expected().setPositions(kBall, positions);
  for (int k = 0; k < 2; ++k) {  // the second recording takes nothing
    scans.requireSame();
    const auto results = scans.results();
    REQUIRE(results.size() == 1);
    CHECK(results[0].nonFinite == 18);
    CHECK(results[0].degenerate == 2);
  }
  // The triangles of all meshes are counted, also of one that was taken before. Two corners at infinity do not make a
  // triangle degenerate, too.
  VertexBuffer ofFlag(app, 3, 12, 0, 12);
  std::vector<float> flag = scene.meshes[kFlag].positions;
  std::fill(flag.begin() + 3, flag.end(), std::numeric_limits<float>::infinity());
  ofFlag.set(flag);
  scans.recorder().setVertices(kFlag, ofFlag.described());
  scans.expected().setPositions(kFlag, flag);
  scans.requireSame();
  const auto results = scans.results();
  REQUIRE(results.size() == 1);
  CHECK(results[0].nonFinite == 19);
  CHECK(results[0].degenerate == 2);
}

TEST_CASE("vertices that an abandoned recording would have taken are taken by the next one") {
  needVulkan();
  const CommonApp common;
  VulkanApp& app = common.app;
  const Scene scene = room();
  const Mesh& mesh = scene.meshes[kBall];
  BothScans scans(app, scene, {kSensors[0]}, vulkanOptions());
  VertexBuffer vertices(app, mesh.vertexCount(), 12, 0, 12);
  const std::vector<float> positions = waved(mesh, 1);
  vertices.set(positions);
  scans.recorder().setVertices(kBall, vertices.described());
  scans.expected().setPositions(kBall, positions);
  VulkanApp::Frame dropped(app);
  scans.recorder().record(dropped.begin(), 0, {});
  dropped.end();
  scans.recorder().abandon(0);
  scans.requireSame();
}

TEST_CASE("bad vertex buffers get a sentence") {
  needVulkan();
  const CommonApp common;
  VulkanApp& app = common.app;
  Scene scene = room();
  Mesh skin = scene.meshes[kBall];
  skin.morphTargets = {skin.positions};
  scene.meshes.push_back(skin);
  BothScans scans(app, scene, {kSensors[0]}, vulkanOptions());
  const VertexBuffer vertices(app, scene.meshes[kBall].vertexCount(), 12, 0, 12);
  const auto attempt = [&](auto change, size_t mesh = kBall) {
    vulkan::VertexBuffer buffer = vertices.described();
    change(buffer);
    scans.recorder().setVertices(mesh, buffer);
  };
  const auto same = [](vulkan::VertexBuffer&) {};
  CHECK_THROWS_WITH(attempt(same, 9), ContainsSubstring("mesh 9 does not exist, there are 5"));
  CHECK_THROWS_WITH(attempt(same, 4), ContainsSubstring("mesh 4 follows joints or morph targets"));
  CHECK_THROWS_WITH(attempt(same, kCloth), ContainsSubstring("they need") && ContainsSubstring("and the buffer has"));
  CHECK_THROWS_WITH(attempt([](auto& buffer) { buffer.address = 0; }), ContainsSubstring("a multiple of 4 and not 0"));
  CHECK_THROWS_WITH(attempt([](auto& buffer) { buffer.address += 2; }), ContainsSubstring("a multiple of 4 and not 0"));
  CHECK_THROWS_WITH(attempt([](auto& buffer) { buffer.stride = 8; }),
                    ContainsSubstring("positions of this format need 12"));
  CHECK_THROWS_WITH(attempt([](auto& buffer) { buffer.stride = 14; }), ContainsSubstring("in multiples of 4"));
  CHECK_THROWS_WITH(attempt([](auto& buffer) { buffer.bytes -= 1; }),
                    ContainsSubstring("200 vertices, 12 bytes apart"));
  CHECK_THROWS_WITH(attempt([](auto& buffer) { buffer.stride = 1 << 25, buffer.bytes = uint64_t{1} << 40; }),
                    ContainsSubstring("take more than 4 GiB"));
  CHECK_THROWS_WITH(attempt([](auto& buffer) { buffer.scale[1] = 2; }),
                    ContainsSubstring("only integers have a scale"));
  CHECK_THROWS_WITH(attempt([](auto& buffer) { buffer.format = VK_FORMAT_R8G8B8_UNORM; }),
                    ContainsSubstring("cannot have the VkFormat 23"));
  CHECK_THROWS_WITH(attempt([](auto& buffer) {
                      buffer.format = VK_FORMAT_R16G16B16_SNORM;
                      buffer.offset[2] = std::numeric_limits<float>::infinity();
                    }),
                    ContainsSubstring("not finite"));
  CHECK_NOTHROW(attempt(same));
  // The three vertices of the flag, of 6 bytes each, end within a word.
  const auto halves = [](auto& buffer) {
    buffer.format = VK_FORMAT_R16G16B16_SSCALED;
    buffer.stride = 6;
    buffer.bytes = 18;
  };
  CHECK_THROWS_WITH(attempt(halves, kFlag), ContainsSubstring("in words of 4 bytes they need 20 bytes"));
  CHECK_NOTHROW(attempt([&](auto& buffer) { halves(buffer), buffer.bytes = 20; }, kFlag));
}

}  // namespace gnosphere::test
