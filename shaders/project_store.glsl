// SPDX-License-Identifier: Apache-2.0
// Stores the triangles that project_triangles.comp keeps, and their boxes, for stage bin.

void store(uint slot, Projected projected, Box box, uint material) {
  projectedA.at[slot] = projected.a;
  bool moves = MOTION && projected.moves;
  // The sign is set as a bit, because the range may be 0, and a device may take -0 for 0.
  uint range = floatBitsToUint(projected.b.w) | (moves ? 0x80000000u : 0u);
  projectedB.at[slot] = vec4(projected.b.xyz, uintBitsToFloat(range));
  projectedC.at[slot] = projected.c;
  projectedColumns.at[slot] = vec2(box.columnMin, box.columnMax);
  if (VIEWS) projectedViews.at[slot] = view;
  if (TIMED) projectedTimes.at[slot] = box.times;
  if ((EFFECTS & (kFootprint | kCutOuts | kTransmission)) != 0) projectedMaterials.at[slot] = material;
  if ((EFFECTS & kCutOuts) != 0) {
    projectedTexture.at[2 * slot] = vec4(projected.inTexture.a, projected.inTexture.b);
    projectedTexture.at[2 * slot + 1] = vec4(projected.inTexture.c, 0.0, 0.0);
  }
  if (moves)
    for (uint k = 0; k < 3; ++k) projectedMotions.at[3 * slot + k] = vec4(projected.velocities[k], 0.0);
}

// Cuts a large box into tiles.
void storeTiles(uint slot, Box box) {
  uint columnsPerTile = max(kTileBeams / boxRowCount(box), 1);
  uint columnCount = boxColumnCount(box);
  uint count = (columnCount + columnsPerTile - 1) / columnsPerTile;
  uint first = atomicAdd(counters.tiles, count);
  for (uint k = 0; k < count && first + k < frame.tileCapacity; ++k)
    tiles.at[first + k] = uvec4(slot, k * columnsPerTile, columnsPerTile, 0);
}

// Prepends one tile to the list of every slab that the box overlaps and in which beams look. The first tile has the
// index of the triangle. Panes have lists of their own.
void storeSlabs(uint slot, Box box, uint material) {
  uint slabs = (frame.columns - 1 >> frame.slabShift) + 1;
  uint lists = view * slabs;
  if (PANES && isPaneMaterial(material)) lists += frame.views * slabs;
  uint count = boxColumnCount(box), column = wrapColumn(firstColumn(box)), t = slot;
  bool room = true;  // tiles without room are counted, so that the next scan has enough
  bool first = true;
  for (uint k = 0; k < count;) {
    uint slab = column >> frame.slabShift, after = slab - frame.slabFirst;
    uint run = min(min(slab + 1 << frame.slabShift, frame.columns) - column, count - k);
    if (min(after, after + slabs) < frame.slabCount) {
      if (!first) {
        uint more = atomicAdd(counters.tiles, 1);
        room = more < frame.tileCapacity;
        t = frame.projectedCapacity + more;
      }
      first = false;
      if (room) tiles.at[t] = uvec4(slot, k, run, atomicExchange(slabEnds.at[lists + slab], t));
    }
    k += run;
    column = column + run == frame.columns ? 0 : column + run;
  }
}

void storeKept(bool keep, Projected projected, Box box, uint material) {
  bool small = BINNING == kBinningSlabs || isSmall(box);
  uvec4 smallOnes = ballotOf(keep && small);
  uint slot = 0;
  if (isFirstLane()) slot = atomicAdd(counters.projectedSmall, subgroupBallotBitCount(smallOnes));
  slot = slotAfter(slot, smallOnes);
  if (BINNING != kBinningSlabs) {
    uvec4 largeOnes = ballotOf(keep && !small);
    uint large = 0;
    if (isFirstLane()) large = atomicAdd(counters.projectedLarge, subgroupBallotBitCount(largeOnes));
    large = frame.projectedCapacity - 1 - slotAfter(large, largeOnes);
    if (!small) slot = large;
  }
  if (BINNING == kBinningSlabs) {
    uint sum = subgroupAdd(keep ? boxRowCount(box) * boxColumnCount(box) : 0);
    if (isFirstLane() && sum > 0) atomicAdd(counters.boxedBeams, sum);
  }
  if (keep && slot < frame.projectedCapacity) {
    store(slot, projected, box, material);
    if (BINNING == kBinningSlabs)
      storeSlabs(slot, box, material);
    else if (!small)
      storeTiles(slot, box);
  }
}
