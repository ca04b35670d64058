// SPDX-License-Identifier: Apache-2.0
// A Scan as Python holds it.
#pragma once

#include <memory>
#include <utility>

#include "bind.hpp"

namespace gnosphere::python {

/// Shares a Scan with the NumPy views of its arrays, which outlive the Python object. A Scan that a view or a running
/// call shares is never written again.
struct SharedScan {
  std::shared_ptr<Scan> scan = std::make_shared<Scan>();

  /// Takes the Scan out, for the next result: the same memory, or a new Scan if something else shares this one. Until
  /// give() this object is an empty Scan.
  std::shared_ptr<Scan> take() {
    std::shared_ptr<Scan> taken = std::exchange(scan, std::make_shared<Scan>());
    return taken.use_count() == 1 ? taken : std::make_shared<Scan>();
  }
  void give(std::shared_ptr<Scan> made) { scan = std::move(made); }
};

}  // namespace gnosphere::python
