// SPDX-License-Identifier: Apache-2.0
// Exceptions that Python raises while an argument is read.
#pragma once

#include <nanobind/nanobind.h>

namespace gnosphere::python {

/// Whether an exception is no fault of the argument, so that the caller must get it as it is: that of Ctrl-C or of
/// sys.exit(), and a lack of memory.
inline bool isNoFault(const nanobind::python_error& error) {
  return !error.matches(PyExc_Exception) || error.matches(PyExc_MemoryError);
}

/// Forgets the exception that Python raises at the moment, or throws it if it is no fault of the argument.
inline void forgetFault() {
  const nanobind::python_error error;
  if (isNoFault(error)) throw error;
}

}  // namespace gnosphere::python
