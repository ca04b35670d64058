// SPDX-License-Identifier: Apache-2.0
// Transforms of many instances that a caller gives as one array of numbers.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "gnosphere/scene.hpp"

namespace gnosphere {

/// Fewer transforms than this are not worth a thread.
constexpr uint64_t kTransformsPerRun = 4096;

/// Replaces `transforms` by `count` transforms. `values` holds 12 numbers per transform, its rows, or 7: a position x,
/// y, z and a quaternion x, y, z, w of any length but zero. Throws Error(invalidArgument) if there are as many values
/// for neither; values are not checked otherwise.
void readTransforms(std::span<const float> values, size_t count, std::vector<Transform>& transforms);
void readTransforms(std::span<const double> values, size_t count, std::vector<Transform>& transforms);

}  // namespace gnosphere
