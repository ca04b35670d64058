// SPDX-License-Identifier: Apache-2.0
// Step project: no triangle that a beam can hit is culled, whatever its shape and position.
#include <cmath>
#include <limits>

#include "base/transform.hpp"
#include "base/vector.hpp"
#include "support.hpp"

using namespace gnosphere;
using namespace gnosphere::test;

namespace {

void requireAsReference(const Scene& scene, const Sensor& sensor, const Pose& pose = {}) {
  needVulkan();
  const Scan reference = referenceOf(scene, sensor, pose);
  CHECK(reference.counters.hits > 0);
  requireSame(reference, scanOf(scene, sensor, pose, vulkanOptions()));
}

const Sensor kAround = gridSensor(360, 91, -90, 90);

}  // namespace

TEST_CASE("a triangle across the azimuth seam is seen on both sides of it", "[second-driver]") {
  MeshBuilder builder;
  builder.triangle({-5, -2, -1}, {-5, 2, -1}, {-5, 0, 2});
  requireAsReference(sceneOf(builder.take()), kAround);
}

TEST_CASE("ground below the sensor and a roof above it contain the poles") {
  MeshBuilder builder;
  builder.triangle({-10, -10, -1.8}, {10, -10, -1.8}, {0, 15, -1.8});
  builder.triangle({-10, -10, 3}, {0, 15, 3}, {10, -10, 3});
  requireAsReference(sceneOf(builder.take()), kAround);
}

TEST_CASE("an edge above the sensor bulges above both of its ends") {
  MeshBuilder builder;
  builder.triangle({5, -40, 8}, {5, 40, 8}, {5, 0, 2});
  requireAsReference(sceneOf(builder.take()), gridSensor(720, 200, -10, 70));
}

TEST_CASE("an edge of which only the bulge reaches a row is hit there, for every span") {
  // The middle of each edge lies beyond a row by a twentieth of its bulge; its ends and the third corner do not.
  MeshBuilder builder;
  Sensor sensor = gridSensor(7200, 3, 0, 0);
  const double rows[] = {-0.9, -0.3, 0.15, 0.6, 0.95, 1.2};
  sensor.channels.resize(std::size(rows));
  for (size_t j = 0; j < std::size(rows); ++j) {
    sensor.channels[j] = {};
    sensor.channels[j].elevationDeg = rows[j] * 180 / std::numbers::pi;
    for (int i = 0; i < 40; ++i) {
      const double spans = 0.004 * std::pow(1.12, i), azimuth = 0.9 * i, up = rows[j] > 0 ? 1 : -1;
      const auto endOf = [&](double top) { return std::atan(std::tan(top) * std::cos(0.5 * spans)); };
      const double bulge = std::abs(rows[j] - endOf(rows[j])), end = endOf(rows[j] + 0.05 * up * bulge);
      const auto at = [&](double turn, double elevation) {
        return Vec3{9 * std::cos(elevation) * std::cos(turn), 9 * std::cos(elevation) * std::sin(turn),
                    9 * std::sin(elevation)};
      };
      builder.triangle(at(azimuth - 0.5 * spans, end), at(azimuth + 0.5 * spans, end),
                       at(azimuth, end - 0.2 * up * spans));
    }
  }
  const Scene scene = sceneOf(builder.take());
  requireAsReference(scene, sensor);
  CHECK(scanOf(scene, sensor, {}, vulkanOptions()).counters.hits > 500);
}

TEST_CASE("one ground triangle several kilometres wide is seen by all beams that point at it") {
  MeshBuilder builder;
  builder.triangle({-20000, -20000, -1.8}, {30000, -20000, -1.8}, {0, 30000, -1.8});
  Sensor sensor = gridSensor(900, 64, -25, 2, 5000);
  requireAsReference(sceneOf(builder.take()), sensor);
}

TEST_CASE("a triangle with all corners out of range is seen where its middle is near") {
  MeshBuilder builder;
  builder.triangle({-3000, -3000, -2}, {3000, -3000, -2}, {0, 4000, -2});
  const Scene scene = sceneOf(builder.take());
  const Sensor sensor = gridSensor(360, 32, -80, 0, 50);
  requireAsReference(scene, sensor);
  const Scan scan = scanOf(scene, sensor, {}, vulkanOptions());
  CHECK(scan.counters.hits > 0);
}

TEST_CASE("a triangle is not hit by beams that point away from it") {
  // One corner is so near the axis that all columns are tried, above and below the horizon.
  MeshBuilder builder;
  builder.triangle({1e-5, 0, 3}, {5, 1, -3}, {5, -1, -3});
  requireAsReference(sceneOf(builder.take()), kAround);
  // In a sensor of one column, the column is its own neighbour around the turn.
  Sensor sensor = gridSensor(1, 31, -60, 60);
  for (Channel& channel : sensor.channels) channel.azimuthOffsetDeg = 5 * channel.elevationDeg;
  requireAsReference(sceneOf(soup(5, 150, 20, 8)), sensor);
}

