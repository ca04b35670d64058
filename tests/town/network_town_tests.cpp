// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>
#include <cmath>
#include <cstdio>
#include <map>
#include <optional>
#include <utility>

#include "base/quaternion.hpp"
#include "gnosphere/error.hpp"
#include "problem.hpp"
#include "town/opendrive/road_mesh.hpp"
#include "town/opendrive_support.hpp"
#include "town/surfaces.hpp"
#include "town/town.hpp"

using namespace gnosphere;
using town::Surface;
using namespace gnosphere::town::opendrive;
using test::kJunction;
namespace fs = std::filesystem;

namespace {

bool isGround(const std::string& name) {
  return name.starts_with("road") || name.starts_with("junction") || name.starts_with("ground");
}

bool isVehicle(const std::string& name) {
  return name.starts_with("hatchback") || name.starts_with("saloon") || name.starts_with("estate") ||
         name.starts_with("van") || name.starts_with("bus ");
}

/// The ground seen from above, by plain sums over its triangles: heights and materials at a point.
class GroundView {
 public:
  explicit GroundView(const Scene& scene) {
    for (const Instance& instance : scene.instances) {
      if (!isGround(instance.name)) continue;
      const Mesh& mesh = scene.meshes[instance.mesh];
      for (const MeshPart& part : mesh.parts)
        for (size_t t = part.firstTriangle; t < part.firstTriangle + part.triangleCount; ++t) {
          Face face;
          face.surface = static_cast<Surface>(part.material);
          for (size_t k = 0; k < 3; ++k) {
            const float* p = &mesh.positions[3 * mesh.indices[3 * t + k]];
            face.corners[k] = instance.transform * Vec3{p[0], p[1], p[2]};
          }
          const auto [low, high] = std::minmax({face.corners[0].x, face.corners[1].x, face.corners[2].x});
          for (int i = cell(low); i <= cell(high); ++i) faces_[i].push_back(face);
        }
    }
  }

  struct Hit {
    double z;
    Surface surface;
  };
  /// The highest face above or below a point.
  std::optional<Hit> at(double x, double y) const {
    std::optional<Hit> hit;
    const auto found = faces_.find(cell(x));
    if (found == faces_.end()) return hit;
    for (const Face& face : found->second) {
      const Vec3 &a = face.corners[0], &b = face.corners[1], &c = face.corners[2];
      const double area = (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y);
      if (area < 1e-9) continue;  // vertical, or seen from below
      const double u = ((x - a.x) * (c.y - a.y) - (c.x - a.x) * (y - a.y)) / area;
      const double v = ((b.x - a.x) * (y - a.y) - (x - a.x) * (b.y - a.y)) / area;
      if (u < 0 || v < 0 || u + v > 1) continue;
      const double z = a.z + u * (b.z - a.z) + v * (c.z - a.z);
      if (!hit || z > hit->z) hit = Hit{z, face.surface};
    }
    return hit;
  }

