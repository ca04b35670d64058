// SPDX-License-Identifier: Apache-2.0
// Loads of entries of arrays, where each lane loads another entry. Where lanes run in step, lavapipe loads one
// component after the other, and each of them lane by lane, so loads of 64 bits take half as long as twice as many of
// 32 bits.

#if defined(INT64) && defined(VULKAN)

layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer Wide { uint64_t at[]; };

vec2 pairIn(Wide memory, uint i) { return uintBitsToFloat(unpackUint2x32(memory.at[i])); }

// Return entry i of an array with 16 bytes per entry.
vec4 vectorIn(Wide memory, uint i) { return vec4(pairIn(memory, 2 * i), pairIn(memory, 2 * i + 1)); }
TaggedCorner cornerIn(Wide memory, uint i) {
  vec4 values = vectorIn(memory, i);
  return TaggedCorner(values.xyz, floatBitsToUint(values.w));
}

Row rowIn(Wide memory, uint i) {
  TaggedCorner angles = cornerIn(memory, 2 * i);
  vec4 places = vectorIn(memory, 2 * i + 1);
  return Row(angles.corner, angles.tag, floatBitsToUint(places.x), floatBitsToInt(places.y), places.z, places.w);
}

Instance instanceIn(Wide memory, uint i) {
  TaggedCorner last = cornerIn(memory, 4 * i + 3);
  return Instance(vectorIn(memory, 4 * i), vectorIn(memory, 4 * i + 1), vectorIn(memory, 4 * i + 2), last.corner,
                  last.tag);
}

ColumnMotion motionIn(Wide memory, uint i) {
  return ColumnMotion(vectorIn(memory, 7 * i), vectorIn(memory, 7 * i + 1), vectorIn(memory, 7 * i + 2),
                      vectorIn(memory, 7 * i + 3), vectorIn(memory, 7 * i + 4), vectorIn(memory, 7 * i + 5),
                      vectorIn(memory, 7 * i + 6));
}

Group groupIn(Wide memory, uint i) {
  TaggedCorner low = cornerIn(memory, 2 * i), high = cornerIn(memory, 2 * i + 1);
  return Group(low.corner, low.tag, high.corner, high.tag);
}

#define LOADED(array_, i_, wide_) \
  if (kLanesInStep) return wide_; \
  return array_.at[i_];

#else
#define LOADED(array_, i_, wide_) return array_.at[i_];
#endif

TaggedCorner loadedA(uint i) { LOADED(projectedA, i, cornerIn(Wide(projectedA), i)) }
vec4 loadedB(uint i) { LOADED(projectedB, i, vectorIn(Wide(projectedB), i)) }
TaggedCorner loadedC(uint i) { LOADED(projectedC, i, cornerIn(Wide(projectedC), i)) }
vec2 loadedColumn(uint i) { LOADED(columns, i, pairIn(Wide(columns), i)) }
Row loadedRow(uint i) { LOADED(rows, i, rowIn(Wide(rows), i)) }
Instance loadedInstance(uint i) { LOADED(instances, i, instanceIn(Wide(instances), i)) }
ColumnMotion loadedMotion(uint i) { LOADED(columnMotions, i, motionIn(Wide(columnMotions), i)) }
Group loadedGroup(uint i) { LOADED(groups, i, groupIn(Wide(groups), i)) }

// The box of a cluster: the first half of Cluster is laid out as a Group is.
Group loadedBox(uint cluster) {
#if defined(INT64) && defined(VULKAN)
  if (kLanesInStep) {
    TaggedCorner low = cornerIn(Wide(clusters), 4 * cluster), high = cornerIn(Wide(clusters), 4 * cluster + 1);
    return Group(low.corner, low.tag, high.corner, high.tag);
  }
#endif
  return Group(clusters.at[cluster].low, clusters.at[cluster].vertexFirst, clusters.at[cluster].high,
               clusters.at[cluster].triangleFirst);
}
