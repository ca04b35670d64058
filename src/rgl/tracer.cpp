// SPDX-License-Identifier: Apache-2.0
#include "rgl/tracer.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <optional>

#include "rgl/scene.hpp"

namespace gnosphere::rgl {
namespace {

constexpr double kGreatestRange = 1e9;  // metres; the simulator drops what is farther
constexpr float kPartSize = 1000;       // metres: no origin in a cube of this size is 1 km from its centre

bool isUsable(const Ray& ray) {
  const double square = double{ray.direction.x} * ray.direction.x + double{ray.direction.y} * ray.direction.y +
                        double{ray.direction.z} * ray.direction.z;
  return std::isfinite(square) && square > 0 && std::isfinite(ray.origin.x + ray.origin.y + ray.origin.z) &&
         std::abs(ray.origin.x) + std::abs(ray.origin.y) + std::abs(ray.origin.z) < kGreatestRange;
}

Vec3 unitOf(const Vec& v) {
  const double norm = std::sqrt(double{v.x} * v.x + double{v.y} * v.y + double{v.z} * v.z);
  return {v.x / norm, v.y / norm, v.z / norm};
}

/// The pose of a map that is rigid but for rounding.
Pose poseOf(const Mat& a, const Vec& centre) {
  const auto m = [&](int i, int j) { return double{a.m[i][j]}; };
  Pose pose;
  pose.position = {m(0, 0) * centre.x + m(0, 1) * centre.y + m(0, 2) * centre.z + m(0, 3),
                   m(1, 0) * centre.x + m(1, 1) * centre.y + m(1, 2) * centre.z + m(1, 3),
                   m(2, 0) * centre.x + m(2, 1) * centre.y + m(2, 2) * centre.z + m(2, 3)};
  // The component that is greatest in size is found first, so that no small number divides the others.
  const double squares[4] = {1 + m(0, 0) - m(1, 1) - m(2, 2), 1 - m(0, 0) + m(1, 1) - m(2, 2),
                             1 - m(0, 0) - m(1, 1) + m(2, 2), 1 + m(0, 0) + m(1, 1) + m(2, 2)};
  const auto greatest = static_cast<int>(std::max_element(squares, squares + 4) - squares);
  const double s = 2 * std::sqrt(squares[greatest]);
  const double xy = (m(0, 1) + m(1, 0)) / s, xz = (m(0, 2) + m(2, 0)) / s, yz = (m(1, 2) + m(2, 1)) / s,
               wx = (m(2, 1) - m(1, 2)) / s, wy = (m(0, 2) - m(2, 0)) / s, wz = (m(1, 0) - m(0, 1)) / s;
  switch (greatest) {
    case 0: pose.orientation = {s / 4, xy, xz, wx}; break;
    case 1: pose.orientation = {xy, s / 4, yz, wy}; break;
    case 2: pose.orientation = {xz, yz, s / 4, wz}; break;
    default: pose.orientation = {wx, wy, wz, s / 4};
  }
  return pose;
}

}  // namespace

Tracer::~Tracer() {
  try {
    removeSensors();
  } catch (...) {  // a simulator that has lost its device keeps them
  }
}

void Tracer::removeSensors() {
  for (const Part& part : parts_) scene().removeSensor(part.sensor);
  parts_.clear();
}

void Tracer::addSensor(Simulator& simulator, Part& part, const std::vector<Ray>& rays, float range) {
  Vec low = rays[part.rays[0]].origin, high = low;
  for (const uint32_t i : part.rays) {
    const Vec& o = rays[i].origin;
    low = {std::min(low.x, o.x), std::min(low.y, o.y), std::min(low.z, o.z)};
    high = {std::max(high.x, o.x), std::max(high.y, o.y), std::max(high.z, o.z)};
  }
  part.centre = low == high ? low : (low + high) * 0.5f;
  BeamList beams;
  for (size_t k = 0; k < part.rays.size(); ++k) {
    const Ray& ray = rays[part.rays[k]];
    const bool repeated =
        k > 0 && ray.origin == rays[part.rays[k - 1]].origin && ray.direction == rays[part.rays[k - 1]].direction;
    if (!repeated) {
      beams.directions.push_back(unitOf(ray.direction));
      const Vec& o = ray.origin;
      if (low != high)
        beams.origins.push_back(
            {double{o.x} - part.centre.x, double{o.y} - part.centre.y, double{o.z} - part.centre.z});
    }
    part.beamOf.push_back(static_cast<uint32_t>(beams.size() - 1));
  }
  Sensor sensor;
  sensor.name = "rays";
  sensor.rangeMax = std::min(kGreatestRange, double{range});
  sensor.patterns.push_back(std::move(beams));
  part.sensor = simulator.addSensor({std::move(sensor), Effects::none()});
}

void Tracer::build(Simulator& simulator, const Key& key, const std::vector<Ray>& rays) {
  std::optional<Vec> first;
  bool together = true;
  for (const Ray& ray : rays) {
    if (!isUsable(ray)) continue;
    if (!first) first = ray.origin;
    together &= length(ray.origin - *first) < kPartSize / 2;
  }
  std::map<std::array<int64_t, 3>, Part> parts;
  for (uint32_t i = 0; i < rays.size(); ++i) {
    if (!isUsable(rays[i])) continue;
    const auto cell = [&](float x) { return together ? int64_t{0} : static_cast<int64_t>(std::floor(x / kPartSize)); };
    const Vec& o = rays[i].origin;
    parts[{cell(o.x), cell(o.y), cell(o.z)}].rays.push_back(i);
  }
  // The former sensors go last: what both they and the new ones need stays in the simulator.
  std::vector<Part> added;
  added.reserve(parts.size());
  try {
    for (auto& [cell, part] : parts) {
      addSensor(simulator, part, rays, key.range);
      added.push_back(std::move(part));
    }
  } catch (...) {
    for (const Part& part : added) simulator.removeSensor(part.sensor);
    throw;
  }
  removeSensors();
  parts_ = std::move(added);
  rayCount_ = rays.size();
  key_ = key;
  built_ = true;
  if (logs(RGL_LOG_LEVEL_DEBUG)) log(RGL_LOG_LEVEL_DEBUG, std::to_string(rays.size()) + " rays are sorted anew");
}

const std::vector<Hit>& Tracer::trace(const Key& key, const Mat& transform, int32_t sensorId,
                                      const std::function<std::vector<Ray>()>& rays) {
  if (scene().empty()) {
    hits_.clear();
    return hits_;
  }
  Simulator& simulator = scene().simulator(sensorId);
  if (!built_ || !(key == key_)) build(simulator, key, rays());
  hits_.assign(rayCount_, {});
  for (const Part& part : parts_) {
    Shot shot;
    shot.pose = poseOf(transform, part.centre);
    shot.sensor = part.sensor;
    simulator.scanInto(shot, scan_);
    for (size_t k = 0; k < part.rays.size(); ++k) {
      const uint32_t beam = part.beamOf[k];
      hits_[part.rays[k]] = {scan_.instances[beam], scan_.triangles[beam]};
    }
  }
  return hits_;
}

}  // namespace gnosphere::rgl
