// SPDX-License-Identifier: Apache-2.0
#include "effects/shot_motion.hpp"

#include <algorithm>

#include "base/transform.hpp"
#include "sensor/beams.hpp"

namespace gnosphere {

namespace {

bool sensorMoves(const SensorPlan& plan, const Shot& shot) {
  return !shot.motion.stamps.empty() && (plan.has(gpu::kSensorMotion) || plan.speeds());
}

}  // namespace

bool moves(const SensorPlan& plan, const Shot& shot) {
  return sensorMoves(plan, shot) || instancesMove(plan, shot);
}

bool isSkewed(const SensorPlan& plan, const Shot& shot) {
  const auto isElsewhere = [&](const SensorMotion::Stamp& stamp) { return !samePose(stamp.pose, shot.pose); };
  return plan.has(gpu::kSensorMotion) && !plan.effects.sensorMotion.deskew &&
         std::any_of(shot.motion.stamps.begin(), shot.motion.stamps.end(), isElsewhere);
}

std::optional<ShotMotion> motionOf(const SensorPlan& plan, const OriginBounds& lasers, const Shot& shot,
                                   const InstanceTable& instances, const Deformables& deformables) {
  const bool moving = moves(plan, shot);
  if (!moving && !plan.origins) return {};
  ShotMotion motion;
  motion.centre = lasers.centre;
  motion.moves = moving;
  const ScanTimes times =
      plan.rows ? scanTimesOf(*plan.rows, plan.sensor) : scanTimesOf(plan.sensor, plan.listed, shot.frame);
  motion.tables = makeMotionTables(times, lasers, shot, plan.has(gpu::kSensorMotion), plan.effects.sensorMotion.deskew);
  if (instancesMove(plan, shot)) {
    const double duration = durationOf(plan.sensor, shot.frame);
    std::map<size_t, double> changes;
    for (const MeshMotion& mesh : shot.meshMotions)
      changes[mesh.mesh] = deformables.writeEnd(mesh.mesh, mesh.end, motion.end);
    motion.farthest =
        instances.findMotions(motion.tables.middle, shot.instanceMotions, changes, duration, motion.instances);
    // Beams may fire before the start and after the end of the motion.
    const float longer = motion.tables.bounds.seconds / static_cast<float>(duration);
    if ((plan.listed || plan.rows) && longer > 1) {
      motion.farthest *= longer;
      for (auto& [instance, of] : motion.instances) {
        of.bound.x *= longer;
        of.bound.y *= longer;
      }
    }
  }
  return motion;
}

Pose seenFrom(std::span<const Shot> shots, size_t shot, ShotMotions motions) {
  if (motions.empty()) return shots[shot].pose;
  return motions.size() == shots.size() ? motions[shot].tables.middle : movedTo(motions[0].centre, shots[shot].pose);
}

double reachOf(ShotMotions motions) {
  double reach = 0;
  for (const ShotMotion& motion : motions) reach = std::max(reach, motion.tables.bounds.shift + motion.farthest);
  return reach;
}

}  // namespace gnosphere
