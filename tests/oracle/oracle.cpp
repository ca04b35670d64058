// SPDX-License-Identifier: Apache-2.0
#include "oracle/oracle.hpp"

#include <algorithm>
#include <bit>
#include <boost/multiprecision/cpp_int.hpp>
#include <cmath>
#include <cstring>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <limits>

#include "pipeline/beam_tables.hpp"
#include "sensor/beams.hpp"

namespace gnosphere::test {

namespace {

using Wide = boost::multiprecision::int256_t;
using Whole = std::array<int64_t, 3>;

float onLattice(float value) {
  return std::abs(value) < 0.015625f ? std::nearbyint(value * 0x1p30f) * 0x1p-30f : value;
}

/// The single-precision transform of an instance to the sensor's frame (src/geometry/instance_table.cpp, compose).
struct Placed {
  float rows[3][3];
  float pivot[3];
  float offset[3];
  bool mirrored;
};

Placed place(const Transform& instance, const Vec3& origin, const Pose& pose) {
  const Transform whole = instance * Transform{{1, 0, 0, origin.x, 0, 1, 0, origin.y, 0, 0, 1, origin.z}};
  const auto& m = whole.rows;
  const glm::dmat3 toWorld(m[0], m[4], m[8], m[1], m[5], m[9], m[2], m[6], m[10]);
  const Quaternion& q = pose.orientation;
  const glm::dmat3 toSensor = glm::transpose(glm::mat3_cast(glm::normalize(glm::dquat(q.w, q.x, q.y, q.z))));
  const glm::dvec3 translation =
      glm::dvec3(m[3], m[7], m[11]) - glm::dvec3(pose.position.x, pose.position.y, pose.position.z);
  glm::dvec3 pivot(0);
  const auto flattens = [](const glm::dmat3& map) {
    const double box = glm::length(map[0]) * glm::length(map[1]) * glm::length(map[2]);
    return !(std::abs(glm::determinant(map)) > gpu::kFlatVolume * box);
  };
  int flat = -1;
  for (int k = 0; k < 3; ++k)
    if (toWorld[k] == glm::dvec3(0)) flat = k;
  glm::dmat3 unflattened = toWorld;
  if (flat >= 0) unflattened[flat] = glm::cross(toWorld[(flat + 1) % 3], toWorld[(flat + 2) % 3]);
  if (!flattens(unflattened)) pivot = -(glm::inverse(unflattened) * translation);
  if (flat >= 0) pivot[flat] = 0;
  glm::vec3 pivot32(pivot);
  if (!glm::all(glm::lessThanEqual(glm::abs(pivot32), glm::vec3(gpu::kCoordinateLimit)))) pivot32 = glm::vec3(0);
  const glm::dmat3 rows = glm::transpose(toSensor * toWorld);
  const glm::vec3 offset(toSensor * (toWorld * glm::dvec3(pivot32) + translation));
  Placed placed = {};
  for (int r = 0; r < 3; ++r) {
    for (int k = 0; k < 3; ++k) placed.rows[r][k] = static_cast<float>(rows[r][k]);
    placed.pivot[r] = pivot32[r];
    placed.offset[r] = offset[r];
  }
  placed.mirrored = !flattens(toWorld) && glm::determinant(toWorld) < 0;
  return placed;
}

Float3 toSensor(const Placed& placed, const float* position) {
  const float x = position[0] - placed.pivot[0], y = position[1] - placed.pivot[1], z = position[2] - placed.pivot[2];
  Float3 result;
  for (int r = 0; r < 3; ++r) {
    const float* row = placed.rows[r];
    result[static_cast<size_t>(r)] = onLattice(row[0] * x + row[1] * y + row[2] * z + placed.offset[r]);
  }
  return result;
}

bool within(const float* p) {
  for (int k = 0; k < 3; ++k)
    if (!(std::abs(p[k]) <= gpu::kCoordinateLimit)) return false;
  return true;
}

bool samePoint(const float* p, const float* q) {
  return p[0] == q[0] && p[1] == q[1] && p[2] == q[2];
}

/// Whether a ball around the whole mesh is certainly out of range.
bool outOfReach(const Mesh& mesh, const Transform& transform, const Pose& pose, double rangeMax) {
  double radius = 0, stretch = 0;
  for (float p : mesh.positions)
    if (std::abs(p) <= gpu::kCoordinateLimit) radius = std::max(radius, 1.8 * std::abs(double(p)));
  for (int r = 0; r < 3; ++r)
    for (int k = 0; k < 3; ++k) stretch += transform.rows[4 * r + k] * transform.rows[4 * r + k];
  const Vec3 centre = transform * mesh.origin;
  const double distance =
      std::hypot(centre.x - pose.position.x, centre.y - pose.position.y, centre.z - pose.position.z);
  return distance > 1.001 * (rangeMax + radius * std::sqrt(stretch)) + 1;
}

/// Returns a float times 2^scale, which must be an integer.
int64_t wholeOf(float value, int scale) {
  return static_cast<int64_t>(std::ldexp(static_cast<double>(value), scale));
}
Whole wholeOf(const Float3& p, int scale) {
  return {wholeOf(p[0], scale), wholeOf(p[1], scale), wholeOf(p[2], scale)};
}

std::array<__int128, 3> cross(const Whole& a, const Whole& b) {
  const auto at = [&](size_t j, size_t k) { return __int128{a[j]} * b[k] - __int128{a[k]} * b[j]; };
  return {at(1, 2), at(2, 0), at(0, 1)};
}

Wide dot(const std::array<__int128, 3>& n, const Whole& p) {
  return Wide(n[0]) * p[0] + Wide(n[1]) * p[1] + Wide(n[2]) * p[2];
}

int signOf(const std::array<__int128, 3>& n, const Wide& side) {
  if (side != 0) return side < 0 ? -1 : 1;
  for (size_t axis : {2u, 1u, 0u})
    if (n[axis] != 0) return n[axis] < 0 ? -1 : 1;
  return 0;
}

/// Returns numerator / denominator * 2^30, rounded to nearest even; both are positive. Returns 0 below 2^-60 m, where
/// no hit is possible.
float roundedQuotient(boost::multiprecision::cpp_int numerator, boost::multiprecision::cpp_int denominator) {
  const int shift = 26 + static_cast<int>(msb(denominator)) - static_cast<int>(msb(numerator));
  if (shift > 0)
    numerator <<= shift;
  else
    denominator <<= -shift;
  boost::multiprecision::cpp_int quotient, rest;
  divide_qr(numerator, denominator, quotient, rest);
  uint64_t mantissa = static_cast<uint64_t>(quotient);
  const int drop = static_cast<int>(std::bit_width(mantissa)) - 24;
  const uint64_t half = uint64_t{1} << (drop - 1), low = mantissa & (2 * half - 1);
  mantissa >>= drop;
  if (low > half || (low == half && (rest != 0 || (mantissa & 1) != 0))) ++mantissa;
  const double range = std::ldexp(static_cast<double>(mantissa), drop - shift + 30);
  return range > 0x1p-60 && range < 0x1p30 ? static_cast<float>(range) : 0;
}

/// Tests in double, with error bounds, that a beam certainly misses a triangle.
struct Filter {
  double ab[3], bc[3], ca[3];
  double abBound, bcBound, caBound;  // 5 roundings on any path; a factor of 8 leaves a margin
};

Filter filterOf(const SeenTriangle& t) {
  Filter filter = {};
  const auto edge = [](const Float3& p, const Float3& q, double* n, double& bound) {
    for (size_t i = 0; i < 3; ++i) {
      const size_t j = (i + 1) % 3, k = (i + 2) % 3;
      n[i] = double(p[j]) * q[k] - double(p[k]) * q[j];
      bound += 8 * 0x1p-53 * std::abs(n[i]);
    }
  };
  edge(t.a, t.b, filter.ab, filter.abBound);
  edge(t.b, t.c, filter.bc, filter.bcBound);
  edge(t.c, t.a, filter.ca, filter.caBound);
  return filter;
}

bool passesBy(const Filter& f, const double* r) {
  const double ab = f.ab[0] * r[0] + f.ab[1] * r[1] + f.ab[2] * r[2];
  const double bc = f.bc[0] * r[0] + f.bc[1] * r[1] + f.bc[2] * r[2];
  if ((ab > f.abBound && bc < -f.bcBound) || (ab < -f.abBound && bc > f.bcBound)) return true;
  const double ca = f.ca[0] * r[0] + f.ca[1] * r[1] + f.ca[2] * r[2];
  const bool up = ab > f.abBound || bc > f.bcBound || ca > f.caBound;
  const bool down = ab < -f.abBound || bc < -f.bcBound || ca < -f.caBound;
  return up && down;
}

}  // namespace

std::vector<SeenTriangle> seenTriangles(const Scene& scene, const Pose& pose, double rangeMax, ReflectingFaces faces) {
  std::vector<SeenTriangle> triangles;
  for (uint32_t i = 0; i < scene.instances.size(); ++i) {
    const Instance& instance = scene.instances[i];
    const Mesh& mesh = scene.meshes[instance.mesh];
    if (outOfReach(mesh, instance.transform, pose, rangeMax)) continue;
    const Placed placed = place(instance.transform, mesh.origin, pose);
    for (const MeshPart& part : mesh.parts) {
      const bool oneSided = faces == ReflectingFaces::front ||
                            (faces == ReflectingFaces::material && !scene.materials[part.material].doubleSided);
      for (uint32_t t = part.firstTriangle; t < part.firstTriangle + part.triangleCount; ++t) {
        const float* corner[3];
        for (size_t k = 0; k < 3; ++k) corner[k] = &mesh.positions[3 * size_t{mesh.indices[3 * size_t{t} + k]}];
        if (!within(corner[0]) || !within(corner[1]) || !within(corner[2])) continue;
        if (samePoint(corner[0], corner[1]) || samePoint(corner[1], corner[2]) || samePoint(corner[2], corner[0]))
          continue;
        SeenTriangle seen = {
            toSensor(placed, corner[0]), toSensor(placed, corner[1]), toSensor(placed, corner[2]), i, t, oneSided};
        if (placed.mirrored) std::swap(seen.b, seen.c);
        if (within(seen.a.data()) && within(seen.b.data()) && within(seen.c.data())) triangles.push_back(seen);
      }
    }
  }
  return triangles;
}

std::vector<Float3> seenBeams(const Sensor& sensor) {
  const BeamTables tables = makeBeamTables(sensor);
  std::vector<Float3> beams(sensor.beamCount());
  for (const gpu::Row& row : tables.rows)
    for (size_t column = 0; column < sensor.columns; ++column) {
      const size_t beam = size_t{row.channel} * sensor.columns + column;
      float c = tables.columns[2 * column], s = tables.columns[2 * column + 1];
      if (sensor.channels[row.channel].azimuthOffsetDeg != 0) {
        c = gnosphere::onLattice(std::cos(azimuthOf(sensor, beam)));
        s = gnosphere::onLattice(std::sin(azimuthOf(sensor, beam)));
      }
      beams[beam] = {row.angles.x * c, row.angles.x * s, row.angles.y};
    }
  return beams;
}

float exactRange(const SeenTriangle& triangle, const Float3& beam) {
  const Whole a = wholeOf(triangle.a, 30), b = wholeOf(triangle.b, 30), c = wholeOf(triangle.c, 30);
  const Whole r = wholeOf(beam, 60);
  const auto ab = cross(a, b), bc = cross(b, c), ca = cross(c, a);
  const Wide sideC = dot(ab, r), sideA = dot(bc, r), sideB = dot(ca, r);
  const int sign = signOf(ab, sideC);
  if (sign == 0 || signOf(bc, sideA) != sign || signOf(ca, sideB) != sign) return 0;
  // Sides are positive if the corners turn counter-clockwise about the beam, which then hits the back of the triangle.
  if (triangle.oneSided && sign > 0) return 0;
  Wide volume = dot(bc, a), spread = sideA + sideB + sideC;
  if (spread < 0) {
    volume = -volume;
    spread = -spread;
  }
  if (spread == 0 || volume <= 0) return 0;
  return roundedQuotient(boost::multiprecision::cpp_int(volume), boost::multiprecision::cpp_int(spread));
}

Scan exactScan(const Scene& scene, const Sensor& sensor, const Pose& pose, ReflectingFaces faces,
               std::vector<uint32_t>* layers) {
  const std::vector<SeenTriangle> triangles = seenTriangles(scene, pose, sensor.rangeMax, faces);
  const std::vector<Float3> beams = seenBeams(sensor);
  std::vector<Filter> filters;
  for (const SeenTriangle& triangle : triangles) filters.push_back(filterOf(triangle));
  const float rangeMin = static_cast<float>(sensor.rangeMin), rangeMax = static_cast<float>(sensor.rangeMax);
  Scan scan;
  scan.columns = sensor.columns;
  scan.channels = static_cast<uint32_t>(sensor.channels.size());
  scan.ranges.assign(beams.size(), std::numeric_limits<float>::quiet_NaN());
  scan.triangles.assign(beams.size(), kNoTriangle);
  scan.instances.assign(beams.size(), kNoTriangle);
  if (layers) layers->assign(beams.size(), 0);
  for (size_t beam = 0; beam < beams.size(); ++beam) {
    const double r[3] = {beams[beam][0], beams[beam][1], beams[beam][2]};
    for (size_t t = 0; t < triangles.size(); ++t) {
      if (passesBy(filters[t], r)) continue;
      const float range = exactRange(triangles[t], beams[beam]);
      if (!(range > 0 && range >= rangeMin && range <= rangeMax)) continue;
      if (layers) ++(*layers)[beam];
      if (scan.hit(beam) && !(range < scan.ranges[beam])) continue;  // the lower index was tested first
      scan.ranges[beam] = range;
      scan.triangles[beam] = triangles[t].index;
      scan.instances[beam] = triangles[t].instance;
    }
    scan.counters.hits += scan.hit(beam);
  }
  return scan;
}

}  // namespace gnosphere::test
