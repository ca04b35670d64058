// SPDX-License-Identifier: Apache-2.0
// The actors that sensors of a drive file ignore, and the actors that they should perhaps ignore.
#include "base/vector.hpp"
#include "drive/drive_reader.hpp"
#include "drive/pose_math.hpp"

namespace gnosphere::drive {
namespace {

/// Whether a point in an actor's frame is in the box of the actor at rest.
bool isWithin(const Actor& actor, const Bounds& model, Vec3 point) {
  const Vec3 extent = model.max - model.min;
  if (actor.size)
    point = {point.x * extent.x / actor.size->x, point.y * extent.y / actor.size->y,
             point.z * extent.z / actor.size->z};
  return point.x > model.min.x && point.x < model.max.x && point.y > model.min.y && point.y < model.max.y &&
         point.z > model.min.z && point.z < model.max.z;
}

}  // namespace

/// Finds the actors that each sensor ignores. Instances of scenes that have boxes are among the actors.
void DriveReader::ignores() {
  std::vector<std::string> names;
  for (const Actor& actor : drive_.actors) names.push_back(actor.name);
  for (size_t i = 0; i < drive_.sensors.size(); ++i) {
    const nlohmann::json& listed = memberOf(root_["sensors"][i], "ignores");
    const std::string path = entryPath("sensors", i) + ".ignores";
    for (size_t k = 0; k < listed.size(); ++k)
      drive_.sensors[i].ignores.push_back(find(names, listed[k], entryPath(path, k)));
  }
  if (mistakes_.empty()) warnOfBodies();
}

/// Warns of sensors that start within the box of an actor which they do not ignore.
void DriveReader::warnOfBodies() {
  std::vector<Bounds> models;
  for (const Scene& model : drive_.models) models.push_back(worldBounds(model));
  for (size_t s = 0; s < drive_.sensors.size(); ++s) {
    const RigSensor& sensor = drive_.sensors[s];
    const Vec3 place = drive_.sensorPose(s, drive_.start).position;
    for (size_t a = 0; a < drive_.actors.size(); ++a) {
      const Actor& actor = drive_.actors[a];
      if (actor.goneOutside && !actor.trajectory.covers(drive_.start)) continue;
      if (sensor.isIgnored(a)) continue;
      if (isWithin(actor, models[actor.model], inverse(actor.trajectory.at(drive_.start)) * place))
        warn(entryPath("sensors", s), inQuotes(sensor.name) + " starts within the box of the actor " +
                                          inQuotes(actor.name) + ", and sees it from inside; \"ignores\": [\"" +
                                          actor.name + "\"] leaves the actor out of its scans");
    }
  }
}

}  // namespace gnosphere::drive
