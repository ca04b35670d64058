// SPDX-License-Identifier: Apache-2.0
// Arguments that are fields: their names in one text, as on the command line, or a sequence of fields and names.
#pragma once

#include <exception>
#include <utility>
#include <vector>

#include "bind.hpp"

namespace gnosphere::python {

/// An argument such as "intensity,class", ["intensity", "class"] or [Field.intensity, Field.class_id].
struct FieldList {
  std::vector<Field> fields;
};

/// Reads an argument; an empty text has no field. Throws Error(invalidArgument) for a name that no field has, and a
/// TypeError for anything else.
FieldList fieldListOf(nb::handle argument);

}  // namespace gnosphere::python

namespace nanobind::detail {

/// Errors of an argument are thrown when the called function takes it, because from_python() cannot throw.
template <>
struct type_caster<gnosphere::python::FieldList> {
  using Value = gnosphere::python::FieldList;
  template <typename T>
  using Cast = movable_cast_t<T>;
  template <typename T>
  static constexpr bool can_cast() {
    return true;
  }
  static constexpr auto Name =
      const_name("str | collections.abc.Sequence[") + make_caster<gnosphere::Field>::Name + const_name(" | str]");

  bool from_python(handle source, uint32_t, cleanup_list*) noexcept {
    try {
      value = gnosphere::python::fieldListOf(source);
    } catch (...) {
      error = std::current_exception();
    }
    return true;
  }
  explicit operator Value*() { return &checked(); }
  explicit operator Value&() { return checked(); }
  explicit operator Value&&() { return static_cast<Value&&>(checked()); }

 private:
  Value& checked() {
    if (error) std::rethrow_exception(error);
    return value;
  }
  Value value;
  std::exception_ptr error;
};

}  // namespace nanobind::detail

namespace gnosphere::python {

/// Defines the property `fields`, which is read as a tuple of copies and is assigned whole.
template <typename Class>
void readWriteFields(nb::class_<Class>& type, std::vector<Field> Class::*list, const char* doc) {
  type.def_prop_rw(
      "fields", [list](const Class& self) { return tupleOf(self.*list); },
      [list](Class& self, FieldList values) { self.*list = std::move(values.fields); }, doc);
}

}  // namespace gnosphere::python
