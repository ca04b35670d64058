// SPDX-License-Identifier: Apache-2.0
// The beams of the sensor. The index of a beam in a grid is row * columns + column. The beams of a head whose rows have
// shifts, and of a list whose beams all lie in places of a grid, are indexed in the same way (MAPPED). Other lists are
// sorted into the cells of a grid, cell (row, column) after cell (LISTED); the index is the place in that order, and it
// also takes the place of the beam's row and column wherever values of a beam are looked up.

// True if a table has the numbers of the beams in a scan, and beams may have ranges of their own.
#define NUMBERED (LISTED || MAPPED)

uint rowOf(uint index) { return LISTED ? index : index / frame.columns; }
uint columnOf(uint index) { return LISTED ? index : index % frame.columns; }

// Where a beam is in the grid. Row and column of a beam of a list are its index.
struct Place {
  uint row, column, index;
};

uint indexOf(uint row, uint column) { return LISTED ? column : row * frame.columns + column; }

// Kernels that process all beams have one row of workgroups per row of the grid. A list is one row. A grid that covers a
// sector of the turn has columns without beams, which these kernels leave out.
uint beamsPerRow() { return LISTED ? frame.beams : frame.beamColumnCount; }

// Returns the column of the k-th of a row's beamsPerRow() beams.
uint beamColumn(uint k) {
  if (LISTED) return k;
  uint column = frame.beamColumnFirst + k;
  return min(column, column - frame.columns);  // after the last column comes the first again
}

// The values that the beams of a row share. A list of beams has none.
struct BeamRow {
  vec3 angles;
  uint channel;
  uint azimuths;  // where its run of `columns` begins
};

BeamRow loadRow(uint row) {
  if (LISTED) return BeamRow(vec3(0.0), 0, 0);
  return BeamRow(loadedRow(row).angles, loadedRow(row).channel, AZIMUTH_OFFSETS ? loadedRow(row).azimuths : 0);
}

Beam listedBeam(uint index) {
  vec4 angles = beamAngles.at[tableEntry(index)];
  return beamOf(angles.xy, angles.z, angles.w);
}

Beam beamIn(BeamRow row, uint column) {
  if (LISTED) return listedBeam(column);
  return beamOf(loadedColumn(row.azimuths + column), row.angles.x, row.angles.y);
}

Beam beamWith(uint index) { return beamIn(loadRow(rowOf(index)), columnOf(index)); }

// Returns the number of a beam in the scan; kNone for a place without a beam, and behind the last beam of a
// table that has fewer than others.
uint numberIn(BeamRow row, uint index, uint column) {
  return NUMBERED ? beamNumbers.at[tableEntry(index)] : row.channel * frame.columns + column;
}
uint numberOf(uint index) { return numberIn(loadRow(rowOf(index)), index, columnOf(index)); }

// Returns the least and the largest range of a beam.
vec2 rangesOf(uint index) {
  if (NUMBERED && frame.hasBeamRanges != 0) return beamRanges.at[tableEntry(index)];
  return vec2(frame.rangeMin, frame.rangeMax);
}

// True if a hit at this range ends the beam without a return.
bool hidesItself(uint index, float range) { return NUMBERED && frame.hidesNear != 0 && range < rangesOf(index).x; }
