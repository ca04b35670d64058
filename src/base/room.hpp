// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace gnosphere {

/// Makes room for `count` entries, so that growing to that size cannot throw. Capacities double, as with push_back().
template <typename T>
void makeRoom(std::vector<T>& values, size_t count) {
  if (values.capacity() < count) values.reserve(std::max(count, 2 * values.capacity()));
}

}  // namespace gnosphere
