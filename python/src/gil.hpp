// SPDX-License-Identifier: Apache-2.0
// The GIL, and calls that work without it.
#pragma once

#include <nanobind/nanobind.h>

#include <chrono>

namespace gnosphere::python {

/// Releases the GIL while it lives. A thread that would take the GIL back while the interpreter ends sleeps until the
/// process has ended. Otherwise Python would end the thread in the middle of C++, and with it abort the process.
class ReleasedGil {
 public:
  ReleasedGil() : state_(PyEval_SaveThread()) {}
  ~ReleasedGil();
  ReleasedGil(const ReleasedGil&) = delete;
  ReleasedGil& operator=(const ReleasedGil&) = delete;

 private:
  PyThreadState* state_;
};

/// Holds the GIL while it lives, in a call that has released it. As ReleasedGil, it sleeps if the interpreter ends.
class AcquiredGil {
 public:
  AcquiredGil();
  ~AcquiredGil() { PyGILState_Release(state_); }
  AcquiredGil(const AcquiredGil&) = delete;
  AcquiredGil& operator=(const AcquiredGil&) = delete;

 private:
  PyGILState_STATE state_;
};

/// The progress of a long call, in which the functions of signals are called, such as that of Ctrl-C. Other threads may
/// hold the GIL for a while, so it is asked for at most ten times a second.
class SeesSignals {
 public:
  void operator()(size_t done = 0);

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point next_ = Clock::now() + std::chrono::milliseconds(100);
};

/// Makes ReleasedGil and AcquiredGil know when the interpreter ends.
void watchEnd();

}  // namespace gnosphere::python
