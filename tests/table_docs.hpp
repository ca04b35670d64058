// SPDX-License-Identifier: Apache-2.0
// The rows of parameters and options as the tables of the documents have them.
#pragma once

#include <string>

#include "base/text.hpp"
#include "effects/parameter_text.hpp"

namespace gnosphere::test {

/// Returns "| `name` | unit | allowed | default | meaning": a row without its end.
template <class Owner>
std::string tableRow(const Parameter<Owner>& parameter) {
  Parameter<Owner> plain = parameter;
  plain.unit = "";
  return "| `" + std::string(parameter.name) + "` | " + parameter.unit + " | " + allowedText(plain) + " | " +
         defaultText(parameter) + " | " + parameter.doc;
}

/// Returns the text in small letters, with its comment marks, line ends and full stops removed: a sentence may stand
/// behind a member or above it.
inline std::string sentences(const std::string& text) {
  std::string plain;
  for (size_t i = 0; i < text.size(); ++i) {
    if (text.compare(i, 3, "///") == 0) {
      i += text.compare(i, 4, "///<") == 0 ? 3 : 2;
      continue;
    }
    const char c = text[i];
    if (c == '.' && (i + 1 == text.size() || text[i + 1] == ' ' || text[i + 1] == '\n')) continue;
    if (c == ' ' || c == '\n') {
      if (!plain.empty() && plain.back() != ' ') plain += ' ';
    } else {
      plain += lower(c);
    }
  }
  while (!plain.empty() && plain.back() == ' ') plain.pop_back();
  return plain;
}

}  // namespace gnosphere::test
