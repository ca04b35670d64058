// SPDX-License-Identifier: Apache-2.0
#include "drive/formats/osi_ground_truth.hpp"

#include <algorithm>
#include <string_view>

#include "base/text.hpp"
#include "base/vector.hpp"
#include "drive/formats/format.hpp"
#include "drive/formats/osi_messages.hpp"

namespace gnosphere::drive::osi {
namespace {

// The numbers of the fields that are written, by message.
// osi_common.proto
enum class Dimension3d : Tag { length = 1, width = 2, height = 3 };
enum class BaseStationary : Tag { dimension = 1, position = 2, orientation = 3 };
enum class BaseMoving : Tag { dimension = 1, position = 2, orientation = 3, velocity = 4, acceleration = 5 };
// osi_object.proto
enum class StationaryClassification : Tag { type = 1 };
enum class StationaryObject : Tag { id = 1, base = 2, classification = 3 };
enum class VehicleAttributes : Tag { bbcenterToRear = 4 };
enum class VehicleClassification : Tag { type = 1, role = 5 };
enum class MovingObject : Tag {
  id = 1,
  base = 2,
  type = 3,
  vehicleAttributes = 5,
  vehicleClassification = 6,
  pedestrianAttributes = 12
};
// osi_groundtruth.proto
enum class GroundTruth : Tag { version = 1, timestamp = 2, hostVehicleId = 3, stationaryObject = 4, movingObject = 5 };

// Values of MovingObject.Type, and the value of VehicleClassification.Type, its Role and StationaryObject's Type for
// anything that has no value of its own. "Unknown" is not allowed in ground truth.
constexpr int32_t kOtherObject = 1, kVehicle = 2, kPedestrian = 3, kAnimal = 4;
constexpr int32_t kOther = 1;

struct Kind {
  int32_t type = kOtherObject;  ///< MovingObject.Type
  int32_t vehicle = kOther;     ///< VehicleClassification.Type
};
struct NamedKind {
  std::string_view name;
  Kind kind;
};

/// The names of classes that say what an object is, in plain words and as nuScenes and SemanticKITTI have them. A
/// class that begins with one of the names and a point, such as vehicle.emergency.police, is of its kind.
constexpr NamedKind kKinds[] = {
    {"vehicle", {kVehicle}},
    {"other-vehicle", {kVehicle}},
    {"van", {kVehicle}},
    {"car", {kVehicle, 4}},
    {"vehicle.car", {kVehicle, 4}},
    {"truck", {kVehicle, 7}},
    {"vehicle.truck", {kVehicle, 7}},
    {"trailer", {kVehicle, 9}},
    {"vehicle.trailer", {kVehicle, 9}},
    {"motorcycle", {kVehicle, 10}},
    {"motorbike", {kVehicle, 10}},
    {"vehicle.motorcycle", {kVehicle, 10}},
    {"motorcyclist", {kVehicle, 10}},
    {"bicyclist", {kVehicle, 11}},
    {"bicycle", {kVehicle, 11}},
    {"vehicle.bicycle", {kVehicle, 11}},
    {"bus", {kVehicle, 12}},
    {"vehicle.bus", {kVehicle, 12}},
    {"tram", {kVehicle, 13}},
    {"train", {kVehicle, 14}},
    {"on-rails", {kVehicle}},
    {"person", {kPedestrian}},
    {"pedestrian", {kPedestrian}},
    {"human.pedestrian", {kPedestrian}},
    {"animal", {kAnimal}},
};

Kind kindOf(const std::string& category) {
  std::string name = lower(category);
  while (true) {
    const auto found = std::ranges::find(kKinds, std::string_view(name), &NamedKind::name);
    if (found != std::end(kKinds)) return found->kind;
    const size_t point = name.rfind('.');
    if (point == name.npos) return {};
    name.resize(point);
  }
}

/// An object as both kinds of base have it: without a size only its origin is known.
struct Place {
  std::optional<Vec3> size;
  Pose middle;
  Vec3 velocity, acceleration;
};

template <typename Base>
void addPlace(Builder<Base>& base, const Place& place) {
  if (place.size) {
    Builder<Dimension3d> size(base, Base::dimension);
    size.add_double(Dimension3d::length, place.size->x);
    size.add_double(Dimension3d::width, place.size->y);
    size.add_double(Dimension3d::height, place.size->z);
  }
  addVector(base, Base::position, place.middle.position);
  addOrientation(base, Base::orientation, place.middle.orientation);
}

/// Adds an object that may move. `toRear` leads from the middle of the host vehicle to the origin of its frame.
void addMoving(Builder<GroundTruth>& message, uint64_t id, const Place& place, const Kind& kind,
               const std::optional<Vec3>& toRear) {
  Builder<MovingObject> object(message, GroundTruth::movingObject);
  addIdentifier(object, MovingObject::id, id);
  {
    Builder<BaseMoving> base(object, MovingObject::base);
    addPlace(base, place);
    addVector(base, BaseMoving::velocity, place.velocity);
    addVector(base, BaseMoving::acceleration, place.acceleration);
  }
  object.add_enum(MovingObject::type, kind.type);
  // The attributes of vehicles and pedestrians must be set, although little of them is known.
  if (kind.type == kVehicle) {
    if (toRear) {
      Builder<VehicleAttributes> attributes(object, MovingObject::vehicleAttributes);
      addVector(attributes, VehicleAttributes::bbcenterToRear, *toRear);
    } else {
      object.add_message(MovingObject::vehicleAttributes, std::string());
    }
    Builder<VehicleClassification> classification(object, MovingObject::vehicleClassification);
    classification.add_enum(VehicleClassification::type, kind.vehicle);
    classification.add_enum(VehicleClassification::role, kOther);
  } else if (kind.type == kPedestrian) {
    object.add_message(MovingObject::pedestrianAttributes, std::string());
  }
}

void addStationary(Builder<GroundTruth>& message, uint64_t id, const Place& place) {
  Builder<StationaryObject> object(message, GroundTruth::stationaryObject);
  addIdentifier(object, StationaryObject::id, id);
  {
    Builder<BaseStationary> base(object, StationaryObject::base);
    addPlace(base, place);
  }
  Builder<StationaryClassification> classification(object, StationaryObject::classification);
  classification.add_enum(StationaryClassification::type, kOther);
}

}  // namespace

GroundTruthMessages::GroundTruthMessages(const Drive& drive, const World& world) : drive_(drive), world_(world) {
  for (size_t a = 0; a < drive.actors.size() && !body_; ++a)
    if (isBody(a)) body_ = a;
  // Without a body the vehicle has the number after those of the objects and the sensors.
  hostId_ = body_ ? world.objectOfActor(*body_) : world.scene().instances.size() + drive.sensors.size();
  for (const Actor& actor : drive.actors)
    stands_.push_back(kindOf(drive.classes[actor.category].name).type == kOtherObject && !actor.animation &&
                      !actor.trajectory.movesWithin(drive.start, drive.start + drive.duration));
}

bool GroundTruthMessages::isBody(size_t actor) const {
  constexpr double kSame = 1e-3;  // m and rad
  const Trajectory &ego = drive_.ego, &way = drive_.actors[actor].trajectory;
  if (drive_.actors[actor].goneOutside) return false;
  // An actor around a vehicle that stands may be anything, such as a bridge.
  const bool moves = ego.movesWithin(ego.begin(), ego.end());
  if (!moves && kindOf(drive_.classes[drive_.actors[actor].category].name).type != kVehicle) return false;
  const auto offsetAt = [&](double time) { return inverse(way.at(time)) * ego.at(time); };
  const Pose offset = offsetAt(drive_.start);
  const auto isSame = [&](const Trajectory::Stamp& stamp) {
    const Pose other = offsetAt(stamp.time);
    return lengthOf(other.position - offset.position) < kSame && angleBetween(other.orientation, {}) < kSame;
  };
  if (!std::ranges::all_of(ego.stamps(), isSame) || !std::ranges::all_of(way.stamps(), isSame)) return false;
  const Bounds bounds = world_.placementOf(actor, drive_.start, drive_.start, drive_.start).bounds;
  return offset.position.x > bounds.min.x && offset.position.x < bounds.max.x && offset.position.y > bounds.min.y &&
         offset.position.y < bounds.max.y;
}

std::string GroundTruthMessages::messageAt(double time) const {
  std::string bytes;
  Builder<GroundTruth> message(bytes);
  addVersion(message, GroundTruth::version);
  addTime(message, GroundTruth::timestamp, unixNanoseconds(drive_, time));
  addIdentifier(message, GroundTruth::hostVehicleId, hostId_);
  if (!body_) {
    const Trajectory::Rates rates = drive_.ego.ratesAt(time);
    const Place place = {{}, drive_.ego.at(time), drive_.ego.velocityAt(time), rates.acceleration};
    addMoving(message, hostId_, place, {kVehicle}, Vec3{});
  }
  for (size_t a = 0; a < drive_.actors.size(); ++a) {
    if (!world_.poseOf(a, time)) continue;
    const Actor& actor = drive_.actors[a];
    const auto [pose, bounds, velocity] = world_.placementOf(a, time, time, time);
    const Vec3 middle = 0.5 * (bounds.min + bounds.max);
    const Place place = {bounds.max - bounds.min, pose * Pose{middle, {}}, velocity,
                         actor.trajectory.ratesAt(time, {middle, {}}).acceleration};
    if (stands_[a] && a != body_) {
      addStationary(message, world_.objectOfActor(a), place);
      continue;
    }
    Kind kind = kindOf(drive_.classes[actor.category].name);
    std::optional<Vec3> toRear;
    if (a == body_) {
      if (kind.type != kVehicle) kind = {kVehicle};
      toRear = inverse(place.middle) * drive_.ego.at(time).position;
    }
    addMoving(message, world_.objectOfActor(a), place, kind, toRear);
  }
  return bytes;  // the outermost message has no length that its end would write
}

}  // namespace gnosphere::drive::osi
