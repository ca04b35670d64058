// SPDX-License-Identifier: Apache-2.0
#include "shot_checks.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/finite.hpp"
#include "base/quaternion.hpp"
#include "base/text.hpp"
#include "gnosphere/error.hpp"
#include "scan/fields.hpp"
#include "scan/layout.hpp"
#include "sensor/beams.hpp"

namespace gnosphere {

void validate(const AccuracyParts& parts) {
  if ((parts.range == AccuracyParts::Range::exact) != (parts.inside == AccuracyParts::Inside::exact))
    throw Error(ErrorCode::invalidArgument, "an exact range needs the exact inside test, and the other way round");
}

void validate(const Pose& pose, const std::string& which) {
  const auto& [p, q] = pose;
  if (!allFinite(std::array{p.x, p.y, p.z, q.x, q.y, q.z, q.w}))
    throw Error(ErrorCode::invalidArgument, which + "the pose has a value that is not finite");
  if (isZero(q)) throw Error(ErrorCode::invalidArgument, which + "the pose's quaternion is zero; 0,0,0,1 is no turn");
}

void validate(const Transform& transform, size_t instance, const std::string& which) {
  if (!allFinite(transform.rows))
    throw Error(ErrorCode::invalidArgument,
                which + "instance " + std::to_string(instance) + ": its transform is not finite");
}

void validate(const SensorMotion& motion, const std::string& which) {
  for (size_t i = 0; i < motion.stamps.size(); ++i) {
    const auto& [time, pose] = motion.stamps[i];
    validate(pose, which + "stamp " + std::to_string(i) + ": ");
    if (!std::isfinite(time) || (i > 0 && !(time > motion.stamps[i - 1].time)))
      throw Error(ErrorCode::invalidArgument,
                  which + "the time of stamp " + std::to_string(i) + " does not come after the one before");
  }
}

void checkTimes(const SensorMotion& motion, const Sensor& sensor, uint64_t frame, const std::string& which) {
  if (motion.stamps.size() < 2 || !firesInTurn(sensor)) return;
  const ScanTimes times = scanTimesOf(sensor, true, frame);
  const double first = motion.stamps.front().time, last = motion.stamps.back().time;
  if (first <= times.last && last >= times.earliest) return;
  throw Error(ErrorCode::invalidArgument, which + "the motion is from " + numberText(first) + " to " +
                                              numberText(last) + " s, and the beams fire from " +
                                              numberText(times.earliest) + " to " + numberText(times.last) +
                                              " s; stamps count from the start of the scan");
}

void checkSensorOfBatch(std::span<const Shot> shots) {
  for (size_t i = 0; i < shots.size(); ++i)
    if (shots[i].sensor != shots[0].sensor)
      throw Error(ErrorCode::invalidArgument, "shot " + std::to_string(i) + " is one of sensor " +
                                                  std::to_string(shots[i].sensor) + ", the first one of sensor " +
                                                  std::to_string(shots[0].sensor) +
                                                  "; a batch has one sensor, so make a batch for each");
}

// How far the instance moves during the scan would bound what it may hide, and only the device knows it.
void refuseMotion(size_t instance, const std::string& which) {
  throw Error(ErrorCode::invalidArgument,
              which + "the transform of instance " + std::to_string(instance) +
                  " comes from a buffer, so neither it nor its mesh can move during a scan; "
                  "Simulator::setTransform() sets the transform from the host again");
}

SensorRequest withFieldsOfLayout(SensorRequest request) {
  for (const Field field : fieldsOf(request.layout))
    if (std::find(request.fields.begin(), request.fields.end(), field) == request.fields.end())
      request.fields.push_back(field);
  return request;
}

std::vector<Field> fieldsOfBatch(const SensorRequest& request, const DeviceChoice& device, size_t sensor,
                                 std::span<const Field> asked) {
  std::vector<Field> known = request.fields;
  for (size_t i = 0; i < kFieldCount; ++i)
    if (isOfEveryScan(static_cast<Field>(i))) known.push_back(static_cast<Field>(i));
  if (hasRings(request.sensor)) known.push_back(Field::ring);
  if (device.kind == DeviceChoice::Kind::reference) known.insert(known.end(), {Field::tie, Field::tolerance});
  for (const Field field : asked)
    if (std::find(known.begin(), known.end(), field) == known.end())
      throw Error(ErrorCode::invalidArgument, std::string("the batch asks for field '") + fieldInfo(field).name +
                                                  "', which sensor " + std::to_string(sensor) +
                                                  " does not report; add it to the fields of the sensor");
  return asked.empty() ? known : std::vector<Field>(asked.begin(), asked.end());
}

}  // namespace gnosphere
