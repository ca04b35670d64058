// SPDX-License-Identifier: Apache-2.0
// Computes entries of the farthest-range table: the largest range among the words of an entry's beams.

// For the next shells only the rows in which they have content are computed; for a still image, all rows.
bool worthKnowing(uint fineRow) {
  bool later = fineRow * kFineRows < shells.of[pass.shell].laterRowsUp &&
               (fineRow + 1) * kFineRows > frame.rows - shells.of[pass.shell].laterRowsDown;
  return later || pass.table == kTableAll;
}

uint farthestIn(uvec2 entry) {
  uint result = 0;
  uint rowEnd = min((entry.y + 1) * kFineRows, frame.rows), first = entry.x * kFineColumns;
  uint last = min(kFineColumns, frame.columns - first) - 1;
  if (LISTED) {
    for (uint row = entry.y * kFineRows; row < rowEnd && result != kNone; ++row) {
      uint cell = cellEntry(row * frame.columns + first);
      for (uint index = cellStarts.at[cell], end = cellStarts.at[cell + last + 1]; index < end && result != kNone; ++index)
        result = max(result, words.at[beamEntry(index)].y);
    }
    return result;
  }
  // A beam without a hit hides nothing, so the search stops there.
  for (uint row = entry.y * kFineRows; row < rowEnd && result != kNone; ++row)
    [[unroll]] for (uint k = 0; k < kFineColumns; ++k)
      result = max(result, words.at[firstWord() + row * frame.columns + first + min(k, last)].y);
  return result;
}

// Computes a coarse entry of the table and its fine entries, one per invocation. All lanes of the subgroup must call
// this. A workgroup per coarse entry would need barriers; on lavapipe that took three times as long as everything
// else.
void computeEntry(uvec2 coarse) {
  uint perRow = (frame.columns + kFineColumns - 1) / kFineColumns, fineRows = (frame.rows + kFineRows - 1) / kFineRows;
  uvec2 across = uvec2(kCoarseColumns / kFineColumns, kCoarseRows / kFineRows);
  uint largest = 0;
  uint any = 0;
  for (uint k = gl_SubgroupInvocationID; k < across.x * across.y; k += gl_SubgroupSize) {
    uvec2 entry = coarse * across + uvec2(k % across.x, k / across.x);
    if (entry.x >= perRow || entry.y >= fineRows) continue;
    bool known = worthKnowing(entry.y);
    uint found = known ? farthestIn(entry) : kNone;
    farthest.at[firstFarthest() + entry.y * perRow + entry.x] = found;
    if (known) largest = max(largest, found);
    any |= uint(known);
  }
  largest = subgroupMax(largest);
  any = subgroupMax(any);
  uint coarsePerRow = (frame.columns + kCoarseColumns - 1) / kCoarseColumns;
  if (subgroupElect())
    farthest.at[firstFarthest() + perRow * fineRows + coarse.y * coarsePerRow + coarse.x] = any != 0 ? largest : kNone;
}
