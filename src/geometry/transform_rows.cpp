// SPDX-License-Identifier: Apache-2.0
#include "geometry/transform_rows.hpp"

#include <algorithm>
#include <string>

#include "base/quaternion.hpp"
#include "base/threads.hpp"
#include "gnosphere/error.hpp"

namespace gnosphere {
namespace {

// A quaternion without length becomes a transform that is not finite.
template <typename T>
Transform transformOfPose(const T* values) {
  const auto [x, y, z, w] = withUsableLength({values[3], values[4], values[5], values[6]});
  const double s = 2 / (x * x + y * y + z * z + w * w);
  const double xx = s * x * x, yy = s * y * y, zz = s * z * z;
  const double xy = s * x * y, xz = s * x * z, yz = s * y * z, wx = s * w * x, wy = s * w * y, wz = s * w * z;
  return {{1 - yy - zz, xy - wz, xz + wy, values[0],  //
           xy + wz, 1 - xx - zz, yz - wx, values[1],  //
           xz - wy, yz + wx, 1 - xx - yy, values[2]}};
}

template <typename T>
void read(std::span<const T> values, size_t count, std::vector<Transform>& transforms) {
  if (values.size() != 12 * count && values.size() != 7 * count)
    throw Error(ErrorCode::invalidArgument, "there must be 12 or 7 numbers for each of " + std::to_string(count) +
                                                " instances; " + std::to_string(values.size()) + " numbers were given");
  const size_t width = count == 0 ? 0 : values.size() / count;
  transforms.resize(count);
  inRuns(count, kTransformsPerRun, threadCount(), [&](uint64_t first, uint64_t end) {
    for (uint64_t i = first; i < end; ++i) {
      const T* row = &values[i * width];
      if (width == 7)
        transforms[i] = transformOfPose(row);
      else
        std::copy_n(row, 12, transforms[i].rows.begin());
    }
  });
}

}  // namespace

void readTransforms(std::span<const float> values, size_t count, std::vector<Transform>& transforms) {
  read(values, count, transforms);
}
void readTransforms(std::span<const double> values, size_t count, std::vector<Transform>& transforms) {
  read(values, count, transforms);
}

}  // namespace gnosphere
