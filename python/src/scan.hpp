// SPDX-License-Identifier: Apache-2.0
// Results as Python holds them.
#pragma once

#include <memory>
#include <utility>

#include "bind.hpp"

namespace gnosphere::python {

/// Shares a result with the NumPy views of its arrays, which outlive the Python object. A result that a view or a
/// running call shares is never written again.
template <typename Result>
struct Shared {
  std::shared_ptr<Result> value = std::make_shared<Result>();

  /// Takes the result out, for the next one: the same memory, or a new result if something else shares this one. Until
  /// give() this object is an empty result.
  std::shared_ptr<Result> take() {
    std::shared_ptr<Result> taken = std::exchange(value, std::make_shared<Result>());
    return taken.use_count() == 1 ? taken : std::make_shared<Result>();
  }
  void give(std::shared_ptr<Result> made) { value = std::move(made); }
};

using SharedScan = Shared<Scan>;

/// Defines a property that reads a copy of a member of the result.
template <typename Result, typename T>
void readMember(nb::class_<Shared<Result>>& type, const char* name, T Result::*member, const char* doc) {
  type.def_prop_ro(
      name, [member](const Shared<Result>& self) -> T { return (*self.value).*member; }, doc);
}

/// A Python object that keeps a result.
template <typename Result>
nb::capsule keeperOf(const Shared<Result>& self) {
  auto* shared = new std::shared_ptr<Result>(self.value);
  return nb::capsule(shared, [](void* memory) noexcept { delete static_cast<std::shared_ptr<Result>*>(memory); });
}

}  // namespace gnosphere::python
