// SPDX-License-Identifier: Apache-2.0
// Poses that the bench finds in scenes of which it knows nothing, and the scenes of what is seen from a pose.
#include <algorithm>

#include "poses.hpp"
#include "seen.hpp"
#include "support.hpp"

using namespace gnosphere;
using namespace gnosphere::bench;

namespace {

std::vector<Pose> posesIn(const Scene& scene, size_t count, uint64_t seed = 1) {
  return detailedPoses(scene, count, seed, DeviceChoice::Kind::reference);
}

bool same(const std::vector<Pose>& a, const std::vector<Pose>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(Pose)) == 0;
}

/// A plain of 100 x 100 m of few triangles, with 40 posts of many in the corner from (30, 30) to (50, 50).
Scene corner() {
  test::MeshBuilder plain, post;
  plain.quad({-50, -50, 0}, {100, 0, 0}, {0, 100, 0}, 20);
  post.box({-0.2, -0.2, 0}, {0.2, 0.2, 4}, 10);
  Scene scene = test::sceneOf(plain.take());
  scene.meshes.push_back(post.take());
  for (int i = 0; i < 40; ++i)
    scene.instances.push_back({"", 1, test::translation(31 + 4.5 * (i % 5), 31 + 2.5 * (i / 5), 0)});
  return scene;
}

}  // namespace

TEST_CASE("poses stand in the scene's box, above a surface and where the detail is; the seed decides which") {
  const Scene scene = corner();
  const std::vector<Pose> poses = posesIn(scene, 4);
  REQUIRE(poses.size() == 4);
  for (const Pose& pose : poses) {
    CAPTURE(pose.position.x, pose.position.y);
    CHECK(std::min(pose.position.x, pose.position.y) > 20);
    CHECK(std::max(pose.position.x, pose.position.y) < 50);
    CHECK(((pose.position.z > 1.79 && pose.position.z < 1.81) || (pose.position.z > 5.79 && pose.position.z < 5.81)));
  }
  CHECK(same(poses, posesIn(scene, 4)));
  CHECK_FALSE(same(poses, posesIn(scene, 4, 2)));
  for (size_t i = 0; i < 4; ++i)
    for (size_t j = 0; j < i; ++j)
      CHECK(std::hypot(poses[i].position.x - poses[j].position.x, poses[i].position.y - poses[j].position.y) > 0.5);
}

TEST_CASE("poses keep a distance from what is around them") {
  // A wood of posts 1 m apart, in which a place at random is near one more often than not.
  test::MeshBuilder ground, post;
  ground.quad({-10, -10, 0}, {20, 0, 0}, {0, 20, 0}, 4);
  post.box({-0.05, -0.05, 0}, {0.05, 0.05, 4}, 4);
  Scene scene = test::sceneOf(ground.take());
  scene.meshes.push_back(post.take());
  for (int i = 0; i < 400; ++i) scene.instances.push_back({"", 1, test::translation(i % 20 - 9.5, i / 20 - 9.5, 0)});
  const std::vector<Pose> poses = posesIn(scene, 3);
  REQUIRE(poses.size() == 3);
  for (const Pose& pose : poses) {
    if (pose.position.z > 2) continue;  // on top of a post
    const double x = std::remainder(pose.position.x - 0.5, 1), y = std::remainder(pose.position.y - 0.5, 1);
    CAPTURE(x, y);
    CHECK(std::hypot(std::max(0.0, std::abs(x) - 0.05), std::max(0.0, std::abs(y) - 0.05)) > 0.44);
  }
}

TEST_CASE("poses are those of the reference on every device") {
  test::needVulkan();
  const Scene scene = corner();
  CHECK(same(posesIn(scene, 3), detailedPoses(scene, 3, 1, {})));
}

TEST_CASE("poses keep their distances in proportion in small scenes") {
  // A model of a street: 4 m long, two rows of blocks with many triangles.
  test::MeshBuilder model;
  model.quad({-2, -1, 0}, {4, 0, 0}, {0, 2, 0}, 8);
  for (double y : {-0.9, 0.3})
    for (int i = 0; i < 4; ++i) model.box({i - 1.9, y, 0}, {i - 1.1, y + 0.6, 3}, 12);
  for (bool mirrored : {false, true}) {
    Scene scene = test::sceneOf(model.take());
    if (mirrored) scene.instances[0].transform = test::scaling(-1, 1, 1);
    const std::vector<Pose> poses = posesIn(scene, 3);
    REQUIRE(poses.size() == 3);
    for (const Pose& pose : poses) {
      CAPTURE(pose.position.x, pose.position.y, pose.position.z);
      CHECK(std::abs(pose.position.z - 0.4) < 0.001);
      const bool inRow = std::abs(std::abs(pose.position.y) - 0.6) < 0.3 + 0.05;
      const bool inBlock = std::abs(std::remainder(pose.position.x - 0.5, 1)) < 0.4 + 0.05;
      CHECK_FALSE((inRow && inBlock));
    }
    if (!mirrored) model.mesh() = scene.meshes[0];
  }
}

