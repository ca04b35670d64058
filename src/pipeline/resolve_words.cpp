// SPDX-License-Identifier: Apache-2.0
#include "pipeline/resolve_words.hpp"

#include <algorithm>
#include <bit>

#include "beam.h"
#include "laser.h"

namespace gnosphere {
namespace {

constexpr float kMiss = std::bit_cast<float>(0x7fc00000u);

}  // namespace

uint64_t resolveWords(const Word* words, const BeamTables& tables, bool exact, const InstanceTable& instances,
                      const Sensor& sensor, const ShotMotion* motion, uint32_t first, uint32_t end, Scan& scan) {
  const uint32_t columns = tables.frame.columns;
  uint64_t hits = 0;
  InstanceTable::Owner owner;  // kept from beam to beam: neighbours mostly hit the same instance
  for (uint32_t row = first; row < end; ++row) {
    const auto& angles = tables.rows[row].angles;
    const gpu::vec4& offset = tables.rows[row].offset;
    const Vec3& laser = sensor.channels[tables.rows[row].channel].origin;
    const gpu::vec3 origin = {static_cast<float>(laser.x), static_cast<float>(laser.y), static_cast<float>(laser.z)};
    const uint64_t begin = uint64_t{tables.rows[row].channel} * columns;
    const Word* word = words + uint64_t{row} * columns;
    float *point = &scan.points[3 * begin], *range = &scan.ranges[begin];
    uint32_t *triangle = &scan.triangles[begin], *instance = &scan.instances[begin];
    for (uint32_t column = 0; column < columns; ++column, ++word, point += 3) {
      if (word->range == gpu::kNone) {
        point[0] = point[1] = point[2] = range[column] = kMiss;
        triangle[column] = instance[column] = gpu::kNone;
        continue;
      }
      const gpu::vec2 azimuth = gpu::azimuthOfBeam({tables.columns[2 * column], tables.columns[2 * column + 1]}, offset,
                                                   tables.azimuthOffsets, exact);
      const gpu::Beam beam = gpu::beamOf(azimuth, angles.x, angles.y);
      const float metres = std::bit_cast<float>(word->range);
      const gpu::vec3 place = motion ? gpu::reportedPoint(motion->tables.columns[column], gpu::laserAt(origin, azimuth),
                                                          beam.direction, metres)
                                     : beam.direction * metres;
      std::copy_n(&place.x, 3, point);
      range[column] = metres;
      if (word->triangle - owner.first >= owner.triangles) owner = instances.ownerOf(word->triangle);
      triangle[column] = word->triangle - owner.first;
      instance[column] = owner.instance;
      ++hits;
    }
  }
  return hits;
}

}  // namespace gnosphere
