// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "drive/median.hpp"
#include "drive/pose_math.hpp"
#include "drive/record.hpp"
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
  return beams;
}

template <typename Use>
void BoxFinder::eachBeamThrough(const PlannedScan& planned, const Pose& seen, const Vec3& size, const Use& use) {
  const Beams& beams = beamsOf(planned);
  const Vec3 centre = seen.position;
  const double radius = lengthOf(size) / 2, distance = lengthOf(centre);
  double reach = radius;  // beams leave from within this distance of the sensor's origin
  for (const Vec3& origin : beams.origins) reach = std::max(reach, radius + lengthOf(origin));
  // A beam meets the ball around the box if its angle to the centre is small enough.
  const float least =
      distance > reach ? static_cast<float>(std::sqrt(distance * distance - reach * reach) - 1e-3) : -INFINITY;
  const auto x = static_cast<float>(centre.x), y = static_cast<float>(centre.y), z = static_cast<float>(centre.z);
  const Pose toBox = inverse(seen);
  const auto isNear = [&](size_t beam) { return x * beams.x[beam] + y * beams.y[beam] + z * beams.z[beam] >= least; };
  const auto follow = [&](size_t beam) {
    const Vec3 along = toBox.orientation * Vec3{beams.x[beam], beams.y[beam], beams.z[beam]};
    const Vec3 from = beams.origins.empty() ? toBox.position : toBox * beams.origins[beam];
    const double entry = entryRange(from, along, size);
    if (entry < INFINITY) use(beam, entry);
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

double BoxFinder::visibility(const RecordedScan& recorded, const Box& box) {
  constexpr double kMargin = 0.1;  // metres before the box that still count as the actor's own
  const uint32_t object = world_.objectOfActor(box.actor);
  const size_t returns = recorded.scan.returns;
  uint64_t through = 0, stopped = 0;
  eachBeamThrough(recorded.planned, box.seen, box.size, [&](size_t beam, double entry) {
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
  return through == 0 ? NAN : 1 - static_cast<double>(stopped) / static_cast<double>(through);
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
  box.seen = inverse(recorded.sensorMoves ? drive_.sensorPose(planned.sensor, seenAt) : recorded.pose) * box.inWorld;
  box.inSensor = recorded.deskewed ? inverse(recorded.pose) * box.inWorld : box.seen;
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
  std::vector<Box> boxes;
  for (size_t a = 0; a < times.size(); ++a) {
    if (times[a].empty()) continue;
    Box& box = boxes.emplace_back(boxAt(recorded, a, medianOf(times[a])));
    box.points = times[a].size();
    box.visibility = visibility(recorded, box);
    if (std::isnan(box.visibility)) box.visibility = 1;  // all its points lie beside the box
  }
  return boxes;
}

std::vector<Box> BoxFinder::findMissed(const RecordedScan& recorded) {
  const auto& [index, number, time] = recorded.planned;
  const RigSensor& rigged = drive_.sensors[index];
  const double reach = widestWindow(rigged.sensor).most;
  std::vector<Box> boxes;
  for (size_t a = 0; a < drive_.actors.size(); ++a) {
    if (std::ranges::find(recorded.boxes, a, &Box::actor) != recorded.boxes.end()) continue;
    if (rigged.isIgnored(a) || !world_.poseOf(a, time)) continue;
    Box box = boxAt(recorded, a, 0);
    const Vec3 from = inverse(box.seen).position, half = 0.5 * box.size;
    const Vec3 nearest = {std::clamp(from.x, -half.x, half.x), std::clamp(from.y, -half.y, half.y),
                          std::clamp(from.z, -half.z, half.z)};
    if (lengthOf(from - nearest) > reach) continue;
    std::vector<float> times;  // at which beams pass the actor
    eachBeamThrough(recorded.planned, box.seen, box.size, [&](size_t beam, double) {
      times.push_back(static_cast<float>(timeOf(rigged.sensor, beam, number)));
    });
    if (!times.empty()) box = boxAt(recorded, a, medianOf(times));
    box.visibility = visibility(recorded, box);
    boxes.push_back(box);
  }
  return boxes;
}

}  // namespace gnosphere::drive
