// SPDX-License-Identifier: Apache-2.0
// Panes: triangles of materials that let light pass. Where beams are single lines, `words` has the nearest opaque hit
// of each beam, and its list has the panes before that hit. An opaque hit ends light, however close to a pane.

// The bit of a link of a footprint's chain that says that its triangle is a pane.
const uint kPaneBit = 1u << 31;

bool isPaneMaterial(uint material) { return optics.at[material].passage.x > 0.0; }
bool isPane(uint projected) { return isPaneMaterial(projectedMaterials.at[projected]); }

// Returns whether a hit comes before the beam's word.
bool comesBefore(float range, uint id, uvec2 word) {
  uint bits = floatBitsToUint(range);
  return bits < word.y || (bits == word.y && id < word.x);
}
