// SPDX-License-Identifier: Apache-2.0
#include "cases/hardness.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace gnosphere::bench {
namespace {

constexpr double kRadians = std::numbers::pi / 180;

/// A rotation about all three axes. Without it, planes along the axes would have smaller errors than usual planes.
Transform generalTurn() {
  const double a = 0.7, b = 0.4, c = 1.1;
  const Transform x = {{1, 0, 0, 0, 0, std::cos(a), -std::sin(a), 0, 0, std::sin(a), std::cos(a), 0}};
  const Transform y = {{std::cos(b), 0, std::sin(b), 0, 0, 1, 0, 0, -std::sin(b), 0, std::cos(b), 0}};
  const Transform z = {{std::cos(c), -std::sin(c), 0, 0, std::sin(c), std::cos(c), 0, 0, 0, 0, 1, 0}};
  return z * y * x;
}

Transform transposed(const Transform& t) {
  const auto& m = t.rows;
  return {{m[0], m[4], m[8], 0, m[1], m[5], m[9], 0, m[2], m[6], m[10], 0}};
}

class Builder {
 public:
  /// The mesh holds rotated points and the instance rotates them back, so neither is exact in single precision.
  explicit Builder(const Transform& turn = generalTurn()) : turn_(turn) {}

  uint32_t vertex(const Vec3& p) {
    const Vec3 q = turn_ * p;
    for (double value : {q.x, q.y, q.z}) mesh_.positions.push_back(static_cast<float>(value));
    return static_cast<uint32_t>(mesh_.vertexCount() - 1);
  }
  void quad(uint32_t a, uint32_t b, uint32_t c, uint32_t d) {
    mesh_.indices.insert(mesh_.indices.end(), {a, b, c, a, c, d});
  }
  /// Adds a vertex for every pair of coordinates; `point` maps the pair to space.
  template <class Point>
  void grid(const std::vector<double>& us, const std::vector<double>& vs, Point point) {
    const uint32_t first = static_cast<uint32_t>(mesh_.vertexCount()), width = static_cast<uint32_t>(vs.size());
    for (double u : us)
      for (double v : vs) vertex(point(u, v));
    for (uint32_t i = 0; i + 1 < us.size(); ++i)
      for (uint32_t j = 0; j + 1 < vs.size(); ++j) {
        const uint32_t a = first + i * width + j, b = a + width;
        quad(a, b, b + 1, a + 1);
      }
  }
  Scene take() {
    Scene scene;
    scene.materials.emplace_back();
    mesh_.parts = {{0, static_cast<uint32_t>(mesh_.triangleCount()), 0}};
    scene.meshes.push_back(std::move(mesh_));
    scene.instances.push_back({"", 0, transposed(turn_)});
    return scene;
  }

