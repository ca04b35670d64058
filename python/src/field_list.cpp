// SPDX-License-Identifier: Apache-2.0
#include "field_list.hpp"

#include <gnosphere/output.hpp>
#include <string>

#include "scan/fields.hpp"

namespace gnosphere::python {
namespace {

/// A text of Python, in which lone surrogates, which UTF-8 does not have, are escaped as in Python's source.
std::string textOf(nb::handle object) {
  const nb::object bytes = nb::steal(PyUnicode_AsEncodedString(object.ptr(), "utf-8", "backslashreplace"));
  if (!bytes.is_valid()) throw nb::python_error();
  return {PyBytes_AsString(bytes.ptr()), static_cast<size_t>(PyBytes_Size(bytes.ptr()))};
}

}  // namespace

FieldList fieldListOf(nb::handle argument) {
  FieldList list;
  if (nb::isinstance<nb::str>(argument)) {
    if (const auto names = textOf(argument); !names.empty()) list.fields = parseFields(names);
    return list;
  }
  if (!PySequence_Check(argument.ptr()) || nb::isinstance<nb::bytes>(argument))
    throw nb::type_error(("fields is " + aTypeName(argument.type()) +
                          "; it must be a sequence of Field or of their names, or a text such as 'intensity,class'")
                             .c_str());
  for (const nb::handle item : nb::borrow<nb::object>(argument)) {
    if (nb::isinstance<nb::str>(item)) {
      const std::vector<Field> named = parseFields(textOf(item));
      list.fields.insert(list.fields.end(), named.begin(), named.end());
    } else if (Field field = {}; nb::try_cast(item, field, false)) {
      list.fields.push_back(field);
    } else {
      throw nb::type_error(
          ("fields holds " + aTypeName(item.type()) + "; it must hold Field or names of fields, such as 'intensity'")
              .c_str());
    }
  }
  return list;
}

FieldLike fieldLikeOf(nb::handle argument) {
  if (const std::optional<Field> field = findFieldOf(argument)) return {*field};
  const std::string name = textOf(argument);
  const std::vector<Field> named = parseFields(name);  // which refuses a name that no field has
  if (named.size() != 1) refuse("one field is wanted, not " + std::to_string(named.size()) + ": '" + name + "'");
  return {named[0]};
}

std::optional<Field> findFieldOf(nb::handle object) {
  if (nb::isinstance<nb::str>(object)) return findField(textOf(object));
  if (nb::isinstance<Field>(object)) return nb::cast<Field>(object);
  throw nb::type_error(
      ("a field is a Field or the name of one, such as 'intensity', and not " + aTypeName(object.type())).c_str());
}

}  // namespace gnosphere::python
