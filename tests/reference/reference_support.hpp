// SPDX-License-Identifier: Apache-2.0
// Scenes, sensors and a brute-force solution in quadruple precision to check the reference.
#pragma once

#include <algorithm>
#include <array>
#include <catch2/catch_test_macros.hpp>
#include <cmath>
#include <cstring>
#include <numeric>
#include <random>

#include "bits.hpp"
#include "effects/sensor_plan.hpp"
#include "pipeline/backend.hpp"
#include "reference/doubt.hpp"
#include "reference/hit.hpp"

namespace gnosphere::test {

typedef float Quad __attribute__((mode(TF)));  // __float128 on x86-64, long double on arm64
inline constexpr double kPi = 3.14159265358979323846;

inline Sensor grid(uint32_t columns, uint32_t channels, double low, double high, double rangeMax = 120) {
  Sensor sensor{"grid", columns, {}, 0, rangeMax};
  for (uint32_t i = 0; i < channels; ++i)
    sensor.channels.push_back({channels == 1 ? low : low + (high - low) * i / (channels - 1), 0});
  return sensor;
}

/// A sensor of one column, in which every channel has its own direction.
inline Sensor aimed(const std::vector<Vec3>& targets, double rangeMax = 1e4) {
  Sensor sensor{"aimed", 1, {}, 0, rangeMax};
  for (const Vec3& p : targets)
    sensor.channels.push_back(
        {std::atan2(p.z, std::hypot(p.x, p.y)) * 180 / kPi, 180 + std::atan2(p.y, p.x) * 180 / kPi});
  return sensor;
}

inline Scene sceneOf(std::vector<float> positions, std::vector<uint32_t> indices, bool doubleSided = true) {
  Scene scene;
  scene.materials.emplace_back().doubleSided = doubleSided;
  Mesh mesh{"mesh", {}, std::move(positions), std::move(indices), {}};
  mesh.parts.push_back({0, static_cast<uint32_t>(mesh.triangleCount()), 0});
  scene.meshes.push_back(std::move(mesh));
  scene.instances.push_back({"instance", 0, {}});
  return scene;
}

/// Adds a box whose front faces are outside.
inline void addBox(Mesh& mesh, const Vec3& centre, const Vec3& half) {
  const auto base = static_cast<uint32_t>(mesh.vertexCount());
  for (int i = 0; i < 8; ++i)
    for (double c : {centre.x + (i & 1 ? half.x : -half.x), centre.y + (i & 2 ? half.y : -half.y),
                     centre.z + (i & 4 ? half.z : -half.z)})
      mesh.positions.push_back(static_cast<float>(c));
  for (uint32_t i :
       {0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5, 0, 1, 5, 0, 5, 4, 2, 6, 7, 2, 7, 3, 0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6})
    mesh.indices.push_back(base + i);
  mesh.parts = {{0, static_cast<uint32_t>(mesh.triangleCount()), 0}};
}

inline Scene cube(double half, bool doubleSided = true) {
  Scene scene = sceneOf({}, {}, doubleSided);
  addBox(scene.meshes[0], {}, {half, half, half});
  return scene;
}

inline Scene soup(uint32_t seed, int count, double spread, double size) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(-1, 1);
  std::vector<float> positions;
  std::vector<uint32_t> indices;
  for (int t = 0; t < count; ++t) {
    const Vec3 centre = spread * Vec3{unit(random), unit(random), unit(random)};
    for (int k = 0; k < 3; ++k) {
      const Vec3 p = centre + size * Vec3{unit(random), unit(random), unit(random)};
      for (double c : {p.x, p.y, p.z}) positions.push_back(static_cast<float>(c));
      indices.push_back(static_cast<uint32_t>(indices.size()));
    }
  }
  return sceneOf(std::move(positions), std::move(indices));
}

/// A ground grid with cells of 2 m, and boxes on it.
inline Scene yard(int cells, double boxEvery) {
  Scene scene = sceneOf({}, {});
  Mesh& mesh = scene.meshes[0];
  for (int y = 0; y <= cells; ++y)
    for (int x = 0; x <= cells; ++x)
      for (double c : {2.0 * x - cells, 2.0 * y - cells, 0.0}) mesh.positions.push_back(static_cast<float>(c));
  for (int y = 0; y < cells; ++y)
    for (int x = 0; x < cells; ++x) {
      const auto i = static_cast<uint32_t>(y * (cells + 1) + x), up = i + static_cast<uint32_t>(cells) + 1;
      for (uint32_t v : {i, i + 1, up + 1, i, up + 1, up}) mesh.indices.push_back(v);
    }
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(0, 1);
  for (double y = 5 - cells; y < cells; y += boxEvery)
    for (double x = 5 - cells; x < cells; x += boxEvery) {
      const double half = 0.3 + 2 * unit(random), height = 0.5 + 4 * unit(random);
      addBox(mesh, {x + unit(random), y + unit(random), height}, {half, 0.3 + unit(random), height});
    }
  return scene;
}

