// SPDX-License-Identifier: Apache-2.0
// Doubtful beams of the reference: a plain single-precision simulator must stay within its ties and tolerances.
#include <limits>

#include "columns.hpp"
#include "reference/reference_support.hpp"

using namespace gnosphere;
using namespace gnosphere::test;

namespace {

/// A plain single-precision simulator: corners by x - pivot and a rounded matrix, rotated into the beam's column and
/// then its row, edge products, weighted depths. The simulator handles only the first instance, at most translated.
Scan singlePrecision(const Scene& scene, const Sensor& sensor, const Pose& pose) {
  const Mesh& mesh = scene.meshes[0];
  const auto& m = scene.instances[0].transform.rows;
  const reference::SensorFrame frame(pose);
  const Vec3 pivot = pose.position - mesh.origin - Vec3{m[3], m[7], m[11]};
  const auto asFloats = [](const Vec3& p) {
    return std::array{static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)};
  };
  const auto near = asFloats(pivot);
  const Vec3 left = Vec3{near[0], near[1], near[2]} - pivot;
  std::array<std::array<float, 3>, 3> matrix;
  std::array<float, 3> rest;
  for (size_t row = 0; row < 3; ++row) {
    matrix[row] = asFloats(frame.axes[row]);
    rest[row] = static_cast<float>(dot(frame.axes[row], left));
  }
  std::vector<std::array<float, 3>> corners;
  for (uint32_t index : mesh.indices) {
    const float* p = &mesh.positions[3 * size_t{index}];
    const float x = p[0] - near[0], y = p[1] - near[1], z = p[2] - near[2];
    auto& v = corners.emplace_back();
    for (size_t row = 0; row < 3; ++row)
      v[row] = matrix[row][0] * x + matrix[row][1] * y + matrix[row][2] * z + rest[row];
  }
  Scan scan;
  for (size_t beam = 0; beam < sensor.beamCount(); ++beam) {
    const Vec3 d = sensor.direction(beam);
    const double level = std::hypot(d.x, d.y);
    const auto ca = static_cast<float>(d.x / level), sa = static_cast<float>(d.y / level);
    const auto ce = static_cast<float>(level), se = static_cast<float>(d.z);
    float best = std::numeric_limits<float>::infinity();
    uint32_t owner = kNoTriangle;
    for (size_t t = 0; 3 * t < corners.size(); ++t) {
      float q[3], w[3], depth[3];
      for (size_t k = 0; k < 3; ++k) {
        const auto& v = corners[3 * t + k];
        const float across = v[0] * ca + v[1] * sa;
        q[k] = v[1] * ca - v[0] * sa;
        w[k] = v[2] * ce - across * se;
        depth[k] = across * ce + v[2] * se;
      }
      const float a = q[1] * w[2] - w[1] * q[2], b = q[2] * w[0] - w[2] * q[0], c = q[0] * w[1] - w[0] * q[1];
      const float sum = a + b + c;
      if (!((a >= 0 && b >= 0 && c >= 0) || (a <= 0 && b <= 0 && c <= 0)) || sum == 0) continue;
      const float range = (a * depth[0] + b * depth[1] + c * depth[2]) / sum;
      if (!(range > 0) || range < sensor.rangeMin || range > sensor.rangeMax || range >= best) continue;
      best = range;
      owner = static_cast<uint32_t>(t);
    }
    scan.ranges.push_back(best);
    scan.triangles.push_back(owner);
  }
  return scan;
}

/// Requires that every beam except ties has the same owner, and a range within the tolerance, and that few are ties.
void requireAllowed(const Scan& truth, const Scan& other) {
  size_t hits = 0;
  for (size_t i = 0; i < truth.beamCount(); ++i) {
    if (truth.column<uint8_t>(Field::tie)[i]) continue;
    INFO("beam " << i);
    REQUIRE(truth.triangles[i] == other.triangles[i]);
    if (!truth.hit(i)) continue;
    ++hits;
    REQUIRE(std::abs(double{truth.ranges[i]} - other.ranges[i]) <= truth.column<float>(Field::tolerance)[i]);
  }
  CHECK(hits > 20);  // slivers are met by few beams
  CHECK(tieCount(truth) < truth.beamCount() / 20);
}

/// Scenes that are difficult in single precision: grazing ground, boxes, slivers, corners close to the sensor.
std::vector<std::pair<Scene, Pose>> hardScenes() {
  std::vector<std::pair<Scene, Pose>> scenes;
  scenes.emplace_back(yard(20, 9), poseAt({0.31, 0.17, 1.73}, 0.3));
  scenes.emplace_back(soup(11, 400, 50, 3), poseAt({0.1, 0.2, 0.3}, 1, 0.4));
  scenes.emplace_back(soup(12, 400, 1, 0.5), poseAt({0.1, 0.2, 0.3}));
  scenes.emplace_back(sceneOf({-400, -400, 0, 400, -400, 0, 400, 400, 0, -400, 400, 0}, {0, 1, 2, 0, 2, 3}),
                      poseAt({3, 5, 0.02}, 0.2));
  Scene slivers = soup(13, 500, 10, 5);
  auto& p = slivers.meshes[0].positions;
  for (size_t t = 0; t < p.size(); t += 9)
    for (size_t k = 0; k < 3; ++k) p[t + 6 + k] = p[t + k] + 3e-3f * (p[t + 6 + k] - p[t + k]);
  scenes.emplace_back(std::move(slivers), poseAt({0, 0, 0}, 0.5));
  return scenes;
}

}  // namespace

