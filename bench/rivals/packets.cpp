// SPDX-License-Identifier: Apache-2.0
#include "rivals/packets.hpp"

#include <algorithm>
#include <cmath>

namespace gnosphere::bench {
namespace {

/// The shape of a packet: of those that hold 16 beams the one whose solid angle is nearest to a square.
uint32_t packetChannels(const Sensor& sensor) {
  const auto [low, high] =
      std::minmax_element(sensor.channels.begin(), sensor.channels.end(),
                          [](const Channel& a, const Channel& b) { return a.elevationDeg < b.elevationDeg; });
  const double gaps = std::max(1.0, static_cast<double>(sensor.channels.size()) - 1);
  const double spacing = (high->elevationDeg - low->elevationDeg) / gaps;
  const double step = 360.0 / sensor.columns;
  uint32_t best = 1;
  const auto skew = [&](uint32_t n) { return std::abs(std::log2(n * spacing / (kPacketBeams / n * step))); };
  for (uint32_t n : {2U, 4U, 8U})
    if (spacing > 0 && skew(n) < skew(best)) best = n;
  return best;
}

/// v turned by q: v + 2 w (u x v) + 2 u x (u x v), u being q's vector part.
Vec3 turn(const Quaternion& q, const Vec3& v) {
  const Vec3 t = {2 * (q.y * v.z - q.z * v.y), 2 * (q.z * v.x - q.x * v.z), 2 * (q.x * v.y - q.y * v.x)};
  return {v.x + q.w * t.x + q.y * t.z - q.z * t.y, v.y + q.w * t.y + q.z * t.x - q.x * t.z,
          v.z + q.w * t.z + q.x * t.y - q.y * t.x};
}

}  // namespace

void PacketTable::layOut(const Sensor& sensor) {
  const std::string json = toJson(sensor);
  if (json == sensor_) return;
  sensor_ = json;
  orientation_ = {0, 0, 0, 0};
  directions_.resize(sensor.beamCount());
  for (size_t beam = 0; beam < directions_.size(); ++beam) directions_[beam] = sensor.direction(beam);
  packets_.clear();
  if (directions_.empty()) return;
  const uint32_t high = packetChannels(sensor), wide = kPacketBeams / high;
  const uint32_t channels = static_cast<uint32_t>(sensor.channels.size());
  for (uint32_t row = 0; row < channels; row += high) {
    for (uint32_t column = 0; column < sensor.columns; column += wide) {
      Packet& packet = packets_.emplace_back();
      for (uint32_t lane = 0; lane < kPacketBeams; ++lane) {
        const uint32_t r = row + lane / wide, c = column + lane % wide;
        packet.beam[lane] = r < channels && c < sensor.columns ? r * sensor.columns + c : kNoBeam;
      }
    }
  }
}

void PacketTable::prepare(const Sensor& sensor, const Quaternion& q) {
  layOut(sensor);
  const Quaternion& o = orientation_;
  if (o.x == q.x && o.y == q.y && o.z == q.z && o.w == q.w) return;
  orientation_ = q;
  for (Packet& packet : packets_) {
    for (uint32_t lane = 0; lane < kPacketBeams; ++lane) {
      const Vec3 d = packet.beam[lane] == kNoBeam ? Vec3{1, 0, 0} : turn(q, directions_[packet.beam[lane]]);
      packet.x[lane] = static_cast<float>(d.x);
      packet.y[lane] = static_cast<float>(d.y);
      packet.z[lane] = static_cast<float>(d.z);
    }
  }
}

}  // namespace gnosphere::bench
