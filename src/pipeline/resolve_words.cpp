// SPDX-License-Identifier: Apache-2.0
#include "pipeline/resolve_words.hpp"

#include <algorithm>
#include <bit>

#include "beam.h"
#include "laser.h"

namespace gnosphere {
namespace {

constexpr float kMiss = std::bit_cast<float>(0x7fc00000u);

/// Writes the results of the beams, one by one.
class Resolver {
 public:
  Resolver(const InstanceTable& instances, Scan& scan) : instances_(instances), scan_(scan) {}

  void miss(size_t beam) {
    float* const point = &scan_.points[3 * beam];
    point[0] = point[1] = point[2] = scan_.ranges[beam] = kMiss;
    scan_.triangles[beam] = scan_.instances[beam] = gpu::kNone;
  }

  void hit(size_t beam, uint32_t triangle, float range, const gpu::vec3& point) {
    std::copy_n(&point.x, 3, &scan_.points[3 * beam]);
    scan_.ranges[beam] = range;
    if (triangle == gpu::kNone) {
      scan_.triangles[beam] = scan_.instances[beam] = gpu::kNone;
      return;
    }
    if (triangle - owner_.first >= owner_.triangles) owner_ = instances_.ownerOf(triangle);
    scan_.triangles[beam] = triangle - owner_.first;
    scan_.instances[beam] = owner_.instance;
    ++hits_;
  }

  uint64_t hits() const { return hits_; }

 private:
  const InstanceTable& instances_;
  Scan& scan_;
  InstanceTable::Owner owner_;  // kept from beam to beam: neighbours mostly hit the same instance
  uint64_t hits_ = 0;
};

gpu::Beam beamWith(const BeamTables& tables, uint32_t index) {
  if (tables.listed) {
    const gpu::vec4& angles = tables.angles[index];
    return gpu::beamOf({angles.x, angles.y}, angles.z, angles.w);
  }
  const uint32_t column = index % tables.frame.columns;
  const gpu::vec3& angles = tables.rows[index / tables.frame.columns].angles;
  return gpu::beamOf({tables.columns[2 * column], tables.columns[2 * column + 1]}, angles.x, angles.y);
}

// Beams of a list, or in places of a grid.
uint64_t resolveNumbered(const SensorPlan& plan, const Word* words, const BeamTables& tables,
                         const InstanceTable& instances, const ShotMotion* motion, uint32_t first, uint32_t end,
                         Scan& scan) {
  // Stage effects asks whether a hit hides itself before it adds noise to ranges.
  const bool reported = plan.has(gpu::kRangeNoise);
  Resolver resolver(instances, scan);
  for (uint32_t index = first; index < end; ++index) {
    const Word& word = words[index];
    const uint32_t number = tables.numbers[index];
    if (number == gpu::kNone) continue;
    const float range = std::bit_cast<float>(word.range);
    if (word.range == gpu::kNone || !(reported || tables.reports(index, range))) {
      resolver.miss(number);
      continue;
    }
    const gpu::Beam beam = beamWith(tables, index);
    gpu::vec3 point = beam.direction * range;
    if (motion) {
      const gpu::vec4& origin = tables.origins[index];
      const auto before = static_cast<uint32_t>(origin.w);
      const gpu::ColumnMotion* const moments = &motion->tables.columns[before];
      point = gpu::reportedPoint(gpu::motionBetween(moments[0], moments[1], origin.w - static_cast<float>(before)),
                                 gpu::laserAt({origin.x, origin.y, origin.z}, beam.azimuth), beam.direction, range);
    }
    resolver.hit(number, word.triangle, range, point);
  }
  return resolver.hits();
}

}  // namespace

uint64_t resolveWords(const SensorPlan& plan, const Word* words, const BeamTables& tables, bool exact,
                      const InstanceTable& instances, const ShotMotion* motion, uint32_t first, uint32_t end,
                      Scan& scan) {
  if (tables.listed || tables.mapped) return resolveNumbered(plan, words, tables, instances, motion, first, end, scan);
  const uint32_t columns = tables.frame.columns;
  Resolver resolver(instances, scan);
  for (uint32_t row = first; row < end; ++row) {
    const auto& angles = tables.rows[row].angles;
    const gpu::vec4& offset = tables.rows[row].offset;
    const Vec3& laser = plan.sensor.channels[tables.rows[row].channel].origin;
    const gpu::vec3 origin = {static_cast<float>(laser.x), static_cast<float>(laser.y), static_cast<float>(laser.z)};
    const uint64_t begin = uint64_t{tables.rows[row].channel} * columns;
    const Word* word = words + uint64_t{row} * columns;
    for (uint32_t column = 0; column < columns; ++column, ++word) {
      if (word->range == gpu::kNone) {
        resolver.miss(begin + column);
        continue;
      }
      const gpu::vec2 azimuth = gpu::azimuthOfBeam({tables.columns[2 * column], tables.columns[2 * column + 1]}, offset,
                                                   tables.azimuthOffsets, exact);
      const gpu::Beam beam = gpu::beamOf(azimuth, angles.x, angles.y);
      const float metres = std::bit_cast<float>(word->range);
      const gpu::vec3 place = motion ? gpu::reportedPoint(motion->tables.columns[column], gpu::laserAt(origin, azimuth),
                                                          beam.direction, metres)
                                     : beam.direction * metres;
      resolver.hit(begin + column, word->triangle, metres, place);
    }
  }
  return resolver.hits();
}

}  // namespace gnosphere