inline Pose poseAt(const Vec3& position, double yaw = 0, double pitch = 0) {
  return {position,
          {-std::sin(yaw / 2) * std::sin(pitch / 2), std::cos(yaw / 2) * std::sin(pitch / 2),
           std::sin(yaw / 2) * std::cos(pitch / 2), std::cos(yaw / 2) * std::cos(pitch / 2)}};
}

inline Scan scanOf(const Scene& scene, const Sensor& sensor, const Pose& pose = {},
                   ReflectingFaces faces = ReflectingFaces::material) {
  SimulatorOptions options;
  options.device = DeviceChoice::Kind::reference;
  options.faces = faces;
  const Shot shot = {pose, 0};
  Scan result;
  SensorPlanner planner(options);
  const auto plan = planner.plan(scene, {sensor, Effects::none()}, 0, false);
  makeReferenceBackend(scene, {plan}, options)->scanAll({&shot, 1}, result, [](size_t) {});
  return result;
}

inline size_t tieCount(const Scan& scan) {
  const auto ties = scan.column<uint8_t>(Field::tie);
  return static_cast<size_t>(std::count(ties.begin(), ties.end(), 1));
}

struct QuadVector {
  Quad x, y, z;
};
inline QuadVector operator-(const QuadVector& a, const QuadVector& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Quad dot(const QuadVector& a, const QuadVector& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline QuadVector cross(const QuadVector& a, const QuadVector& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// Returns the corners of every triangle of the first instance in the sensor frame, in quadruple precision.
inline std::vector<QuadVector> cornersOf(const Scene& scene, const Pose& pose) {
  const Mesh& mesh = scene.meshes[0];
  const auto& m = scene.instances[0].transform.rows;
  const Quad x = pose.orientation.x, y = pose.orientation.y, z = pose.orientation.z, w = pose.orientation.w;
  const Quad s = 2 / (x * x + y * y + z * z + w * w);
  const QuadVector axes[3] = {{1 - s * (y * y + z * z), s * (x * y + w * z), s * (x * z - w * y)},
                              {s * (x * y - w * z), 1 - s * (x * x + z * z), s * (y * z + w * x)},
                              {s * (x * z + w * y), s * (y * z - w * x), 1 - s * (x * x + y * y)}};
  std::vector<QuadVector> corners;
  for (uint32_t index : mesh.indices) {
    const Quad p[3] = {Quad(mesh.origin.x) + mesh.positions[3 * index],
                       Quad(mesh.origin.y) + mesh.positions[3 * index + 1],
                       Quad(mesh.origin.z) + mesh.positions[3 * index + 2]};
    const QuadVector q = {m[0] * p[0] + m[1] * p[1] + m[2] * p[2] + m[3] - pose.position.x,
                          m[4] * p[0] + m[5] * p[1] + m[6] * p[2] + m[7] - pose.position.y,
                          m[8] * p[0] + m[9] * p[1] + m[10] * p[2] + m[11] - pose.position.z};
    corners.push_back({dot(axes[0], q), dot(axes[1], q), dot(axes[2], q)});
  }
  return corners;
}

struct Answer {
  uint32_t triangle = kNoTriangle;
  Quad range = 0;
};

/// Whether a beam passes beside a triangle by far more than the rounding errors of double precision.
inline bool clearlyBeside(const QuadVector& corner, const QuadVector& side1, const QuadVector& side2, const Vec3& d) {
  const auto rounded = [](const QuadVector& v) {
    return Vec3{static_cast<double>(v.x), static_cast<double>(v.y), static_cast<double>(v.z)};
  };
  const Vec3 a = rounded(corner), e1 = rounded(side1), e2 = rounded(side2);
  const Vec3 p = gnosphere::cross(d, e2), q = gnosphere::cross(e1, a);
  double det = gnosphere::dot(e1, p), u = -gnosphere::dot(a, p), v = gnosphere::dot(d, q);
  const double size = lengthOf(a) + lengthOf(e1) + lengthOf(e2), error = 1e-13 * size * size;
  if (!(std::abs(det) > error)) return false;
  if (det < 0) det = -det, u = -u, v = -v;
  return u < -error || v < -error || u + v - det > 3 * error;
}

/// Intersection by Moller and Trumbore 1997, with a division, in quadruple precision.
inline Answer bruteForce(const std::vector<QuadVector>& corners, const Vec3& direction, double rangeMax) {
  const QuadVector d = {direction.x, direction.y, direction.z};
  Answer answer;
  for (size_t t = 0; 3 * t < corners.size(); ++t) {
    const QuadVector a = corners[3 * t], e1 = corners[3 * t + 1] - a, e2 = corners[3 * t + 2] - a;
    if (clearlyBeside(a, e1, e2, direction)) continue;
    const QuadVector p = cross(d, e2), s = QuadVector{} - a, q = cross(s, e1);
    const Quad det = dot(e1, p);
    if (det == 0) continue;
    const Quad u = dot(s, p) / det, v = dot(d, q) / det, range = dot(e2, q) / det;
    if (u < 0 || v < 0 || u + v > 1 || range <= 0 || range > rangeMax) continue;
    if (answer.triangle == kNoTriangle || range < answer.range) answer = {static_cast<uint32_t>(t), range};
  }
  return answer;
}

}  // namespace gnosphere::test
