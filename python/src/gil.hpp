// SPDX-License-Identifier: Apache-2.0
// The GIL, and calls that work without it.
#pragma once

#include <nanobind/nanobind.h>

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

/// Makes ReleasedGil know when the interpreter ends.
void watchEnd();

}  // namespace gnosphere::python
