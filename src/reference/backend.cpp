// SPDX-License-Identifier: Apache-2.0
// Every beam against every triangle it may meet, in double: the oracle that judges the other backends. It is written
// from the mathematics and shares nothing with the shaders.
#include "backend.hpp"

#include <atomic>
#include <chrono>
#include <thread>
#include <utility>

#include "effects/planned.hpp"
#include "gnosphere/error.hpp"
#include "reference/bvh.hpp"
#include "reference/doubt.hpp"

namespace gnosphere {

namespace {

using namespace reference;

/// Further out, in the mesh's or in the sensor's frame, a coordinate counts as broken.
constexpr double kFarthest = 1e9;
/// Further out in the world a double no longer resolves a decimetre; broken from whatever pose.
constexpr double kFarthestWorld = 1e15;
/// A matrix worse than this is for no single-precision simulator; more would only fatten every beam.
constexpr double kWorstCondition = 1e3;

bool within(const Vec3& p, double limit) {  // false for NaN
  return std::abs(p.x) <= limit && std::abs(p.y) <= limit && std::abs(p.z) <= limit;
}

double determinant(const Transform& t) {
  const auto& m = t.rows;
  return m[0] * (m[5] * m[10] - m[6] * m[9]) - m[1] * (m[4] * m[10] - m[6] * m[8]) + m[2] * (m[4] * m[9] - m[5] * m[8]);
}

/// How much larger than for a rotation the error of matrix * (x - pivot) may be, for a given distance of the result.
/// Rounding is relative to each column's contribution, so scaling along the mesh's own axes is harmless and only the
/// angles between the columns count: with unit columns in B it is |B| |B^-1| / 3 in Frobenius norms, 1 for a rotation.
double condition(const Transform& t) {
  Vec3 columns[3];
  int empty = -1, emptyCount = 0;
  for (int k = 0; k < 3; ++k) {
    columns[k] = {t.rows[k], t.rows[4 + k], t.rows[8 + k]};
    const double length = norm(columns[k]);
    if (length > 0) {
      columns[k] = (1 / length) * columns[k];
    } else {
      empty = k;
      ++emptyCount;
    }
  }
  if (emptyCount > 1) return 1;  // a line or a point: nothing to hit
  if (emptyCount == 1) {         // a flattened mesh: the missing column adds no error
    const Vec3 n = cross(columns[(empty + 1) % 3], columns[(empty + 2) % 3]);
    columns[empty] = (1 / std::max(norm(n), 1e-30)) * n;
  }
  double squares = 0;
  for (int k = 0; k < 3; ++k) {
    const Vec3 row = cross(columns[(k + 1) % 3], columns[(k + 2) % 3]);
    squares += dot(row, row);
  }
  const double volume = std::abs(dot(columns[0], cross(columns[1], columns[2])));
  return std::clamp(std::sqrt(squares / 3) / std::max(volume, 1e-30), 1.0, kWorstCondition);
}

/// What is known of an instance before there is a pose.
struct Place {
  double condition = 1;
  Vec3 origin;  ///< of the mesh, in the world
};

/// The absolute part of a corner's error: 1e-9 m, some roundings of the world's doubles (2^-53 each), and what is left
/// of a pivot that is split into a float and a float remainder (2^-48) and moved through a rounded matrix.
double absoluteError(const Place& place, const Vec3& position) {
  return 1e-9 + 0x1p-48 * (norm(place.origin) + norm(position)) + 0x1p-45 * norm(place.origin - position);
}

/// The triangles of one instance, put in the world.
void placeInstance(const Scene& scene, uint32_t index, Faces faces, std::vector<Triangle>& triangles,
                   Counters& counters) {
  const Instance& instance = scene.instances[index];
  const Mesh& mesh = scene.meshes[instance.mesh];
  std::vector<Vec3> world(mesh.vertexCount());
  std::vector<uint8_t> broken(mesh.vertexCount());
  for (size_t v = 0; v < world.size(); ++v) {
    const float* p = &mesh.positions[3 * v];
    const Vec3 local = mesh.origin + Vec3{p[0], p[1], p[2]};
    world[v] = instance.transform * local;
    broken[v] = !within(local, kFarthest) || !within(world[v], kFarthestWorld);
  }
  const auto samePoint = [&](uint32_t a, uint32_t b) {
    const float* p = &mesh.positions[3 * size_t{a}];
    const float* q = &mesh.positions[3 * size_t{b}];
    return p[0] == q[0] && p[1] == q[1] && p[2] == q[2];
  };
  const int8_t outside = determinant(instance.transform) < 0 ? 1 : -1;
  size_t part = 0;
  for (size_t t = 0; t < mesh.triangleCount(); ++t) {
    const uint32_t* corner = &mesh.indices[3 * t];
    if (broken[corner[0]] || broken[corner[1]] || broken[corner[2]]) {
      ++counters.nonFinite;
      continue;
    }
    if (samePoint(corner[0], corner[1]) || samePoint(corner[1], corner[2]) || samePoint(corner[2], corner[0])) {
      ++counters.degenerate;
      continue;
    }
    while (part < mesh.parts.size() && t >= size_t{mesh.parts[part].firstTriangle} + mesh.parts[part].triangleCount)
      ++part;
    const bool oneSided = faces == Faces::front || (faces == Faces::material && part < mesh.parts.size() &&
                                                    !scene.materials[mesh.parts[part].material].doubleSided);
    Triangle placed = {{world[corner[0]], world[corner[1]], world[corner[2]]}, index, static_cast<uint32_t>(t), 0};
    int8_t turn = outside;
    const auto order = [&](Vec3& a, Vec3& b) {
      if (!before(b, a)) return;
      std::swap(a, b);
      turn = static_cast<int8_t>(-turn);
    };
    order(placed.corners[0], placed.corners[1]);
    order(placed.corners[1], placed.corners[2]);
    order(placed.corners[0], placed.corners[1]);
    if (oneSided) placed.front = turn;
    triangles.push_back(placed);
  }
}

std::vector<Triangle> placeAll(const Scene& scene, Faces faces, Counters& counters) {
  std::vector<Triangle> triangles;
  counters.triangles = scene.placedTriangleCount();
  triangles.reserve(counters.triangles);
  for (uint32_t i = 0; i < scene.instances.size(); ++i) placeInstance(scene, i, faces, triangles, counters);
  return triangles;
}

unsigned threadCount() {
  return std::max(1u, std::thread::hardware_concurrency());
}

/// Calls `work(first, last)` for runs of indices until all are done, on every thread of the machine.
template <typename Work>
void onAllThreads(size_t count, const Work& work) {
  constexpr size_t kRun = 1024;
  std::atomic<size_t> next = 0;
  const auto loop = [&] {
    for (size_t first = next.fetch_add(kRun); first < count; first = next.fetch_add(kRun))
      work(first, std::min(count, first + kRun));
  };
  std::vector<std::jthread> threads;
  for (size_t i = 1; i < threadCount() && i * kRun < count; ++i) threads.emplace_back(loop);
  loop();
}

/// What all beams of one scan share.
struct View {
  const Sensor& sensor;
  SensorFrame frame;
  std::vector<CornerError> errors;  ///< per instance
  std::vector<uint8_t> dropped;     ///< per triangle of the tree: out of bounds from this pose; empty if none is
  double spread = 0;                ///< of the fat beam that finds every triangle in doubt
  double floor = 0;
};

constexpr uint32_t kNobody = kNoTriangle;

struct Nearest {
  uint32_t triangle = kNobody;  ///< in the tree
  double range = 0;
};

class ReferenceBackend : public Backend {
 public:
  ReferenceBackend(const Scene& scene, const std::vector<Sensor>& sensors, const SimulatorOptions& options)
      : sensors_(sensors), faces_(options.faces), scene_(scene), device_(referenceDevice()) {
    for (const Sensor& sensor : sensors) {
      planned_.push_back(planEffects(options, sensor, scene));
      if (!planned_.back().bare())
        throw Error(ErrorCode::invalidArgument, "the reference does not simulate effects; use --effects clean");
    }
    scene_.meshes.emplace_back();
    build();
  }

