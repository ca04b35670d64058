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

/// Checks that a file has `text`, whatever its white space is, behind `before` and up to `after`, searched from a
/// position on. With GNOSPHERE_UPDATE in the environment the text is written there. Returns the position behind it.
inline size_t checkRepeated(const std::filesystem::path& file, size_t from, const std::string& before,
                            const std::string& after, const std::string& text) {
  std::string bytes = bytesOf(file) + "\n";  // so that a table may be the end of the file
  const size_t found = bytes.find(before, from), start = found + before.size();
  const size_t end = found == bytes.npos ? bytes.npos : bytes.find(after, start);
  INFO(file << " must have, behind '" << before << "':\n" << text);
  REQUIRE(end != bytes.npos);
  const auto words = [](const std::string& all) {
    std::istringstream in(all);
    return std::vector<std::string>{std::istream_iterator<std::string>(in), {}};
  };
  if (words(bytes.substr(start, end - start)) == words(text)) return end;
  if (!std::getenv("GNOSPHERE_UPDATE"))
    FAIL_CHECK("it has another text; GNOSPHERE_UPDATE=1 writes this one");
  else
    std::ofstream(file, std::ios::binary) << bytes.replace(start, end - start, text).substr(0, bytes.size() - 1);
  return start + text.size();
}

/// Checks the rows of the first table behind a line of a page.
inline void checkTable(const std::filesystem::path& page, const std::string& line, const std::string& rows) {
  checkRepeated(page, bytesOf(page).find(line), "---|\n", "\n\n", rows.substr(0, rows.size() - 1));
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
