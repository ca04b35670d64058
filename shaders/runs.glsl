// SPDX-License-Identifier: Apache-2.0
// Division of the beams among subgroups. Each subgroup processes a run of neighbouring beams: some devices execute the
// subgroups of a workgroup one after the other, and these then read and write memory in order. A dispatch may be a part
// of its step: the workgroups of a step are counted through.
#include "dealt.glsl"

// For a row of workgroups per row of beams (see beamsPerRow()): returns the first beam of the subgroup's run and the one
// after its last. At the end of a row the run may be empty.
uvec2 runOfBeams() {
  uint length = kResolveColumns / gl_NumSubgroups;
  uint first = (pass.firstGroup + gl_WorkGroupID.x) * kResolveColumns + gl_SubgroupID * length;
  return uvec2(first, min(first + length, beamsPerRow()));
}

// The same for `count` beams that all workgroups share.
uvec2 runOf(uint count) {
  uint subgroups = pass.groups * gl_NumSubgroups, group = dealt(pass.firstGroup + gl_WorkGroupID.x, pass.groups);
  uint steps = (count + subgroups * gl_SubgroupSize - 1) / (subgroups * gl_SubgroupSize);
  uint first = (group * gl_NumSubgroups + gl_SubgroupID) * steps * gl_SubgroupSize;
  return uvec2(first, min(first + steps * gl_SubgroupSize, count));
}

// Returns the number of this subgroup among those of all workgroups of the step.
uint subgroupOfStep() { return (pass.firstGroup + gl_WorkGroupID.x) * gl_NumSubgroups + gl_SubgroupID; }
