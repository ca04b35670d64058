// SPDX-License-Identifier: Apache-2.0
// The order in which workgroups take work. Lavapipe hands each thread an equal run of neighbouring workgroups, all at
// once, and the work in some directions costs much more than in others.

// Returns the share of the work that workgroup or row i of `count` takes: i itself on a GPU. On a CPU a run of
// neighbouring workgroups gets shares from 64 parts of the work. With 8 parts, footprints took 1.08 of the time, because
// beams with many candidates come first.
uint dealt(uint i, uint count) {
  if (!kLanesInStep || count < 2) return i;
  uint parts = min(count / 2, 64u), each = count / parts;
  return i < parts * each ? i % parts * each + i / parts : i;
}
