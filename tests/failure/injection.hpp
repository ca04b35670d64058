// SPDX-License-Identifier: Apache-2.0
// Allocations of host memory, and operations on files, that fail once: the n-th one while an Injection lives.
#pragma once

#include <exception>
#include <functional>
#include <string>

namespace gnosphere::test {

enum class Fails { memory, files };

/// Counts the library's allocations, or its operations on files, and lets one of them fail. Calls of drivers and of the
/// tests themselves are not counted.
class Injection {
 public:
  /// `at` counts from 1; 0 lets none fail.
  Injection(Fails what, long at);
  ~Injection();
  Injection(const Injection&) = delete;
  Injection& operator=(const Injection&) = delete;
  long count() const;
  bool fired() const;
};

/// A call that is tried with failures.
struct Trial {
  std::function<void()> call;
  std::function<void()> undo;   ///< called after a call that succeeded although something failed; may be empty
  std::function<void()> check;  ///< called after every call; the object must be as before the call
};

/// Makes the call once for every n, until nothing fails any more: n-th failure after n-th failure. The default suite
/// tries the first ones and then fewer and fewer. A call may fail only with gnosphere::Error or std::bad_alloc.
/// Returns the number of calls that failed.
long failEach(const std::string& name, Fails what, const Trial& trial);

}  // namespace gnosphere::test