TEST_CASE("poses are outside of solids, although more triangles are seen from within") {
  test::MeshBuilder hall;
  hall.quad({-20, -20, 0}, {40, 0, 0}, {0, 40, 0}, 20);
  hall.box({-5, -5, 0}, {5, 5, 6}, 40);
  const std::vector<Pose> poses = posesIn(test::sceneOf(hall.take()), 3);
  REQUIRE(poses.size() == 3);
  for (const Pose& pose : poses)
    CHECK((std::max(std::abs(pose.position.x), std::abs(pose.position.y)) > 5 || pose.position.z > 6));
}

TEST_CASE("a scene without a place for a sensor has no poses") {
  CHECK(posesIn(Scene(), 2).empty());
  test::MeshBuilder wall;
  wall.quad({0, 0, 0}, {10, 0, 0}, {0, 0, 5}, 4);
  CHECK(posesIn(test::sceneOf(wall.take()), 2).empty());
}

TEST_CASE("the scene of what is seen holds the triangles that own a hit, and is seen as the whole one") {
  Scene scene = corner();
  scene.materials.push_back(test::material(true));
  MeshPart half = scene.meshes[1].parts[0];
  half.triangleCount /= 2;
  scene.meshes[1].parts = {half, {half.triangleCount, half.triangleCount, 1}};
  scene.meshes[1].origin = {0.125, 0, 0};
  const Sensor sensor = test::gridSensor(360, 16, -30, 20);
  const Pose pose = {{28, 28, 1.5}, {}};
  const Scan whole = test::referenceOf(scene, sensor, pose);
  const Scene seen = seenIn(scene, whole);
  CHECK(seen.placedTriangleCount() < scene.placedTriangleCount() / 10);
  CHECK(seen.instances.size() < scene.instances.size());
  const Scan scan = test::referenceOf(seen, sensor, pose);
  CHECK(std::memcmp(scan.ranges.data(), whole.ranges.data(), whole.ranges.size() * sizeof(float)) == 0);
  const auto materialOf = [&](const Scene& in, const Scan& of, size_t beam) {
    for (const MeshPart& part : in.meshes[in.instances[of.instances[beam]].mesh].parts)
      if (of.triangles[beam] - part.firstTriangle < part.triangleCount) return part.material;
    return kNoMesh;
  };
  std::vector<std::pair<uint32_t, uint32_t>> owners;
  for (size_t beam = 0; beam < scan.beamCount(); ++beam) {
    if (!scan.hit(beam)) continue;
    owners.emplace_back(scan.instances[beam], scan.triangles[beam]);
    CHECK(materialOf(seen, scan, beam) == materialOf(scene, whole, beam));
  }
  std::sort(owners.begin(), owners.end());
  owners.erase(std::unique(owners.begin(), owners.end()), owners.end());
  CHECK(owners.size() == seen.placedTriangleCount());
}

TEST_CASE("the contender in scenes of what is seen scans from its poses alone, while nothing moves") {
  const Scene scene = corner();
  SimulatorOptions options;
  options.device = DeviceChoice::Kind::reference;
  const SensorRequest request = {test::gridSensor(90, 8, -30, 20), Effects::none()};
  const std::vector<Pose> poses = {{{28, 28, 1.5}, {}}, {{45, 25, 1}, {}}};
  const auto seen = makeSeen(scene, request, options, poses);
  for (const Pose& pose : {poses[1], poses[0]}) {
    seen->run({{pose}, {}});
    const Scan whole = test::referenceOf(scene, request.sensor, pose);
    CHECK(std::memcmp(seen->answer().ranges.data(), whole.ranges.data(), whole.ranges.size() * sizeof(float)) == 0);
  }
  CHECK_THROWS_AS(seen->run({{Pose()}, {}}), Error);
  const std::vector<Moved> moved = {{0, {}}};
  CHECK_THROWS_AS(seen->run({{poses[0]}, moved}), Error);
}