TEST_CASE("every beam of a sensor in a closed box returns", "[second-driver]") {
  needVulkan();
  MeshBuilder builder;
  builder.box({-7, -4, -2}, {9, 6, 5}, 5);
  const Scene scene = sceneOf(builder.take());
  for (const Sensor& sensor : {builtinSensors()[0], kAround}) {
    const Scan scan = scanOf(scene, sensor, {{0.3, -0.2, 0.1}, {0.1, 0.2, 0.3, 0.9}}, vulkanOptions());
    CHECK(scan.counters.misses == 0);
  }
}

TEST_CASE("a sensor in the plane of a triangle, on its edge or on its corner sees what is behind") {
  for (const Vec3& corner : {Vec3{0, 3, 0}, Vec3{3, 0, 0}, Vec3{0, 0, 0}}) {
    MeshBuilder builder;
    builder.triangle({-2, -3, 0}, {2, -3, 0}, corner);
    builder.box({-7, -4, -2}, {9, 6, 5}, 3);
    requireAsReference(sceneOf(builder.take()), kAround);
  }
}

TEST_CASE("a wall in a vertical plane through the axis costs little and is not hit") {
  needVulkan();
  MeshBuilder builder;
  builder.quad({0, 2, -3}, {0, 40, 0}, {0, 0, 6}, 40);
  builder.box({-60, -60, -5}, {60, 60, 20}, 3);
  const Scene scene = sceneOf(builder.take());
  requireAsReference(scene, kAround);
  // With slabs, a cluster that few beams may meet is not projected triangle by triangle.
  TestOptions options = vulkanOptions();
  options.tuning.binning = Binning::nearest;
  const Scan scan = scanOf(scene, kAround, {}, options);
  // Seen edge-on the wall lies within one column or between two. None of its 3,200 triangles could be left out if its
  // bounds covered the whole sensor.
  CHECK(scan.counters.culledBetweenBeams + scan.counters.culledByCluster >= 1500);
  for (const uint32_t triangle : scan.triangles) REQUIRE(triangle >= 3200);
}

TEST_CASE("only front faces reflect if one side is requested, also on mirrored instances") {
  needVulkan();
  Scene scene = sceneOf(ball(12, 24, 1), false);
  scene.instances[0].transform = translation(5, 0, 0);
  scene.instances.push_back({"mirrored", 0, translation(-5, 1, 0) * scaling(-1, 1.5, 0.7)});
  scene.instances.push_back({"turned", 0, translation(0, 6, 0) * rotationZ(1) * scaling(2, 1, 1)});
  scene.instances.push_back({"around", 0, scaling(50, 50, 50)});  // seen from inside, where its faces are back-facing
  for (const ReflectingFaces faces : {ReflectingFaces::material, ReflectingFaces::front, ReflectingFaces::both}) {
    TestOptions options = vulkanOptions();
    options.faces = faces;
    const Scan reference = referenceOf(scene, kAround, {}, faces);
    const Scan scan = scanOf(scene, kAround, {}, options);
    requireSame(reference, scan);
    if (faces == ReflectingFaces::both)
      CHECK(scan.counters.misses == 0);
    else
      CHECK(scan.counters.culledByFace > 0);
    for (size_t b = 0; b < scan.beamCount(); ++b)
      if (faces != ReflectingFaces::both && scan.hit(b)) REQUIRE(scan.instances[b] != 3);
  }
}

TEST_CASE("a mirrored instance shows its front however small its scale is") {
  needVulkan();
  for (const double scale : {1e-7, 1e-10, 5e-11, 1e-11})
    for (const double mirror : {1.0, -1.0}) {
      INFO("scale " << scale << ", mirrored by " << mirror);
      Scene scene = sceneOf(ball(12, 24, 5e8), false);
      const double radius = 5e8 * scale;
      scene.instances[0].transform = translation(2 * radius, 0, 0) * scaling(scale, mirror * scale, scale);
      const Scan scan = scanOf(scene, kAround, {}, vulkanOptions());
      CHECK(scan.counters.hits > 1000);
      for (size_t b = 0; b < scan.beamCount(); ++b)  // the back is farther
        if (scan.hit(b)) REQUIRE(scan.ranges[b] < 1.75 * radius);
      requireSame(referenceOf(scene, kAround, {}, ReflectingFaces::material), scan);
    }
}

