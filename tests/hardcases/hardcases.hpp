// SPDX-License-Identifier: Apache-2.0
// Thousands of small seeded worlds; the tests check that every beam in each is right.
//
// The worlds of a family are placed in one scene, too far apart to see each other, and each is scanned from its own
// pose. So a family needs few pipelines instead of thousands.
#pragma once

#include <algorithm>
#include <cstdio>
#include <optional>
#include <utility>

#include "columns.hpp"
#include "cuda/twin.hpp"
#include "oracle/oracle.hpp"
#include "sensor/beams.hpp"
#include "support.hpp"

namespace gnosphere::test {

/// Returns how many worlds a test tries: `worlds` if the test tries every combination of its settings, else a third of
/// that number.
inline int rounds(int worlds) {
  return everyCombination() ? worlds : worlds / 3;
}

class Family {
 public:
  /// `spacing` between worlds must be a power of two, and more than twice the reach of a world.
  Family(std::string title, std::vector<Sensor> familySensors, double spacing = 4096)
      : name(std::move(title)), sensors(std::move(familySensors)), spacing_(spacing) {}

  /// Adds a world near the origin and a pose in it.
  void add(const Scene& world, const Pose& pose = {}, size_t sensor = 0) {
    const double x = spacing_ * static_cast<double>(visits.size() % 32);
    const double y = spacing_ * static_cast<double>(visits.size() / 32);
    const auto firstMaterial = static_cast<uint32_t>(scene.materials.size());
    const auto firstMesh = static_cast<uint32_t>(scene.meshes.size());
    scene.materials.insert(scene.materials.end(), world.materials.begin(), world.materials.end());
    for (Mesh mesh : world.meshes) {
      for (MeshPart& part : mesh.parts) part.material += firstMaterial;
      scene.meshes.push_back(std::move(mesh));
    }
    for (const Instance& instance : world.instances)
      scene.instances.push_back({"", instance.mesh + firstMesh, translation(x, y, 0) * instance.transform});
    visits.push_back({{{x + pose.position.x, y + pose.position.y, pose.position.z}, pose.orientation}, sensor});
  }

  struct Visit {
    Pose pose;
    size_t sensor;
  };
  std::string name;
  std::vector<Sensor> sensors;
  Scene scene;
  std::vector<Visit> visits;
  bool everyHitTies = false;  ///< whether `paper` is also judged by ties

