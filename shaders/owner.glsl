// SPDX-License-Identifier: Apache-2.0
// Finds the instance of a placed triangle. With several views, an instance is an entry of the view.

uint firstTriangleOf(uint instance) { return instances.at[instance].firstTriangle & 0x7fffffffu; }

// Returns the last of the instances first..last whose first triangle is not above `id`; `first` if there is none.
uint lastNotAbove(uint first, uint last, uint id) {
  while (first < last) {
    uint middle = (first + last + 1) / 2;
    if (firstTriangleOf(middle) <= id)
      first = middle;
    else
      last = middle - 1;
  }
  return first;
}

// Returns the last instance whose first triangle is not above `id`.
uint instanceOf(uint id) {
  if (!VIEWS) {
    uvec2 range = ownerRanges.at[id / kOwnerBlock];
    return lastNotAbove(range.x, range.y, id);
  }
  // A view has two runs of instances, those of all worlds and those of its own, whose triangle numbers are interleaved. The
  // owner is the last instance of both runs whose first triangle is not above `id`.
  uint found = kNone, foundFirst = 0;
  for (uint k = 0; k < 2; ++k) {
    uvec2 run = ownerRanges.at[2 * view + k];
    if (run.x == run.y) continue;
    uint instance = lastNotAbove(run.x, run.y - 1, id), first = firstTriangleOf(instance);
    if (first > id || (found != kNone && first < foundFirst)) continue;
    found = instance;
    foundFirst = first;
  }
  return found;
}

// Returns the triangle's number within its mesh, and its instance.
uvec2 ownerOf(uint id) {
  uint instance = instanceOf(id);
  return uvec2(id - firstTriangleOf(instance), instance);
}
