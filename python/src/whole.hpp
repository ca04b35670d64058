// SPDX-License-Identifier: Apache-2.0
// Whole numbers whose errors name them and their limits.
#pragma once

#include <cstdint>
#include <exception>
#include <limits>
#include <string>

#include "bind.hpp"

namespace gnosphere::python {

/// An argument that is a whole number, of Python or NumPy, of any size.
struct Whole {
  nb::object number;
  std::exception_ptr raised;  // while it was read, and no fault of it; see isNoFault()

  /// Throws Error(invalidArgument), "<name> must be a whole number, 0..65535, is 70000".
  uint64_t within(uint64_t least, uint64_t most, const std::string& name) const {
    if (raised) std::rethrow_exception(raised);
    uint64_t value = 0;
    if (nb::try_cast(number, value) && value >= least && value <= most) return value;
    refuse(name + " must be a whole number, " + std::to_string(least) + ".." + std::to_string(most) + ", is " +
           nb::cast<std::string>(nb::str(number)));
  }
  template <typename T>
  T of(const std::string& name) const {
    return static_cast<T>(within(0, std::numeric_limits<T>::max(), name));
  }
};

/// Defines a property that is a whole number. Its name in messages is that of the class and its own.
template <typename Class, typename T>
void readWriteWhole(nb::class_<Class>& type, const char* name, T Class::*member, const char* doc) {
  const std::string what = typeName(type) + ": " + name;
  type.def_prop_rw(
      name, [member](const Class& self) { return self.*member; },
      [member, what](Class& self, const Whole& value) { self.*member = value.of<T>(what); }, doc);
}

}  // namespace gnosphere::python

namespace nanobind::detail {

template <>
struct type_caster<gnosphere::python::Whole> {
  NB_TYPE_CASTER(gnosphere::python::Whole, const_name("int"))
  bool from_python(handle source, uint32_t, cleanup_list*) noexcept {
    value.number = steal(PyNumber_Index(source.ptr()));
    if (value.number.is_valid()) return true;
    try {
      gnosphere::python::forgetFault();
    } catch (...) {
      value.raised = std::current_exception();
    }
    return value.raised != nullptr;
  }
};

}  // namespace nanobind::detail
