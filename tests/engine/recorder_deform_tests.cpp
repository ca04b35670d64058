// SPDX-License-Identifier: Apache-2.0
// Recorded scans of meshes that are deformed anew in every frame, against scans on a device of our own.
#include <algorithm>
#include <catch2/generators/catch_generators.hpp>
#include <vector>

#include "deformable.hpp"
#include "engine/recorded.hpp"

namespace gnosphere::test {

TEST_CASE("recorded scans have the bytes of scan(), with meshes deformed in every frame", "[second-driver]") {
  needVulkan();
  const bool during = GENERATE(false, true);  // between the scans, or also while they are made
  const CommonApp common;
  VulkanApp& app = common.app;
  Random random(21);
  const Scene scene = limbs(random, 4);
  SensorRequest request = {gridSensor(180, 12, -30, 30, 60), Effects::none()};
  request.sensor.rotationPeriod = 0.1;
  if (during) request.effects.objectMotion.use = EffectUse::on;
  const std::vector<Field> fields = {Field::x, Field::y, Field::z, Field::range, Field::triangle, Field::normal};
  const RecordLayout layout = layoutOf(fields);
  SensorRequest onHost = request;
  onHost.fields = fields;
  TestOptions own = vulkanOptions();
  own.device = {DeviceChoice::Kind::vulkan, app.deviceName()};
  Simulator expected(scene, onHost, own);
  Recorded recorded(app, scene, request, vulkanOptions(), layout);

  std::vector<std::vector<std::byte>> rows(2);
  for (uint64_t frame = 0; frame < 6; ++frame) {
    INFO((during ? "during the scan, " : "between scans, ") << "frame " << frame);
    Shot shot;
    shot.frame = frame;
    for (size_t mesh = 1; mesh < scene.meshes.size(); ++mesh) {
      const Deformation deformation = bend(random, scene.meshes[mesh]);
      recorded.simulator().setDeformation(mesh, deformation);
      expected.setDeformation(mesh, deformation);
      if (during) shot.meshMotions.push_back({mesh, bend(random, scene.meshes[mesh])});
    }
    // The next frame is recorded and submitted while this one may be running.
    recorded.submit(shot);
    Scan scan;
    expected.scanInto(shot, scan);
    CHECK(scan.counters.hits > 300);
    rows[frame % 2] = rowsOf(scan, layout);
    CHECK(rows[0] != rows[1]);
    if (frame % 2 == 0) continue;
    for (size_t at = 0; at < 2; ++at) {
      recorded.frame(at).wait();
      CHECK(recorded.headerOf(at).incomplete == 0);
      const std::byte* found = recorded.bytes(at);
      CHECK(std::equal(rows[at].begin(), rows[at].end(), found));
    }
  }
}

}  // namespace gnosphere::test
