// SPDX-License-Identifier: Apache-2.0
// Checks the reference by closed forms and by brute force in quadruple precision.
#include <limits>

#include "columns.hpp"
#include "gnosphere/error.hpp"
#include "reference/reference_support.hpp"

using namespace gnosphere;
using namespace gnosphere::test;

TEST_CASE("the range of flat ground is the height over the sine of the depression") {
  const Scene ground = sceneOf({-400, -400, 0, 400, -400, 0, 400, 400, 0, -400, 400, 0}, {0, 1, 2, 0, 2, 3});
  const Sensor sensor = grid(360, 24, -25, -2);
  const Scan scan = scanOf(ground, sensor, poseAt({0.3, -0.2, 1.75}, 0.7));
  REQUIRE(scan.counters.hits == sensor.beamCount());
  for (size_t i = 0; i < scan.beamCount(); ++i) {
    const double range = 1.75 / std::sin(-sensor.channels[i / 360].elevationDeg * kPi / 180);
    REQUIRE(std::abs(scan.ranges[i] - range) <= 1e-7 * range);
    REQUIRE(std::abs(scan.points[3 * i + 2] + 1.75) <= 1e-6);
  }
  CHECK(scan.counters.triangles == 2);
  CHECK(scan.counters.misses == 0);
}

TEST_CASE("every beam of every sensor returns from inside a closed cube with the exact range") {
  const Vec3 at = {1.25, -2.5, 0.75};
  for (const Sensor& sensor : {grid(1800, 16, -15, 15), grid(3600, 32, -25, 15), grid(4500, 64, -25, 2),
                               grid(1000, 91, -90, 90), grid(18000, 10, -45, 45)}) {
    const Scan scan = scanOf(cube(8), sensor, poseAt(at));
    REQUIRE(scan.counters.hits == sensor.beamCount());
    for (size_t i = 0; i < scan.beamCount(); ++i) {
      const Vec3 d = sensor.direction(i);
      double range = 1e9;
      for (auto [p, c] : {std::pair(at.x, d.x), std::pair(at.y, d.y), std::pair(at.z, d.z)})
        if (c != 0) range = std::min(range, ((c > 0 ? 8 : -8) - p) / c);
      REQUIRE(scan.ranges[i] == static_cast<float>(range));
    }
  }
}

