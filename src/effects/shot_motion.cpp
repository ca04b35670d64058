// SPDX-License-Identifier: Apache-2.0
#include "effects/shot_motion.hpp"

namespace gnosphere {

std::optional<ShotMotion> motionOf(const EffectsSetup& setup, const Shot& shot, const InstanceTable& instances) {
  const PlannedEffects& planned = setup.planned;
  const bool instancesMove = !shot.instanceMotions.empty() && planned.has(gpu::kObjectMotion);
  const bool sensorMoves = !shot.motion.stamps.empty() && (planned.has(gpu::kSensorMotion) || planned.speeds());
  if (!sensorMoves && !instancesMove && !planned.origins) return {};
  ShotMotion motion;
  motion.tables =
      makeMotionTables(setup.sensor, shot, planned.has(gpu::kSensorMotion), setup.effects.sensorMotion.deskew);
  if (instancesMove) {
    motion.instances.resize(instances.count());
    motion.farthest = instances.writeMotions(motion.tables.middle, shot.instanceMotions, setup.sensor.rotationPeriod,
                                             motion.instances.data());
    motion.tables.bounds.instances = 1;
  }
  return motion;
}

double reachOf(const std::optional<ShotMotion>& motion) {
  return motion ? motion->tables.bounds.shift + motion->farthest : 0;
}

}  // namespace gnosphere
