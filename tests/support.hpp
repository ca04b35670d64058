// SPDX-License-Identifier: Apache-2.0
// Small scenes, and the comparison at the end of most tests.
#pragma once

#include <catch2/catch_test_macros.hpp>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <numbers>
#include <random>
#include <string>

#include "bits.hpp"
#include "gnosphere/gnosphere.hpp"

namespace gnosphere::test {

/// Skips the test if no Vulkan device is usable; fails it if GNOSPHERE_REQUIRE names vulkan.
inline void needVulkan() {
  std::string problem;
  for (const DeviceInfo& device : listDevices(&problem))
    if (device.usable && device.type != "reference" && device.type != "cuda") return;
  const char* required = std::getenv("GNOSPHERE_REQUIRE");
  if (required && std::strstr(required, "vulkan")) FAIL("no usable Vulkan device: " << problem);
  SKIP("no usable Vulkan device: " << problem);
}

/// Whether a test tries every combination of its settings, as the slow tests do. Otherwise it tries each setting in
/// some of its combinations.
inline bool everyCombination() {
  return std::getenv("GNOSPHERE_SLOW") != nullptr;
}

/// Whether a test tries fewer combinations on this device, because SwiftShader compiles for seconds what lavapipe
/// compiles in a fraction of one.
inline bool fewerCombinations(const DeviceInfo& device) {
  return device.name.find("SwiftShader") != std::string::npos && !everyCombination();
}

/// Options that a test scans with: the options of a simulator, and what each of its sensors simulates and reports.
struct TestOptions : SimulatorOptions {
  Effects effects = Effects::none();
  std::vector<Field> fields;
};

/// Requests the effects and fields of the options from every sensor.
inline std::vector<SensorRequest> requestsOf(const std::vector<Sensor>& sensors, const TestOptions& setup) {
  std::vector<SensorRequest> requests;
  for (const Sensor& sensor : sensors) requests.push_back({sensor, setup.effects, setup.fields});
  return requests;
}

inline Simulator makeSimulator(const Scene& scene, const std::vector<Sensor>& sensors, const TestOptions& setup = {}) {
  return Simulator(scene, requestsOf(sensors, setup), setup);
}
inline Simulator makeSimulator(const Scene& scene, const Sensor& sensor, const TestOptions& setup = {}) {
  return makeSimulator(scene, std::vector{sensor}, setup);
}

/// Options of every GPU test: no files on disk, the validation layer on, and an exception for any of its messages.
/// GNOSPHERE_NO_VALIDATION is for machines with a GPU and without the layer.
inline TestOptions vulkanOptions() {
  TestOptions options;
  options.cache = "off";
  options.validation = std::getenv("GNOSPHERE_NO_VALIDATION") == nullptr;
  return options;
}

inline Material material(bool doubleSided) {
  Material result;
  result.doubleSided = doubleSided;
  return result;
}

class MeshBuilder {
 public:
  uint32_t vertex(const Vec3& p) {
    for (double value : {p.x, p.y, p.z}) mesh_.positions.push_back(static_cast<float>(value));
    return static_cast<uint32_t>(mesh_.vertexCount() - 1);
  }
  void triangle(uint32_t a, uint32_t b, uint32_t c) { mesh_.indices.insert(mesh_.indices.end(), {a, b, c}); }
  void triangle(const Vec3& a, const Vec3& b, const Vec3& c) {
    const uint32_t first = vertex(a);
    vertex(b);
    vertex(c);
    triangle(first, first + 1, first + 2);
  }
  /// Adds a grid of n x n quads from `origin` along `u` and `v`; its front faces u x v.
  void quad(const Vec3& origin, const Vec3& u, const Vec3& v, uint32_t n = 1) {
    const uint32_t first = static_cast<uint32_t>(mesh_.vertexCount());
    for (uint32_t i = 0; i <= n; ++i)
      for (uint32_t j = 0; j <= n; ++j) {
        const double a = double(i) / n, b = double(j) / n;
        vertex({origin.x + a * u.x + b * v.x, origin.y + a * u.y + b * v.y, origin.z + a * u.z + b * v.z});
      }
    for (uint32_t i = 0; i < n; ++i)
      for (uint32_t j = 0; j < n; ++j) {
        const uint32_t p = first + i * (n + 1) + j, q = p + n + 1;
        triangle(p, q, p + 1);
        triangle(p + 1, q, q + 1);
      }
  }
  /// Adds a closed box with front faces outward.
  void box(const Vec3& low, const Vec3& high, uint32_t n = 1) {
    const double x = high.x - low.x, y = high.y - low.y, z = high.z - low.z;
    quad(low, {0, y, 0}, {x, 0, 0}, n);
    quad({low.x, low.y, high.z}, {x, 0, 0}, {0, y, 0}, n);
    quad(low, {x, 0, 0}, {0, 0, z}, n);
    quad({low.x, high.y, low.z}, {0, 0, z}, {x, 0, 0}, n);
    quad(low, {0, 0, z}, {0, y, 0}, n);
    quad({high.x, low.y, low.z}, {0, y, 0}, {0, 0, z}, n);
  }
  Mesh take(uint32_t materialIndex = 0) {
    mesh_.parts = {{0, static_cast<uint32_t>(mesh_.triangleCount()), materialIndex}};
    return std::move(mesh_);
  }
  Mesh& mesh() { return mesh_; }

