// SPDX-License-Identifier: Apache-2.0
// Values of parameters as text: reading them from JSON, checking them, writing them, and the texts about them.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "base/json_text.hpp"
#include "base/text.hpp"
#include "effects/parameter.hpp"

namespace gnosphere {

/// Largest extinction of a box of Effects::Volumes in 1/m; with it the visible depth is about a millimetre.
inline constexpr double kMaxExtinction = 1000;
/// Least size of a number that is not 0. Formulas in single precision divide by such numbers.
inline constexpr double kLeastSize = 1e-20;

[[noreturn]] void refuseArgument(const std::string& why);
/// Returns "0..500 mm/h", without the unit if it is empty.
std::string rangeText(double min, double max, bool endsOnly, const char* unit);
/// Returns "a, b or c".
std::string listed(const std::vector<ChoiceWord>& words);
std::string quoted(const char* word);

/// Refuses a number that is not 0, but too small to count with.
void checkSize(double value, const std::string& what);
double numberOf(const nlohmann::json& value, const std::string& what, const std::string& allowed);
uint64_t wholeNumberOf(const nlohmann::json& value, uint64_t max, const std::string& what, const std::string& allowed);
std::vector<Effects::Volume> boxesOf(const nlohmann::json& list, const std::string& what);
void checkBoxes(const std::vector<Effects::Volume>& boxes, const std::string& what);
std::string boxesText(const std::vector<Effects::Volume>& boxes);

/// Splits "NAME=VALUE" into the name and the value, which is JSON or a word without quotes. Throws
/// Error(invalidArgument) that shows `example` if there is no equals sign.
std::pair<std::string, nlohmann::json> splitAssignment(const std::string& assignment, const char* example);

template <class... Kinds>
struct Visitor : Kinds... {
  using Kinds::operator()...;
};
template <class... Kinds>
Visitor(Kinds...) -> Visitor<Kinds...>;

/// Returns the allowed values for messages and lists: "0..500 mm/h", "uniform or gaussian".
template <class Owner>
std::string allowedText(const Parameter<Owner>& parameter) {
  return std::visit(
      Visitor{[&](const NumberParameter<Owner>& n) { return rangeText(n.min, n.max, n.endsOnly, parameter.unit); },
              [](const CountParameter<Owner>& n) {
                return "a whole number, " + std::to_string(n.min) + ".." + std::to_string(n.max);
              },
              [](const ChoiceParameter<Owner>& choice) { return listed(choice.words); },
              [](const FlagParameter<Owner>&) { return std::string("true or false"); },
              [](const TextParameter<Owner>&) { return std::string("a text"); },
              [](const IndicesParameter<Owner>& list) {
                return std::string("a list of ") + list.noun + " indices, as [0, 3]";
              },
              [](const BoxesParameter<Owner>&) {
                return std::string("a list of {\"min\": [x, y, z], \"max\": [x, y, z], \"extinction\": 1/m}");
              }},
      parameter.kind);
}

/// Reads a value, which `what` names in messages. checkValue() checks its range later.
template <class Owner>
void readValue(const Parameter<Owner>& parameter, Owner& owner, const std::string& what, const nlohmann::json& value) {
  const std::string allowed = allowedText(parameter);
  const auto refuse = [&] { refuseArgument(what + " must be " + allowed + ", is " + shown(value)); };
  std::visit(Visitor{[&](const NumberParameter<Owner>& n) { n.of(owner) = numberOf(value, what, allowed); },
                     [&](const CountParameter<Owner>& n) { n.set(owner, wholeNumberOf(value, n.max, what, allowed)); },
                     [&](const FlagParameter<Owner>& flag) {
                       if (!value.is_boolean()) refuse();
                       flag.of(owner) = value.template get<bool>();
                     },
                     [&](const ChoiceParameter<Owner>& choice) {
                       const auto found =
                           std::find_if(choice.words.begin(), choice.words.end(),
                                        [&](const ChoiceWord& word) { return isText(value, word.name); });
                       if (found == choice.words.end()) refuse();
                       choice.set(owner, static_cast<size_t>(found - choice.words.begin()));
                     },
                     [&](const TextParameter<Owner>& text) {
                       text.of(owner) = value.is_string() ? value.template get<std::string>() : jsonText(value);
                     },
                     [&](const IndicesParameter<Owner>& list) {
                       if (!value.is_array()) refuse();
                       std::vector<uint32_t> indices;
                       for (const nlohmann::json& index : value)
                         indices.push_back(static_cast<uint32_t>(wholeNumberOf(index, UINT32_MAX, what, allowed)));
                       list.of(owner) = std::move(indices);
                     },
                     [&](const BoxesParameter<Owner>& boxes) {
                       if (!value.is_array()) refuse();
                       boxes.of(owner) = boxesOf(value, what);
                     }},
             parameter.kind);
}

/// Checks a value that a C++ caller may also have set: its range, and NaN. The owner is not changed.
template <class Owner>
void checkValue(const Parameter<Owner>& parameter, Owner& owner, const std::string& what) {
  const auto refuse = [&](const std::string& value) {
    refuseArgument(what + " must be " + allowedText(parameter) + ", is " + value);
  };
  std::visit(
      Visitor{[&](const NumberParameter<Owner>& n) {
                const double value = n.of(owner);
                const bool between = value >= n.min && value <= n.max;
                if (!between || (n.endsOnly && value != n.min && value != n.max))
                  refuse(numberText(value) + (value > n.max ? n.beyond : ""));
                checkSize(value, what);
              },
              [&](const CountParameter<Owner>& n) {
                const uint64_t value = n.get(owner);
                if (value < n.min || value > n.max) refuse(std::to_string(value));
              },
              [&](const ChoiceParameter<Owner>& choice) {
                if (choice.get(owner) >= choice.words.size())
                  refuseArgument(what + " must be " + allowedText(parameter));
              },
              [&](const BoxesParameter<Owner>& boxes) { checkBoxes(boxes.of(owner), what); }, [](const auto&) {}},
      parameter.kind);
}

/// Returns the value as JSON text: 0.004, "gaussian", [].
template <class Owner>
std::string valueText(const Parameter<Owner>& parameter, const Owner& from) {
  Owner owner = from;
  return std::visit(
      Visitor{[&](const NumberParameter<Owner>& n) { return numberText(n.of(owner)); },
              [&](const CountParameter<Owner>& n) { return std::to_string(n.get(owner)); },
              [&](const FlagParameter<Owner>& flag) { return std::string(flag.of(owner) ? "true" : "false"); },
              [&](const ChoiceParameter<Owner>& choice) { return quoted(choice.words[choice.get(owner)].name); },
              [&](const TextParameter<Owner>& text) { return jsonText(nlohmann::json(text.of(owner))); },
              [&](const IndicesParameter<Owner>& indices) {
                std::string list;
                for (uint32_t index : indices.of(owner)) list += (list.empty() ? "" : ", ") + std::to_string(index);
                return std::string("[").append(list).append("]");
              },
              [&](const BoxesParameter<Owner>& boxes) { return boxesText(boxes.of(owner)); }},
      parameter.kind);
}

/// Returns the default of a parameter as tables print it, such as 0.004, gaussian or [].
template <class Owner>
std::string defaultText(const Parameter<Owner>& parameter) {
  const Owner defaults;
  if (const auto* choice = std::get_if<ChoiceParameter<Owner>>(&parameter.kind))
    return choice->words[choice->get(defaults)].name;
  return valueText(parameter, defaults);
}

}  // namespace gnosphere
