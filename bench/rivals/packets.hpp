// SPDX-License-Identifier: Apache-2.0
// Packets of 16 neighbouring beams, which suit ray tracers.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "gnosphere/scan.hpp"
#include "gnosphere/sensor.hpp"

namespace gnosphere::bench {

inline constexpr uint32_t kPacketBeams = 16;

/// `count` neighbouring beams of a row of the cloud from number `first` on, with directions in the world. (Packets of
/// 2, 4, 8 and 16 channels were slower to trace with every sensor tried.)
struct alignas(64) Packet {
  float x[kPacketBeams] = {}, y[kPacketBeams] = {}, z[kPacketBeams] = {};
  uint32_t first = 0, count = 0;
};

/// The packets of a sensor, rotated to its orientation. All packets are computed in double precision.
class PacketTable {
 public:
  /// Does nothing if the table already has this sensor and orientation.
  void prepare(const Sensor& sensor, const Quaternion& orientation);
  const std::vector<Packet>& packets() const { return packets_; }

 private:
  void layOut(const Sensor& sensor);

  std::string sensor_;                  ///< a grid as JSON; the name and size of a list
  std::vector<Vec3> directions_;        ///< of the beams, in the sensor's frame
  Quaternion orientation_{0, 0, 0, 0};  ///< orientation of packets_
  std::vector<Packet> packets_;
};

}  // namespace gnosphere::bench