 private:
  struct Face {
    Vec3 corners[3];
    Surface surface;
  };
  static int cell(double x) { return static_cast<int>(std::floor(x / 2)); }
  std::map<int, std::vector<Face>> faces_;
};

/// Sums of area times centroid and of area by material, which do not depend on the order of triangles.
std::vector<std::array<double, 4>> moments(const Scene& scene) {
  std::vector<std::array<double, 4>> sums(scene.materials.size());
  for (const Instance& instance : scene.instances) {
    const Mesh& mesh = scene.meshes[instance.mesh];
    for (const MeshPart& part : mesh.parts)
      for (size_t t = part.firstTriangle; t < part.firstTriangle + part.triangleCount; ++t) {
        Vec3 c[3];
        for (size_t k = 0; k < 3; ++k) {
          const float* p = &mesh.positions[3 * mesh.indices[3 * t + k]];
          c[k] = instance.transform * (mesh.origin + Vec3{p[0], p[1], p[2]});
        }
        const Vec3 n = cross(c[1] - c[0], c[2] - c[0]);
        const double area = std::sqrt(dot(n, n)) / 2;
        auto& sum = sums[part.material];
        sum[0] += area;
        sum[1] += area * (c[0].x + c[1].x + c[2].x) / 3;
        sum[2] += area * (c[0].y + c[1].y + c[2].y) / 3;
        sum[3] += area * (c[0].z + c[1].z + c[2].z) / 3;
      }
  }
  return sums;
}

double headingOf(const Pose& pose) {
  const Vec3 x = pose.orientation * Vec3{1, 0, 0};
  return std::atan2(x.y, x.x);
}

/// A network of one road with a lane of 3.5 m to each side.
std::string oneRoad(double length, double heading, const std::string& shape, const std::string& profiles,
                    const std::string& heights = "") {
  const auto lane = [&](int id) {
    return "<lane id='" + std::to_string(id) + "' type='driving'><width sOffset='0' a='3.5' b='0' c='0' d='0'/>" +
           heights + "</lane>";
  };
  const std::string metres = std::to_string(length);
  return "<OpenDRIVE><header/><road id='1' length='" + metres +
         "' junction='-1'><planView><geometry s='0' x='0' y='0' " + "hdg='" + std::to_string(heading) + "' length='" +
         metres + "'>" + shape + "</geometry></planView>" + profiles + "<lanes><laneSection s='0'><left>" + lane(1) +
         "</left><center><lane id='0'/></center><right>" + lane(-1) +
         "</right></laneSection></lanes></road></OpenDRIVE>";
}

/// The positions of the four wheels of a car with this transform or pose.
template <typename Turn>
std::vector<Vec3> wheelsOf(const Turn& turn) {
  std::vector<Vec3> wheels;
  for (double x : {-1.3, 1.3})
    for (double y : {-0.75, 0.75}) wheels.push_back(turn(Vec3{x, y, 0}));
  return wheels;
}

}  // namespace

TEST_CASE("a town on a road network has the requested number of triangles within ten percent") {
  const uint64_t triangles = GENERATE(10'000u, 100'000u, 1'000'000u, 8'000'000u);
  const Scene scene = makeTown({triangles, 1, kJunction});
  const double placed = static_cast<double>(scene.placedTriangleCount());
  CAPTURE(triangles, placed);
  CHECK(std::abs(placed - static_cast<double>(triangles)) <= 0.1 * static_cast<double>(triangles));
  CHECK_NOTHROW(validate(scene));
  size_t unsound = 0;
  for (const Mesh& mesh : scene.meshes)
    for (float value : mesh.positions) unsound += std::isfinite(value) ? 0 : 1;
  CHECK(unsound == 0);
}

