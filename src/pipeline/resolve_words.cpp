// SPDX-License-Identifier: Apache-2.0
#include "pipeline/resolve_words.hpp"

#include <algorithm>
#include <bit>

#include "common/beam.h"
#include "common/laser.h"

namespace gnosphere {
namespace {

constexpr float kMiss = std::bit_cast<float>(0x7fc00000u);

/// Writes the results of the beams, one by one.
class Resolver {
 public:
  Resolver(const InstanceTable& instances, const Places& to) : instances_(instances), to_(to) {}

  bool wantsPoints() const { return to_.points != nullptr; }

  void miss(size_t beam) {
    setPoint(beam, {kMiss, kMiss, kMiss});
    setRange(beam, kMiss);
    setOwner(beam, gpu::kNone, gpu::kNone);
  }

  void hit(size_t beam, uint32_t triangle, float range, const gpu::vec3& point) {
    setPoint(beam, point);
    setRange(beam, range);
    if (triangle == gpu::kNone) {
      setOwner(beam, gpu::kNone, gpu::kNone);
      return;
    }
    ++hits_;
    if (!to_.triangles && !to_.instances) return;
    if (triangle - owner_.first >= owner_.triangles) owner_ = instances_.ownerOf(triangle);
    setOwner(beam, triangle - owner_.first, owner_.instance);
  }

  uint64_t hits() const { return hits_; }

 private:
  void setPoint(size_t beam, const gpu::vec3& point) {
    if (to_.points) std::copy_n(&point.x, 3, to_.points + 3 * beam);
  }
  void setRange(size_t beam, float range) {
    if (to_.ranges) to_.ranges[beam] = range;
  }
  void setOwner(size_t beam, uint32_t triangle, uint32_t instance) {
    if (to_.triangles) to_.triangles[beam] = triangle;
    if (to_.instances) to_.instances[beam] = instance;
  }

  const InstanceTable& instances_;
  const Places to_;
  InstanceTable::Owner owner_;  // kept from beam to beam: neighbours mostly hit the same instance
  uint64_t hits_ = 0;
};

gpu::Beam beamWith(const BeamTables& tables, uint32_t index) {
  if (tables.listed) {
    const gpu::vec4& angles = tables.angles[index];
    return gpu::beamOf({angles.x, angles.y}, angles.z, angles.w);
  }
  const gpu::Row& row = tables.rows[index / tables.frame.columns];
  const size_t column = size_t{row.azimuths} + index % tables.frame.columns;
  return gpu::beamOf({tables.columns[2 * column], tables.columns[2 * column + 1]}, row.angles.x, row.angles.y);
}

// Returns the point at a range along a beam of a scan with motion.
gpu::vec3 pointAt(const BeamTables& tables, const MotionTables& motion, uint32_t index, const gpu::Beam& beam,
                  float range) {
  const uint32_t columns = tables.frame.columns, r = tables.listed ? 0 : index / columns, column = index % columns;
  const gpu::vec4& origin = tables.listed ? tables.origins[index] : tables.rowOrigins[r];
  const gpu::vec3 laser = gpu::laserAt({origin.x, origin.y, origin.z}, beam.azimuth);
  if (!tables.listed && (motion.bounds.sensor == 0 || !tables.staggered))
    return gpu::reportedPoint(motion.columns[tables.staggered ? 0 : column], laser, beam.direction, range);
  const float entry =
      tables.listed ? origin.w : gpu::momentOf(tables.rows[r].first, tables.rows[r].lag, column, columns);
  const auto before = static_cast<uint32_t>(entry);
  const gpu::ColumnMotion* const moments = &motion.columns[before];
  return gpu::reportedPoint(gpu::motionBetween(moments[0], moments[1], entry - static_cast<float>(before)), laser,
                            beam.direction, range);
}

// Beams of a list, or in places of a grid.
uint64_t resolveNumbered(const SensorPlan& plan, const Word* words, const BeamTables& tables,
                         const InstanceTable& instances, const ShotMotion* motion, uint32_t first, uint32_t end,
                         const Places& to) {
  // Stage effects asks whether a hit hides itself before it adds noise to ranges.
  const bool reported = plan.has(gpu::kRangeNoise);
  Resolver resolver(instances, to);
  for (uint32_t index = first; index < end; ++index) {
    const Word& word = words[index];
    const uint32_t number = tables.numbers[index];
    if (number == gpu::kNone) continue;
    const float range = std::bit_cast<float>(word.range);
    if (word.range == gpu::kNone || !(reported || tables.reports(index, range))) {
      resolver.miss(number);
      continue;
    }
    if (!resolver.wantsPoints()) {
      resolver.hit(number, word.triangle, range, {});
      continue;
    }
    const gpu::Beam beam = beamWith(tables, index);
    const gpu::vec3 point = motion ? pointAt(tables, motion->tables, index, beam, range) : beam.direction * range;
    resolver.hit(number, word.triangle, range, point);
  }
  return resolver.hits();
}

}  // namespace

uint64_t resolveWords(const SensorPlan& plan, const Word* words, const BeamTables& tables,
                      const InstanceTable& instances, const ShotMotion* motion, uint32_t first, uint32_t end,
                      const Places& to) {
  if (tables.listed || tables.mapped) return resolveNumbered(plan, words, tables, instances, motion, first, end, to);
  const uint32_t columns = tables.frame.columns;
  Resolver resolver(instances, to);
  for (uint32_t row = first; row < end; ++row) {
    const uint64_t begin = uint64_t{tables.rows[row].channel} * columns;
    const Word* word = words + uint64_t{row} * columns;
    for (uint32_t column = 0; column < columns; ++column, ++word) {
      if (word->range == gpu::kNone) {
        resolver.miss(begin + column);
        continue;
      }
      const uint32_t index = row * columns + column;
      const float metres = std::bit_cast<float>(word->range);
      if (!resolver.wantsPoints()) {
        resolver.hit(begin + column, word->triangle, metres, {});
        continue;
      }
      const gpu::Beam beam = beamWith(tables, index);
      resolver.hit(begin + column, word->triangle, metres,
                   motion ? pointAt(tables, motion->tables, index, beam, metres) : beam.direction * metres);
    }
  }
  return resolver.hits();
}

}  // namespace gnosphere
