// SPDX-License-Identifier: Apache-2.0
// The numbers of the triangles that the instances of a scene place.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace gnosphere {

/// Triangles are numbered instance by instance, so that a triangle's number leads to its instance.
class TriangleNumbers {
 public:
  /// Numbers the triangles anew; `triangles` has their number by instance.
  void set(const std::vector<uint32_t>& triangles);

  /// Version of the numbers: with the same version they are the same.
  uint64_t version() const { return version_; }
  /// The number of an instance's first triangle.
  uint32_t firstOf(size_t instance) const { return firsts_[instance]; }

  /// The instance to which a triangle belongs. Its triangles are numbered first..first + triangles - 1.
  struct Owner {
    uint32_t first = 0, triangles = 0, instance = 0;
  };
  Owner ownerOf(uint32_t number) const;
  /// For each block of gpu::kOwnerBlock triangles: the first and the last instance in it.
  const std::vector<std::array<uint32_t, 2>>& ownerRanges() const { return ownerRanges_; }

 private:
  std::vector<uint32_t> firsts_;  // by instance
  std::vector<std::array<uint32_t, 2>> ownerRanges_;
  uint32_t count_ = 0;
  uint64_t version_ = 0;
};

}  // namespace gnosphere
