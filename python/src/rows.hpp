// SPDX-License-Identifier: Apache-2.0
// Properties, enums and their documentation from the rows of the library's tables.
#pragma once

#include <nanobind/stl/variant.h>

#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "bind.hpp"
#include "effects/effect_table.hpp"
#include "effects/parameter_text.hpp"
#include "option_table.hpp"
#include "whole.hpp"

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

/// An argument from Python that chooses an enumerator: the enumerator, or the name of it. The number of an enumerator,
/// as those of other enums are, chooses none.
template <typename Enum>
struct Choice {
  std::variant<Enum, std::string> given;
};

/// Returns the enumerator of this name of the enum of which `any` is one. Throws Error(invalidArgument) with the known
/// names, which begins with `what`.
nb::object enumeratorNamed(const std::string& name, nb::handle any, const std::string& what);

template <typename Enum>
Enum chosen(const Choice<Enum>& choice, const std::string& what) {
  if (const Enum* const value = std::get_if<Enum>(&choice.given)) return *value;
  return nb::cast<Enum>(enumeratorNamed(std::get<std::string>(choice.given), nb::cast(Enum()), what));
}

/// Defines a property that is a choice, to which a name can be assigned, too.
template <typename Class, typename Enum>
void readWriteChoice(nb::class_<Class>& type, const char* name, Enum Class::*member, const char* doc) {
  const std::string what = typeName(type) + ": " + name;
  type.def_prop_rw(
      name, [member](const Class& self) { return self.*member; },
      [member, what](Class& self, const Choice<Enum>& given) { self.*member = chosen(given, what); }, doc);
}

/// Defines the property of a row whose value is a number, a truth value or a text; other rows need a type of their own.
/// `kReach` gives the part of the row's owner that the class binds.
template <auto kReach, typename Class, typename Owner>
void bindRow(nb::class_<Class>& type, const char* name, const Parameter<Owner>& parameter) {
  const std::string doc =
      pythonText(*parameter.unit ? std::string(parameter.unit) + "; " + parameter.doc : parameter.doc);
  const auto define = [&]<typename Value>(std::type_identity<Value>, auto get, auto set) {
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
    define(
        std::type_identity<Value>(), [of = kind.of](Owner& owner) -> Value { return of(owner); },
        [of = kind.of](Owner& owner, Value value) { of(owner) = std::move(value); });
  };
  if (const auto* number = std::get_if<NumberParameter<Owner>>(&parameter.kind)) member(*number);
  if (const auto* flag = std::get_if<FlagParameter<Owner>>(&parameter.kind)) member(*flag);
  if (const auto* text = std::get_if<TextParameter<Owner>>(&parameter.kind)) member(*text);
  if (const auto* count = std::get_if<CountParameter<Owner>>(&parameter.kind))
    define(std::type_identity<Whole>(), count->get,
           [count, what = typeName(type) + ": " + name](Owner& owner, const Whole& value) {
             count->set(owner, value.within(count->min, count->max, what));
           });
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

/// The parameters of a constructor that takes the properties of a class as keywords, each with its type. The properties
/// in `positional` come first, and a caller may give them without their names.
std::string keywordsOf(nb::handle type, const std::vector<std::string>& positional);
/// Sets a property by a keyword. Throws a TypeError for a name that no property has, with the nearest names, and for a
/// value of another type; Error(invalidArgument) for a word that is no name of a choice, with its names.
void setProperty(nb::handle object, const std::string& name, nb::handle value);
/// Throws a TypeError if a constructor gets more arguments without a name than it takes.
void checkPositional(nb::handle type, size_t given, size_t taken);

/// Lets a class, all of whose properties have been defined, be made of keywords: what make() returns, with these
/// properties.
template <typename T>
void bindKeywords(
    nb::class_<T>& type, const char* doc, const std::vector<std::string>& positional = {},
    T (*make)() = [] { return T(); }) {
  const std::string signature = "def __init__(self" + keywordsOf(type, positional) + ") -> None";
  type.def(
      "__init__",
      [positional, make](T* self, nb::args values, nb::kwargs keywords) {
        const nb::object made = nb::cast(make());
        checkPositional(made.type(), values.size(), positional.size());
        for (size_t i = 0; i < values.size(); ++i) {
          if (keywords.contains(positional[i].c_str()))
            throw nb::type_error(("'" + positional[i] + "' is given twice").c_str());
          setProperty(made, positional[i], values[i]);
        }
        for (const auto& [name, value] : keywords) setProperty(made, nb::cast<std::string>(name), value);
        new (self) T(std::move(nb::cast<T&>(made)));
      },
      nb::sig(signature.c_str()), doc);
}

}  // namespace gnosphere::python

namespace nanobind::detail {

template <typename Enum>
struct type_caster<gnosphere::python::Choice<Enum>> {
  NB_TYPE_CASTER(gnosphere::python::Choice<Enum>, make_caster<Enum>::Name + const_name(" | str"))
  bool from_python(handle source, uint32_t, cleanup_list*) noexcept {
    Enum enumerator = {};
    std::string name;
    if (try_cast(source, enumerator, false))
      value.given = enumerator;
    else if (try_cast(source, name))
      value.given = std::move(name);
    else
      return false;
    return true;
  }
};

}  // namespace nanobind::detail
