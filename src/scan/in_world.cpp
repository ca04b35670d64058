// SPDX-License-Identifier: Apache-2.0
#include "base/transform.hpp"
#include "gnosphere/error.hpp"
#include "gnosphere/scan.hpp"
#include "scan/columns.hpp"

namespace gnosphere {
namespace {

/// Maps `count` vectors of three floats each in place; they lie side by side.
void map(const Transform& transform, float* vectors, size_t count) {
  for (float* v = vectors; v < vectors + 3 * count; v += 3) {
    const Vec3 mapped = transform * Vec3{v[0], v[1], v[2]};
    v[0] = static_cast<float>(mapped.x);
    v[1] = static_cast<float>(mapped.y);
    v[2] = static_cast<float>(mapped.z);
  }
}

}  // namespace

Scan inWorld(Scan scan) {
  const size_t entries = scan.ranges.size();
  if (scan.points.size() != 3 * entries) throw Error(ErrorCode::invalidArgument, "the scan has no points to map");
  if (scan.skewed)
    throw Error(
        ErrorCode::invalidArgument,
        "the sensor moved during the scan, whose columns have frames of their own; scan with sensor-motion.deskew");
  if (!scan.poseKnown)
    throw Error(ErrorCode::invalidArgument,
                "the file that the scan was read from does not state the sensor's pose; PCD files do, so write one");
  const Vec3 one = {1, 1, 1};
  map(composed(scan.pose.position, scan.pose.orientation, one), scan.points.data(), entries);
  const Transform rotation = composed({}, scan.pose.orientation, one);
  for (const Field field : {Field::normal, Field::velocity})
    if (scan.has(field)) map(rotation, ScanColumns(scan).data<float>(field), entries);
  scan.pose = {};
  return scan;
}

}  // namespace gnosphere