 private:
  double spacing_;
};

/// Results of a family of hard cases.
struct Verdict {
  uint64_t beams = 0, hits = 0, ties = 0;
  uint64_t misses = 0;      ///< of `standard`, including ties
  uint64_t paperWrong = 0;  ///< worlds in which `paper` has a wrong beam
  double errorOfBound = 0;  ///< of `standard`: the largest |range error| / tolerance, without ties
  double error = 0;         ///< of `standard`, metres
  double errorOfRange = 0;  ///< of `standard`: relative to the range
};

inline void addErrors(const Scan& reference, const Scan& standard, Verdict& verdict) {
  const auto ties = reference.column<uint8_t>(Field::tie);
  const auto tolerances = reference.column<float>(Field::tolerance);
  for (size_t b = 0; b < reference.beamCount(); ++b) {
    verdict.hits += reference.hit(b);
    verdict.ties += ties[b];
    if (ties[b] || !reference.hit(b)) continue;
    const double error = std::abs(double(reference.ranges[b]) - standard.ranges[b]);
    verdict.errorOfBound = std::max(verdict.errorOfBound, error / tolerances[b]);
    verdict.error = std::max(verdict.error, error);
    verdict.errorOfRange = std::max(verdict.errorOfRange, error / reference.ranges[b]);
  }
  verdict.beams += reference.beamCount();
  verdict.misses += standard.counters.misses;
}

/// Requires that the cloud of `exact` has the owners and the bits of the exact oracle.
inline void requireExact(const Scan& oracle, const Scan& exact) {
  for (size_t b = 0; b < oracle.beamCount(); ++b) {
    if (oracle.triangles[b] == exact.triangles[b] && oracle.instances[b] == exact.instances[b] &&
        (!oracle.hit(b) || oracle.ranges[b] == exact.ranges[b]))
      continue;
    char line[200];
    std::snprintf(line, sizeof line, "beam %zu: oracle %d of %d at %a, exact %d of %d at %a", b,
                  static_cast<int>(oracle.triangles[b]), static_cast<int>(oracle.instances[b]), oracle.ranges[b],
                  static_cast<int>(exact.triangles[b]), static_cast<int>(exact.instances[b]), exact.ranges[b]);
    FAIL(line);
  }
}

/// Appends a line per family to the file that GNOSPHERE_TEST_REPORT names; docs/accuracy.md quotes these lines.
inline void report(const Family& family, const Verdict& verdict) {
  const char* file = std::getenv("GNOSPHERE_TEST_REPORT");
  std::FILE* out = file ? std::fopen(file, "a") : nullptr;
  if (!out) return;
  std::fprintf(out,
               "%-34s worlds %5zu beams %9llu hits %9llu ties %8llu paper wrong %5llu standard: of bound %.3f, %.3g m, "
               "%.3g of range\n",
               family.name.c_str(), family.visits.size(), static_cast<unsigned long long>(verdict.beams),
               static_cast<unsigned long long>(verdict.hits), static_cast<unsigned long long>(verdict.ties),
               static_cast<unsigned long long>(verdict.paperWrong), verdict.errorOfBound, verdict.error,
               verdict.errorOfRange);
  std::fclose(out);
}

/// Compares `standard` with the reference, and `exact` with the reference and the oracle, in every world: 0 missed, 0
/// false, 0 wrong owners, 0 wrong ranges, also on CUDA. Counts the worlds in which `paper` is wrong, unless it
/// refuses one of the sensors.
inline Verdict requireRight(const Family& family, ReflectingFaces faces = ReflectingFaces::material) {
  needVulkan();
  const auto simulator = [&](const char* device, Accuracy accuracy) {
    TestOptions options = vulkanOptions();
    options.device = deviceByName(device);
    options.accuracy = accuracy;
    options.faces = faces;
    return makeSimulator(family.scene, family.sensors, options);
  };
  Simulator reference = simulator("reference", Accuracy::standard), standard = simulator("auto", Accuracy::standard);
  Simulator exact = simulator("auto", Accuracy::exact);
  std::optional<Simulator> paper;
  if (std::all_of(family.sensors.begin(), family.sensors.end(),
                  [](const Sensor& s) { return causeAgainstPaper(s).empty(); }))
    paper = simulator("auto", Accuracy::paper);
  CudaTwin twin(family.scene, family.sensors, faces);
  Verdict verdict;
  for (size_t i = 0; i < family.visits.size(); ++i) {
    const Family::Visit& visit = family.visits[i];
    INFO(family.name << ", world " << i);
    const Scan truth = reference.scan(visit.pose, visit.sensor);
    const Scan rounded = standard.scan(visit.pose, visit.sensor);
    requireSame(truth, rounded);
    const Scan decided = exact.scan(visit.pose, visit.sensor);
    requireSame(truth, decided);
    requireExact(exactScan(family.scene, family.sensors[visit.sensor], visit.pose, faces), decided);
    twin.require(visit.pose, visit.sensor, truth, decided);
    addErrors(truth, rounded, verdict);
    Scan judge = truth;
    if (family.everyHitTies) ScanColumns(judge).fill(Field::tie, uint8_t{0});
    if (paper) verdict.paperWrong += !compare(judge, paper->scan(visit.pose, visit.sensor)).same();
  }
  report(family, verdict);
  return verdict;
}

// --- Parts of worlds -----------------------------------------------------------------------------------------------

/// Rounds to a multiple of 2^-20 m: such corners are transformed by an unrotated pose without rounding.
inline double coarse(double value) {
  return std::round(value * 0x1p20) * 0x1p-20;
}
inline Vec3 coarse(const Vec3& p) {
  return {coarse(p.x), coarse(p.y), coarse(p.z)};
}

inline Vec3 along(const Vec3& direction, double range) {
  return {direction.x * range, direction.y * range, direction.z * range};
}

/// A random rotation that maps no axis to another.
inline Quaternion anyTurn(Random& random) {
  return {random(), random(), random(), random()};
}

/// A random point within `reach` of the origin.
inline Vec3 anywhere(Random& random, double reach) {
  return {reach * random(), reach * random(), reach * random()};
}

inline double logUniform(Random& random, double low, double high) {
  return low * std::pow(high / low, 0.5 * (random() + 1));
}

/// A closed mesh around the origin. Ring 0 is one corner at the bottom, ring `rings` another at the top; the rings
/// between have `segments` corners each, counter-clockwise seen from above. `cornerOf(ring, segment)` is called ring by
/// ring.
template <typename CornerOf>
Mesh closedShell(uint32_t rings, uint32_t segments, const CornerOf& cornerOf) {
  MeshBuilder builder;
  const auto corner = [&](uint32_t ring, uint32_t segment) { return builder.vertex(cornerOf(ring, segment)); };
  const uint32_t bottom = corner(0, 0);
  for (uint32_t ring = 1; ring < rings; ++ring)
    for (uint32_t segment = 0; segment < segments; ++segment) corner(ring, segment);
  const uint32_t top = corner(rings, 0);
  const auto at = [&](uint32_t ring, uint32_t segment) { return 1 + (ring - 1) * segments + segment % segments; };
  for (uint32_t s = 0; s < segments; ++s) {
    builder.triangle(bottom, at(1, s + 1), at(1, s));
    for (uint32_t ring = 1; ring + 1 < rings; ++ring) {
      builder.triangle(at(ring, s), at(ring, s + 1), at(ring + 1, s));
      builder.triangle(at(ring, s + 1), at(ring + 1, s + 1), at(ring + 1, s));
    }
    builder.triangle(at(rings - 1, s), at(rings - 1, s + 1), top);
  }
  return builder.take();
}

/// A closed shell with corners on the beams of every `step`-th column and channel of `sensor`, at the ranges given by
/// `rangeOf(direction)`. The lowest and the highest channel must point straight down and up.
template <typename RangeOf>
Mesh aimedMesh(const Sensor& sensor, uint32_t step, const RangeOf& rangeOf) {
  const std::vector<Float3> beams = seenBeams(sensor);
  const auto rings = static_cast<uint32_t>((sensor.channels.size() - 1) / step);
  return closedShell(rings, sensor.columns / step, [&](uint32_t ring, uint32_t segment) {
    const Float3& d = beams[size_t{ring} * step * sensor.columns + size_t{segment} * step];
    const Vec3 direction = {d[0], d[1], d[2]};
    return along(direction, rangeOf(direction));
  });
}

/// Elevations from -90 to 90 degrees, both included.
inline Sensor allAround(uint32_t columns, uint32_t channels, double rangeMax = 200) {
  return gridSensor(columns, channels, -90, 90, rangeMax);
}

}  // namespace gnosphere::test
