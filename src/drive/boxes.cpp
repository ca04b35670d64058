// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "drive/median.hpp"
#include "drive/pose_math.hpp"
#include "drive/record.hpp"
#include "effects/trajectory.hpp"
#include "sensor/beams.hpp"

namespace gnosphere::drive {
namespace {

/// Where a ray enters the box of this size around the origin; infinity if it passes by or the box lies behind.
double entryRange(const Vec3& from, const Vec3& along, const Vec3& size) {
  double near = 0, far = INFINITY;
  const double origins[] = {from.x, from.y, from.z}, steps[] = {along.x, along.y, along.z},
               halves[] = {size.x / 2, size.y / 2, size.z / 2};
  for (int axis = 0; axis < 3; ++axis) {
    if (steps[axis] == 0) {
      if (std::abs(origins[axis]) > halves[axis]) return INFINITY;
      continue;
    }
    const double a = (-halves[axis] - origins[axis]) / steps[axis], b = (halves[axis] - origins[axis]) / steps[axis];
    near = std::max(near, std::min(a, b));
    far = std::min(far, std::max(a, b));
  }
  return near <= far ? near : INFINITY;
}

}  // namespace

SensorPath::SensorPath(const Sensor& sensor, const RecordedScan& recorded) : recorded_(recorded) {
  const ScanTimes times = scanTimesOf(sensor, true, recorded.planned.number);
  first_ = times.first;
  last_ = times.last;
  // Between two stamps that are less than a quarter turn from the middle pose nothing is farther from it than they are.
  // If the sensor turns by a sixth of a turn or more, eachBeamThrough() follows every beam.
  const Pose between = at(middle());
  for (const SensorMotion::Stamp& stamp : recorded.motion.stamps) {
    shift_ = std::max(shift_, lengthOf(stamp.pose.position - between.position));
    turn_ = std::max(turn_, angleBetween(stamp.pose.orientation, between.orientation));
  }
}

const BoxFinder::Beams& BoxFinder::beamsOf(const PlannedScan& planned) {
  const Sensor& sensor = drive_.sensors[planned.sensor].sensor;
  const uint64_t pattern = sensor.isGrid() ? 0 : planned.number % sensor.patterns.size();
  const auto [entry, isNew] = beams_.try_emplace({planned.sensor, pattern});
  Beams& beams = entry->second;
  if (!isNew) return beams;
  const BeamList list = gnosphere::beamsOf(sensor, pattern);
  for (const Vec3& direction : list.directions) {
    beams.x.push_back(static_cast<float>(direction.x));
    beams.y.push_back(static_cast<float>(direction.y));
    beams.z.push_back(static_cast<float>(direction.z));
  }
  beams.origins = list.origins;
  beams.times = list.times;
  for (const Vec3& origin : beams.origins) beams.spread = std::max(beams.spread, lengthOf(origin));
  return beams;
}

SensorMotion BoxFinder::motionOf(const RecordedScan& recorded, const Box& box) const {
  if (!recorded.actorsMove) return {};
  const double begin = recorded.planned.time, end = recorded.endOfMotion();
  const auto placeAt = [&](double time) { return box.inWorld.position + (time - box.time) * box.velocity; };
  return {{{0, {placeAt(begin), drive_.actors[box.actor].trajectory.at(begin).orientation}},
           {recorded.duration, {placeAt(end), world_.endOf(box.actor, begin, end).orientation}}}};
}

template <typename Use>
void BoxFinder::eachBeamThrough(const RecordedScan& recorded, const SensorPath& path, const Box& box, const Use& use) {
  const Beams& beams = beamsOf(recorded.planned);
  const SensorMotion motion = motionOf(recorded, box);
  const auto boxIn = [&](double seconds) { return poseAt(motion, box.inWorld, seconds); };
  // A beam whose angle to the centre is small enough meets the ball around all places of the box in the sensor's frame.
  const Vec3 centre = inverse(path.at(path.middle())) * boxIn(path.middle()).position;
  const double distance = lengthOf(centre), speed = motion.stamps.empty() ? 0 : lengthOf(box.velocity);
  const double reach = lengthOf(box.size) / 2 + beams.spread + path.shift() + speed * path.halfSpan() +
                       2 * std::sin(path.turn() / 2) * distance;
  const float least =
      distance > reach ? static_cast<float>(std::sqrt(distance * distance - reach * reach) - 1e-3) : -INFINITY;
  const auto x = static_cast<float>(centre.x), y = static_cast<float>(centre.y), z = static_cast<float>(centre.z);
  const auto isNear = [&](size_t beam) { return x * beams.x[beam] + y * beams.y[beam] + z * beams.z[beam] >= least; };
  const auto follow = [&](size_t beam) {
    const double seconds = beams.times.empty() ? 0 : beams.times[beam];
    const Pose toBox = inverse(boxIn(seconds)) * path.at(seconds);
    const Vec3 along = toBox.orientation * Vec3{beams.x[beam], beams.y[beam], beams.z[beam]};
    const Vec3 from = beams.origins.empty() ? toBox.position : toBox * beams.origins[beam];
    const double entry = entryRange(from, along, box.size);
    if (entry < INFINITY) use(beam, seconds, entry);
  };
  // Few beams come near a box. The count of those of a block is vectorised, because it does not branch.
  constexpr size_t kBlock = 64;
  for (size_t start = 0; start < beams.x.size(); start += kBlock) {
    const size_t end = std::min(start + kBlock, beams.x.size());
    uint32_t near = 0;
    for (size_t beam = start; beam < end; ++beam) near += isNear(beam) ? 1 : 0;
    for (size_t beam = start; near > 0 && beam < end; ++beam)
      if (isNear(beam)) follow(beam);
  }
}

BoxFinder::Sight BoxFinder::sightOf(const RecordedScan& recorded, const SensorPath& path, const Box& box) {
  constexpr double kMargin = 0.1;  // metres before the box that still count as the actor's own
  const uint32_t object = world_.objectOfActor(box.actor);
  const size_t returns = recorded.scan.returns;
  Sight sight;
  uint64_t through = 0, stopped = 0;
  eachBeamThrough(recorded, path, box, [&](size_t beam, double seconds, double entry) {
    sight.times.push_back(static_cast<float>(seconds));
    // A beam without a return from a surface does not tell whether something stands before the box.
    bool meets = false, arrives = false;
    for (size_t i = beam * returns; i < (beam + 1) * returns; ++i) {
      const uint32_t met = recorded.scan.instances[i];
      meets |= met != kNoTriangle;
      arrives |= met == object || (met != kNoTriangle && recorded.scan.ranges[i] >= entry - kMargin);
    }
    if (!meets) return;
    ++through;
    if (!arrives) ++stopped;
  });
  if (through > 0) sight.visibility = 1 - static_cast<double>(stopped) / static_cast<double>(through);
  return sight;
}

Box BoxFinder::boxAt(const RecordedScan& recorded, size_t actor, double seconds) {
  const PlannedScan& planned = recorded.planned;
  Box box;
  box.actor = actor;
  const double seenAt = planned.time + seconds;
  box.time = recorded.actorsMove ? seenAt : planned.time;
  const World::Placement placement = world_.placementOf(actor, planned.time, recorded.endOfMotion(), box.time);
  const Bounds& bounds = placement.bounds;
  box.size = bounds.max - bounds.min;
  box.inWorld = placement.pose * Pose{0.5 * (bounds.min + bounds.max), {}};
  const bool ownFrames = recorded.sensorMoves && !recorded.deskewed;
  box.inSensor = inverse(ownFrames ? drive_.sensorPose(planned.sensor, seenAt) : recorded.pose) * box.inWorld;
  box.velocity = placement.velocity;
  box.moving = placement.isMoving();
  return box;
}

std::vector<Box> BoxFinder::find(const RecordedScan& recorded) {
  const Scan& scan = recorded.scan;
  std::vector<std::vector<float>> times(drive_.actors.size());
  const uint32_t firstActor = drive_.actors.empty() ? kNoTriangle : world_.objectOfActor(0);
  std::vector<size_t> actors(world_.scene().instances.size());
  for (size_t a = 0; a < drive_.actors.size(); ++a) actors[world_.objectOfActor(a)] = a;
  const bool timed = recorded.duration > 0;
  const ColumnView<float> seconds = timed ? scan.column<float>(Field::time) : ColumnView<float>();
  for (size_t entry = 0; entry < scan.ranges.size(); ++entry) {
    const uint32_t object = scan.instances[entry];
    if (object >= firstActor && object != kNoTriangle) times[actors[object]].push_back(timed ? seconds[entry] : 0);
  }
  const SensorPath path(drive_.sensors[recorded.planned.sensor].sensor, recorded);
  std::vector<Box> boxes;
  for (size_t a = 0; a < times.size(); ++a) {
    if (times[a].empty()) continue;
    Box& box = boxes.emplace_back(boxAt(recorded, a, medianOf(times[a])));
    box.points = times[a].size();
    box.visibility = sightOf(recorded, path, box).visibility;
  }
  return boxes;
}

std::vector<Box> BoxFinder::findMissed(const RecordedScan& recorded) {
  const auto& [index, number, time] = recorded.planned;
  const RigSensor& rigged = drive_.sensors[index];
  const double reach = widestWindow(rigged.sensor).most;
  const SensorPath path(rigged.sensor, recorded);
  std::vector<Box> boxes;
  for (size_t a = 0; a < drive_.actors.size(); ++a) {
    if (std::ranges::find(recorded.boxes, a, &Box::actor) != recorded.boxes.end()) continue;
    if (rigged.isIgnored(a) || !world_.poseOf(a, time)) continue;
    Box box = boxAt(recorded, a, 0);
    const Vec3 from = inverse(box.inWorld) * recorded.pose.position, half = 0.5 * box.size;
    const Vec3 nearest = {std::clamp(from.x, -half.x, half.x), std::clamp(from.y, -half.y, half.y),
                          std::clamp(from.z, -half.z, half.z)};
    if (lengthOf(from - nearest) > reach) continue;
    Sight sight = sightOf(recorded, path, box);
    if (!sight.times.empty()) box = boxAt(recorded, a, medianOf(sight.times));
    box.visibility = sight.visibility;
    boxes.push_back(box);
  }
  return boxes;
}

}  // namespace gnosphere::drive
