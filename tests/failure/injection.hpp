// SPDX-License-Identifier: Apache-2.0
// Allocations of host memory, operations on files, and calls of a Vulkan device, that fail: the n-th one while an
// Injection lives, alone or with all after it.
#pragma once

#include <exception>
#include <functional>
#include <string>

namespace gnosphere::test {

/// The library asks for one of these and does not get it. `device` is whatever a Vulkan device makes: memory, buffers,
/// pipelines, and all else that takes memory.
enum class Fails { memory, files, device };

/// Whether the n-th one fails alone, or all from it on, as when memory has run out for good.
enum class Lasts { once, forGood };

/// Counts the library's allocations, its operations on files, or its calls of devices, and lets some of them fail.
/// Calls of drivers and of the tests themselves are not counted.
class Injection {
 public:
  /// `at` counts from 1; 0 lets none fail.
  Injection(Fails what, long at, Lasts lasts = Lasts::once);
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

/// Makes the call for every n, until nothing fails any more: first with the n-th failing alone, then with all from it
/// on. The default suite tries the first ones and then fewer and fewer. A call may fail only with gnosphere::Error or
/// std::bad_alloc; one that needs no file or nothing of the device is no trial of these. Returns the number of calls
/// that failed.
long failEach(const std::string& name, Fails what, const Trial& trial);

}  // namespace gnosphere::test
