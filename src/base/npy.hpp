// SPDX-License-Identifier: Apache-2.0
// Reads the header of NPY 1.0 to 3.0, a Python dictionary in the few forms in which NumPy writes it, and writes that of
// NPY 1.0.
#pragma once

#include <charconv>
#include <cstdint>
#include <set>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "base/text.hpp"
#include "gnosphere/error.hpp"

namespace gnosphere {

struct NpyHeader {
  struct Column {
    std::string name, type;  ///< as NumPy writes it: <f4; the gaps of aligned types are |V4, without a name
  };
  std::vector<Column> columns;  ///< of a structured type
  std::string type;             ///< of any other; then there are no columns
  bool fortran = false;
  std::vector<uint64_t> shape;
  size_t dataAt = 0;
};

[[noreturn]] inline void refuseNpy(const std::string& file, const std::string& why) {
  throw Error(ErrorCode::format, file + ": " + plainAscii(why));
}

/// Reads the dictionary of Python in a header.
class NpyDictionary {
 public:
  NpyDictionary(const std::string& file, std::string_view text) : file_(file), text_(text) {}

  void read(NpyHeader& header) {
    std::set<std::string> keys;
    expect('{');
    while (!accept('}')) {
      const std::string key = quoted();
      if (!keys.insert(key).second) refuse();
      expect(':');
      if (key == "descr") {
        readType(header);
      } else if (key == "shape") {
        readList('(', ')', [&] { header.shape.push_back(count()); });
      } else if (key == "fortran_order") {
        header.fortran = acceptWord("True");
        if (!header.fortran && !acceptWord("False")) refuse();
      } else {
        refuse();
      }
      if (accept(',')) continue;
      expect('}');
      break;
    }
    for (const char* key : {"descr", "fortran_order", "shape"})
      if (!keys.contains(key)) refuseNpy(file_, std::string("the NPY header has no '") + key + "'");
  }

 private:
  [[noreturn]] void refuse() const {
    refuseNpy(file_, "NPY header is not understood near '" + std::string(text_.substr(0, 40)) + "'");
  }
  void skipSpace() {
    while (!text_.empty() && (text_[0] == ' ' || text_[0] == '\n')) text_.remove_prefix(1);
  }
  bool acceptWord(std::string_view word) {
    skipSpace();
    if (!text_.starts_with(word)) return false;
    text_.remove_prefix(word.size());
    return true;
  }
  bool accept(char c) { return acceptWord({&c, 1}); }
  void expect(char c) {
    if (!accept(c)) refuse();
  }
  std::string quoted() {
    expect('\'');
    const size_t end = text_.find('\'');
    if (end == text_.npos) refuse();
    std::string word(text_.substr(0, end));
    text_.remove_prefix(end + 1);
    return word;
  }
  uint64_t count() {
    skipSpace();
    uint64_t value = 0;
    const auto [end, problem] = std::from_chars(text_.data(), text_.data() + text_.size(), value);
    if (problem != std::errc()) refuse();
    text_.remove_prefix(static_cast<size_t>(end - text_.data()));
    return value;
  }
  template <class Item>
  void readList(char open, char close, Item item) {
    expect(open);
    while (!accept(close)) {
      item();
      if (accept(',')) continue;
      expect(close);
      return;
    }
  }
  void readType(NpyHeader& header) {
    skipSpace();
    if (text_.starts_with('\'')) {
      header.type = quoted();
      return;
    }
    readList('[', ']', [&] {
      NpyHeader::Column& column = header.columns.emplace_back();
      expect('(');
      column.name = quoted();
      expect(',');
      column.type = quoted();
      expect(')');
    });
  }

  const std::string& file_;
  std::string_view text_;
};

/// Reads the header of an NPY file, of which at least 12 bytes are there, the first of them those of all NPY files.
/// Throws Error(format) that names the file and the place of the mistake.
inline NpyHeader readNpyHeader(std::string_view bytes, const std::string& file) {
  const auto byte = [&](size_t i) { return static_cast<size_t>(static_cast<unsigned char>(bytes[i])); };
  if (byte(6) < 1 || byte(6) > 3) refuseNpy(file, "NPY version " + std::to_string(byte(6)) + " is not read");
  const size_t start = byte(6) == 1 ? 10 : 12;
  const size_t size = byte(8) | byte(9) << 8 | (byte(6) == 1 ? 0 : byte(10) << 16 | byte(11) << 24);
  if (size > bytes.size() - start) refuseNpy(file, "the NPY header is cut short");
  NpyHeader header;
  header.dataAt = start + size;
  NpyDictionary(file, bytes.substr(start, size)).read(header);
  return header;
}

/// Returns the header of NPY 1.0 for a type and a shape as Python writes them, such as "'<f4'" and "(5, 4)": magic,
/// version, length of the text, and the text, padded so that the data starts at a multiple of 64 bytes.
inline std::string npyHeaderOf(const std::string& type, const std::string& shape) {
  std::string text = "{'descr': " + type + ", 'fortran_order': False, 'shape': " + shape + ", }";
  constexpr size_t kFixed = 10;
  text.append(63 - (kFixed + text.size()) % 64, ' ');
  text += '\n';
  std::string header("\x93NUMPY\x01\x00", 8);
  header += static_cast<char>(text.size() & 0xff);
  header += static_cast<char>(text.size() >> 8);
  return header + text;
}

}  // namespace gnosphere
