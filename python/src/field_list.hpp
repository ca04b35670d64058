// SPDX-License-Identifier: Apache-2.0
// Arguments that are fields: their names in one text, as on the command line, or a sequence of fields and names; or one
// of these.
#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "late.hpp"

namespace gnosphere::python {

/// An argument such as "intensity,class", ["intensity", "class"] or [Field.intensity, Field.class_id].
struct FieldList {
  std::vector<Field> fields;
};

/// Reads an argument; an empty text has no field. Throws Error(invalidArgument) for a name that no field has, and a
/// TypeError for anything else.
FieldList fieldListOf(nb::handle argument);

/// An argument that is one field, such as Field.intensity or "intensity".
struct FieldLike {
  Field field = {};
};

/// Returns what a caller means by an argument that names one field. Throws the errors of fieldListOf().
FieldLike fieldLikeOf(nb::handle argument);
/// The field that an object is or names; none if no field has this name. Throws a TypeError for another object.
std::optional<Field> findFieldOf(nb::handle object);

}  // namespace gnosphere::python

namespace nanobind::detail {

template <>
struct type_caster<gnosphere::python::FieldList>
    : late_caster<gnosphere::python::FieldList, &gnosphere::python::fieldListOf> {
  static constexpr auto Name =
      const_name("str | collections.abc.Sequence[") + make_caster<gnosphere::Field>::Name + const_name(" | str]");
};

template <>
struct type_caster<gnosphere::python::FieldLike>
    : late_caster<gnosphere::python::FieldLike, &gnosphere::python::fieldLikeOf> {
  static constexpr auto Name = make_caster<gnosphere::Field>::Name + const_name(" | str");
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
