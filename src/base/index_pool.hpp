// SPDX-License-Identifier: Apache-2.0
// A pool of indices for objects that come and go.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "base/room.hpp"
#include "gnosphere/error.hpp"

namespace gnosphere {

/// Keeps which of the indices 0..size - 1 exist and how often each is used. A freed index is taken again first.
class IndexPool {
 public:
  explicit IndexPool(const char* noun) : noun_(noun) {}

  size_t size() const { return uses_.size(); }
  bool has(size_t index) const { return index < uses_.size() && uses_[index] != kFree; }
  /// Returns the index that the next take() will occupy.
  size_t next() const { return free_.empty() ? uses_.size() : free_.back(); }
  /// Makes room, so that the next take() cannot throw, nor any giveBack().
  void reserve() {
    makeRoom(uses_, uses_.size() + 1);
    makeRoom(free_, uses_.size() + 1);
  }
  void take() {
    reserve();
    if (free_.empty())
      uses_.push_back(0);
    else {
      uses_[free_.back()] = 0;
      free_.pop_back();
    }
  }
  void giveBack(size_t index) noexcept {
    uses_[index] = kFree;
    free_.push_back(index);
  }
  /// Throws Error(invalidArgument) if the index never existed or was removed; the message says which, after `start`.
  void check(size_t index, const std::string& start = "") const {
    if (has(index)) return;
    throw Error(ErrorCode::invalidArgument,
                start + noun_ + " " + std::to_string(index) +
                    (index < size() ? " has been removed" : " does not exist, there are " + std::to_string(size())));
  }
  uint64_t& uses(size_t index) { return uses_[index]; }
  void checkUnused(size_t index, const char* users) const {
    check(index);
    if (uses_[index] > 0)
      throw Error(ErrorCode::invalidArgument, std::string(noun_) + " " + std::to_string(index) + " is used by " +
                                                  std::to_string(uses_[index]) + " " + users +
                                                  "; remove them before it");
  }

 private:
  static constexpr uint64_t kFree = ~uint64_t{0};
  const char* noun_;
  std::vector<uint64_t> uses_;
  std::vector<size_t> free_;
};

}  // namespace gnosphere
