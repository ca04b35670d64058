// SPDX-License-Identifier: Apache-2.0
// The lines of light of a scan, each with its own origin: beams, or the sub-rays of their footprints.
#pragma once

#include <cstdint>
#include <vector>

#include "gnosphere/simulator.hpp"

namespace gnosphere::bench {

inline constexpr uint32_t kPacketLines = 16;

/// Lines that follow each other: the sub-rays of a beam, then those of the next one. Lanes beyond `count`, and those of
/// beams that never fire, have far < near.
struct alignas(64) LinePacket {
  float originX[kPacketLines], originY[kPacketLines], originZ[kPacketLines];
  float x[kPacketLines], y[kPacketLines], z[kPacketLines];
  float near[kPacketLines], far[kPacketLines];
};

struct Lines {
  uint32_t perBeam = 1;  ///< sub-rays
  uint32_t layers = 1;   ///< most surfaces that a line meets: all but the last let light pass
  size_t count = 0;
  std::vector<LinePacket> packets;
};

/// Computes the lines of a scan in double precision, relative to the place `origin` in the world: of each beam from
/// where its laser is when it fires, with the sub-rays of these effects if `footprints`.
Lines linesOf(const Sensor& sensor, const Effects& effects, bool footprints, const Shot& shot, const Vec3& origin);

/// Ranges of the surfaces that lines meet, `layers` for each line, in order; NaN beyond the last.
struct LineHits {
  std::vector<float> ranges;
};

}  // namespace gnosphere::bench