TEST_CASE("no beam passes the corners and edges of a closed mesh") {
  // A geodesic sphere of 20 * 4^4 triangles around a sensor with a general position and orientation.
  const double g = (1 + std::sqrt(5.0)) / 2;
  std::vector<Vec3> corners = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                               {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  std::vector<uint32_t> faces = {0, 11, 5,  0, 5,  1, 0, 1, 7, 0, 7,  10, 0, 10, 11, 1, 5, 9, 5, 11,
                                 4, 11, 10, 2, 10, 7, 6, 7, 1, 8, 3,  9,  4, 3,  4,  2, 3, 2, 6, 3,
                                 6, 8,  3,  8, 9,  4, 9, 5, 2, 4, 11, 6,  2, 10, 8,  6, 7, 9, 8, 1};
  for (int level = 0; level < 4; ++level) {
    std::vector<uint32_t> finer;
    for (size_t t = 0; t < faces.size(); t += 3) {
      uint32_t middle[3];
      for (size_t k = 0; k < 3; ++k) {  // a copy per side: same bits, as the midpoint does not depend on the order
        middle[k] = static_cast<uint32_t>(corners.size());
        corners.push_back(0.5 * (corners[faces[t + k]] + corners[faces[t + (k + 1) % 3]]));
      }
      for (uint32_t v : {faces[t], middle[0], middle[2], middle[0], faces[t + 1], middle[1], middle[2], middle[1],
                         faces[t + 2], middle[0], middle[1], middle[2]})
        finer.push_back(v);
    }
    faces = finer;
  }
  std::vector<float> positions;
  for (const Vec3& p : corners)
    for (double c : {p.x, p.y, p.z}) positions.push_back(static_cast<float>(10 / lengthOf(p) * c));
  const Scene sphere = sceneOf(positions, faces);
  const Pose pose = poseAt({1.1, -0.7, 2.3}, 0.4, 0.3);
  const reference::SensorFrame frame(pose);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<Vec3> targets;
  const auto corner = [&](size_t i) {
    return frame.toSensor({positions[3 * faces[i]], positions[3 * faces[i] + 1], positions[3 * faces[i] + 2]});
  };
  for (size_t i = 0; i < faces.size(); ++i) {
    const Vec3 a = corner(i), b = corner(i / 3 * 3 + (i + 1) % 3);
    for (const Vec3& p : {a, 0.5 * (a + b), a + unit(random) * (b - a)}) targets.push_back(p);
  }
  const Scan scan = scanOf(sphere, aimed(targets), pose);
  CHECK(scan.counters.misses == 0);
  for (size_t i = 0; i < targets.size(); ++i) REQUIRE(std::abs(scan.ranges[i] - lengthOf(targets[i])) < 1e-5);
  CHECK(tieCount(scan) == targets.size());
}

TEST_CASE("beams exactly on edges and corners return") {
  // At elevation 0 sine and height are exactly 0, so that every beam of the ring lies in the plane of the equator.
  const Scene octahedron = sceneOf({3, 0, 0, -3, 0, 0, 0, 3, 0, 0, -3, 0, 0, 0, 3, 0, 0, -3},
                                   {0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4, 2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5});
  const Sensor sensor = grid(360, 1, 0, 0);
  const Scan scan = scanOf(octahedron, sensor);
  CHECK(scan.counters.misses == 0);
  CHECK(tieCount(scan) == 360);
  CHECK(scan.ranges[180] == 3);
  for (const Vec3& target : {Vec3{1, 0, 0}, Vec3{1, 2, 0}, Vec3{1, 0, 2}, Vec3{0, -1, -1}, Vec3{0, 0, -1}}) {
    int positive = 0, negative = 0;
    const std::vector<float>& p = octahedron.meshes[0].positions;
    const std::vector<uint32_t>& indices = octahedron.meshes[0].indices;
    for (size_t t = 0; t < indices.size(); t += 3) {
      Vec3 c[3];
      for (size_t k = 0; k < 3; ++k)
        c[k] = {p[3 * indices[t + k]], p[3 * indices[t + k] + 1], p[3 * indices[t + k] + 2]};
      const reference::Pierce hit = reference::pierce(target, c[0], c[1], c[2]);
      if (hit.inside && hit.range > 0) (hit.facing > 0 ? positive : negative) += 1;
    }
    CHECK(positive >= 2);  // all triangles at the edge or corner, seen from inside
    CHECK(negative == 0);
  }
}

TEST_CASE("the inside test has the exact sign where double arithmetic loses it") {
  // Small steps about points on one line through the origin, so that products differ only from the 106th bit on.
  std::mt19937 random(5);
  std::uniform_int_distribution<int> step(-3, 3);
  size_t filtered = 0;
  for (int i = 0; i < 20000; ++i) {
    const auto nudged = [&](double c) { return c + step(random) * 0x1p-50 * std::abs(c); };
    const Vec3 d = {nudged(0.3), nudged(0.7), nudged(0.9)};
    const Vec3 a = 7 * Vec3{nudged(0.3), nudged(0.7), nudged(0.9)},
               b = 90 * Vec3{nudged(0.3), nudged(0.7), nudged(0.9)};
    // Exact products of integers of 54 bits would need 162 bits. Quadruple precision decides all but the last few
    // cases, which are skipped.
    const QuadVector qa = {a.x, a.y, a.z}, qb = {b.x, b.y, b.z}, qd = {d.x, d.y, d.z};
    const Quad truth = dot(qd, cross(qa, qb));
    if ((truth < 0 ? -truth : truth) < Quad(1e-30)) continue;
    const double value = reference::edge(d, a, b);
    REQUIRE((value > 0) == (truth > 0));
    REQUIRE(std::abs(static_cast<double>((value - truth) / truth)) < 0.01);
    REQUIRE(reference::edgeExact(d, b, a) == -reference::edgeExact(d, a, b));
    ++filtered;
  }
  CHECK(filtered > 10000);
  CHECK(reference::edge({1, 2, 3}, {2, 4, 6}, {7, 1, 5}) == 0);
}

TEST_CASE("owners and ranges equal brute force in quadruple precision") {
  for (uint32_t seed = 1; seed <= 6; ++seed) {
    INFO("seed " << seed);
    Scene scene = soup(seed, 300, seed % 2 ? 20 : 3, seed % 3 ? 4 : 0.8);
    if (seed == 6) scene.instances[0].transform.rows = {2, 0.3, 0, 1, -0.1, 0.5, 0.2, 0, 0, 0.4, -1.5, 2};
    const Sensor sensor = grid(128, 16, -60, 75, 30);
    const Pose pose = poseAt({0.5, 0.25 * seed, -1}, 0.1 * seed, 0.2);
    const Scan scan = scanOf(scene, sensor, pose);
    const std::vector<QuadVector> corners = cornersOf(scene, pose);
    const reference::SensorFrame frame(pose);
    for (size_t i = 0; i < scan.beamCount(); ++i) {
      const Answer answer = bruteForce(corners, sensor.direction(i), sensor.rangeMax);
      if (scan.column<uint8_t>(Field::tie)[i]) continue;
      REQUIRE(scan.triangles[i] == answer.triangle);
      if (answer.triangle == kNoTriangle) {
        REQUIRE(std::isnan(scan.ranges[i]));
        continue;
      }
      const auto range = static_cast<double>(answer.range);
      REQUIRE(scan.ranges[i] == static_cast<float>(range));
      // On a grazing beam every formula in double loses as many digits as the tolerance shows for single precision.
      const double allowed = std::max(1e-12, 1e-8 * double{scan.column<float>(Field::tolerance)[i]});
      Vec3 c[3];
      for (size_t k = 0; k < 3; ++k) {
        const float* p = &scene.meshes[0].positions[9 * answer.triangle + 3 * k];
        c[k] = frame.toSensor(scene.instances[0].transform * Vec3{p[0], p[1], p[2]});
      }
      std::sort(c, c + 3, reference::before);
      REQUIRE(std::abs(reference::pierce(sensor.direction(i), c[0], c[1], c[2]).range - range) <= allowed);
    }
    CHECK(scan.counters.hits > 20);
    CHECK(tieCount(scan) < scan.beamCount() / 100);
  }
}

TEST_CASE("the range window is inclusive, and nearer hits are ignored") {
  const Scene walls = sceneOf({5, -9, -9, 5, 9, -9, 5, 0, 9, 8, -9, -9, 8, 9, -9, 8, 0, 9}, {0, 1, 2, 3, 4, 5});
  struct Window {
    double min, max;
    uint32_t owner;
    uint8_t tie;
  };
  for (const Window& w : {Window{0, 100, 0, 0},
                          {5, 100, 0, 1},
                          {5.0000001, 100, 1, 1},
                          {6, 100, 1, 0},
                          {6, 7, kNoTriangle, 0},
                          {0, 5, 0, 1},
                          {0, 4.9999999, kNoTriangle, 1},
                          {0, 4.9, kNoTriangle, 0},
                          {6, 8, 1, 1},
                          {8, 8, 1, 1},
                          {0, 8, 0, 0}}) {
    INFO(w.min << " to " << w.max);
    Sensor sensor = {"one", 1, {{0, 180}}, w.min, w.max};
    const Scan scan = scanOf(walls, sensor);
    CHECK(scan.triangles[0] == w.owner);
    CHECK(scan.column<uint8_t>(Field::tie)[0] == w.tie);
    CHECK(scan.counters.misses == (w.owner == kNoTriangle));
  }
}

TEST_CASE("one-sided triangles reflect from their front, also on mirrored instances") {
  const Sensor sensor = grid(36, 5, -40, 40);
  for (bool mirrored : {false, true})
    for (bool byMaterial : {false, true}) {
      Scene scene = cube(3, !byMaterial);
      if (mirrored) scene.instances[0].transform.rows = {-1, 0.2, 0, 0, 0, 1, 0, 0, 0, 0, 2, 0};
      const ReflectingFaces faces = byMaterial ? ReflectingFaces::material : ReflectingFaces::front;
      CHECK(scanOf(scene, sensor, {}, faces).counters.hits == 0);
      CHECK(tieCount(scanOf(scene, sensor, {}, faces)) == 0);
      CHECK(scanOf(scene, sensor, {}, ReflectingFaces::both).counters.misses == 0);
      const Pose outside = poseAt({-30, 4, 1});
      const Scan front = scanOf(scene, sensor, outside, faces),
                 both = scanOf(scene, sensor, outside, ReflectingFaces::both);
      CHECK(front.counters.hits > 0);
      CHECK(sameBytes(front.triangles, both.triangles));
      std::vector<uint32_t>& indices = scene.meshes[0].indices;
      for (size_t t = 0; t < indices.size(); t += 3) std::swap(indices[t], indices[t + 1]);
      CHECK(scanOf(scene, sensor, {}, faces).counters.misses == 0);
    }
}

TEST_CASE("a world 5,000 km from the origin has the same ranges") {
  // All coordinates are short binary fractions, so that moving the world adds no rounding error.
  const Vec3 far = {4.0e6, -3.0e6, 1.5e5};
  const Sensor sensor = grid(500, 16, -25, 15);
  const Pose pose = poseAt({0.25, 0.75, 1.625}, 0.6, 0.1);
  Scene scene = yard(12, 7);
  for (float& c : scene.meshes[0].positions) c = std::round(c * 4096) / 4096;
  const Scan here = scanOf(scene, sensor, pose);
  Scene byOrigin = scene;
  byOrigin.meshes[0].origin = far;
  Scene byInstance = scene;
  byInstance.instances[0].transform.rows = {1, 0, 0, far.x, 0, 1, 0, far.y, 0, 0, 1, far.z};
  for (const Scene& moved : {byOrigin, byInstance}) {
    const Scan there = scanOf(moved, sensor, {pose.position + far, pose.orientation});
    CHECK(sameBytes(here.points, there.points));
    CHECK(sameBytes(here.triangles, there.triangles));
    CHECK(tieCount(there) < 2 * tieCount(here) + 10);
  }
  const reference::SensorFrame frame(pose), farFrame({pose.position + far, pose.orientation});
  const Vec3 p = {17.125, -3.25, 0.5}, q = frame.toSensor(p), r = farFrame.toSensor(p + far);
  CHECK((q.x == r.x && q.y == r.y && q.z == r.z));
}

TEST_CASE("invalid triangles are dropped and counted and change nothing else") {
  const Sensor sensor = grid(200, 16, -60, 60);
  Scene scene = soup(21, 200, 20, 4);
  const Scan clean = scanOf(scene, sensor);
  Mesh& mesh = scene.meshes[0];
  const float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
  for (float bad : {nan, infinity, -infinity, 1e30f, 1.1e9f}) {
    const auto v = static_cast<uint32_t>(mesh.vertexCount());
    mesh.positions.insert(mesh.positions.end(), {3, -9, -9, 3, 9, bad, 3, 0, 9});
    mesh.indices.insert(mesh.indices.end(), {v, v + 1, v + 2});
  }
  const auto v = static_cast<uint32_t>(mesh.vertexCount());
  mesh.positions.insert(mesh.positions.end(), {2, -9, 0.f, 2, 9, 9, 2, -9, -0.f});
  mesh.indices.insert(mesh.indices.end(), {v, v + 1, v + 2, v, v, v + 1});
  mesh.parts[0].triangleCount += 7;
  const Scan scan = scanOf(scene, sensor);
  CHECK(scan.counters.triangles == clean.counters.triangles + 7);
  CHECK(scan.counters.nonFinite == 5);
  CHECK(scan.counters.degenerate == 2);
  CHECK(sameBytes(scan.ranges, clean.ranges));
  CHECK(sameBytes(scan.triangles, clean.triangles));
  CHECK(sameBytes(valuesOf<uint8_t>(scan, Field::tie), valuesOf<uint8_t>(clean, Field::tie)));

  Scene away = cube(1);
  away.instances.push_back({"too far", 0, {{1, 0, 0, 1.5e9, 0, 1, 0, 0, 0, 0, 1, 0}}});
  const Scan counted = scanOf(away, sensor);
  CHECK(counted.counters.nonFinite == 12);
  CHECK(counted.counters.misses == 0);
  CHECK(scanOf(away, sensor, poseAt({1.5e9, 0, 0})).counters.misses == 0);
}

TEST_CASE("vertices within 1e9 m of the origin of their mesh count, wherever the mesh has its origin") {
  const Sensor sensor = grid(200, 16, -60, 60);
  for (const Vec3& far : {Vec3{1.5e9, 0, 0}, Vec3{0, -3e9, 2e9}}) {
    Scene scene = cube(1);
    scene.meshes[0].origin = far;
    const Scan scan = scanOf(scene, sensor, poseAt(far));
    CHECK(scan.counters.nonFinite == 0);
    CHECK(scan.counters.misses == 0);
    scene.instances[0].transform.rows = {1, 0, 0, -far.x, 0, 1, 0, -far.y, 0, 0, 1, -far.z};
    CHECK(scanOf(scene, sensor).counters.misses == 0);
    CHECK(scanOf(scene, sensor, poseAt(far)).counters.nonFinite == 12);
  }
}

TEST_CASE("equal ranges go to the lower instance, then to the lower triangle, and are ties") {
  Scene scene =
      sceneOf({7.1f, -3.3f, -3.7f, 9.3f, 4.1f, -2.9f, 5.7f, 0.3f, 5.1f}, {1, 2, 0, 0, 1, 2, 2, 0, 1, 0, 2, 1});
  scene.instances.push_back(scene.instances[0]);
  std::vector<Vec3> targets;
  for (int y = 0; y < 10; ++y)
    for (int z = 0; z < 10; ++z) targets.push_back({7, 0.11 * y, 0.13 * z});
  const Scan scan = scanOf(scene, aimed(targets));
  CHECK(scan.counters.hits == 100);
  CHECK(std::count(scan.triangles.begin(), scan.triangles.end(), 0u) == 100);
  CHECK(std::count(scan.instances.begin(), scan.instances.end(), 0u) == 100);
  CHECK(tieCount(scan) == 100);
}

TEST_CASE("two walls are a tie while their tolerances overlap") {
  const auto walls = [](float gap) {
    const float far = 10 + gap;
    return sceneOf({10, -5, -5, 10, 5, -5, 10, 0, 5, far, -5, -5, far, 5, -5, far, 0, 5}, {0, 1, 2, 3, 4, 5});
  };
  const Sensor sensor = aimed({{10, 1, 1}});
  const float tolerance = scanOf(walls(1), sensor).column<float>(Field::tolerance)[0];
  for (float overlap : {0.5f, 1.5f, 2.5f}) {
    const Scan scan = scanOf(walls(overlap * tolerance), sensor);
    CHECK(scan.triangles[0] == 0);
    CHECK(int{scan.column<uint8_t>(Field::tie)[0]} == (overlap < 2));
  }
}

TEST_CASE("the order of the triangles changes only their numbers") {
  const Sensor sensor = grid(300, 16, -60, 60);
  for (Scene scene : {soup(31, 500, 15, 3), yard(100, 6)}) {
    const Pose pose = poseAt({0.2, 0.1, 1.4}, 0.8);
    const Scan scan = scanOf(scene, sensor, pose);
    Mesh& mesh = scene.meshes[0];
    std::vector<uint32_t> order(mesh.triangleCount());
    std::iota(order.begin(), order.end(), 0u);
    std::shuffle(order.begin(), order.end(), std::mt19937(1));
    const std::vector<uint32_t> before = mesh.indices;
    for (size_t t = 0; t < order.size(); ++t)  // also rotated, so that another corner is the first
      for (size_t k = 0; k < 3; ++k) mesh.indices[3 * t + k] = before[3 * order[t] + (k + t) % 3];
    const Scan shuffled = scanOf(scene, sensor, pose);
    CHECK(sameBytes(scan.ranges, shuffled.ranges));
    CHECK(sameBytes(valuesOf<uint8_t>(scan, Field::tie), valuesOf<uint8_t>(shuffled, Field::tie)));
    for (size_t i = 0; i < scan.beamCount(); ++i) {
      REQUIRE(scan.hit(i) == shuffled.hit(i));
      if (scan.hit(i) && !scan.column<uint8_t>(Field::tie)[i])
        REQUIRE(scan.triangles[i] == order[shuffled.triangles[i]]);
    }
  }
}

TEST_CASE("a pose whose quaternion is zero is refused") {
  SimulatorOptions options;
  options.device = DeviceChoice::Kind::reference;
  Simulator simulator(cube(1), {grid(10, 2, -10, 10), Effects()}, options);
  CHECK_THROWS_AS(simulator.scan({{}, {0, 0, 0, 0}}), Error);
}

TEST_CASE("a scene without visible triangles gives a cloud of misses") {
  const Sensor sensor = grid(10, 2, -10, 10);
  const Scan empty = scanOf({}, sensor);
  CHECK(empty.counters.misses == 20);
  CHECK(tieCount(empty) == 0);
  CHECK(std::isnan(empty.points[59]));
  CHECK(scanOf(cube(1), Sensor{"blind", 10, {}, 0, 1}).beamCount() == 0);
  const Scan on = scanOf(sceneOf({0, -1, -1, 0, 1, -1, 0, 0, 1}, {0, 1, 2}), sensor);
  // The sensor is on the triangle: the range is 0 up to rounding, so every beam is in doubt.
  for (float range : on.ranges) CHECK_FALSE(range > 1e-12f);
  CHECK(tieCount(on) == 20);
  CHECK(referenceDevice().usable);
}
