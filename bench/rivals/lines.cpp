// SPDX-License-Identifier: Apache-2.0
#include "rivals/lines.hpp"

#include <cmath>

#include "base/quaternion.hpp"
#include "common/effects/bits.h"
#include "effects/formula_inputs.hpp"
#include "effects/trajectory.hpp"
#include "sensor/beams.hpp"

namespace gnosphere::bench {

Lines linesOf(const Sensor& sensor, const Effects& effects, bool footprints, const Shot& shot, const Vec3& origin) {
  const std::vector<SubRay> rays = subRays(effects, sensor, footprints ? gpu::kDivergence : 0);
  Lines lines;
  lines.perBeam = static_cast<uint32_t>(rays.size());
  lines.count = sensor.beamCount() * rays.size();
  LinePacket unused = {};
  for (uint32_t lane = 0; lane < kPacketLines; ++lane) unused.far[lane] = -1;
  lines.packets.assign((lines.count + kPacketLines - 1) / kPacketLines, unused);
  const std::vector<bool> silent = silentBeams(sensor);
  for (size_t beam = 0; beam < sensor.beamCount(); ++beam) {
    if (silent[beam]) continue;
    const Pose pose = poseAt(shot.motion, shot.pose, timeOf(sensor, beam, shot.frame));
    const Vec3 axis = directionOf(sensor, beam, shot.frame);
    const double azimuth = azimuthOf(sensor, beam, shot.frame), elevation = elevationOf(sensor, beam, shot.frame);
    const double c = std::cos(azimuth), s = std::sin(azimuth);
    const Vec3 left = {-s, c, 0}, up = {-std::sin(elevation) * c, -std::sin(elevation) * s, std::cos(elevation)};
    const Vec3 start = pose.position + pose.orientation * originOf(sensor, beam, shot.frame) - origin;
    const RangeWindow window = rangeWindowOf(sensor, beam, shot.frame);
    for (size_t ray = 0; ray < rays.size(); ++ray) {
      const Vec3 along = axis + (rays[ray].u * left + rays[ray].v * up);
      const Vec3 d = pose.orientation * (1 / lengthOf(along) * along);
      const size_t line = beam * rays.size() + ray, lane = line % kPacketLines;
      LinePacket& packet = lines.packets[line / kPacketLines];
      packet.originX[lane] = static_cast<float>(start.x);
      packet.originY[lane] = static_cast<float>(start.y);
      packet.originZ[lane] = static_cast<float>(start.z);
      packet.x[lane] = static_cast<float>(d.x);
      packet.y[lane] = static_cast<float>(d.y);
      packet.z[lane] = static_cast<float>(d.z);
      packet.near[lane] = static_cast<float>(window.least);
      packet.far[lane] = static_cast<float>(window.most);
    }
  }
  return lines;
}

}  // namespace gnosphere::bench
