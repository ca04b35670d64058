// SPDX-License-Identifier: Apache-2.0
#include "rows.hpp"

#include <algorithm>
#include <cctype>
#include <utility>

#include "base/nearest_text.hpp"

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

/// The names of the properties of a class, in the order in which they were defined.
std::vector<std::string> propertiesOf(nb::handle type) {
  std::vector<std::string> names;
  const nb::object members = type.attr("__dict__");
  for (const nb::handle name : members)
    if (nb::hasattr(members[name], "fset")) names.push_back(nb::cast<std::string>(name));
  return names;
}

/// The type of a property in the signature of its setter.
std::string typeOf(nb::handle type, const std::string& property) {
  const nb::object setter = type.attr(property.c_str()).attr("fset");
  const auto signature = nb::cast<std::string>(setter.attr("__nb_signature__")[0][0]);  // def f(self, arg: T, /)
  const size_t first = signature.find(": ") + 2;
  return signature.substr(first, signature.rfind(", /)") - first);
}

/// Returns "off, on or automatic".
std::string listedNames(nb::handle members) {
  std::vector<ChoiceWord> words;
  for (nb::handle name : members) words.push_back({nb::cast<const char*>(name)});
  return listed(words);
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

std::string keywordsOf(nb::handle type, const std::vector<std::string>& positional) {
  std::string keywords;
  const auto add = [&](const std::string& name) { keywords += ", " + name + ": " + typeOf(type, name) + " = ..."; };
  for (const std::string& name : positional) add(name);
  bool first = true;
  for (const std::string& name : propertiesOf(type)) {
    if (std::ranges::find(positional, name) != positional.end()) continue;
    if (std::exchange(first, false)) keywords += ", *";
    add(name);
  }
  return keywords;
}

nb::object enumeratorNamed(const std::string& name, nb::handle any, const std::string& what) {
  const nb::object members = any.type().attr("__members__");
  const nb::object word = nb::cast(pythonName(name));
  if (!nb::cast<nb::mapping>(members).contains(word))
    refuse(what + " must be " + listedNames(members) + ", is " + nb::cast<std::string>(nb::repr(nb::cast(name))));
  return members[word];
}

void setProperty(nb::handle object, const std::string& name, nb::handle value) {
  const nb::handle type = object.type();
  const std::vector<std::string> known = propertiesOf(type);
  if (std::ranges::find(known, name) == known.end())
    throw nb::type_error((typeName(type) + " has no '" + name + "'; " + nearestText(name, known)).c_str());
  nb::setattr(object, name.c_str(), value);  // gnosphere/_properties.py says what is wrong
}

void checkPositional(nb::handle type, size_t given, size_t taken) {
  if (given <= taken) return;
  const std::string allowed =
      taken == 0 ? "its properties by their names alone"
                 : "at most " + std::to_string(taken) + " arguments without a name, not " + std::to_string(given);
  throw nb::type_error((typeName(type) + " takes " + allowed).c_str());
}

}  // namespace gnosphere::python
