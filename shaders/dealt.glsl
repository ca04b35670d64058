// SPDX-License-Identifier: Apache-2.0
// The order in which workgroups take work. Lavapipe hands each thread an equal run of neighbouring workgroups, all at
// once, and the work in some directions costs much more than in others.

// Returns the share of the work that workgroup or row i of `count` takes: i itself on a GPU. On a CPU a run of
// neighbouring workgroups gets shares from eight parts of the work.
uint dealt(uint i, uint count) {
  if (!kLanesInStep || count < 2) return i;
  uint parts = min(count / 2, 8u), each = count / parts;
  return i < parts * each ? i % parts * each + i / parts : i;
}
