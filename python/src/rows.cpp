// SPDX-License-Identifier: Apache-2.0
#include "rows.hpp"

#include <algorithm>
#include <cctype>

namespace gnosphere::python {
namespace {

bool isWord(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) || c == '_';
}

bool isUpper(char c) {
  return c >= 'A' && c <= 'Z';
}

/// meshMotions becomes mesh_motions; a word that begins with a capital stays.
std::string snakeCase(const std::string& word) {
  if (isUpper(word[0])) return word;
  std::string result;
  for (char c : word) {
    if (isUpper(c)) result += '_';
    result += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  return result;
}

}  // namespace

std::string pythonText(const std::string& sentence) {
  std::string text;
  for (size_t i = 0; i < sentence.size();) {
    if (sentence.compare(i, 2, "::") == 0) {
      text += '.';
      i += 2;
    } else if (isWord(sentence[i])) {
      size_t end = i;
      while (end < sentence.size() && isWord(sentence[end])) ++end;
      const std::string word = sentence.substr(i, end - i);
      text += word == "throws" ? "raises" : word == "thrown" ? "raised" : snakeCase(word);
      i = end;
    } else {
      text += sentence[i++];
    }
  }
  return text;
}

std::string pythonName(const std::string& word) {
  std::string name = word == "auto" ? "automatic" : word;
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}

const EffectInfo& effectNamed(const std::string& name) {
  const auto& table = effectTable();
  return *std::find_if(table.begin(), table.end(), [&](const EffectInfo& info) { return name == info.name; });
}

const Parameter<Effects>& parameterOf(const std::string& effect, const std::string& parameter) {
  const auto& rows = effectNamed(effect).parameters;
  return *std::find_if(rows.begin(), rows.end(), [&](const auto& row) { return parameter == row.name; });
}

bool setKeyword(SimulatorOptions& options, const std::string& group, const std::string& key, nb::handle value) {
  for (const auto& option : simulatorOptionTable()) {
    const Parameter<SimulatorOptions>& parameter = option.parameter;
    if (parameter.name != group + key) continue;
    const auto* choice = std::get_if<ChoiceParameter<SimulatorOptions>>(&parameter.kind);
    const bool enumerator = choice && nb::hasattr(value, "name");
    const nb::object shown = enumerator ? nb::object(value.attr("name")) : nb::borrow(value);
    const std::string text = nb::cast<std::string>(nb::str(shown));
    std::string word = text == "True" || text == "False" ? (text == "True" ? "true" : "false") : text;
    if (choice)
      for (const ChoiceWord& known : choice->words)
        if (pythonName(known.name) == text) word = known.name;
    assign(options, parameter.name + std::string("=") + word);
    return true;
  }
  return false;
}

}  // namespace gnosphere::python
