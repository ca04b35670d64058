// SPDX-License-Identifier: Apache-2.0
// The instances whose transforms lie in buffers of the caller.
#pragma once

#include <cstdint>
#include <vector>

#include "common/shared.h"
#include "gnosphere/scene.hpp"

namespace gnosphere {

/// Transforms of neighbouring instances in memory of the caller's device, in single precision.
struct CallerTransforms {
  uint64_t address = 0, bytes = 0;  ///< of the first transform; of the memory from there on
  uint32_t stride = 0;              ///< bytes from one transform to the next
  bool byColumns = false;           ///< 4 x 4 numbers, column by column, instead of 3 x 4, row by row
  Vec3 origin;                      ///< point in the world to which the transforms are relative, in metres
  size_t firstInstance = 0, instances = 0;
};

/// Throws Error(invalidArgument) if the buffer is too small for the transforms, or the layout is wrong.
void validate(const CallerTransforms& buffer);

class TransformSources {
 public:
  bool any() const { return count_ > 0; }
  size_t count() const { return count_; }
  /// Whether the instance's transform lies in a buffer.
  bool has(size_t instance) const { return instance < entries_.size() && entries_[instance].source != gpu::kNone; }
  /// Tells where the transforms of the buffer's instances are.
  void set(const CallerTransforms& buffer);
  void remove(size_t instance);

  /// The buffers that instances still use, and per instance its place; see gpu::TransformedInstance.
  const std::vector<CallerTransforms>& buffers() const { return buffers_; }
  uint32_t bufferOf(size_t instance) const { return entries_[instance].source; }
  uint32_t numberOf(size_t instance) const { return entries_[instance].number; }

 private:
  struct Entry {
    uint32_t source = gpu::kNone, number = 0;
  };

  std::vector<Entry> entries_;             // by instance
  std::vector<CallerTransforms> buffers_;  // one without a user is taken by the next set()
  std::vector<size_t> users_;              // by buffer
  size_t count_ = 0;                       // of the instances
};

}  // namespace gnosphere
