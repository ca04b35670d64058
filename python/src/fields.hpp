// SPDX-License-Identifier: Apache-2.0
// Binds the access to a result by the names of its fields, as to a mapping: result["range"].
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "field_list.hpp"

namespace gnosphere::python {

/// The fields for which has(field) is true, in the order of the enumeration.
template <typename Has>
std::vector<Field> fieldsWith(const Has& has) {
  std::vector<Field> fields;
  for (size_t i = 0; i < kFieldCount; ++i)
    if (const auto field = static_cast<Field>(i); has(field)) fields.push_back(field);
  return fields;
}

inline std::vector<std::string> namesOf(const std::vector<Field>& fields) {
  std::vector<std::string> names;
  for (const Field field : fields) names.emplace_back(fieldInfo(field).name);
  return names;
}

/// Defines result[name], `name in result`, `for name in result` and keys(). There is no len(), with which NumPy would
/// take a result for a sequence. `kHas` says whether a result has a field and `kColumn` returns its values; `what`
/// names the result in messages, and `remedy` says how a result gets more fields.
template <auto kHas, auto kColumn, typename Result>
void bindNames(nb::class_<Result>& type, const char* what, const char* remedy) {
  const auto fieldsOf = [](const Result& self) { return fieldsWith([&](Field field) { return kHas(self, field); }); };
  type.def(
          "__getitem__",
          [=](const Result& self, nb::handle name) -> nb::object {
            const std::optional<Field> field = findFieldOf(name);
            if (field && kHas(self, *field)) return kColumn(self, *field);
            std::string known;
            for (const std::string& one : namesOf(fieldsOf(self))) known += (known.empty() ? "" : ", ") + one;
            const auto wanted =
                nb::cast<std::string>(nb::repr(field ? nb::cast(fieldInfo(*field).name) : nb::borrow(name)));
            throw nb::key_error(
                (std::string(what) + " has no field " + wanted + "; it has " + known + ", and " + remedy).c_str());
          },
          "name"_a, nb::sig("def __getitem__(self, name: str | Field) -> numpy.typing.NDArray[typing.Any]"),
          (std::string("The column of a field, by its name, such as \"range\", or as a Field; see column() and keys(). "
                       "Raises KeyError if ") +
           what + " does not have it.")
              .c_str())
      .def(
          "__contains__",
          [=](const Result& self, nb::handle name) {
            if (!nb::isinstance<nb::str>(name) && !nb::isinstance<Field>(name)) return false;
            const std::optional<Field> field = findFieldOf(name);
            return field && kHas(self, *field);
          },
          "name"_a.none(), nb::sig("def __contains__(self, name: object) -> bool"),
          (std::string("Whether ") + what + " has the field of this name, or this Field.").c_str())
      .def(
          "_ipython_key_completions_", [=](const Result& self) { return nb::list(tupleOf(namesOf(fieldsOf(self)))); },
          nb::sig("def _ipython_key_completions_(self) -> list[str]"),
          "The names that IPython and Jupyter offer for what stands in brackets.")
      .def(
          "__iter__", [=](const Result& self) { return nb::iter(tupleOf(namesOf(fieldsOf(self)))); },
          nb::sig("def __iter__(self) -> collections.abc.Iterator[str]"),
          (std::string("Iterates over the names of the fields that ") + what + " has.").c_str())
      .def(
          "keys", [=](const Result& self) { return tupleOf(namesOf(fieldsOf(self))); },
          (std::string("The names of the fields that ") + what + " has.").c_str());
}

}  // namespace gnosphere::python
