// SPDX-License-Identifier: Apache-2.0
#include "geometry/triangle_numbers.hpp"

#include <algorithm>

#include "common/shared.h"

namespace gnosphere {

void TriangleNumbers::set(const std::vector<uint32_t>& triangles) {
  count_ = 0;
  firsts_.clear();
  for (const uint32_t each : triangles) {
    firsts_.push_back(count_);
    count_ += each;
  }
  uint32_t owner = 0;
  const auto lastWith = [&](uint32_t triangle) {
    while (owner + 1 < firsts_.size() && firsts_[owner + 1] <= triangle) ++owner;
    return owner;
  };
  ownerRanges_.clear();
  for (uint32_t first = 0; first < count_; first += gpu::kOwnerBlock) {
    const uint32_t from = lastWith(first);
    ownerRanges_.push_back({from, lastWith(std::min(first + gpu::kOwnerBlock, count_) - 1)});
  }
  ++version_;
}

// Finds the last instance whose first triangle number is at most `number`.
TriangleNumbers::Owner TriangleNumbers::ownerOf(uint32_t number) const {
  const auto [from, to] = ownerRanges_[number / gpu::kOwnerBlock];
  const auto owner = std::upper_bound(firsts_.begin() + from, firsts_.begin() + to + 1, number) - 1;
  const uint32_t end = owner + 1 < firsts_.end() ? owner[1] : count_;
  return {*owner, end - *owner, static_cast<uint32_t>(owner - firsts_.begin())};
}

}  // namespace gnosphere
