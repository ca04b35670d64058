// SPDX-License-Identifier: Apache-2.0
#include "pipeline/resolve_words.hpp"

#include <algorithm>
#include <bit>

#include "common/beam.h"
#include "common/laser.h"

namespace gnosphere {
namespace {

constexpr float kMiss = std::bit_cast<float>(0x7fc00000u);

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

/// Resolves the words of one beam after the other.
class Resolver {
 public:
  Resolver(const SensorPlan& plan, const Words& words, const BeamTables& tables, const InstanceTable& instances,
           const ShotMotion* motion, const Places& to)
      : returns_(plan.returns), words_(words), tables_(tables), instances_(instances), motion_(motion), to_(to) {}

  /// `reports` tells whether the range of a hit is reported.
  template <typename Reports>
  void resolve(uint32_t index, size_t number, const Reports& reports) {
    const size_t entry = number * returns_;
    hits_ += set(entry, words_.first[index], index, reports) ? 1 : 0;
    for (uint32_t j = 1; j < returns_; ++j) {
      if (words_.later)
        set(entry + j, words_.later[size_t{j - 1} * tables_.frame.beams + index], index, reports);
      else
        write(entry + j, {kMiss, kMiss, kMiss}, kMiss, gpu::kNone, gpu::kNone);
    }
  }

  /// Beams whose first return is one of a surface.
  uint64_t hits() const { return hits_; }

 private:
  /// Returns whether the return is one of a surface.
  template <typename Reports>
  bool set(size_t entry, const Word& word, uint32_t index, const Reports& reports) {
    const float range = std::bit_cast<float>(word.range);
    if (word.range == gpu::kNone || !reports(range)) {
      write(entry, {kMiss, kMiss, kMiss}, kMiss, gpu::kNone, gpu::kNone);
      return false;
    }
    gpu::vec3 point = {};
    if (to_.points) {
      const gpu::Beam beam = beamWith(tables_, index);
      point = motion_ ? pointAt(tables_, motion_->tables, index, beam, range) : beam.direction * range;
    }
    const bool solid = word.triangle != gpu::kNone;
    if (solid && (to_.triangles || to_.instances)) {
      if (word.triangle - owner_.first >= owner_.triangles) owner_ = instances_.numbers().ownerOf(word.triangle);
      write(entry, point, range, word.triangle - owner_.first, owner_.instance);
    } else {
      write(entry, point, range, gpu::kNone, gpu::kNone);
    }
    return solid;
  }

  void write(size_t entry, const gpu::vec3& point, float range, uint32_t triangle, uint32_t instance) {
    if (to_.points) std::copy_n(&point.x, 3, to_.points + 3 * entry);
    if (to_.ranges) to_.ranges[entry] = range;
    if (to_.triangles) to_.triangles[entry] = triangle;
    if (to_.instances) to_.instances[entry] = instance;
  }

  const uint32_t returns_;
  const Words words_;
  const BeamTables& tables_;
  const InstanceTable& instances_;
  const ShotMotion* motion_;
  const Places to_;
  TriangleNumbers::Owner owner_;  // kept from beam to beam: neighbours mostly hit the same instance
  uint64_t hits_ = 0;
};

}  // namespace

uint64_t resolveWords(const SensorPlan& plan, const Words& words, const BeamTables& tables,
                      const InstanceTable& instances, const ShotMotion* motion, uint32_t first, uint32_t end,
                      const Places& to) {
  Resolver resolver(plan, words, tables, instances, motion, to);
  if (tables.listed || tables.mapped) {
    // Stage effects asks whether a hit hides itself before it adds noise to ranges.
    const bool reported = plan.has(gpu::kRangeNoise);
    for (uint32_t index = first; index < end; ++index)
      if (const uint32_t number = tables.numbers[index]; number != gpu::kNone)
        resolver.resolve(index, number, [&](float range) { return reported || tables.reports(index, range); });
    return resolver.hits();
  }
  const uint32_t columns = tables.frame.columns;
  for (uint32_t row = first; row < end; ++row) {
    const size_t begin = size_t{tables.rows[row].channel} * columns;
    for (uint32_t column = 0; column < columns; ++column)
      resolver.resolve(row * columns + column, begin + column, [](float) { return true; });
  }
  return resolver.hits();
}

}  // namespace gnosphere
