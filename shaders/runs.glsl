// SPDX-License-Identifier: Apache-2.0
// How kernels that process all beams of a row divide them (see beamsPerRow()). Each subgroup processes a run of
// neighbouring beams: some devices execute the subgroups of a workgroup one after the other, and these then read and
// write memory in order.

// Returns the first beam of the subgroup's run and the one after its last. At the end of a row the run may be empty.
uvec2 runOfBeams() {
  uint length = kResolveColumns / gl_NumSubgroups;
  uint first = gl_WorkGroupID.x * kResolveColumns + gl_SubgroupID * length;
  return uvec2(first, min(first + length, beamsPerRow()));
}
