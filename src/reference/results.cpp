// SPDX-License-Identifier: Apache-2.0
#include "reference/results.hpp"

#include "base/vector.hpp"
#include "effects/trajectory.hpp"
#include "scan/columns.hpp"

namespace gnosphere::reference {

namespace {

void put(const Vec3& value, float* to) {
  to[0] = static_cast<float>(value.x);
  to[1] = static_cast<float>(value.y);
  to[2] = static_cast<float>(value.z);
}

/// Rotates a direction about the vertical axis and away from the horizon, by radians.
Vec3 turnedBy(const Vec3& direction, double azimuth, double elevation) {
  const double az = std::atan2(direction.y, direction.x) + azimuth;
  const double el = std::atan2(direction.z, lengthOf(direction.x, direction.y)) + elevation;
  return {std::cos(el) * std::cos(az), std::cos(el) * std::sin(az), std::sin(el)};
}

}  // namespace

struct Judge::Reported {
  Beam beam;
  Vec3 direction;      ///< in which points are reported, in the beam's frame
  Vec3 light;          ///< in which the light leaves, in the beam's frame
  SensorFrame frame;   ///< in which everything is reported
  SensorFrame column;  ///< of the sensor when the beam is fired

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
      receiver_(effects.plan, shot),
      silent_(silentBeams(view.sensor)),
      deskew_(effects.plan.has(gpu::kSensorMotion) && effects.plan.effects.sensorMotion.deskew) {}

Cause Judge::judge(size_t index, Scan& scan, uint64_t& lost) const {
  const SensorPlan& plan = effects_.plan;
  const bool moves = plan.has(gpu::kSensorMotion);
  const Beam beam = beamOf(view_.sensor, shot_, moves, index);
  const Light light = lightOf(beam, plan, receiver_, index);
  BeamDoubt doubt;
  std::vector<Echo> met;
  if (!silent_[index]) met = echoesOf(view_, beam, light, effects_, doubt, lost);
  // Without the receiver a beam has one echo.
  if (!plan.signals() && !met.empty() && less(met[0].range, given(beam.least), doubt.tie)) met.clear();
  Judgement judged;
  if (silent_[index]) {
    judged.cause = Cause::dead;
  } else if (plan.signals()) {
    judged = receiver_.judge(index, beam.axis, beam.least, met, doubt.tie);
  } else if (!met.empty()) {
    judged = {{{met[0].range, met[0].range.value, 0, 0, met[0].hit}}, Cause::returned};
  }
  Reported reported = {beam, beam.axis.direction, light.direction, SensorFrame(shot_.pose), SensorFrame(beam.pose)};
  if (plan.has(gpu::kAngleNoise) && !plan.has(gpu::kStrays)) {
    const auto [azimuth, elevation] = receiver_.angleError(index);
    reported.direction = turnedBy(reported.direction, azimuth.value, elevation.value);
  }
  const ScanColumns columns(scan);
  uint8_t* const causes = columns.data<uint8_t>(Field::cause);
  for (size_t k = 0; k < plan.returns; ++k) {
    const size_t at = index * plan.returns + k;
    columns.data<uint8_t>(Field::tie)[at] = doubt.tie;
    if (!met.empty()) columns.data<float>(Field::tolerance)[at] = static_cast<float>(doubt.tolerance);
    if (causes) causes[at] = static_cast<uint8_t>(judged.cause);
    if (k < judged.returns.size()) store(reported, judged.returns[k], at, scan);
  }
  return judged.cause;
}

void Judge::store(const Reported& reported, const Return& value, size_t at, Scan& scan) const {
  const Vec3 point = reported.beam.origin + value.range.value * reported.direction;
  put(deskew_ ? reported.frame.toSensor(reported.column.position + reported.column.directionToWorld(point)) : point,
      &scan.points[3 * at]);
  scan.ranges[at] = static_cast<float>(value.range.value);
  const ScanColumns columns(scan);
  // The range of the reference is rounded, too, when it is stored.
  columns.data<float>(Field::tolerance)[at] =
      static_cast<float>(value.range.error + kUnitRoundoff * std::abs(value.range.value));
  const bool solid = value.hit.triangle != kNobody;
  if (float* const intensities = columns.data<float>(Field::intensity))
    intensities[at] = static_cast<float>(value.intensity);
  if (columns.data<uint8_t>(Field::label)) {
    columns.data<float>(Field::trueRange)[at] = static_cast<float>(value.trueRange);
    columns.data<float>(Field::width)[at] = static_cast<float>(value.width);
    columns.data<uint8_t>(Field::label)[at] = static_cast<uint8_t>(solid ? Label::solid : Label::scatter);
  }
  if (columns.data<float>(Field::radialSpeed)) storeMotion(reported, value, at, scan);
  if (!solid) return;
  const Triangle& triangle = view_.tree.triangles()[value.hit.triangle];
  scan.triangles[at] = triangle.index;
  scan.instances[at] = triangle.instance;
  storeSurface(reported, value.hit, at, scan);
}

void Judge::storeSurface(const Reported& reported, const Hit& hit, size_t at, Scan& scan) const {
  const Line& axis = reported.beam.axis;
  const Triangle triangle = view_.tree.sweeps().at(view_.tree.triangles()[hit.triangle], axis.time);
  const ScanColumns columns(scan);
  if (float* const normals = columns.data<float>(Field::normal)) {
    const Vec3 corners[3] = {axis.frame.toSensor(triangle.corners[0]), axis.frame.toSensor(triangle.corners[1]),
                             axis.frame.toSensor(triangle.corners[2])};
    const Vec3 normal = normalTowardsOrigin(corners);
    put(reported.turned(normal, deskew_), normals + 3 * at);
    columns.data<float>(Field::incidence)[at] =
        static_cast<float>(std::acos(std::clamp(-dot(normal, axis.direction), 0.0, 1.0)));
    columns.data<uint32_t>(Field::material)[at] = materialOf(view_.scene, triangle);
  }
  if (float* const barycentrics = columns.data<float>(Field::barycentrics)) {
    const auto [second, third] = barycentricsOf(triangle, hit.weights);
    barycentrics[2 * at] = static_cast<float>(second);
    barycentrics[2 * at + 1] = static_cast<float>(third);
  }
}

void Judge::storeMotion(const Reported& reported, const Return& value, size_t at, Scan& scan) const {
  const Hit& hit = value.hit;
  const Line& axis = reported.beam.axis;
  const ScanColumns columns(scan);
  const auto inColumn = [&](const Vec3& world) {
    const auto& axes = reported.column.axes;
    return Vec3{dot(axes[0], world), dot(axes[1], world), dot(axes[2], world)};
  };
  Vec3 velocity;  // 0 of fog, drops, flakes and dust
  const uint32_t sweep = hit.triangle != kNobody ? view_.tree.triangles()[hit.triangle].sweep : Triangle::kStill;
  if (sweep != Triangle::kStill)
    for (size_t k = 0; k < 3; ++k) velocity = velocity + hit.weights[k] * view_.tree.sweeps().velocities[sweep][k];
  // The sensor's velocity counts even without sensor-motion: a sensor that fires all beams at once measures its own
  // speed.
  const Vec3 sensor = inColumn(velocityAt(shot_.motion, axis.time)),
             arm = cross(angularVelocityAt(shot_.motion, axis.time), reported.beam.origin);
  columns.data<float>(Field::radialSpeed)[at] =
      static_cast<float>(dot(reported.light, inColumn(velocity) - (sensor + arm)) + value.speedError);
  put(reported.turned(inColumn(velocity), deskew_), columns.data<float>(Field::velocity) + 3 * at);
}

}  // namespace gnosphere::reference
