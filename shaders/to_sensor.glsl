// SPDX-License-Identifier: Apache-2.0
// From the mesh frame to the sensor's.

// Where the sensor is in the mesh frame, as a float.
vec3 pivotOf(Instance instance) { return vec3(instance.row0.w, instance.row1.w, instance.row2.w); }
bool mirrors(Instance instance) { return (instance.firstTriangle >> 31) != 0; }
uint placedFirstOf(Instance instance) { return instance.firstTriangle & 0x7fffffffu; }

// The pivot is subtracted first: that is exact where it matters.
vec3 toSensor(Instance to, vec3 position) {
  precise vec3 d = position - pivotOf(to);
  precise vec3 p = vec3(to.row0.x * d.x + to.row0.y * d.y + to.row0.z * d.z + to.offset.x,
                        to.row1.x * d.x + to.row1.y * d.y + to.row1.z * d.z + to.offset.y,
                        to.row2.x * d.x + to.row2.y * d.y + to.row2.z * d.z + to.offset.z);
  return p;
}
