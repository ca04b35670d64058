// SPDX-License-Identifier: Apache-2.0
// Finds the beams of a box, and keeps the nearest hit of every beam in `words`.

#ifdef INT64_ATOMICS
layout(buffer_reference, scalar, buffer_reference_align = 16) coherent buffer Words64 { uint64_t at[]; };
Words64 words64 = Words64(words);
#endif

float farthestOf(uint index) {
  return BINNING == kBinningLists ? frame.rangeMax : min(uintBitsToFloat(min(words.at[index].y, 0x7f800000u)), frame.rangeMax);
}

// Any invocation may call this. Ranges are positive, so their bits order like numbers.
void offerNearest(uint beam, float range, uint id) {
#ifdef INT64_ATOMICS
  atomicMin(words64.at[beam], packUint2x32(uvec2(id, floatBitsToUint(range))));
#endif
}

// Returns the beam in the k-th column of a box and in a row, and its index in `words`. If the row's azimuth offset
// is n columns, rounded down, its beam at a grid column is beam number (grid column - n) of the row. So k counts grid
// columns in every row, and the slab that owns the grid column owns the beam.
Beam beamAt(Box box, uint k, uint row, out uint index) {
  vec3 angles = rows.at[row].angles;
  vec4 offset = AZIMUTH_OFFSETS ? rows.at[row].offset : vec4(0.0);
  uint column = wrapColumn(firstColumn(box) + int(k) - (AZIMUTH_OFFSETS ? int(floor(offset.z)) : 0));
  index = row * frame.columns + column;
  return beamOf(azimuthOfBeam(columns.at[column], offset, AZIMUTH_OFFSETS, INSIDE == kInsideExact), angles.x, angles.y);
}
