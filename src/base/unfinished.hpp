// SPDX-License-Identifier: Apache-2.0
// The names of the files that os::removeUnfinishedAtEnd() removes. Their table has a fixed size, because a signal may
// come at any moment, and its handler may neither wait for a lock nor ask for memory.
#pragma once

#include <atomic>
#include <cstddef>
#include <filesystem>

namespace gnosphere::os {

class UnfinishedFiles {
 public:
  using Name = std::filesystem::path::value_type;

  /// Returns the place of a file in the table; -1 if there is no room for it.
  int add(const std::filesystem::path& file) {
    const auto& name = file.native();
    if (name.size() >= kLongest) return -1;
    for (int i = 0; i < kMost; ++i) {
      State free = State::free;
      if (!entries_[i].state.compare_exchange_strong(free, State::added)) continue;
      entries_[i].name[name.copy(entries_[i].name, kLongest)] = 0;
      entries_[i].state = State::named;
      return i;
    }
    return -1;
  }

  void drop(int place) {
    State named = State::named;  // unless the file is being removed: then its name stays as it is
    if (place >= 0) entries_[place].state.compare_exchange_strong(named, State::free);
  }

  /// Calls `remove` with each name, once.
  void removeAll(void (*remove)(const Name*)) {
    for (Entry& entry : entries_) {
      State named = State::named;
      if (entry.state.compare_exchange_strong(named, State::removed)) remove(entry.name);
    }
  }

 private:
  static constexpr int kMost = 64;
  static constexpr size_t kLongest = 4096;  // with the zero at the end
  enum class State { free, added, named, removed };
  struct Entry {
    std::atomic<State> state = State::free;
    Name name[kLongest];
  };
  static_assert(std::atomic<State>::is_always_lock_free);

  Entry entries_[kMost];
};

}  // namespace gnosphere::os