 private:
  Transform turn_;
  Mesh mesh_;
};

std::vector<double> evenly(double from, double to, uint32_t steps) {
  std::vector<double> values;
  for (uint32_t i = 0; i <= steps; ++i) values.push_back(from + (to - from) * i / steps);
  return values;
}

Sensor sensorOf(uint32_t columns, const std::vector<double>& elevations, double rangeMax) {
  Sensor sensor = {"grid", columns, {}, 0, rangeMax};
  for (double elevation : elevations) sensor.channels.push_back({elevation, 0});
  return sensor;
}

Scene ballScene(double radius) {
  Builder builder;
  builder.grid(evenly(0, 2 * std::numbers::pi, 48), evenly(-0.5 * std::numbers::pi, 0.5 * std::numbers::pi, 24),
               [&](double azimuth, double elevation) {
                 return Vec3{radius * std::cos(elevation) * std::cos(azimuth),
                             radius * std::cos(elevation) * std::sin(azimuth), radius * std::sin(elevation)};
               });
  return builder.take();
}

/// The sensor is inside a ball of 20 m that is far from the world's origin.
HardCase worldOffset(double offset) {
  HardCase test = {offset, ballScene(20), sensorOf(1800, evenly(-60, 60, 31), 200), {}};
  const Vec3 at = {0.61 * offset, -0.77 * offset, 0.18 * offset};
  Transform& place = test.scene.instances[0].transform;
  place.rows[3] = at.x;
  place.rows[7] = at.y;
  place.rows[11] = at.z;
  test.pose.position = {at.x + 3.1, at.y - 2.3, at.z + 1.7};
  return test;
}

/// A prism of 36 walls around the sensor, 10 m away. Each wall has a vertical sliver in its middle, at which a column
/// of beams is aimed; neighbouring walls overlap behind their common line.
HardCase sliverWidth(double width) {
  constexpr uint32_t kWalls = 36;
  constexpr double kDistance = 10;
  const double half = 1.01 * kDistance * std::tan(std::numbers::pi / kWalls);
  Builder builder{Transform{}};
  builder.grid({-half, -0.5 * width, 0.5 * width, half}, evenly(-10, 10, 6), [](double y, double z) {
    return Vec3{kDistance, y, z};
  });
  HardCase test = {width, builder.take(), sensorOf(2 * kWalls, evenly(-20, 20, 199), 200), {}};
  test.scene.instances.clear();
  for (uint32_t wall = 0; wall < kWalls; ++wall) {
    const double azimuth = 2 * std::numbers::pi * wall / kWalls, c = std::cos(azimuth), s = std::sin(azimuth);
    test.scene.instances.push_back({"", 0, {{c, -s, 0, 0, s, c, 0, 0, 0, 0, 1, 0}}});
  }
  return test;
}

/// The sensor is above a plane, which the beams hit 25 to 50 m away under 1 to 2 times the given angle.
HardCase grazingAngle(double degrees) {
  const double height = 50 * std::sin(degrees * kRadians);
  Builder builder;
  builder.grid(evenly(-70, 73, 11), evenly(-71, 72, 11), [&](double x, double y) { return Vec3{x, y, -height}; });
  return {degrees, builder.take(), sensorOf(1800, evenly(-2 * degrees, -degrees, 15), 200), {}};
}

/// The sensor is above a ground of square quads, at least 140 m wide; the largest quad is the whole ground.
HardCase quadSize(double size) {
  const uint32_t count = std::max(1u, static_cast<uint32_t>(std::ceil(140 / size)));
  const double low = count == 1 ? -0.47 * size : -0.5 * count * size + 0.37, high = low + count * size;
  Builder builder;
  builder.grid(evenly(low, high, count), evenly(low - 0.01 * size, high - 0.01 * size, count), [](double x, double y) {
    return Vec3{x, y, -1.8};
  });
  return {size, builder.take(), sensorOf(1800, evenly(-25, -2, 31), 120), {}};
}

/// The sensor is inside a ball of this radius, not at its centre.
HardCase range(double radius) {
  HardCase test = {radius, ballScene(radius), sensorOf(1800, evenly(-60, 60, 31), 4 * radius), {}};
  test.pose.position = {0.21 * radius, -0.13 * radius, 0.08 * radius};
  return test;
}

std::vector<double> decades(int from, int to) {
  std::vector<double> values;
  for (int e = from; e != to; e += from < to ? 1 : -1) values.push_back(std::pow(10, e));
  values.push_back(std::pow(10, to));
  return values;
}

}  // namespace

const std::vector<Family>& families() {
  static const std::vector<Family> list = {
      {"world_offset", "World offset", "m", decades(0, 7), worldOffset},
      {"sliver_width", "Sliver width", "m", decades(0, -9), sliverWidth},
      {"grazing_angle", "Grazing angle", "degrees", decades(1, -4), grazingAngle},
      {"quad_size", "Quad size", "m", {1, 2, 5, 10, 20, 50, 100, 200, 500, 1e3, 2e3, 5e3, 1e4}, quadSize},
      {"range", "Range", "m", decades(-3, 4), range},
  };
  return list;
}

}  // namespace gnosphere::bench
