// SPDX-License-Identifier: Apache-2.0
#include "pipeline/resolve_words.hpp"

#include <bit>
#include <cmath>

namespace gnosphere {
namespace {

constexpr float kMiss = std::bit_cast<float>(0x7fc00000u);

struct Azimuth {
  float cosine, sine;
};

// As lattice.glsl and beam.glsl have them, operation by operation.
float onLattice(float value) {
  return std::abs(value) < 0.015625f ? std::nearbyint(value * 1073741824.0f) * (1.0f / 1073741824.0f) : value;
}

Azimuth shifted(Azimuth column, const gpu::vec4& offset, bool exact) {
  const float c = column.cosine * offset.x - column.sine * offset.y;
  const float s = column.sine * offset.x + column.cosine * offset.y;
  return exact ? Azimuth{onLattice(c), onLattice(s)} : Azimuth{c, s};
}

}  // namespace

uint64_t resolveWords(const Word* words, const BeamTables& tables, bool exact, const InstanceTable& instances,
                      uint32_t first, uint32_t end, Scan& scan) {
  const uint32_t columns = tables.frame.columns;
  uint64_t hits = 0;
  InstanceTable::Owner owner;  // neighbours mostly meet the same instance
  for (uint32_t row = first; row < end; ++row) {
    const gpu::vec3& angles = tables.rows[row].angles;
    const gpu::vec4& offset = tables.rows[row].offset;
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
      Azimuth azimuth = {tables.columns[2 * column], tables.columns[2 * column + 1]};
      if (tables.azimuthOffsets) azimuth = shifted(azimuth, offset, exact);
      const float metres = std::bit_cast<float>(word->range);
      point[0] = angles.x * azimuth.cosine * metres;
      point[1] = angles.x * azimuth.sine * metres;
      point[2] = angles.y * metres;
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
