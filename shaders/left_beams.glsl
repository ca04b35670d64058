// SPDX-License-Identifier: Apache-2.0
// The beams that the first pass of effects_footprint leaves to the later ones. Beams are sorted into classes by their
// number of candidates, because the lanes of a subgroup wait for the beam with the most. Each class has room for all beams
// in `hardBeams`: beams that meet no pane are listed from its start on, the others from its end on.

// Returns the class of a beam. A class spans half an octave.
uint effortOf(uint candidateCount) {
  uint larger = candidateCount + 1, octave = uint(findMSB(larger));
  uint half_ = octave == 0 ? 0 : larger >> octave - 1 & 1;
  return min(max(2 * octave + half_, 3) - 3, kEffortClasses - 1);
}

uint placeInClass(uint effort, uint number, uint ofPass) {
  uint beams = beamsOfViews();
  return effort * beams + (ofPass == kPassFootprintPanesToo ? beams - 1 - number : number);
}

// Lists a beam for a pass and in a class.
void leave(uint index, uvec2 passAndEffort) {
  uint effort = passAndEffort.y, number = 0;
  if (passAndEffort.x == kPassFootprintPanesToo)
    number = atomicAdd(counters.paneBeams[effort], 1);
  else
    number = atomicAdd(counters.edgeBeams[effort], 1);
  hardBeams.at[placeInClass(effort, number, passAndEffort.x)] = beamEntry(index);
}

uint leftBeams(uint effort) {
  return PASS == kPassFootprintPanesToo ? counters.paneBeams[effort] : counters.edgeBeams[effort];
}

uint leftBeams() {
  uint sum = 0;
  [[unroll]] for (uint effort = 0; effort < kEffortClasses; ++effort) sum += leftBeams(effort);
  return sum;
}

// Returns beam i of those left to this pass, as beamEntry() does. The first ones have the most candidates.
uint leftBeam(uint i) {
  uint place = 0;
  bool found = false;
  [[unroll]] for (uint k = 0; k < kEffortClasses; ++k) {
    uint effort = kEffortClasses - 1 - k, count = leftBeams(effort);
    place = !found && i < count ? placeInClass(effort, i, PASS) : place;
    found = found || i < count;
    i -= found ? 0 : count;
  }
  return hardBeams.at[place];
}
