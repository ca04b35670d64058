// SPDX-License-Identifier: Apache-2.0
#include "reference/results.hpp"

#include "effects/doppler.h"
#include "effects/trajectory.hpp"

namespace gnosphere::reference {

namespace {

constexpr float kMiss = std::numeric_limits<float>::quiet_NaN();

gpu::vec3 single(const Vec3& v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

void put(const Vec3& value, float* to) {
  to[0] = static_cast<float>(value.x);
  to[1] = static_cast<float>(value.y);
  to[2] = static_cast<float>(value.z);
}

/// The return of a beam that no effect touches.
gpu::Return plainReturn(const BeamEcho& echo) {
  gpu::Return value = {};
  value.range = value.trueRange = static_cast<float>(echo.range);
  value.label = gpu::kLabelSolid;
  return value;
}

}  // namespace

void clearResult(const SensorPlan& plan, size_t beams, Scan& scan) {
  const size_t count = beams * plan.returns;
  scan.returns = plan.returns;
  scan.points.assign(3 * count, kMiss);
  scan.ranges.assign(count, kMiss);
  scan.triangles.assign(count, kNoTriangle);
  scan.instances.assign(count, kNoTriangle);
  scan.ties.assign(count, 0);
  scan.tolerances.assign(count, kMiss);
  const auto wants = [&](bool asked, size_t size) { return asked ? size : 0; };
  const bool signal = plan.asks(gpu::kFieldSignal), surface = plan.asks(gpu::kFieldSurface);
  for (auto* array : {&scan.intensities, &scan.trueRanges, &scan.widths}) array->assign(wants(signal, count), kMiss);
  scan.labels.assign(wants(signal, count), 0);
  scan.causes.assign(wants(signal, beams), 0);
  scan.normals.assign(wants(surface, 3 * count), kMiss);
  scan.incidences.assign(wants(surface, count), kMiss);
  scan.materials.assign(wants(surface, count), kNoTriangle);
  scan.velocities.assign(wants(plan.speeds(), 3 * count), 0);
  scan.radialSpeeds.assign(wants(plan.speeds(), count), kMiss);
  scan.barycentrics.assign(wants(plan.asks(gpu::kFieldBarycentrics), 2 * count), kMiss);
}

struct Judge::Reported {
  Beam beam;
  Vec3 direction;      ///< in which points are reported, in the beam's frame
  SensorFrame frame;   ///< in which everything is reported
  SensorFrame column;  ///< of the sensor as the beam is fired

