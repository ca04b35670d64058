// SPDX-License-Identifier: Apache-2.0
#include "field_list.hpp"

#include <gnosphere/output.hpp>
#include <string>

namespace gnosphere::python {
namespace {

std::string typeOf(nb::handle object) {
  return nb::cast<std::string>(object.type().attr("__name__"));
}

}  // namespace

FieldList fieldListOf(nb::handle argument) {
  FieldList list;
  if (nb::isinstance<nb::str>(argument)) {
    if (const auto names = nb::cast<std::string>(argument); !names.empty()) list.fields = parseFields(names);
    return list;
  }
  if (!PySequence_Check(argument.ptr()) || nb::isinstance<nb::bytes>(argument))
    throw nb::type_error(("fields is a " + typeOf(argument) +
                          "; it must be a sequence of Field or of their names, or a text such as 'intensity,class'")
                             .c_str());
  for (const nb::handle item : nb::borrow<nb::object>(argument)) {
    if (nb::isinstance<nb::str>(item)) {
      const std::vector<Field> named = parseFields(nb::cast<std::string>(item));
      list.fields.insert(list.fields.end(), named.begin(), named.end());
    } else if (Field field = {}; nb::try_cast(item, field)) {
      list.fields.push_back(field);
    } else {
      throw nb::type_error(
          ("fields holds a " + typeOf(item) + "; it must hold Field or names of fields, such as 'intensity'").c_str());
    }
  }
  return list;
}

}  // namespace gnosphere::python
