// SPDX-License-Identifier: Apache-2.0
// A Python function as SimulatorOptions::warn.
#pragma once

#include <memory>
#include <string>

#include "bind.hpp"

namespace gnosphere::python {

/// Calls a Python function. Copies share it, so they can be made and destroyed without the GIL.
class Warn {
 public:
  explicit Warn(nb::object function)
      : function_(new nb::object(std::move(function)), [](nb::object* object) {
          const nb::gil_scoped_acquire acquired;
          delete object;
        }) {}
  /// An exception of the function is printed, because the library's call goes on.
  void operator()(const std::string& message) const {
    const nb::gil_scoped_acquire acquired;
    try {
      (*function_)(message);
    } catch (nb::python_error& error) {
      error.discard_as_unraisable("SimulatorOptions.warn");
    }
  }
  const nb::object& function() const { return *function_; }

 private:
  std::shared_ptr<nb::object> function_;
};

}  // namespace gnosphere::python
