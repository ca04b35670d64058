// SPDX-License-Identifier: Apache-2.0
// Motion within a scan: the sensor's pose when a column fires, and moving instances. Projected triangles are in the
// sensor's frame at the middle of the scan; corners of moving instances are at their positions at the start of the
// scan.

#include "common/laser.h"
#include "whole_numbers.glsl"

// True if all lasers see a triangle always in the same place; `moves` is the triangle's.
bool atRest(bool moves) { return !moves && motion.sensor == 0; }

// Applies the rotation without the shift. Calling through() with w = 0 is not the same: adding 0 turns -0 into 0, and
// some compilers omit the addition.
vec3 rotated(vec4 row0, vec4 row1, vec4 row2, vec3 d) {
  precise vec3 result = vec3(row0.x * d.x + row0.y * d.y + row0.z * d.z, row1.x * d.x + row1.y * d.y + row1.z * d.z,
                             row2.x * d.x + row2.y * d.y + row2.z * d.z);
  return result;
}

vec3 inColumn(ColumnMotion column, vec3 p) { return through(column.row0, column.row1, column.row2, p); }

// Returns the velocity of a point of a mesh, which moves with its instance, in the sensor's axes.
vec3 velocityOf(InstanceMotion moving, vec3 p) { return through(moving.row0, moving.row1, moving.row2, p); }

// Finds the velocity of the point of an instance that is at `p`, in the frame at the middle of the scan, at a time in
// seconds. The point is `x` from the instance's pivot in the mesh frame, and Cramer's rule finds x, as
// p = (M + time V) x + where the pivot is by then, with the linear part M of the instance's map at the start of the scan
// and V of the velocity. Returns false if the instance is flat at this time.
bool findVelocity(InstanceMotion moving, Instance instance, float time, vec3 p, out vec3 velocity) {
  precise vec3 a = instance.row0.xyz + time * moving.row0.xyz, b = instance.row1.xyz + time * moving.row1.xyz,
               c = instance.row2.xyz + time * moving.row2.xyz;
  vec3 pivot = vec3(instance.row0.w, instance.row1.w, instance.row2.w);
  precise vec3 q = p - instance.offset - time * velocityOf(moving, pivot);
  vec3 bc = crossOf(b, c), ca = crossOf(c, a), ab = crossOf(a, b);
  float determinant = dotOf(a, bc);
  precise vec3 x = (q.x * bc + q.y * ca + q.z * ab) * quotient(1.0, determinant);
  velocity = velocityOf(moving, pivot + x);
  return abs(determinant) > 1e-5 * length(a) * length(b) * length(c);
}

// Returns the position of a moving corner when the column fires, in the column's frame.
vec3 inColumn(ColumnMotion column, vec3 corner, vec3 velocity) {
  precise vec3 p = corner + velocity * column.velocity.w;
  return inColumn(column, p);
}

// Returns the sensor at a place in its table, which may lie between two entries.
ColumnMotion columnMotionAt(float place) {
  uint before = uint(whole(floor(place))), entry = firstMoment() + before;
  return motionBetween(loadedMotion(entry), loadedMotion(entry + 1), place - float(before));
}

// Returns the sensor when the beam in a column of a row fires. Beams of a list, and those of rows with shifts, fire
// between two entries of the table, which a straight line joins. Where the path bends at a stamp between two entries, the line
// cuts the bend off, by at most a quarter of the entries' distance in time times the change of the velocity.
ColumnMotion columnMotionOf(uint row, uint column) {
  if (LISTED) return columnMotionAt(beamOrigins.at[tableEntry(column)].w);
  if (STAGGERED) return columnMotionAt(momentOf(loadedRow(row).first, loadedRow(row).lag, column, frame.columns));
  return loadedMotion(firstMoment() + column);
}

// Returns the sensor at a whole place in its table; other places are rounded down. The places of a grid are its columns. A
// list asks for the middles of runs of slices, which are whole, because the number of places of a slice is even.
ColumnMotion columnMotionOfPlace(float place) {
  return loadedMotion(firstMoment() + uint(int(floor(place)) + int(frame.momentsBefore)));
}

// Returns the origin of a row's laser in the head: forward along the beam's azimuth, left, up.
vec3 laserOf(uint row) { return LISTED ? beamOrigins.at[tableEntry(row)].xyz : rowOrigins.at[row].xyz; }

// Returns the position of a row's laser when it fires.
vec3 originOf(uint row, vec2 azimuth) {
  return laserAt(laserOf(row), azimuth);
}

// Returns the point at a range along a beam, in the frame that points are reported in. `at` is where the sensor is when
// the beam fires.
vec3 reported(ColumnMotion at, vec3 laser, vec3 direction, float range) {
  if (STAGGERED && motion.sensor == 0) return reportedPoint(columnMotions.at[firstMoment()], laser, direction, range);
  return reportedPoint(at, laser, direction, range);
}

vec3 reported(uint column, uint row, vec2 azimuth, vec3 direction, float range) {
  return reported(columnMotionOf(row, column), originOf(row, azimuth), direction, range);
}

// Returns the largest angle, in radians, by which an object at least `distance` away appears to move while the sensor
// shifts and turns. asin(x) is at most 1.05 x up to half a radian; beyond that the result is 4, which stands for every
// direction.
float seemingAngle(float shift, float turn, float distance) {
  float angle = turn;
  if (shift > 0.0) angle += shift < 0.5 * distance ? 1.05 * shift / distance : 4.0;
  return angle < 0.5 ? angle : 4.0;
}

// Transforms a direction from the column's frame to the frame that points are reported in.
vec3 reportedDirection(ColumnMotion at, vec3 direction) {
  return rotated(at.report0, at.report1, at.report2, direction);
}

// Transforms a point from the column's frame to the frame at the middle of the scan. The rows are a rotation and a
// shift, so the transpose inverts the rotation.
vec3 fromColumn(ColumnMotion at, vec3 p) {
  precise vec3 q = p - vec3(at.row0.w, at.row1.w, at.row2.w);
  precise vec3 result = at.row0.xyz * q.x + at.row1.xyz * q.y + at.row2.xyz * q.z;
  return result;
}

// Transforms a plane (normal, offset) from the frame at the middle of the scan to a frame with the column's axes and
// the laser as its origin.
vec4 seenPlane(ColumnMotion at, vec3 laser, vec4 plane) {
  vec3 origin = fromColumn(at, laser);
  precise float offset = plane.x * origin.x + plane.y * origin.y + plane.z * origin.z + plane.w;
  return vec4(rotated(at.row0, at.row1, at.row2, plane.xyz), offset);
}