  void scanAll(std::span<const Shot> shots, Scan& result, const std::function<void(size_t)>& receive) override;
  Plan plan(size_t sensor) const override;
  const DeviceInfo& device() const override { return device_; }
  MemoryUse memory() const override { return {bvh_.bytes() + places_.size() * sizeof(Place), 0, 0}; }
  size_t clusterCount() const override { return 0; }
  void setInstance(size_t index, uint32_t mesh, const Transform& transform) override;
  void setPositions(size_t mesh, std::span<const float> positions) override;

 private:
  void build();
  void scan(const Shot& shot, Scan& result) const;
  View prepare(const Sensor& sensor, const Pose& pose, Counters& counters) const;
  Nearest nearest(const View& view, const Vec3& direction) const;
  bool inDoubt(const View& view, const Vec3& direction, const Nearest& hit, double& tolerance) const;
  void beam(const View& view, size_t index, Scan& scan) const;

  std::vector<Sensor> sensors_;
  std::vector<PlannedEffects> planned_;  // of each sensor
  Faces faces_;
  Scene scene_;  // its last mesh is empty: that of instances that were removed
  bool changed_ = false;
  Counters counters_;
  Bvh bvh_ = Bvh({});
  std::vector<Place> places_;
  DeviceInfo device_;
};

Plan ReferenceBackend::plan(size_t sensor) const {
  Plan plan;
  plan.effects = planned_[sensor].decisions;
  plan.returns = planned_[sensor].returns;
  return plan;
}

void ReferenceBackend::build() {
  counters_ = {};
  bvh_ = Bvh(placeAll(scene_, faces_, counters_));
  places_.clear();
  for (const Instance& instance : scene_.instances)
    places_.push_back({condition(instance.transform), instance.transform * scene_.meshes[instance.mesh].origin});
  changed_ = false;
}

void ReferenceBackend::setInstance(size_t index, uint32_t mesh, const Transform& transform) {
  if (index == scene_.instances.size()) scene_.instances.emplace_back();
  const auto none = static_cast<uint32_t>(scene_.meshes.size() - 1);
  scene_.instances[index] = {"", mesh == kNoMesh ? none : mesh, transform};
  changed_ = true;
}

void ReferenceBackend::setPositions(size_t mesh, std::span<const float> positions) {
  scene_.meshes[mesh].positions.assign(positions.begin(), positions.end());
  changed_ = true;
}

View ReferenceBackend::prepare(const Sensor& sensor, const Pose& pose, Counters& counters) const {
  View view = {sensor, SensorFrame(pose), {}, {}, 0, 0};
  for (const Place& place : places_) {
    const CornerError error = {kCornerError * place.condition, absoluteError(place, pose.position)};
    view.errors.push_back(error);
    view.spread = std::max(view.spread, error.relative);
    view.floor = std::max(view.floor, error.absolute);
  }
  const Box bounds = bvh_.bounds();
  if (bvh_.triangles().empty()) return view;
  const Vec3 low = bounds.min - pose.position, high = bounds.max - pose.position;
  // The distance bounds every coordinate in any orientation; half as far is safe without a look at each triangle.
  if (norm({std::max(-low.x, high.x), std::max(-low.y, high.y), std::max(-low.z, high.z)}) < 0.5 * kFarthest)
    return view;
  view.dropped.resize(bvh_.triangles().size());
  for (size_t i = 0; i < view.dropped.size(); ++i)
    for (const Vec3& corner : bvh_.triangles()[i].corners)
      if (!within(view.frame.toSensor(corner), kFarthest)) view.dropped[i] = 1;
  for (uint8_t dropped : view.dropped) counters.nonFinite += dropped;
  return view;
}

Nearest ReferenceBackend::nearest(const View& view, const Vec3& direction) const {
  // The double rounding of the ray, of the corners' way into the sensor frame and of the range.
  constexpr double kRounding = 0x1p-46;
  const Ray ray(view.frame.position, view.frame.directionToWorld(direction), kRounding, 0);
  Nearest best;
  bvh_.walk(ray, view.sensor.rangeMax, [&](uint32_t i, double limit) {
    if (!view.dropped.empty() && view.dropped[i]) return limit;
    const Triangle& triangle = bvh_.triangles()[i];
    const Vec3 a = view.frame.toSensor(triangle.corners[0]);
    const Vec3 b = view.frame.toSensor(triangle.corners[1]);
    const Vec3 c = view.frame.toSensor(triangle.corners[2]);
    const Pierce hit = pierce(direction, a, b, c);
    if (!hit.inside || (triangle.front != 0 && (hit.facing > 0) != (triangle.front > 0))) return limit;
    if (!(hit.range > 0) || hit.range < view.sensor.rangeMin || hit.range > view.sensor.rangeMax) return limit;
    if (best.triangle != kNobody) {
      const Triangle& other = bvh_.triangles()[best.triangle];
      if (hit.range > best.range) return limit;
      if (hit.range == best.range &&
          std::pair(other.instance, other.index) < std::pair(triangle.instance, triangle.index))
        return limit;
    }
    best = {i, hit.range};
    return hit.range;
  });
  return best;
}

/// A beam is a tie unless exactly one triangle may be its owner and must be hit, or no triangle may be hit: that is,
/// its owner's hit is not certain, or a second triangle may report a range no farther than the owner may.
bool ReferenceBackend::inDoubt(const View& view, const Vec3& direction, const Nearest& hit, double& tolerance) const {
  const Across across(direction);
  const auto look = [&](const Triangle& triangle) {
    const Vec3 corners[3] = {view.frame.toSensor(triangle.corners[0]), view.frame.toSensor(triangle.corners[1]),
                             view.frame.toSensor(triangle.corners[2])};
    return doubtOf(across, corners, triangle.front, view.errors[triangle.instance], view.sensor);
  };
  double farthest = view.sensor.rangeMax;
  if (hit.triangle != kNobody) {
    const Doubt owner = look(bvh_.triangles()[hit.triangle]);
    tolerance = std::max({hit.range - owner.nearest, owner.farthest - hit.range, kUnitRoundoff * hit.range});
    if (!owner.certain) return true;
    farthest = std::min(farthest, owner.farthest);
  }
  // Twice the reach and the place error: across the beam and along it.
  const auto fat = [&](const CornerError& error) {
    return Ray(view.frame.position, view.frame.directionToWorld(direction), 2 * (error.relative + kDirectionError),
               2 * error.absolute);
  };
  bool doubt = false;
  bvh_.walk(fat({view.spread, view.floor}), farthest, [&](uint32_t i, double limit) {
    if (i == hit.triangle || (!view.dropped.empty() && view.dropped[i])) return limit;
    const Triangle& triangle = bvh_.triangles()[i];
    // Its own box as well, so that the answer does not depend on what else shares the leaf.
    if (fat(view.errors[triangle.instance]).enter(boxOf(triangle)) > limit) return limit;
    const Doubt other = look(triangle);
    doubt = other.possible && other.nearest <= farthest;
    return doubt ? -1.0 : limit;
  });
  return doubt;
}

void ReferenceBackend::beam(const View& view, size_t index, Scan& scan) const {
  const Vec3 direction = view.sensor.direction(index);
  const Nearest hit = nearest(view, direction);
  double tolerance = std::numeric_limits<double>::quiet_NaN();
  scan.ties[index] = inDoubt(view, direction, hit, tolerance);
  scan.tolerances[index] = static_cast<float>(tolerance);
  if (hit.triangle == kNobody) return;
  const Triangle& triangle = bvh_.triangles()[hit.triangle];
  const Vec3 point = hit.range * direction;
  scan.points[3 * index] = static_cast<float>(point.x);
  scan.points[3 * index + 1] = static_cast<float>(point.y);
  scan.points[3 * index + 2] = static_cast<float>(point.z);
  scan.ranges[index] = static_cast<float>(hit.range);
  scan.triangles[index] = triangle.index;
  scan.instances[index] = triangle.instance;
}

void ReferenceBackend::scanAll(std::span<const Shot> shots, Scan& result, const std::function<void(size_t)>& receive) {
  if (changed_) build();
  for (size_t i = 0; i < shots.size(); ++i) {
    scan(shots[i], result);
    receive(i);
  }
}

void ReferenceBackend::scan(const Shot& shot, Scan& scan) const {
  const auto start = std::chrono::steady_clock::now();
  const Sensor& sensor = sensors_.at(shot.sensor);
  const Pose& pose = shot.pose;
  const Quaternion& q = pose.orientation;
  if (!(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w > 0))
    throw Error(ErrorCode::invalidArgument, "the pose's orientation has no length; use 0 0 0 1 for no rotation");
  const size_t beams = sensor.beamCount();
  constexpr float kMiss = std::numeric_limits<float>::quiet_NaN();
  scan.points.assign(3 * beams, kMiss);
  scan.ranges.assign(beams, kMiss);
  scan.triangles.assign(beams, kNoTriangle);
  scan.instances.assign(beams, kNoTriangle);
  scan.ties.assign(beams, 0);
  scan.tolerances.assign(beams, kMiss);
  scan.counters = counters_;
  scan.timings = {};
  const View view = prepare(sensor, pose, scan.counters);
  onAllThreads(beams, [&](size_t first, size_t last) {
    for (size_t i = first; i < last; ++i) beam(view, i, scan);
  });
  scan.counters.beams = beams;
  for (uint32_t triangle : scan.triangles) scan.counters.hits += triangle != kNoTriangle;
  scan.counters.misses = beams - scan.counters.hits;
  scan.timings.wallMs = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace

std::unique_ptr<Backend> makeReferenceBackend(const Scene& scene, const std::vector<Sensor>& sensors,
                                              const SimulatorOptions& options) {
  return std::make_unique<ReferenceBackend>(scene, sensors, options);
}

DeviceInfo referenceDevice() {
  DeviceInfo info;
  info.name = "reference";
  info.type = "reference";
  const unsigned threads = threadCount();
  info.driver = "double precision on the CPU, " + std::to_string(threads) + (threads == 1 ? " thread" : " threads");
  info.usable = true;
  return info;
}

}  // namespace gnosphere
