// SPDX-License-Identifier: Apache-2.0
// Properties, enums and their documentation from the rows of the library's tables.
#pragma once

#include <string>
#include <type_traits>
#include <variant>
#include <vector>

#include "bind.hpp"
#include "effects/effect_table.hpp"
#include "option_table.hpp"

namespace gnosphere::python {

/// A sentence of a C++ header in Python's spelling: Shot::meshMotions becomes Shot.mesh_motions.
std::string pythonText(const std::string& sentence);
/// A word of a table as the name of an enumerator: second-strongest becomes second_strongest, auto becomes automatic.
std::string pythonName(const std::string& word);

/// Returns the effect of this name.
const EffectInfo& effectNamed(const std::string& name);
const Parameter<Effects>& parameterOf(const std::string& effect, const std::string& parameter);
inline const Parameter<SimulatorOptions>& optionNamed(const std::string& name) {
  return simulatorOption(name).parameter;
}

/// Binds an enum whose enumerators are the words of a choice.
template <typename Enum>
void bindWords(nb::handle scope, const std::string& name, const std::vector<ChoiceWord>& words, const char* doc) {
  nb::enum_<Enum> type(scope, name.c_str(), pythonText(doc).c_str());
  for (size_t i = 0; i < words.size(); ++i) {
    const std::string about = pythonText(words[i].doc);
    type.value(pythonName(words[i].name).c_str(), static_cast<Enum>(i), about.empty() ? nullptr : about.c_str());
  }
}

template <typename Enum, typename Owner>
void bindWords(nb::handle scope, const std::string& name, const Parameter<Owner>& parameter) {
  bindWords<Enum>(scope, name, std::get<ChoiceParameter<Owner>>(parameter.kind).words, parameter.doc);
}

/// Defines the property of a row whose value is a number, a truth value or a text; other rows need a type of their own.
/// `kReach` gives the part of the row's owner that the class binds.
template <auto kReach, typename Class, typename Owner>
void bindRow(nb::class_<Class>& type, const char* name, const Parameter<Owner>& parameter) {
  const std::string doc =
      pythonText(*parameter.unit ? std::string(parameter.unit) + "; " + parameter.doc : parameter.doc);
  const auto define = [&](auto get, auto set) {
    using Value = decltype(get(std::declval<Owner&>()));
    type.def_prop_rw(
        name,
        [get](const Class& self) {
          Owner owner;
          kReach(owner) = self;
          return get(owner);
        },
        [set](Class& self, Value value) {
          Owner owner;
          kReach(owner) = self;
          set(owner, std::move(value));
          self = kReach(owner);
        },
        doc.c_str());
  };
  const auto member = [&](const auto& kind) {
    using Value = std::remove_reference_t<decltype(kind.of(std::declval<Owner&>()))>;
    define([of = kind.of](Owner& owner) -> Value { return of(owner); },
           [of = kind.of](Owner& owner, Value value) { of(owner) = std::move(value); });
  };
  if (const auto* number = std::get_if<NumberParameter<Owner>>(&parameter.kind)) member(*number);
  if (const auto* flag = std::get_if<FlagParameter<Owner>>(&parameter.kind)) member(*flag);
  if (const auto* text = std::get_if<TextParameter<Owner>>(&parameter.kind)) member(*text);
  if (const auto* count = std::get_if<CountParameter<Owner>>(&parameter.kind))
    define([get = count->get](Owner& owner) { return get(owner); }, count->set);
}

/// Defines the properties of the rows of a group of options, such as "tuning.culling.".
template <auto kReach, typename Class>
void bindOptionRows(nb::class_<Class>& type, const std::string& group) {
  for (const auto& [parameter, changes] : simulatorOptionTable()) {
    const std::string name = parameter.name;
    if (name.starts_with(group) && name.find('.', group.size()) == name.npos)
      bindRow<kReach>(type, name.substr(group.size()).c_str(), parameter);
  }
}

/// Sets the options of a group by keywords. The value of a choice may be its enumerator or its name. Returns false for
/// a keyword that is no option of the group.
bool setKeyword(SimulatorOptions& options, const std::string& group, const std::string& key, nb::handle value);

}  // namespace gnosphere::python
