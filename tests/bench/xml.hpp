// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cctype>
#include <string>
#include <vector>

namespace gnosphere::test {

/// Returns what is malformed in this XML (elements, quoted attributes and the named entities only), or nothing.
inline std::string xmlProblem(const std::string& xml) {
  std::vector<std::string> open;
  bool rooted = false;
  for (size_t at = 0; at < xml.size();) {
    if (xml[at] == '&') {
      const std::string name = xml.substr(at + 1, xml.find(';', at) - at - 1);
      if (name != "amp" && name != "lt" && name != "gt" && name != "quot" && name != "apos") return "entity &" + name;
    }
    if (xml[at] != '<') {
      if (open.empty() && !std::isspace(static_cast<unsigned char>(xml[at]))) return "text outside the root";
      ++at;
      continue;
    }
    size_t end = at + 1;
    for (char quote = 0; end < xml.size() && (quote || xml[end] != '>'); ++end) {
      if (xml[end] == '<') return "< within a tag";
      if (quote ? xml[end] == quote : xml[end] == '\'' || xml[end] == '"') quote = quote ? '\0' : xml[end];
    }
    if (end >= xml.size()) return "a tag without end";
    const std::string tag = xml.substr(at + 1, end - at - 1);
    const std::string name = tag.substr(0, tag.find_first_of(" \n/", 1));
    at = end + 1;
    if (name[0] == '/') {
      if (open.empty() || "/" + open.back() != name) return "unexpected <" + name + ">";
      open.pop_back();
    } else {
      if (open.empty() && rooted) return "a second root, " + name;
      rooted = true;
      if (tag.back() != '/') open.push_back(name);
    }
  }
  if (!open.empty()) return open.back() + " is not closed";
  return rooted ? "" : "no root";
}

}  // namespace gnosphere::test
