// SPDX-License-Identifier: Apache-2.0
#include "effects/shot_motion.hpp"

namespace gnosphere {

std::optional<ShotMotion> motionOf(const SensorPlan& plan, const Shot& shot, const InstanceTable& instances) {
  const bool instancesMove = !shot.instanceMotions.empty() && plan.has(gpu::kObjectMotion);
  const bool sensorMoves = !shot.motion.stamps.empty() && (plan.has(gpu::kSensorMotion) || plan.speeds());
  if (!sensorMoves && !instancesMove && !plan.origins) return {};
  ShotMotion motion;
  motion.tables = makeMotionTables(plan.sensor, shot, plan.has(gpu::kSensorMotion), plan.effects.sensorMotion.deskew);
  if (instancesMove) {
    motion.instances.resize(instances.count());
    motion.farthest = instances.writeMotions(motion.tables.middle, shot.instanceMotions, plan.sensor.rotationPeriod,
                                             motion.instances.data());
    motion.tables.bounds.instances = 1;
  }
  return motion;
}

double reachOf(const std::optional<ShotMotion>& motion) {
  return motion ? motion->tables.bounds.shift + motion->farthest : 0;
}

}  // namespace gnosphere
