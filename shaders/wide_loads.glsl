// SPDX-License-Identifier: Apache-2.0
// Loads of entries of arrays, where each lane loads another entry. Where lanes run in step, lavapipe loads one
// component after the other, and each of them lane by lane, so loads of 64 bits take half as long as twice as many of
// 32 bits.

#if defined(INT64) && defined(VULKAN)

layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer Wide { uint64_t at[]; };

uvec2 pairIn(Wide memory, uint i) { return unpackUint2x32(memory.at[i]); }

// Returns entry i of an array with 16 bytes per entry.
uvec4 wordsIn(Wide memory, uint i) { return uvec4(pairIn(memory, 2 * i), pairIn(memory, 2 * i + 1)); }

vec4 vectorIn(Wide memory, uint i) { return uintBitsToFloat(wordsIn(memory, i)); }

TaggedCorner cornerIn(Wide memory, uint i) {
  uvec4 words = wordsIn(memory, i);
  return TaggedCorner(uintBitsToFloat(words.xyz), words.w);
}

Row rowIn(Wide memory, uint i) {
  uvec4 angles = wordsIn(memory, 2 * i), places = wordsIn(memory, 2 * i + 1);
  return Row(uintBitsToFloat(angles.xyz), angles.w, places.x, int(places.y), uintBitsToFloat(places.z),
             uintBitsToFloat(places.w));
}

Instance instanceIn(Wide memory, uint i) {
  TaggedCorner last = cornerIn(memory, 4 * i + 3);
  return Instance(vectorIn(memory, 4 * i), vectorIn(memory, 4 * i + 1), vectorIn(memory, 4 * i + 2), last.corner,
                  last.tag);
}

ColumnMotion motionIn(Wide memory, uint i) {
  return ColumnMotion(vectorIn(memory, 9 * i), vectorIn(memory, 9 * i + 1), vectorIn(memory, 9 * i + 2),
                      vectorIn(memory, 9 * i + 3), vectorIn(memory, 9 * i + 4), vectorIn(memory, 9 * i + 5),
                      vectorIn(memory, 9 * i + 6), vectorIn(memory, 9 * i + 7),
                      vectorIn(memory, 9 * i + 8));
}

BeamFrame beamFrameIn(Wide memory, uint i) {
  return BeamFrame(vectorIn(memory, 3 * i), vectorIn(memory, 3 * i + 1), vectorIn(memory, 3 * i + 2));
}

Group groupIn(Wide memory, uint i) {
  TaggedCorner low = cornerIn(memory, 2 * i), high = cornerIn(memory, 2 * i + 1);
  return Group(low.corner, low.tag, high.corner, high.tag);
}

#define LOADED(wide_, plain_)     \
  if (kLanesInStep) return wide_; \
  return plain_;

#else
#define LOADED(wide_, plain_) return plain_;
#endif

TaggedCorner loadedA(uint i) { LOADED(cornerIn(Wide(projectedA), i), projectedA.at[i]) }
vec4 loadedB(uint i) { LOADED(vectorIn(Wide(projectedB), i), projectedB.at[i]) }
TaggedCorner loadedC(uint i) { LOADED(cornerIn(Wide(projectedC), i), projectedC.at[i]) }
vec2 loadedColumn(uint i) { LOADED(uintBitsToFloat(pairIn(Wide(columns), i)), columns.at[i]) }
Row loadedRow(uint i) { LOADED(rowIn(Wide(rows), i), rows.at[i]) }
Instance loadedInstance(uint i) { LOADED(instanceIn(Wide(instances), i), instances.at[i]) }
ColumnMotion loadedMotion(uint i) { LOADED(motionIn(Wide(columnMotions), i), columnMotions.at[i]) }
BeamFrame loadedBeamFrame(uint i) { LOADED(beamFrameIn(Wide(beamFrames), i), beamFrames.at[i]) }
Group loadedGroup(uint i) { LOADED(groupIn(Wide(groups), i), groups.at[i]) }

// Returns the box of a cluster. A Cluster is as large as two Groups, and its first half is laid out as a Group is.
Group loadedBox(uint i) {
  LOADED(groupIn(Wide(clusters), 2 * i),
         Group(clusters.at[i].low, clusters.at[i].vertexFirst, clusters.at[i].high, clusters.at[i].triangleFirst))
}