TEST_CASE("every lane exists at its height, with asphalt on driving lanes") {
  const GroundView ground(makeTown({600'000, 1, kJunction}));
  const Network network = readNetwork(kJunction);
  size_t points = 0, missing = 0, off = 0, wrong = 0;
  for (const Road& road : network.roads)
    for (double s = 0.37; s < road.length; s += 0.93) {
      const LaneSection& section = road.sectionAt(s);
      const std::vector<double> edges = laneEdges(road, section, s);
      for (size_t i = 0; i < section.lanes.size(); ++i) {
        if (edges[i] - edges[i + 1] < 0.8) continue;
        for (double share : {0.13, 0.5, 0.87}) {
          const double t = edges[i] + share * (edges[i + 1] - edges[i]);
          const Vec3 p = network.toFile * road.frame(s).point(t);
          const auto hit = ground.at(p.x, p.y);
          const bool sidewalk = section.lanes[i].use == LaneUse::sidewalk;
          ++points;
          missing += hit ? 0 : 1;
          if (!hit) continue;
          CAPTURE(road.id, s, t, hit->z, p.z);
          off += std::abs(hit->z - p.z - (sidewalk ? kCurbHeight : 0)) < 0.03 ? 0 : 1;
          const bool paved = hit->surface == Surface::paving || hit->surface == Surface::kerb;
          const bool driven = hit->surface == Surface::asphalt || hit->surface == Surface::roadPaint;
          wrong += (sidewalk ? paved : driven) ? 0 : 1;
        }
      }
    }
  CHECK(points > 3000);
  CHECK(missing == 0);
  CHECK(off == 0);
  CHECK(wrong == 0);
}

TEST_CASE("roads come before what stands beside them, and a town without room for all of them says so") {
  std::string warning;
  TownOptions options = {2'000, 1, kJunction, [&](const std::string& message) { warning = message; }};
  (void)makeTown(options);
  int placed = 0, all = 0;
  unsigned long long needed = 0;
  CAPTURE(warning);
  REQUIRE(std::sscanf(warning.c_str(),
                      "2000 triangles have room for %d of %d roads and junctions; all of them need --triangles %llu",
                      &placed, &all, &needed) == 3);
  CHECK(placed < all);
  CHECK(all == 5);  // roads 1 to 4 and the junction
  options.triangles = needed - 1;
  (void)makeTown(options);
  CHECK(warning.starts_with(std::to_string(needed - 1) + " triangles have room for 4 of 5 roads"));
  warning.clear();
  options.triangles = needed;
  const GroundView ground(makeTown(options));
  CHECK(warning == "");
  size_t without = 0;
  for (const Pose& pose : makeDrive(options)) without += ground.at(pose.position.x, pose.position.y) ? 0 : 1;
  CHECK(without == 0);
}

TEST_CASE("only vehicles stand on a carriageway") {
  const Scene scene = makeTown({600'000, 1, kJunction});
  const GroundView ground(scene);
  size_t things = 0, vehicles = 0;
  for (const Instance& instance : scene.instances) {
    if (isGround(instance.name)) continue;
    const Mesh& mesh = scene.meshes[instance.mesh];
    const double base = instance.transform.rows[11];
    bool onRoad = false;
    for (size_t v = 0; v < mesh.vertexCount() && !onRoad; ++v) {
      const float* q = &mesh.positions[3 * v];
      const Vec3 p = instance.transform * Vec3{q[0], q[1], q[2]};
      if (p.z > base + 1) continue;  // tree crowns and balconies may be above it
      const auto hit = ground.at(p.x, p.y);
      onRoad = hit && (hit->surface == Surface::asphalt || hit->surface == Surface::roadPaint);
    }
    INFO(instance.name);
    if (isVehicle(instance.name))
      vehicles += onRoad ? 1 : 0;
    else
      CHECK_FALSE(onRoad);
    ++things;
  }
  CHECK(things > 300);
  CHECK(vehicles > 5);
}

TEST_CASE("a drive has even steps, is smooth, stays in the right lane 1.8 m above the road, and is free of obstacles") {
  const bool onNetwork = GENERATE(true, false);
  const TownOptions options = {600'000, 1, onNetwork ? kJunction : fs::path()};
  const std::vector<Pose> drive = makeDrive(options);
  const Scene scene = makeTown(options);
  const GroundView ground(scene);
  REQUIRE(drive.size() == 400);
  for (size_t i = 1; i < drive.size(); ++i) {
    const Vec3 step = drive[i].position - drive[i - 1].position;
    const double turn = std::remainder(headingOf(drive[i]) - headingOf(drive[i - 1]), 2 * M_PI);
    CAPTURE(onNetwork, i);
    REQUIRE(std::abs(std::sqrt(dot(step, step)) - 0.8) < 0.01);
    REQUIRE(std::abs(turn) < 0.2);
    REQUIRE(std::abs(std::remainder(std::atan2(step.y, step.x) - headingOf(drive[i]), 2 * M_PI)) < 0.15);
  }
  if (onNetwork)
    for (const Pose& pose : drive) {
      const auto below = ground.at(pose.position.x, pose.position.y);
      REQUIRE(below);
      REQUIRE((below->surface == Surface::asphalt || below->surface == Surface::roadPaint));
      REQUIRE(std::abs(pose.position.z - below->z - 1.8) < 0.03);
      // The lane is 3.5 m wide: kerb or verge is at most 4 m to the right, and more road is to the left.
      const double heading = headingOf(pose);
      const auto left = ground.at(pose.position.x - 1.6 * std::sin(heading), pose.position.y + 1.6 * std::cos(heading));
      REQUIRE((left && (left->surface == Surface::asphalt || left->surface == Surface::roadPaint)));
    }
  // A vehicle is at least 4 m long and 1.8 m wide, so its middle keeps a distance from every pose.
  for (const Instance& instance : scene.instances) {
    if (!isVehicle(instance.name)) continue;
    const auto& rows = instance.transform.rows;
    for (size_t i = 0; i < drive.size(); ++i) {
      const Vec3 d = Vec3{rows[3], rows[7], rows[11]} - drive[i].position;
      const double heading = headingOf(drive[i]);
      const double ahead = d.x * std::cos(heading) + d.y * std::sin(heading);
      const double left = d.y * std::cos(heading) - d.x * std::sin(heading);
      if (std::abs(ahead) < 2 && std::abs(left) < 1.4 && std::abs(d.z) < 4) FAIL(instance.name << " at pose " << i);
    }
  }
}

TEST_CASE("vehicles and the drive stand on a road with a slope, a superelevation and heights of lanes") {
  const double heading = 0.5, slope = 0.1, roll = 0.06, height = 0.2;
  const test::TemporaryFile file(
      oneRoad(400, heading, "<line/>",
              "<elevationProfile><elevation s='0' a='3' b='0.1' c='0' d='0'/></elevationProfile>"
              "<lateralProfile><superelevation s='0' a='0.06' b='0' c='0' d='0'/></lateralProfile>",
              "<height sOffset='0' inner='0.2' outer='0.2'/>"));
  const TownOptions options = {200'000, 1, file.path};
  const std::vector<Pose> drive = makeDrive(options);
  const Scene scene = makeTown(options);
  // The road's axes: along it, to its left, and upright on both; its points at s and t.
  const Vec3 level = {std::cos(heading), std::sin(heading), 0};
  const Vec3 along = 1 / std::sqrt(1 + slope * slope) * (level + Vec3{0, 0, slope});
  const Vec3 left = {-std::cos(roll) * level.y, std::cos(roll) * level.x, std::sin(roll)};
  const Vec3 upright = cross(along, left), up = 1 / lengthOf(upright) * upright;
  const auto heightAt = [&](const Vec3& p) {  // of the lanes' surface
    const double s = dot(p, level), t = (p.y * level.x - p.x * level.y) / std::cos(roll);
    return 3 + slope * s + std::sin(roll) * t + height;
  };
  for (const Pose& pose : drive) {
    const double direction = dot(pose.orientation * Vec3{1, 0, 0}, along) > 0 ? 1 : -1;
    REQUIRE(lengthOf(pose.orientation * Vec3{1, 0, 0} - direction * along) < 1e-6);
    REQUIRE(lengthOf(pose.orientation * Vec3{0, 0, 1} - up) < 1e-6);
    REQUIRE(std::abs(pose.position.z - heightAt(pose.position) - 1.8) < 1e-6);
  }
  size_t vehicles = 0;
  for (const Instance& instance : scene.instances) {
    const auto& rows = instance.transform.rows;
    if (!isVehicle(instance.name) || std::abs(dot({rows[3], rows[7], 0}, {-level.y, level.x, 0})) > 3.5) continue;
    INFO(instance.name);
    ++vehicles;
    CHECK(std::abs(dot({rows[0], rows[4], rows[8]}, along)) > 1 - 1e-9);
    CHECK(lengthOf(Vec3{rows[2], rows[6], rows[10]} - up) < 1e-6);
    CHECK(std::abs(rows[11] - heightAt({rows[3], rows[7], 0})) < 1e-6);
  }
  CHECK(vehicles > 2);
}

TEST_CASE("the wheels of vehicles and of the drive's car touch the road") {
  const TownOptions options = {600'000, 1, kJunction};
  const Scene scene = makeTown(options);
  const GroundView ground(scene);
  std::vector<Vec3> wheels;
  for (const Instance& instance : scene.instances)
    if (isVehicle(instance.name))
      for (const Vec3& wheel : wheelsOf([&](const Vec3& p) { return instance.transform * p; })) wheels.push_back(wheel);
  for (const Pose& pose : makeDrive(options))
    for (const Vec3& wheel : wheelsOf([&](const Vec3& p) { return pose.position + pose.orientation * p; }))
      wheels.push_back(wheel - Vec3{0, 0, 1.8});
  CHECK(wheels.size() > 1640);
  double farthest = 0;
  size_t elsewhere = 0;
  for (const Vec3& wheel : wheels) {
    const auto road = ground.at(wheel.x, wheel.y);
    if (road)
      farthest = std::max(farthest, std::abs(road->z - wheel.z));
    else
      ++elsewhere;
  }
  CHECK(farthest < 0.04);
  CHECK(elsewhere == 0);
}

TEST_CASE("an offset in the header moves the town without changing vertices") {
  std::string moved = test::bytesOf(kJunction);
  const std::string header = "version=\"1\"/>";
  moved.replace(moved.find(header), header.size(),
                "version=\"1\"><offset x=\"500000\" y=\"5400000\" z=\"7\"/></header>");
  const test::TemporaryFile file(moved);
  const Scene here = makeTown({100'000, 1, kJunction}), there = makeTown({100'000, 1, file.path});
  const std::vector<Pose> drive = makeDrive({100'000, 1, kJunction}), far = makeDrive({100'000, 1, file.path});
  REQUIRE(here.instances.size() == there.instances.size());
  for (size_t i = 0; i < here.meshes.size(); ++i) REQUIRE(here.meshes[i].positions == there.meshes[i].positions);
  for (size_t i = 0; i < here.instances.size(); ++i) {
    const auto &a = here.instances[i].transform.rows, &b = there.instances[i].transform.rows;
    REQUIRE(std::abs(b[3] - a[3] - 500000) < 1e-8);
    REQUIRE(std::abs(b[7] - a[7] - 5400000) < 1e-8);
    REQUIRE(std::abs(b[11] - a[11] - 7) < 1e-12);
  }
  CHECK(std::abs(far[200].position.y - drive[200].position.y - 5400000) < 1e-8);
}

TEST_CASE("towns of a million triangles and more have the same centre") {
  const fs::path xodr = GENERATE(fs::path(), kJunction);
  const Scene small = makeTown({1'000'000, 1, xodr}), large = makeTown({12'000'000, 1, xodr});
  const Vec3 start = makeDrive({1'000'000, 1, xodr}).front().position;
  const auto near = [&](const Scene& scene) {
    std::vector<std::pair<std::array<double, 12>, uint64_t>> list;
    for (const Instance& instance : scene.instances) {
      const auto& rows = instance.transform.rows;
      if (std::abs(rows[3] - start.x) < 70 && std::abs(rows[7] - start.y) < 70)
        list.push_back({rows, scene.meshes[instance.mesh].triangleCount()});
    }
    return list;
  };
  CAPTURE(xodr);
  CHECK(near(small).size() > 200);
  CHECK(near(small) == near(large));
}

TEST_CASE("baking keeps every triangle, in tiles") {
  const Scene scene = makeTown({300'000, 2, kJunction}), baked = bake(scene);
  CHECK_NOTHROW(validate(baked));
  CHECK(baked.placedTriangleCount() == scene.placedTriangleCount());
  CHECK(baked.uniqueTriangleCount() == scene.placedTriangleCount());
  CHECK(baked.instances.size() == baked.meshes.size());
  CHECK(baked.meshes.size() < 100);
  const auto before = moments(scene), after = moments(baked);
  for (size_t material = 0; material < before.size(); ++material)
    for (size_t k = 0; k < 4; ++k) {
      CAPTURE(scene.materials[material].name, k);
      CHECK(std::abs(before[material][k] - after[material][k]) <=
            1e-4 * (std::abs(before[material][k]) + before[material][0]));
    }
  for (const Mesh& mesh : baked.meshes) {
    CHECK(mesh.triangleCount() <= 1'000'000);
    for (size_t i = 1; i < mesh.parts.size(); ++i) REQUIRE(mesh.parts[i].material > mesh.parts[i - 1].material);
  }
}

TEST_CASE("a town too large to bake is refused before the work") {
  Scene scene;
  scene.materials.resize(1);
  Mesh mesh;
  mesh.positions.resize(3 * 30'000);
  mesh.indices.resize(3 * 10'000);
  mesh.parts = {{0, 10'000, 0}};
  scene.meshes.push_back(mesh);
  scene.instances.resize(20'000);
  const std::string problem = test::problemOf([&] { (void)bake(scene); });
  CHECK(problem.find("a .glb file ends at 4294967295; bake up to 83 million") != std::string::npos);
}
