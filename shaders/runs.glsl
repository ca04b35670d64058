// SPDX-License-Identifier: Apache-2.0
// How kernels that process all beams of a row divide them (see beamsPerRow()). Each subgroup processes a run of
// neighbouring beams: some devices execute the subgroups of a workgroup one after the other, and these then read and
// write memory in order. This file must be included after the size of the workgroup has been declared.

uint lanes() { return min(gl_SubgroupSize, gl_WorkGroupSize.x); }
uint laneNumber() { return gl_LocalInvocationID.x % lanes(); }

// Returns the first beam of the subgroup's run and the one after its last. At the end of a row the run may be empty.
uvec2 runOfBeams() {
  uint length = kResolveColumns * lanes() / gl_WorkGroupSize.x;
  uint first = gl_WorkGroupID.x * kResolveColumns + gl_LocalInvocationID.x / lanes() * length;
  return uvec2(first, min(first + length, beamsPerRow()));
}
