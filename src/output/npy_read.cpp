// SPDX-License-Identifier: Apache-2.0
// Reads NPY 1.0 to 3.0 with a structured type, as numpy.save() and writeCloud() write it.
#include <cstring>
#include <limits>

#include "output/cloud_table.hpp"

namespace gnosphere {
namespace {

/// Parser of the header, a Python dictionary, for the few forms that NumPy writes.
class Dictionary {
 public:
  Dictionary(const CloudTable& table, std::string_view text) : table_(table), text_(text) {}

  void read(CloudTable& out, std::vector<uint64_t>& shape, bool& fortranOrder) {
    expect('{');
    while (!accept('}')) {
      const std::string key = quoted();
      expect(':');
      if (key == "descr") {
        readColumns(out);
      } else if (key == "shape") {
        readShape(shape);
      } else if (key == "fortran_order") {
        fortranOrder = acceptWord("True");
        if (!fortranOrder && !acceptWord("False")) refuse();
      } else {
        refuse();
      }
      if (!accept(',')) {
        expect('}');
        return;
      }
    }
  }

 private:
  [[noreturn]] void refuse() const {
    table_.refuse("NPY header is not understood near '" + std::string(text_.substr(0, 40)) + "'");
  }
  void skipSpace() {
    while (!text_.empty() && (text_[0] == ' ' || text_[0] == '\n')) text_.remove_prefix(1);
  }
  bool accept(char c) {
    skipSpace();
    if (text_.empty() || text_[0] != c) return false;
    text_.remove_prefix(1);
    return true;
  }
  void expect(char c) {
    if (!accept(c)) refuse();
  }
  bool acceptWord(std::string_view word) {
    skipSpace();
    if (text_.substr(0, word.size()) != word) return false;
    text_.remove_prefix(word.size());
    return true;
  }
  std::string quoted() {
    expect('\'');
    const size_t end = text_.find('\'');
    if (end == text_.npos) refuse();
    std::string word(text_.substr(0, end));
    text_.remove_prefix(end + 1);
    return word;
  }
  void readColumns(CloudTable& out) {
    skipSpace();
    if (!text_.empty() && text_[0] == '\'') table_.refuse("NPY array has no field names; a cloud needs x, y, z ...");
    expect('[');
    while (!accept(']')) {
      expect('(');
      CloudColumn column;
      column.name = quoted();
      expect(',');
      const std::string type = quoted();
      const bool known = type.size() == 3 && (type[0] == '<' || type[0] == '|') &&
                         std::string_view("fui").find(type[1]) != std::string_view::npos &&
                         std::string_view(type[1] == 'f' ? "48" : "1248").find(type[2]) != std::string_view::npos;
      if (!known) table_.refuse("NPY field '" + column.name + "' has the type '" + type + "', which is not read");
      column.type = type[1] == 'f' ? 'F' : type[1] == 'u' ? 'U' : 'I';
      column.size = static_cast<size_t>(type[2] - '0');
      out.columns.push_back(column);
      expect(')');
      if (!accept(',')) {
        expect(']');
        return;
      }
    }
  }
  void readShape(std::vector<uint64_t>& shape) {
    expect('(');
    while (!accept(')')) {
      skipSpace();
      const size_t end = text_.find_first_not_of("0123456789");
      if (end == text_.npos) refuse();
      shape.push_back(parseCount(table_, text_.substr(0, end), "NPY shape"));
      text_.remove_prefix(end);
      if (!accept(',')) {
        expect(')');
        return;
      }
    }
  }

  const CloudTable& table_;
  std::string_view text_;
};

}  // namespace

CloudTable readNpy(std::string bytes, const std::string& source) {
  CloudTable table;
  table.source = source;
  table.bytes = std::move(bytes);
  const std::string_view all = table.bytes;
  if (all.size() < 12 || all.substr(0, 6) != "\x93NUMPY") table.refuse("is not an NPY file");
  const int version = all[6];
  if (version < 1 || version > 3) table.refuse("NPY version " + std::to_string(version) + " is not read");
  uint32_t length = 0;
  const size_t lengthBytes = version == 1 ? 2 : 4;
  std::memcpy(&length, all.data() + 8, lengthBytes);
  const size_t start = 8 + lengthBytes;
  if (length > all.size() - start) table.refuse("NPY header is cut short");

  std::vector<uint64_t> shape;
  bool fortranOrder = false;
  Dictionary(table, all.substr(start, length)).read(table, shape, fortranOrder);
  if (table.columns.empty()) table.refuse("NPY header names no field");
  if (shape.empty() || shape.size() > 2) table.refuse("NPY array must have one or two dimensions");
  for (uint64_t extent : shape) {
    if (extent > std::numeric_limits<uint32_t>::max()) table.refuse("NPY shape is beyond 32 bits");
  }
  if (fortranOrder && shape.size() > 1) table.refuse("NPY array is in Fortran order; save it in C order");
  table.rows = shape[0] * (shape.size() == 2 ? shape[1] : 1);
  if (shape.size() == 2) {
    table.height = static_cast<uint32_t>(shape[0]);
    table.width = static_cast<uint32_t>(shape[1]);
  }
  table.layRows(start + length);
  return table;
}

}  // namespace gnosphere