TEST_CASE("a tree built by several tasks finds all hits") {
  const Scene scene = yard(100, 9);
  const Sensor sensor = grid(20, 4, -20, 1);
  const Pose pose = poseAt({0.31, 0.17, 1.73}, 0.3);
  const Scan scan = scanOf(scene, sensor, pose);
  const std::vector<QuadVector> corners = cornersOf(scene, pose);
  for (size_t i = 0; i < scan.beamCount(); ++i) {
    const Answer answer = bruteForce(corners, sensor.direction(i), sensor.rangeMax);
    if (!scan.column<uint8_t>(Field::tie)[i]) REQUIRE(scan.triangles[i] == answer.triangle);
  }
}

TEST_CASE("a plain single-precision simulator stays within ties and tolerances") {
  for (const auto& [scene, pose] : hardScenes()) {
    const Sensor sensor = grid(400, 16, -25, 15);
    requireAllowed(scanOf(scene, sensor, pose), singlePrecision(scene, sensor, pose));
  }
}

TEST_CASE("moving corners as far as single precision may changes only ties") {
  std::mt19937 random(17);
  std::normal_distribution<double> normal;
  for (const auto& [scene, pose] : hardScenes()) {
    const Sensor sensor = grid(400, 16, -25, 15);
    const Scan truth = scanOf(scene, sensor, pose);
    for (int round = 0; round < 3; ++round) {
      // Every triangle gets its own corners, so that cracks open, too; beams other than ties must not be affected.
      std::vector<QuadVector> corners = cornersOf(scene, pose);
      for (QuadVector& c : corners) {
        const Vec3 to = {normal(random), normal(random), normal(random)};
        const double far = std::sqrt(static_cast<double>(dot(c, c)));
        const double step = 0.99 * reference::kCornerError * far / lengthOf(to);
        c = {c.x + step * to.x, c.y + step * to.y, c.z + step * to.z};
      }
      Scan moved;
      for (size_t i = 0; i < truth.beamCount(); ++i) {
        Answer answer;
        if (!truth.column<uint8_t>(Field::tie)[i] && i % 5 == static_cast<size_t>(round))
          answer = bruteForce(corners, sensor.direction(i), sensor.rangeMax);
        else if (truth.hit(i))
          answer = {truth.triangles[i], truth.ranges[i]};
        moved.triangles.push_back(answer.triangle);
        moved.ranges.push_back(static_cast<float>(answer.range));
      }
      requireAllowed(truth, moved);
    }
  }
}

TEST_CASE("an ordinary scene has few ties and small tolerances") {
  const Sensor sensor = grid(1800, 16, -15, 15, 100);
  const Scan scan = scanOf(yard(100, 17), sensor, poseAt({0.31, 0.17, 1.73}, 0.3));
  CHECK(scan.counters.hits > sensor.beamCount() / 2);
  CHECK(tieCount(scan) < sensor.beamCount() / 200);
  const Scan wall =
      scanOf(sceneOf({100, -50, -50, 100, 50, -50, 100, 0, 80}, {0, 1, 2}), aimed({{100, 1, 2}, {100, -20, 9}}));
  REQUIRE(wall.counters.hits == 2);
  for (float tolerance : wall.column<float>(Field::tolerance)) {
    CHECK(tolerance > 1e-6f);
    CHECK(tolerance < 3e-4f);
  }
}

TEST_CASE("a beam is a tie within single precision of an edge and not beyond") {
  const Scene wall = sceneOf({10, -5, -5, 10, 5, -5, 10, 5, 5, 10, -5, 5}, {0, 1, 2, 0, 2, 3});
  const double e = 1e-5;  // metres at 10 m, about 1e-6 rad: 0.9 of it is doubtful, twice of it is not
  const Scan scan = scanOf(wall, aimed({{10, 2, 5 + 0.9 * e},
                                        {10, 2, 5 - 0.9 * e},
                                        {10, 2, 5 + 2 * e},
                                        {10, 2, 5 - 2 * e},
                                        {10, 2 + 0.9 * e, 2},
                                        {10, 2 + 4 * e, 2},
                                        {10, 2, -3}}));
  CHECK(valuesOf<uint8_t>(scan, Field::tie) == std::vector<uint8_t>{1, 1, 0, 0, 1, 0, 0});
  CHECK(scan.triangles == std::vector<uint32_t>{kNoTriangle, 1, kNoTriangle, 1, 0, 0, 0});
  CHECK(std::isnan(scan.column<float>(Field::tolerance)[0]));
  CHECK(scan.column<float>(Field::tolerance)[1] > 0);
}