 private:
  Mesh mesh_;
};

/// A scene of one mesh with one instance.
inline Scene sceneOf(Mesh mesh, bool doubleSided = true) {
  Scene scene;
  scene.materials.push_back(material(doubleSided));
  scene.meshes.push_back(std::move(mesh));
  scene.instances.push_back({"", 0, {}});
  return scene;
}

inline Transform translation(double x, double y, double z) {
  return {{1, 0, 0, x, 0, 1, 0, y, 0, 0, 1, z}};
}
inline Transform scaling(double x, double y, double z) {
  return {{x, 0, 0, 0, 0, y, 0, 0, 0, 0, z, 0}};
}
/// Returns the unit vector with this azimuth and elevation in radians.
inline Vec3 directionAt(double azimuth, double elevation) {
  return {std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth), std::sin(elevation)};
}

inline Transform rotationZ(double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  return {{c, -s, 0, 0, s, c, 0, 0, 0, 0, 1, 0}};
}

inline Sensor gridSensor(uint32_t columns, uint32_t channels, double lowDeg, double highDeg, double rangeMax = 200) {
  Sensor sensor{"grid", columns, {}, 0, rangeMax};
  for (uint32_t j = 0; j < channels; ++j)
    sensor.channels.push_back({channels == 1 ? lowDeg : lowDeg + (highDeg - lowDeg) * j / (channels - 1), 0});
  return sensor;
}

inline Scan scanOf(const Scene& scene, const Sensor& sensor, const Pose& pose, const TestOptions& options) {
  return makeSimulator(scene, sensor, options).scan(pose);
}

inline Scan referenceOf(const Scene& scene, const Sensor& sensor, const Pose& pose,
                        ReflectingFaces faces = ReflectingFaces::material) {
  TestOptions options;
  options.device = DeviceChoice::Kind::reference;
  options.faces = faces;
  return scanOf(scene, sensor, pose, options);
}

inline std::string firstDifference(const Scan& reference, const Scan& other) {
  const auto ties = reference.column<uint8_t>(Field::tie);
  const auto tolerances = reference.column<float>(Field::tolerance);
  for (size_t b = 0; b < reference.beamCount(); ++b) {
    if (ties[b]) continue;
    if (reference.hit(b) == other.hit(b) &&
        (!reference.hit(b) || (reference.triangles[b] == other.triangles[b] &&
                               std::abs(reference.ranges[b] - other.ranges[b]) <= tolerances[b])))
      continue;
    return "beam " + std::to_string(b) + ": triangle " + std::to_string(int64_t(int32_t(reference.triangles[b]))) +
           " at " + std::to_string(reference.ranges[b]) + " m, got " +
           std::to_string(int64_t(int32_t(other.triangles[b]))) + " at " + std::to_string(other.ranges[b]) +
           " m, tolerance " + std::to_string(tolerances[b]);
  }
  return "none";
}

