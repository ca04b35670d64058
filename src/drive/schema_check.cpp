// SPDX-License-Identifier: Apache-2.0
#include "drive/schema_check.hpp"

#include <algorithm>
#include <cmath>

#include "base/json_text.hpp"
#include "base/nearest_text.hpp"

namespace gnosphere::drive {
namespace {

using nlohmann::json;

bool hasType(const json& value, const std::string& type) {
  if (type == "object") return value.is_object();
  if (type == "array") return value.is_array();
  if (type == "string") return value.is_string();
  if (type == "number") return value.is_number();
  // As in JSON Schema, 1.0 is a whole number. Beyond 2^53 a float does not tell one whole number from the next.
  constexpr double kMostWhole = 9007199254740992;
  if (type == "integer" && value.is_number_float())
    return std::abs(value.get<double>()) <= kMostWhole && std::floor(value.get<double>()) == value.get<double>();
  if (type == "integer") return value.is_number_integer();
  return type == "boolean" && value.is_boolean();
}

std::string nounOf(const std::string& type) {
  if (type == "object") return "an object";
  if (type == "array") return "a list";
  if (type == "string") return "a text";
  if (type == "integer") return "a whole number";
  return type == "boolean" ? "true or false" : "a number";
}

std::vector<std::string> namesOf(const json& object) {
  std::vector<std::string> names;
  for (const auto& [name, unused] : object.items()) names.push_back(name);
  return names;
}

class Check {
 public:
  explicit Check(const json& root) : root_(root) {}

  void value(const json& value, const json& schema, const std::string& path) {
    if (schema.contains("$ref")) {
      const std::string name = schema["$ref"].get<std::string>();
      this->value(value, root_.at(json::json_pointer(name.substr(1))), path);
      return;
    }
    if (!type(value, schema, path)) return;
    if (schema.contains("enum")) choice(value, schema["enum"], path);
    if (value.is_object()) object(value, schema, path);
    if (value.is_array()) list(value, schema, path);
    if (value.is_number()) number(value, schema, path);
    if (value.is_string() && value.get_ref<const std::string&>().size() < schema.value("minLength", size_t{0}))
      refuse(path, "must not be empty");
  }

  std::vector<std::string> mistakes;

 private:
  void refuse(const std::string& path, const std::string& why) {
    mistakes.push_back((path.empty() ? "the whole file" : path) + ": " + why);
  }

  bool type(const json& value, const json& schema, const std::string& path) {
    if (!schema.contains("type")) return true;
    const json& type = schema["type"];
    const json types = type.is_array() ? type : json::array({type});
    std::string nouns;
    for (const json& one : types) {
      if (hasType(value, one)) return true;
      nouns.append(nouns.empty() ? "" : " or ").append(nounOf(one));
    }
    refuse(path, "must be " + nouns + ", is " + shown(value));
    return false;
  }

  void choice(const json& value, const json& words, const std::string& path) {
    if (std::find(words.begin(), words.end(), value) != words.end()) return;
    std::vector<std::string> names;
    for (const json& word : words) names.push_back(word.get<std::string>());
    if (value.is_string())
      refuse(path, inQuotes(value.get<std::string>()) + " is unknown; " + nearestText(value.get<std::string>(), names));
    else
      refuse(path, "must be a word, is " + shown(value) + "; " + nearestText("", names));
  }

  void object(const json& value, const json& schema, const std::string& path) {
    static const json kNone = json::object();
    const json& known = schema.contains("properties") ? schema["properties"] : kNone;
    for (const auto& [name, member] : value.items()) {
      if (known.contains(name))
        this->value(member, known[name], memberPath(path, name));
      else if (!schema.contains("additionalProperties"))
        continue;
      else if (schema["additionalProperties"].is_object())
        this->value(member, schema["additionalProperties"], memberPath(path, name));
      else
        refuse(memberPath(path, name), "is an unknown word; " + nearestText(name, namesOf(known)));
    }
    if (!schema.contains("required")) return;
    for (const json& name : schema["required"])
      if (!value.contains(name.get<std::string>())) refuse(memberPath(path, name), "is missing");
  }

  void list(const json& value, const json& schema, const std::string& path) {
    const size_t least = schema.value("minItems", size_t{0}), most = schema.value("maxItems", SIZE_MAX);
    if (value.size() < least || value.size() > most) {
      const std::string wanted = least == most ? std::to_string(least) : "at least " + std::to_string(least);
      refuse(path,
             "must have " + wanted + (least == 1 ? " entry" : " entries") + ", has " + std::to_string(value.size()));
    }
    if (!schema.contains("items")) return;
    for (size_t i = 0; i < value.size(); ++i) this->value(value[i], schema["items"], entryPath(path, i));
  }

  void number(const json& value, const json& schema, const std::string& path) {
    const double n = value.get<double>();
    const auto limit = [&](const char* keyword, const char* words, auto holds) {
      if (schema.contains(keyword) && !holds(n, schema[keyword].get<double>()))
        refuse(path, std::string("must be ") + words + " " + jsonText(schema[keyword]) + ", is " + shown(value));
    };
    limit("minimum", "at least", [](double a, double b) { return a >= b; });
    limit("exclusiveMinimum", "above", [](double a, double b) { return a > b; });
    limit("maximum", "at most", [](double a, double b) { return a <= b; });
  }

  const json& root_;
};

}  // namespace

std::string memberPath(const std::string& path, const std::string& name) {
  return path.empty() ? name : path + "." + name;
}

std::string entryPath(const std::string& path, size_t index) {
  return std::string(path).append("[").append(std::to_string(index)).append("]");
}

std::string inQuotes(const std::string& text) {
  return std::string("'").append(text).append("'");
}

std::vector<std::string> mistakesOf(const json& value, const json& schema) {
  Check check(schema);
  check.value(value, schema, "");
  return std::move(check.mistakes);
}

}  // namespace gnosphere::drive
