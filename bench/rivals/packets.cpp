// SPDX-License-Identifier: Apache-2.0
#include "rivals/packets.hpp"

#include <algorithm>

#include "base/quaternion.hpp"

namespace gnosphere::bench {

void PacketTable::layOut(const Sensor& sensor) {
  const std::string identity = sensor.isGrid() ? toJson(sensor) : sensor.name + std::to_string(sensor.beamCount());
  if (identity == sensor_) return;
  sensor_ = identity;
  orientation_ = {0, 0, 0, 0};
  directions_.resize(sensor.beamCount());
  for (size_t beam = 0; beam < directions_.size(); ++beam) directions_[beam] = sensor.direction(beam);
  packets_.clear();
  const uint32_t width = sensor.width();
  for (uint32_t row = 0; row < sensor.height(); ++row) {
    for (uint32_t column = 0; column < width; column += kPacketBeams) {
      Packet& packet = packets_.emplace_back();
      packet.first = row * width + column;
      packet.count = std::min(kPacketBeams, width - column);
    }
  }
}

void PacketTable::prepare(const Sensor& sensor, const Quaternion& q) {
  layOut(sensor);
  if (isSame(orientation_, q)) return;
  orientation_ = q;
  for (Packet& packet : packets_) {
    for (uint32_t lane = 0; lane < packet.count; ++lane) {
      const Vec3 d = q * directions_[packet.first + lane];
      packet.x[lane] = static_cast<float>(d.x);
      packet.y[lane] = static_cast<float>(d.y);
      packet.z[lane] = static_cast<float>(d.z);
    }
  }
}

}  // namespace gnosphere::bench
