// SPDX-License-Identifier: Apache-2.0
// Transforms points from the mesh frame to the sensor's frame.

// Returns the sensor's position in the mesh frame, rounded to float.
vec3 pivotOf(Instance instance) { return vec3(instance.row0.w, instance.row1.w, instance.row2.w); }
bool mirrors(Instance instance) { return (instance.firstTriangle >> 31) != 0; }
uint placedFirstOf(Instance instance) { return instance.firstTriangle & 0x7fffffffu; }

// The pivot is subtracted first: for points near the sensor that subtraction is exact.
vec3 toSensor(Instance to, vec3 position) {
  precise vec3 d = position - pivotOf(to);
  precise vec3 p = vec3(to.row0.x * d.x + to.row0.y * d.y + to.row0.z * d.z + to.offset.x,
                        to.row1.x * d.x + to.row1.y * d.y + to.row1.z * d.z + to.offset.y,
                        to.row2.x * d.x + to.row2.y * d.y + to.row2.z * d.z + to.offset.z);
  return p;
}
