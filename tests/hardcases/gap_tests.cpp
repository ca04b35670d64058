// SPDX-License-Identifier: Apache-2.0
// Aims a hundred million beams at shared corners and edges of closed meshes around the sensor: `standard` must lose
// none. The test takes minutes on a CPU and has the label slow.
#include <algorithm>
#include <cstdio>

#include "hardcases/hardcases.hpp"

using namespace gnosphere;
using namespace gnosphere::test;

namespace {

constexpr uint32_t kSegments = 720, kRings = 40;

double ringElevation(uint32_t ring) {
  return -84 + 168.0 * ring / (kRings - 1) + 0.3 * std::sin(7.0 * ring);
}

/// Channels point through the rings, the middles of the rings' edges (which bulge), and between rings. Even columns run
/// along the meridians of the mesh, odd ones between them.
Sensor aimedSensor() {
  constexpr double kRadian = 180 / std::numbers::pi;
  Sensor sensor{"aimed", 2 * kSegments, {}, 0, 1000};
  for (uint32_t ring = 0; ring < kRings; ++ring) {
    const double elevation = ringElevation(ring);
    sensor.channels.push_back({elevation, 0});
    sensor.channels.push_back(
        {kRadian * std::atan(std::tan(elevation / kRadian) / std::cos(std::numbers::pi / kSegments)), 0});
    sensor.channels.push_back({elevation + 1.1 + 0.7 * std::sin(3.0 * ring), 0});
  }
  return sensor;
}
// Beams per scan that are aimed at corners and middles of edges on every ring, and along edges in even columns.
constexpr uint64_t kAimedBeams = uint64_t{kSegments} * (3 * kRings + kRings);

template <typename RangeOf>
Mesh aimedBall(const RangeOf& rangeOf) {
  return closedShell(kRings + 1, kSegments, [&](uint32_t ring, uint32_t s) {
    const double azimuth = std::numbers::pi * (-1 + 2.0 * s / kSegments);
    const double elevation = ring == 0 ? -90 : ring > kRings ? 90 : ringElevation(ring - 1);
    const Vec3 d = directionAt(azimuth, elevation * std::numbers::pi / 180);
    return along(d, rangeOf(d));
  });
}

}  // namespace

TEST_CASE("a hundred million beams at shared corners and edges of closed meshes are all hits") {
  needVulkan();
  Random random(41);
  const Mesh meshes[] = {
      aimedBall([](const Vec3&) { return 20.0; }),
      aimedBall([&](const Vec3&) { return 20 * (1.5 + random()); }),  // a star-shaped mesh
      aimedBall([](const Vec3& d) {
        return 7 / std::max({std::abs(d.x), std::abs(d.y), std::abs(d.z)});
      }),  // a box
      aimedBall([](const Vec3&) { return 0.03; }),
      aimedBall([](const Vec3&) { return 900.0; }),
  };
  uint64_t aimed = 0, beams = 0, gaps = 0, draftGaps = 0;
  for (const Mesh& mesh : meshes) {
    TestOptions options = vulkanOptions();
    options.validation = false;  // for speed; smaller tests run these paths with the layer
    Simulator simulator = makeSimulator(sceneOf(Mesh(mesh)), aimedSensor(), options);
    options.accuracy = Accuracy::draft;
    draftGaps += scanOf(sceneOf(Mesh(mesh)), aimedSensor(), {}, options).counters.misses;
    for (uint32_t turn = 0; turn < 180; ++turn) {
      // Rotated by whole segments and a few roundings, so that every corner lies beside its beam in a different way.
      const double yaw = std::numbers::pi / kSegments * (random.bits() % kSegments);
      const Pose pose = {{}, {3e-8 * random(), 3e-8 * random(), std::sin(yaw) + 3e-8 * random(), std::cos(yaw)}};
      const Scan scan = simulator.scan(pose);
      gaps += scan.counters.misses;
      beams += scan.beamCount();
      aimed += kAimedBeams;
    }
  }
  std::printf("%llu beams, %llu of them aimed: %llu gaps; draft, one scan per mesh: %llu\n",
              static_cast<unsigned long long>(beams), static_cast<unsigned long long>(aimed),
              static_cast<unsigned long long>(gaps), static_cast<unsigned long long>(draftGaps));
  CHECK(aimed >= 100'000'000);
  CHECK(gaps == 0);
  CHECK(draftGaps > 0);  // checks that the beams are aimed well: without watertight edges some pass
}
