// SPDX-License-Identifier: Apache-2.0
// Large worlds: results do not depend on the position in the world.
#include <fstream>
#include <sstream>

#include "hardcases/hardcases.hpp"
#include "town/town.hpp"

using namespace gnosphere;
using namespace gnosphere::test;

namespace {

Scene moved(Scene scene, const Vec3& by) {
  for (Instance& instance : scene.instances) instance.transform = translation(by.x, by.y, by.z) * instance.transform;
  return scene;
}

Pose moved(Pose pose, const Vec3& by) {
  pose.position = {pose.position.x + by.x, pose.position.y + by.y, pose.position.z + by.z};
  return pose;
}

Simulator simulatorOf(const Scene& scene, const Sensor& sensor, Accuracy accuracy) {
  TestOptions options = vulkanOptions();
  options.accuracy = accuracy;
  return makeSimulator(scene, sensor, options);
}

/// Requires the same hits with ranges within 1e-4 m, except on ties.
void requireNear(const Scan& reference, const Scan& here, const Scan& there) {
  const auto ties = reference.column<uint8_t>(Field::tie);
  size_t differences = 0;
  for (size_t b = 0; b < here.beamCount(); ++b) {
    if (ties[b]) continue;
    differences += here.triangles[b] != there.triangles[b] ||
                   (here.hit(b) && !(std::abs(here.ranges[b] - there.ranges[b]) <= 1e-4f));
  }
  REQUIRE(differences == 0);
}

std::string dataFile(const char* name) {
  const char* folder = std::getenv("GNOSPHERE_SCENES");
  if (!folder) SKIP("GNOSPHERE_SCENES names no folder of scenes");
  const std::string file = std::string(folder) + "/" + name;
  if (!std::ifstream(file)) SKIP(file << " is not there");
  return file;
}

std::vector<Pose> readTum(const std::string& file) {
  std::ifstream in(file);
  std::vector<Pose> poses;
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    double time = 0;
    Pose p;
    if (words >> time >> p.position.x >> p.position.y >> p.position.z >> p.orientation.x >> p.orientation.y >>
        p.orientation.z >> p.orientation.w)
      poses.push_back(p);
  }
  return poses;
}

}  // namespace

TEST_CASE("large worlds: a scene moved by 5,000 km gives the same bytes, or ranges within 0.1 mm") {
  needVulkan();
  const Sensor sensor = allAround(180, 31);
  Scene scene = sceneOf(soup(51, 1500, 25, 5));
  scene.instances.push_back({"", 0, translation(3, -2, 0.5) * rotationZ(0.7) * scaling(1, -1.5, 0.5)});
  const Pose pose = {{1.5, 0.25, 2}, {0.1, -0.2, 0.3, 0.9}};
  const Scan truth = referenceOf(scene, sensor, pose);
  for (const Accuracy accuracy : {Accuracy::standard, Accuracy::exact}) {
    Simulator near = simulatorOf(scene, sensor, accuracy);
    const Scan here = near.scan(pose);
    requireSame(truth, here);
    for (const Vec3& by : {Vec3{5e6, 0, 0}, Vec3{-3e6, 4e6, 1024}, Vec3{0x1p22, -0x1p22, 0x1p20}}) {
      Simulator far = simulatorOf(moved(scene, by), sensor, accuracy);
      REQUIRE(sameBytes(here, far.scan(moved(pose, by))));
    }
    const Vec3 uneven = {4999999.7, -3e6 / 7, 1e6 / 3};
    Simulator far = simulatorOf(moved(scene, uneven), sensor, accuracy);
    requireNear(truth, here, far.scan(moved(pose, uneven)));
  }
}

TEST_CASE("large worlds: a georeferenced town in the Netherlands gives the same scan as at the origin") {
  needVulkan();
  const Scene scene = loadScene(dataFile("3dfier-nl/lod1.obj"));
  const Bounds bounds = worldBounds(scene);
  const Vec3 back = {-std::round(bounds.min.x), -std::round(bounds.min.y), 0};
  Scene home = scene;
  for (Mesh& mesh : home.meshes) mesh.origin = {mesh.origin.x + back.x, mesh.origin.y + back.y, mesh.origin.z};
  const Sensor sensor = gridSensor(450, 32, -30, 15, 300);
  TestOptions options = vulkanOptions();
  options.device = DeviceChoice::Kind::reference;
  Simulator reference = makeSimulator(scene, sensor, options);
  uint64_t hits = 0;
  for (const Accuracy accuracy : {Accuracy::standard, Accuracy::exact}) {
    Simulator there = simulatorOf(scene, sensor, accuracy), here = simulatorOf(home, sensor, accuracy);
    for (int k = 0; k < 20; ++k) {
      const double s = (k + 0.5) / 20;
      const Pose pose = {{std::round(bounds.min.x + s * (bounds.max.x - bounds.min.x)) + 0.25,
                          std::round(bounds.min.y + s * (bounds.max.y - bounds.min.y)) + 0.5, bounds.min.z + 12},
                         {0, 0, std::sin(s), std::cos(s)}};
      INFO("pose " << k);
      const Scan truth = reference.scan(pose), scan = there.scan(pose);
      requireSame(truth, scan);
      if (accuracy == Accuracy::exact && k % 5 == 0) requireExact(exactScan(scene, sensor, pose), scan);
      const Scan atHome = here.scan(moved(pose, back));
      requireNear(truth, atHome, scan);
      hits += scan.counters.hits;
    }
  }
  INFO(hits << " hits");
  CHECK(hits > 0);
}

TEST_CASE("large worlds: a drive in UTM coordinates gives the same scans as at the origin") {
  needVulkan();
  const std::vector<Pose> poses = readTum(dataFile("../trajectories/evo/georeferenced.tum"));
  REQUIRE(poses.size() > 100);
  const Vec3 far = {std::round(poses[0].position.x), std::round(poses[0].position.y), 0};
  // Multiples of 2^-16 m are exact at both places.
  const auto stepped = [](double value) { return std::round(value * 0x1p16) * 0x1p-16; };
  Scene town = makeTown({.triangles = 60'000});
  for (Instance& instance : town.instances)
    for (size_t k : {3u, 7u, 11u}) instance.transform.rows[k] = stepped(instance.transform.rows[k]);
  const Sensor sensor = gridSensor(450, 32, -30, 15, 300);
  for (const Accuracy accuracy : {Accuracy::standard, Accuracy::exact}) {
    Simulator near = simulatorOf(town, sensor, accuracy), there = simulatorOf(moved(town, far), sensor, accuracy);
    uint64_t hits = 0;
    for (size_t i = 0; i < poses.size(); i += 50) {
      Pose pose = poses[i];
      pose.position = {stepped(pose.position.x), stepped(pose.position.y), 2};
      const Scan here = near.scan(moved(pose, {-far.x, -far.y, 0}));
      REQUIRE(sameBytes(here, there.scan(pose)));
      hits += here.counters.hits;
    }
    CHECK(hits > 0);
  }
}