TEST_CASE("a corner that is not finite or too far drops its triangle, which is counted, and changes nothing else") {
  needVulkan();
  MeshBuilder builder;
  builder.box({-7, -4, -2}, {9, 6, 5}, 4);
  const Scan clean = scanOf(sceneOf(builder.take()), kAround, {}, vulkanOptions());
  for (float poison : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), 1e30f}) {
    MeshBuilder poisoned;
    poisoned.box({-7, -4, -2}, {9, 6, 5}, 4);
    poisoned.triangle({1, 1, 1}, {1, 2, 1}, {poison, 1, 2});
    poisoned.triangle({1, poison, 1}, {1, 2, 1}, {1, 1, 2});
    poisoned.triangle({1, 1, 1}, {1, 1, 1}, {1, 1, 2});
    const Scan scan = scanOf(sceneOf(poisoned.take()), kAround, {}, vulkanOptions());
    CHECK(scan.counters.nonFinite == 2);
    CHECK(scan.counters.degenerate == 1);
    CHECK(sameBytes(scan.triangles, clean.triangles));
    CHECK(sameBytes(scan.ranges, clean.ranges));
  }
}

TEST_CASE("an instance scaled beyond the coordinate limit is dropped and counted on the device") {
  needVulkan();
  MeshBuilder builder;
  builder.box({-1, -1, -1}, {1, 1, 1});
  Scene scene = sceneOf(builder.take());
  scene.instances.push_back({"huge", 0, scaling(1e12, 1e12, 1e12)});
  const Scan scan = scanOf(scene, kAround, {}, vulkanOptions());
  CHECK(scan.counters.nonFinite == 12);
  requireSame(referenceOf(scene, kAround, {}), scan);
}

TEST_CASE("an instance flattened to a plane is scanned correctly") {
  MeshBuilder builder;
  builder.box({-1, -1, -1}, {1, 1, 1}, 3);
  Scene scene = sceneOf(builder.take());
  scene.instances[0].transform = translation(6, 0.3, 0.2) * scaling(0, 2, 2);
  requireAsReference(scene, gridSensor(900, 40, -30, 30));
}

TEST_CASE("the points of a flattened instance lie in its plane") {
  needVulkan();
  const auto turned = [](double x, double y, double z, double w) { return composed({}, {x, y, z, w}, {1, 1, 1}); };
  const Transform sheared = scaling(1, 2, 0.5) * turned(0.3, -0.2, 0.5, 1);
  const auto pointsOf = [&](const Scene& scene, const Vec3& place, const Vec3& normal) {
    const Scan scan = scanOf(scene, gridSensor(720, 181, -90, 90), {}, vulkanOptions());
    size_t hits = 0;
    for (size_t beam = 0; beam < scan.ranges.size(); ++beam) {
      if (!std::isfinite(scan.ranges[beam])) continue;
      const float* p = &scan.points[3 * beam];
      const double off = dot(normal, Vec3{p[0], p[1], p[2]} - place);
      INFO("beam " << beam << " is " << off << " m off");
      CHECK(std::abs(off) < 5e-5);
      ++hits;
    }
    CHECK(hits > 100);
  };
  // Far from the origin of the mesh the corners have a precision of a millimetre.
  MeshBuilder far;
  far.box({9990, 9990, 9990}, {10010, 10010, 10010}, 3);
  Scene scene = sceneOf(far.take());
  Transform& map = scene.instances[0].transform;
  map = turned(0.1, 0.2, 0.3, 1) * sheared * scaling(1, 1, 0);
  const Vec3 middle = map * Vec3{10000, 10000, 0};
  const Vec3 across = cross({map.rows[0], map.rows[4], map.rows[8]}, {map.rows[1], map.rows[5], map.rows[9]});
  const Vec3 normal = 1 / lengthOf(across) * across;
  const Vec3 place = 40.0 * normal;
  map = translation(place.x - middle.x, place.y - middle.y, place.z - middle.z) * map;
  pointsOf(scene, place, normal);
  // A map in single precision whose determinant is not quite 0. Its inverse took the mesh out of sight.
  MeshBuilder near;
  near.box({-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}, 3);
  scene = sceneOf(near.take());
  for (const double angle : {0.1, 0.4, 0.7, 1.3, 2.2, 2.9}) {
    Transform flat = sheared * scaling(1, 0, 1) * turned(std::sin(angle), 0.3, angle, 1);
    for (double& value : flat.rows) value = static_cast<float>(value);
    const Vec3 tilted = cross(flat * Vec3{1, 0.3, 0}, flat * Vec3{0, 0.2, 1});
    const Vec3 upright = 1 / lengthOf(tilted) * tilted;
    scene.instances[0].transform = translation(3 * upright.x, 3 * upright.y, 3 * upright.z) * flat;
    pointsOf(scene, 3.0 * upright, upright);
  }
}

TEST_CASE("an empty scene, one triangle and a sensor without channels are scanned") {
  needVulkan();
  const Scene empty;
  const Scan nothing = scanOf(empty, kAround, {}, vulkanOptions());
  CHECK(nothing.counters.misses == kAround.beamCount());
  Sensor blind = kAround;
  blind.channels.clear();
  MeshBuilder builder;
  builder.triangle({2, -1, -1}, {2, 1, -1}, {2, 0, 1});
  const Scene one = sceneOf(builder.take());
  CHECK(scanOf(one, blind, {}, vulkanOptions()).beamCount() == 0);
  requireAsReference(one, kAround);
}
