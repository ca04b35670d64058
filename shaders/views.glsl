// SPDX-License-Identifier: Apache-2.0
// A submission may scan several views at once. A view is one shot of the sensor. Words and the farthest-range table lie
// view after view; rows, columns and indices of beams count within a view.

uint view = 0;       // the view for which this invocation works
uint viewTable = 0;  // of a list: the table of the view's beams

// Sets the view, and loads how its sensor moves, or where its lasers are.
void lookFrom(uint ofView) {
  if (!VIEWS) return;
  view = ofView;
  if (LISTED) viewTable = viewTables.at[view].x;
  if ((MOTION || (LISTED && ORIGINS)) && frame.moments != 0) loadMotionOf(view);
}

// Sets the view to that of an instance. Each entry of `instances` belongs to one view.
void setView(uint instance) {
  if (VIEWS) lookFrom(instanceViews.at[instance]);
}

// Sets the view to that of a projected triangle.
void setViewOf(uint projected) {
  if (VIEWS) lookFrom(projectedViews.at[projected]);
}

// The first entry of the view in `columnMotions`.
uint firstMoment() { return VIEWS ? view * frame.moments : 0; }

// Kernels that process all beams have a row of workgroups per row of the grid, view after view. Sets the view to that of
// a row of workgroups, and returns the row of the grid.
uint rowInView(uint groupRow) {
  if (!VIEWS) return groupRow;
  uint rows = LISTED ? 1 : frame.rows;
  lookFrom(groupRow / rows);
  return groupRow - view * rows;
}

// Entries of the farthest-range table per view, on its fine and on its coarse level.
uint fineEntries() {
  return ((frame.columns - 1) / kFineColumns + 1) * ((frame.rows - 1) / kFineRows + 1);
}
uint coarseEntries() {
  return ((frame.columns - 1) / kCoarseColumns + 1) * ((frame.rows - 1) / kCoarseRows + 1);
}

// The first entries of the view in `words` and other arrays with an entry per index of a beam, in `farthest` and in
// `staleEntries`.
uint firstWord() { return VIEWS ? view * frame.beams : 0; }
uint firstFarthest() { return VIEWS ? view * (fineEntries() + coarseEntries()) : 0; }
uint firstStale() { return VIEWS ? view * coarseEntries() : 0; }

uint beamsOfViews() { return VIEWS ? frame.views * frame.beams : frame.beams; }

// Returns the entry of a beam of the view in arrays with an entry per index of a beam.
uint beamEntry(uint index) { return firstWord() + index; }

// Sets the view to that of an entry of such arrays, and returns the index of the beam in the view.
uint enterView(uint entry) {
  if (!VIEWS) return entry;
  lookFrom(entry / frame.beams);
  return entry - view * frame.beams;
}

// Returns the entry of echo k of a beam of the view in `echoes`. Neighbouring beams have their first echoes side by side,
// then the second ones.
uint echoPlace(uint index, uint k) { return k * beamsOfViews() + beamEntry(index); }

// Returns the entry of a beam in arrays of results with one entry per beam, from the beam's number. Views of a list may
// be parts of one shot.
uint resultOf(uint beam) {
  if (!VIEWS) return beam;
  return (LISTED ? viewTables.at[view].y : view) * frame.scanBeams + beam;
}

// Returns the first entry of the view's table in an array of the sensor with so many entries per table.
uint firstOfTable(uint entries) { return LISTED ? (VIEWS ? viewTable : frame.table) * entries : 0; }

// Returns the entry of a beam in arrays of the sensor, from its index.
uint tableEntry(uint index) { return firstOfTable(frame.beams) + index; }

// Returns the entry of a cell of a list in `cellStarts`.
uint cellEntry(uint cell) { return firstOfTable(frame.rows * frame.columns + 1) + cell; }
