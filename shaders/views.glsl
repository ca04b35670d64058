// SPDX-License-Identifier: Apache-2.0
// A submission may scan several views at once. A view is one shot of the sensor. Words and the farthest-range table lie
// view after view; rows, columns and indices of beams count within a view.

uint view = 0;  // the view for which this invocation works

// Sets the view to that of an instance. Each entry of `instances` belongs to one view.
void setView(uint instance) {
  if (VIEWS) view = instanceViews.at[instance];
}

// Entries of the farthest-range table per view, on its fine and on its coarse level.
uint fineEntries() {
  return ((frame.columns - 1) / kFineColumns + 1) * ((frame.rows - 1) / kFineRows + 1);
}
uint coarseEntries() {
  return ((frame.columns - 1) / kCoarseColumns + 1) * ((frame.rows - 1) / kCoarseRows + 1);
}

// The first entries of the view in `words`, in `farthest` and in `staleEntries`.
uint firstWord() { return VIEWS ? view * frame.beams : 0; }
uint firstFarthest() { return VIEWS ? view * (fineEntries() + coarseEntries()) : 0; }
uint firstStale() { return VIEWS ? view * coarseEntries() : 0; }
