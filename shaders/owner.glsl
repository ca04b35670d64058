// SPDX-License-Identifier: Apache-2.0
// Finds the instance of a placed triangle.

uint firstTriangleOf(uint instance) { return instances.at[instance].firstTriangle & 0x7fffffffu; }

// Returns the last instance whose first triangle is not above `id`.
uint instanceOf(uint id) {
  uvec2 range = ownerRanges.at[id / kOwnerBlock];
  while (range.x < range.y) {
    uint middle = (range.x + range.y + 1) / 2;
    if (firstTriangleOf(middle) <= id)
      range.x = middle;
    else
      range.y = middle - 1;
  }
  return range.x;
}

// Returns the triangle's number within its mesh, and its instance.
uvec2 ownerOf(uint id) {
  uint instance = instanceOf(id);
  return uvec2(id - firstTriangleOf(instance), instance);
}