/// Requires 0 missed, 0 false, 0 wrong owner and 0 wrong range, except for ties.
inline void requireSame(const Scan& reference, const Scan& other) {
  const Comparison difference = compare(reference, other);
  INFO("missed " << difference.missed << ", false " << difference.falseHits << ", wrong owner " << difference.wrongOwner
                 << ", wrong range " << difference.wrongRange << ", wrong point " << difference.wrongPoint << ", ties "
                 << difference.ties << " of " << difference.beams << "; first: " << firstDifference(reference, other));
  REQUIRE(difference.same());
}

inline bool sameBytes(const Scan& a, const Scan& b) {
  return sameBytes(a.points, b.points) && sameBytes(a.ranges, b.ranges) && sameBytes(a.triangles, b.triangles) &&
         sameBytes(a.instances, b.instances);
}

/// Seeded random numbers in -1..1, the same with every standard library.
class Random {
 public:
  explicit Random(uint32_t seed) : engine_(seed) {}
  uint32_t bits() { return static_cast<uint32_t>(engine_()); }
  double operator()() { return 2.0 * bits() / 4294967295.0 - 1; }

 private:
  std::mt19937 engine_;
};

/// Random triangles of all sizes around the sensor.
inline Mesh soup(uint32_t seed, uint32_t count, double spread, double size) {
  Random uniform(seed);
  MeshBuilder builder;
  for (uint32_t i = 0; i < count; ++i) {
    const Vec3 centre = {spread * uniform(), spread * uniform(), spread * uniform()};
    Vec3 corner[3];
    for (Vec3& p : corner) p = {centre.x + size * uniform(), centre.y + size * uniform(), centre.z + size * uniform()};
    builder.triangle(corner[0], corner[1], corner[2]);
  }
  return builder.take();
}

/// A closed ball of triangles that share all corners, with front faces outward.
inline Mesh ball(uint32_t rings, uint32_t segments, double radius, const Vec3& centre = {}) {
  MeshBuilder builder;
  const auto point = [&](uint32_t ring, uint32_t segment) {
    const double polar = std::numbers::pi * ring / rings, azimuth = 2 * std::numbers::pi * segment / segments;
    return Vec3{centre.x + radius * std::sin(polar) * std::cos(azimuth),
                centre.y + radius * std::sin(polar) * std::sin(azimuth), centre.z + radius * std::cos(polar)};
  };
  const uint32_t top = builder.vertex({centre.x, centre.y, centre.z + radius});
  for (uint32_t ring = 1; ring < rings; ++ring)
    for (uint32_t segment = 0; segment < segments; ++segment) builder.vertex(point(ring, segment));
  const uint32_t bottom = builder.vertex({centre.x, centre.y, centre.z - radius});
  const auto at = [&](uint32_t ring, uint32_t segment) { return 1 + (ring - 1) * segments + segment % segments; };
  for (uint32_t s = 0; s < segments; ++s) {
    builder.triangle(top, at(1, s), at(1, s + 1));
    builder.triangle(bottom, at(rings - 1, s + 1), at(rings - 1, s));
  }
  for (uint32_t ring = 1; ring + 1 < rings; ++ring)
    for (uint32_t s = 0; s < segments; ++s) {
      builder.triangle(at(ring, s), at(ring + 1, s), at(ring + 1, s + 1));
      builder.triangle(at(ring, s), at(ring + 1, s + 1), at(ring, s + 1));
    }
  return builder.take();
}

}  // namespace gnosphere::test
