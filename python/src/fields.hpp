// SPDX-License-Identifier: Apache-2.0
// Binds the access to a result by the names of its fields, as to a mapping: result["range"].
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "bind.hpp"

namespace gnosphere::python {

/// The fields of a result, of which has(field) says whether it has them, in the order of the enumeration.
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

inline std::optional<Field> fieldNamed(const std::vector<Field>& fields, std::string_view name) {
  for (const Field field : fields)
    if (fieldInfo(field).name == name) return field;
  return std::nullopt;
}

/// Defines result[name], `name in result`, `for name in result` and keys(). There is no len(), with which NumPy would
/// take a result for a sequence. `kHas` says whether a result has a field and `kColumn` returns its values; `what`
/// names the result in messages, and `remedy` says how a result gets more fields.
template <auto kHas, auto kColumn, typename Result>
void bindNames(nb::class_<Result>& type, const char* what, const char* remedy) {
  const auto fieldsOf = [](const Result& self) { return fieldsWith([&](Field field) { return kHas(self, field); }); };
  type.def(
          "__getitem__",
          [=](const Result& self, std::string_view name) -> nb::object {
            const std::vector<Field> fields = fieldsOf(self);
            if (const std::optional<Field> field = fieldNamed(fields, name)) return kColumn(self, *field);
            std::string known;
            for (const std::string& one : namesOf(fields)) known += (known.empty() ? "" : ", ") + one;
            throw nb::key_error(
                (std::string(what) + " has no field '" + std::string(name) + "'; it has " + known + ", and " + remedy)
                    .c_str());
          },
          "name"_a, nb::sig("def __getitem__(self, name: str) -> numpy.typing.NDArray[typing.Any]"),
          (std::string("The column of the field with this name, such as \"range\"; see column() and keys(). Raises "
                       "KeyError if ") +
           what + " does not have it.")
              .c_str())
      .def(
          "__contains__",
          [=](const Result& self, std::string_view name) { return fieldNamed(fieldsOf(self), name).has_value(); },
          "name"_a, (std::string("Whether ") + what + " has the field with this name.").c_str())
      .def(
          "__iter__", [=](const Result& self) { return nb::iter(tupleOf(namesOf(fieldsOf(self)))); },
          nb::sig("def __iter__(self) -> collections.abc.Iterator[str]"),
          (std::string("Iterates over the names of the fields that ") + what + " has.").c_str())
      .def(
          "keys", [=](const Result& self) { return tupleOf(namesOf(fieldsOf(self))); },
          (std::string("The names of the fields that ") + what + " has.").c_str());
}

}  // namespace gnosphere::python
