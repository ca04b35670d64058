// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

namespace gnosphere {

/// Percentile by nearest rank: the smallest value that at least this share of the sorted values does not exceed. There
/// must be at least one value.
inline double rankOf(const std::vector<double>& sorted, double share) {
  const double rank = std::ceil(share * static_cast<double>(sorted.size()));
  return sorted[static_cast<size_t>(std::max(rank, 1.0)) - 1];
}

}  // namespace gnosphere
