// SPDX-License-Identifier: Apache-2.0
// A value that a text can set: a parameter of an effect, an option of a simulator or of a sensor's request. A table of
// such rows is what JSON, assignments, the command line, Python and the tables of the documents are made of.
#pragma once

#include <cstdint>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "gnosphere/effects.hpp"

namespace gnosphere {

/// A value of a choice: its name in texts, and the sentence about it in the header that declares it.
struct ChoiceWord {
  const char* name;
  const char* doc = "";
};

// In each kind of parameter `of`, or `get` and `set`, reach the member of Owner that the parameter sets.
template <class Owner>
struct NumberParameter {
  double& (*of)(Owner&);
  double min, max;
  bool endsOnly = false;    ///< only min and max are allowed, no value between
  const char* beyond = "";  ///< what a refusal of a value above max goes on with: the reason and the way out
};
template <class Owner>
struct CountParameter {
  uint64_t (*get)(const Owner&);
  void (*set)(Owner&, uint64_t);
  uint64_t min, max;
};
template <class Owner>
struct FlagParameter {
  bool& (*of)(Owner&);
};
template <class Owner>
struct ChoiceParameter {
  std::vector<ChoiceWord> words;  ///< in the order of the enum
  size_t (*get)(const Owner&);
  void (*set)(Owner&, size_t);
};
template <class Owner>
struct TextParameter {
  std::string& (*of)(Owner&);
};
template <class Owner>
struct IndicesParameter {
  std::vector<uint32_t>& (*of)(Owner&);
  const char* noun;  ///< what the indices count
};
template <class Owner>
struct BoxesParameter {
  std::vector<Effects::Volume>& (*of)(Owner&);
};

template <class Owner>
struct Parameter {
  const char* name;
  const char* unit;  ///< empty for a parameter without a unit
  const char* doc;   ///< the sentence of the header that declares the member
  std::variant<NumberParameter<Owner>, CountParameter<Owner>, FlagParameter<Owner>, ChoiceParameter<Owner>,
               TextParameter<Owner>, IndicesParameter<Owner>, BoxesParameter<Owner>>
      kind;
};

/// The struct that a path of members starts from.
template <auto... kPath>
struct PathOwner;
template <class Class, class Member, Member Class::*kFirst, auto... kRest>
struct PathOwner<kFirst, kRest...> {
  using Type = Class;
};
template <auto... kPath>
using OwnerOf = typename PathOwner<kPath...>::Type;

/// Returns the member at the end of a path: at<&Effects::fog, &Effects::Fog::visibility>(effects).
template <auto... kPath>
auto& at(OwnerOf<kPath...>& owner) {
  return (owner.*....*kPath);
}
template <auto... kPath>
const auto& at(const OwnerOf<kPath...>& owner) {
  return (owner.*....*kPath);
}

/// Functions that make the rows of a table, each from the path of members that leads to its value.
namespace rows {

template <auto... kPath>
Parameter<OwnerOf<kPath...>> number(const char* name, const char* unit, double min, double max, const char* doc,
                                    bool endsOnly = false, const char* beyond = "") {
  return {name, unit, doc, NumberParameter<OwnerOf<kPath...>>{&at<kPath...>, min, max, endsOnly, beyond}};
}

template <auto... kPath>
Parameter<OwnerOf<kPath...>> count(const char* name, const char* unit, uint64_t min, uint64_t max, const char* doc) {
  using Owner = OwnerOf<kPath...>;
  const auto get = [](const Owner& owner) { return uint64_t{at<kPath...>(owner)}; };
  const auto set = [](Owner& owner, uint64_t value) {
    auto& member = at<kPath...>(owner);
    member = static_cast<std::remove_reference_t<decltype(member)>>(value);
  };
  return {name, unit, doc, CountParameter<Owner>{get, set, min, max}};
}

template <auto... kPath>
Parameter<OwnerOf<kPath...>> choice(const char* name, std::vector<ChoiceWord> words, const char* doc) {
  using Owner = OwnerOf<kPath...>;
  const auto get = [](const Owner& owner) { return static_cast<size_t>(at<kPath...>(owner)); };
  const auto set = [](Owner& owner, size_t word) {
    auto& member = at<kPath...>(owner);
    member = static_cast<std::remove_reference_t<decltype(member)>>(word);
  };
  return {name, "", doc, ChoiceParameter<Owner>{std::move(words), get, set}};
}

template <auto... kPath>
Parameter<OwnerOf<kPath...>> flag(const char* name, const char* doc) {
  return {name, "", doc, FlagParameter<OwnerOf<kPath...>>{&at<kPath...>}};
}
template <auto... kPath>
Parameter<OwnerOf<kPath...>> text(const char* name, const char* doc) {
  return {name, "", doc, TextParameter<OwnerOf<kPath...>>{&at<kPath...>}};
}
template <auto... kPath>
Parameter<OwnerOf<kPath...>> indices(const char* name, const char* noun, const char* doc) {
  return {name, "", doc, IndicesParameter<OwnerOf<kPath...>>{&at<kPath...>, noun}};
}
template <auto... kPath>
Parameter<OwnerOf<kPath...>> boxes(const char* name, const char* doc) {
  return {name, "", doc, BoxesParameter<OwnerOf<kPath...>>{&at<kPath...>}};
}

}  // namespace rows
}  // namespace gnosphere