  Vec3 turned(const Vec3& v, bool deskew) const {
    if (!deskew) return v;
    const Vec3 world = column.directionToWorld(v);
    return {dot(frame.axes[0], world), dot(frame.axes[1], world), dot(frame.axes[2], world)};
  }
};

Judge::Judge(const View& view, const Shot& shot, const BeamEffects& effects)
    : view_(view),
      shot_(shot),
      effects_(effects),
      parameters_(effects.plan.parameters),
      volumes_(volumeBoxes(effects.plan.effects, shot.pose)),
      deskew_(effects.plan.has(gpu::kSensorMotion) && effects.plan.effects.sensorMotion.deskew) {
  parameters_.frame = static_cast<uint32_t>(shot.frame);
}

Cause Judge::judge(size_t index, Scan& scan) const {
  const SensorPlan& plan = effects_.plan;
  const bool moves = plan.has(gpu::kSensorMotion);
  const Beam beam = beamOf(view_.sensor, shot_, moves, index);
  BeamDoubt doubt;
  const std::vector<BeamEcho> met = echoesOf(view_, beam, effects_, parameters_, index, doubt);
  for (size_t at = index * plan.returns; at < (index + 1) * plan.returns; ++at) {
    scan.ties[at] = doubt.tie;
    if (!met.empty()) scan.tolerances[at] = static_cast<float>(doubt.tolerance);
  }
  Reported reported = {beam, beam.axis.direction, SensorFrame(shot_.pose), SensorFrame(beam.pose)};
  if (!plan.signals()) {
    if (!met.empty()) store(reported, plainReturn(met[0]), &met[0], index, scan);
    return met.empty() ? Cause::noSurface : Cause::returned;
  }

  std::vector<gpu::Echo> echoes;
  for (const BeamEcho& echo : met)
    echoes.push_back({static_cast<float>(echo.range), static_cast<float>(echo.energy), static_cast<float>(echo.width),
                      1, static_cast<uint32_t>(echoes.size())});
  std::vector<gpu::Return> returns(plan.returns);
  std::vector<gpu::VolumeBox> volumes;  // a sensor that moves sees the boxes move
  if (moves) volumes = volumeBoxes(effects_.plan.effects, beam.pose);
  gpu::BeamSignal signal = {plan.bits, echoes, returns, moves ? volumes : volumes_, effects_.plan.deadBeams};
  const gpu::vec3 direction = single(beam.axis.direction);
  const auto number = static_cast<uint32_t>(index);
  uint32_t count = 0;
  const uint32_t cause = signal.signalsOf(parameters_, number, direction, static_cast<uint32_t>(echoes.size()), count);
  if (plan.has(gpu::kAngleNoise) && parameters_.angleNoiseAt == gpu::kAngleAtPoint) {
    const gpu::vec3 astray = gpu::astray(direction, gpu::angleError(parameters_, number));
    reported.direction = {astray.x, astray.y, astray.z};
  }
  for (size_t k = 0; k < count; ++k) {
    const gpu::Return& value = returns[k];
    const BeamEcho* echo = value.label == gpu::kLabelSolid ? &met[value.echo] : nullptr;
    store(reported, value, echo, index * plan.returns + k, scan);
  }
  return static_cast<Cause>(cause);
}

void Judge::store(const Reported& reported, const gpu::Return& value, const BeamEcho* echo, size_t at,
                  Scan& scan) const {
  const double range = echo && value.range == static_cast<float>(echo->range) ? echo->range : value.range;
  const Vec3 point = reported.beam.origin + range * reported.direction;
  put(deskew_ ? reported.frame.toSensor(reported.column.position + reported.column.directionToWorld(point)) : point,
      &scan.points[3 * at]);
  scan.ranges[at] = static_cast<float>(range);
  if (echo) {
    const Triangle& triangle = view_.tree.triangles()[echo->hit.triangle];
    scan.triangles[at] = triangle.index;
    scan.instances[at] = triangle.instance;
  }
  if (!scan.labels.empty()) {
    scan.intensities[at] = value.intensity;
    scan.trueRanges[at] = value.trueRange;
    scan.widths[at] = value.width;
    scan.labels[at] = static_cast<uint8_t>(value.label);
  }
  if (echo) storeSurface(reported, *echo, at, scan);
  if (!scan.radialSpeeds.empty()) storeMotion(reported, echo, at, scan);
}

void Judge::storeSurface(const Reported& reported, const BeamEcho& echo, size_t at, Scan& scan) const {
  const Line& axis = reported.beam.axis;
  const Triangle triangle = view_.tree.sweeps().at(view_.tree.triangles()[echo.hit.triangle], axis.time);
  if (!scan.normals.empty()) {
    const Vec3 corners[3] = {axis.frame.toSensor(triangle.corners[0]), axis.frame.toSensor(triangle.corners[1]),
                             axis.frame.toSensor(triangle.corners[2])};
    const Vec3 normal = normalAgainst(axis.direction, corners);
    put(reported.turned(normal, deskew_), &scan.normals[3 * at]);
    scan.incidences[at] = static_cast<float>(std::acos(std::clamp(-dot(normal, axis.direction), 0.0, 1.0)));
    scan.materials[at] = materialOf(view_.scene, triangle);
  }
  if (!scan.barycentrics.empty()) {
    const auto [second, third] = barycentricsOf(triangle, echo.hit.weights);
    scan.barycentrics[2 * at] = static_cast<float>(second);
    scan.barycentrics[2 * at + 1] = static_cast<float>(third);
  }
}

void Judge::storeMotion(const Reported& reported, const BeamEcho* echo, size_t at, Scan& scan) const {
  if (!echo) return;
  const Line& axis = reported.beam.axis;
  const auto inColumn = [&](const Vec3& world) {
    const auto& axes = reported.column.axes;
    return Vec3{dot(axes[0], world), dot(axes[1], world), dot(axes[2], world)};
  };
  Vec3 velocity;
  const uint32_t sweep = view_.tree.triangles()[echo->hit.triangle].sweep;
  if (sweep != Triangle::kStill)
    for (size_t k = 0; k < 3; ++k)
      velocity = velocity + echo->hit.weights[k] * view_.tree.sweeps().velocities[sweep][k];
  const bool moves = effects_.plan.has(gpu::kSensorMotion);
  const Vec3 sensor = moves ? velocityAt(shot_.motion, axis.time) : Vec3{};
  scan.radialSpeeds[at] =
      gpu::radialSpeed(single(axis.direction), single(inColumn(velocity)), single(inColumn(sensor)));
  put(reported.turned(inColumn(velocity), deskew_), &scan.velocities[3 * at]);
}

}  // namespace gnosphere::reference
