// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>

#include "output/cloud_format.hpp"
#include "output/cloud_table.hpp"

namespace gnosphere {
namespace {

struct PlyType {
  const char* name;
  char type;
  size_t size;
};

constexpr std::array<PlyType, 16> kTypes = {{{"char", 'I', 1},
                                             {"int8", 'I', 1},
                                             {"uchar", 'U', 1},
                                             {"uint8", 'U', 1},
                                             {"short", 'I', 2},
                                             {"int16", 'I', 2},
                                             {"ushort", 'U', 2},
                                             {"uint16", 'U', 2},
                                             {"int", 'I', 4},
                                             {"int32", 'I', 4},
                                             {"uint", 'U', 4},
                                             {"uint32", 'U', 4},
                                             {"float", 'F', 4},
                                             {"float32", 'F', 4},
                                             {"double", 'F', 8},
                                             {"float64", 'F', 8}}};

CloudColumn property(const CloudTable& table, const std::vector<std::string_view>& words) {
  if (words.size() == 3) {
    for (const PlyType& known : kTypes) {
      if (words[1] != known.name) continue;
      std::string name(words[2]);
      for (const PlyName& other : kPlyNames)
        if (name == other.inPly) name = other.name;
      return {name, known.type, known.size};
    }
  }
  table.refuse("PLY header: a vertex has a list or a property of no known type");
}

/// State while the header is read up to the vertices.
struct Header {
  std::string format;
  std::string element;  ///< the element to which the next properties belong
  bool vertexSeen = false;
};

void readElement(CloudTable& table, Header& header, const std::vector<std::string_view>& words) {
  if (words.size() != 3) table.refuse("PLY header: an element needs a name and a count");
  header.element = words[1];
  const uint64_t count = parseCount(table, words[2], "PLY header: element");
  if (header.element == "vertex") {
    header.vertexSeen = true;
    table.rows = count;
  } else if (!header.vertexSeen && count > 0) {
    table.refuse("PLY header: '" + header.element.substr(0, 40) + "' comes before the vertices, which must be first");
  }
}

}  // namespace

CloudTable readPly(std::string bytes, const std::string& source) {
  CloudTable table;
  table.source = source;
  table.bytes = std::move(bytes);
  Header header;
  size_t position = 0;
  std::string_view line;
  if (!nextLine(table.bytes, position, line) || splitWords(line) != std::vector<std::string_view>{"ply"}) {
    table.refuse("is not a PLY file");
  }
  while (nextLine(table.bytes, position, line)) {
    const auto words = splitWords(line);
    if (words.empty() || words[0] == "obj_info") continue;
    if (words[0] == "comment") {
      table.readGridComment(line);
    } else if (words[0] == "format") {
      header.format = words.size() > 1 ? words[1] : "";
    } else if (words[0] == "element") {
      readElement(table, header, words);
    } else if (words[0] == "property") {
      if (header.element == "vertex") table.columns.push_back(property(table, words));
    } else if (words[0] == "end_header") {
      if (!header.vertexSeen || table.columns.empty()) table.refuse("PLY header: there is no element vertex");
      position = std::min(position, table.bytes.size());
      if (header.format == "binary_little_endian") {
        table.layRows(position);
      } else if (header.format == "ascii") {
        table.parseTextRows(position);
      } else {
        table.refuse("PLY format must be ascii or binary_little_endian, is '" + header.format.substr(0, 40) + "'");
      }
      return table;
    } else {
      table.refuse("PLY header: a line starts with '" + std::string(words[0].substr(0, 40)) + "'");
    }
  }
  table.refuse("PLY header is cut short");
}

}  // namespace gnosphere
