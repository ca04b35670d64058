// SPDX-License-Identifier: Apache-2.0
// The texts in which the documents, the schema of drive files and the C header repeat the tables of the code.
#pragma once

#include <catch2/catch_test_macros.hpp>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <vector>

#include "base/text.hpp"
#include "effects/parameter_text.hpp"
#include "folder.hpp"

namespace gnosphere::test {

/// Checks that a file has `text`, whatever its white space is, from `start` to `end`. With GNOSPHERE_UPDATE in the
/// environment the text is written there. Returns the position behind it.
inline size_t checkRepeated(const std::filesystem::path& file, size_t start, size_t end, const std::string& text) {
  std::string bytes = bytesOf(file);
  INFO(file << " must have:\n" << text);
  REQUIRE((start <= end && end <= bytes.size()));
  const auto words = [](const std::string& all) {
    std::istringstream in(all);
    return std::vector<std::string>{std::istream_iterator<std::string>(in), {}};
  };
  if (words(bytes.substr(start, end - start)) == words(text)) return end;
  if (!std::getenv("GNOSPHERE_UPDATE"))
    FAIL_CHECK("it has another text; GNOSPHERE_UPDATE=1 writes this one");
  else
    std::ofstream(file, std::ios::binary) << bytes.replace(start, end - start, text);
  return start + text.size();
}

/// Checks what is between the first `before` from a position on and the next `after`.
inline size_t checkRepeated(const std::filesystem::path& file, size_t from, const std::string& before,
                            const std::string& after, const std::string& text) {
  const std::string bytes = bytesOf(file);
  INFO(file << " must have '" << before << "'");
  REQUIRE(bytes.find(before, from) != bytes.npos);
  const size_t start = bytes.find(before, from) + before.size();
  return checkRepeated(file, start, bytes.find(after, start), text);
}

/// Checks the rows of the first table behind a line of a page.
inline void checkTable(const std::filesystem::path& page, const std::string& line, const std::string& rows) {
  const std::string bytes = bytesOf(page), rule = "---|\n";
  const size_t found = bytes.find(rule, bytes.find(line));
  REQUIRE(found != bytes.npos);
  size_t end = found + rule.size();
  while (end < bytes.size() && bytes[end] == '|') end = bytes.find('\n', end) + 1;
  checkRepeated(page, found + rule.size(), end, rows);
}

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
