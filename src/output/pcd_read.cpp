// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "base/number.hpp"
#include "base/quaternion.hpp"
#include "output/cloud_table.hpp"

namespace gnosphere {
namespace {

using Words = std::vector<std::string_view>;

/// Checks that SIZE, TYPE or COUNT has as many entries as FIELDS.
void checkLength(const CloudTable& table, const Words& words) {
  if (words.size() != table.columns.size() + 1) {
    table.refuse("PCD header: " + std::string(words[0]) + " has " + std::to_string(words.size() - 1) +
                 " entries, FIELDS has " + std::to_string(table.columns.size()));
  }
}

uint32_t count32(const CloudTable& table, const Words& words) {
  const uint64_t value = parseCount(table, words.size() > 1 ? words[1] : "", "PCD header: WIDTH or HEIGHT");
  if (value > std::numeric_limits<uint32_t>::max()) table.refuse("PCD header: WIDTH or HEIGHT is beyond 32 bits");
  return static_cast<uint32_t>(value);
}

void readSizes(CloudTable& table, const Words& words) {
  checkLength(table, words);
  for (size_t i = 1; i < words.size(); ++i) {
    table.columns[i - 1].size = parseCount(table, words[i], "PCD header: SIZE");
  }
}

void readCounts(CloudTable& table, const Words& words) {
  checkLength(table, words);
  for (size_t i = 1; i < words.size(); ++i) {
    const uint64_t count = parseCount(table, words[i], "PCD header: COUNT");
    if (count == 0 || count > 65536) table.refuse("PCD header: COUNT must be 1 to 65536, is " + std::to_string(count));
    table.columns[i - 1].count = count;
  }
}

void readTypes(CloudTable& table, const Words& words) {
  checkLength(table, words);
  for (size_t i = 1; i < words.size(); ++i) {
    if (words[i] != "F" && words[i] != "U" && words[i] != "I") {
      table.refuse("PCD header: TYPE must be F, U or I, is '" + std::string(words[i].substr(0, 40)) + "'");
    }
    table.columns[i - 1].type = words[i][0];
  }
}

/// Reads the pose of the sensor: x y z, then the quaternion, real part first. One of length 0 turns nothing.
void readViewpoint(CloudTable& table, const Words& words) {
  double v[7];
  bool sound = words.size() == 8;
  for (size_t i = 0; sound && i < 7; ++i) sound = parseNumber(words[i + 1], v[i]) && std::isfinite(v[i]);
  if (!sound) table.refuse("PCD header: VIEWPOINT must be x y z qw qx qy qz, seven finite numbers");
  table.pose = Pose{{v[0], v[1], v[2]}, unitOf({v[4], v[5], v[6], v[3]})};
}

void checkHeader(CloudTable& table, bool pointsGiven) {
  if (table.columns.empty()) table.refuse("is not a PCD file: its header has no FIELDS");
  for (const CloudColumn& column : table.columns) {
    const bool sound = column.type == 'F'
                           ? column.size == 4 || column.size == 8
                           : column.size == 1 || column.size == 2 || column.size == 4 || column.size == 8;
    if (!sound) {
      table.refuse("PCD header: field '" + column.name + "' cannot be of type " + column.type + " and " +
                   std::to_string(column.size) + " bytes");
    }
  }
  const uint64_t grid = uint64_t{table.width} * table.height;
  if (!pointsGiven) table.rows = grid;
  if (table.rows != grid) {
    table.refuse("PCD header: POINTS " + std::to_string(table.rows) + " is not WIDTH " + std::to_string(table.width) +
                 " x HEIGHT " + std::to_string(table.height));
  }
}

/// Decompresses LZF, which PCL's binary_compressed uses (Marc Lehmann's liblzf format): a control byte below 32 starts
/// that many literals plus one; any other holds three bits of length and thirteen bits of distance back.
std::string decompressLzf(const CloudTable& table, std::string_view in, size_t size) {
  std::string out;
  // A control sequence has at least three bytes and yields at most 264.
  if (size / 264 > in.size()) table.refuse("compressed data is cut short");
  out.reserve(size);
  const auto byte = [&](size_t i) -> size_t {
    if (i >= in.size()) table.refuse("compressed data is cut short");
    return static_cast<unsigned char>(in[i]);
  };
  for (size_t at = 0; at < in.size();) {
    const size_t control = byte(at++);
    if (control < 32) {
      byte(at + control);
      out.append(in.substr(at, control + 1));
      at += control + 1;
    } else {
      size_t length = control >> 5;
      if (length == 7) length += byte(at++);
      const size_t distance = ((control & 31) << 8) + byte(at++) + 1;
      if (distance > out.size()) table.refuse("compressed data points before its start");
      for (size_t i = 0; i < length + 2; ++i) out.push_back(out[out.size() - distance]);
    }
    if (out.size() > size) break;
  }
  if (out.size() != size) table.refuse("compressed data does not have the stated length");
  return out;
}

/// Reads binary_compressed data: compressed size, full size, then the fields one after another.
void readCompressed(CloudTable& table, size_t offset) {
  uint32_t sizes[2];
  if (table.bytes.size() - offset < sizeof(sizes)) table.refuse("is cut short after its header");
  std::memcpy(sizes, table.bytes.data() + offset, sizeof(sizes));
  const std::string_view rest = std::string_view(table.bytes).substr(offset + sizeof(sizes));
  if (rest.size() < sizes[0]) table.refuse("compressed data is cut short");
  table.bytes = decompressLzf(table, rest.substr(0, sizes[0]), sizes[1]);
  table.layRows(0);
  size_t start = 0;
  for (CloudColumn& column : table.columns) {
    column.offset = start;
    column.step = column.size * column.count;
    start += column.step * table.rows;
  }
}

}  // namespace

CloudTable readPcd(std::string bytes, const std::string& source) {
  CloudTable table;
  table.source = source;
  table.bytes = std::move(bytes);
  table.height = 1;
  bool pointsGiven = false;
  size_t position = 0;
  std::string_view line;
  while (nextLine(table.bytes, position, line)) {
    if (!line.empty() && line[0] == '#') {
      table.readGridComment(line);
      continue;
    }
    const Words words = splitWords(line);
    if (words.empty() || words[0] == "VERSION") continue;
    if (words[0] == "VIEWPOINT") {
      readViewpoint(table, words);
    } else if (words[0] == "FIELDS") {
      table.columns.clear();
      for (size_t i = 1; i < words.size(); ++i) table.columns.push_back({std::string(words[i])});
    } else if (words[0] == "SIZE") {
      readSizes(table, words);
    } else if (words[0] == "TYPE") {
      readTypes(table, words);
    } else if (words[0] == "COUNT") {
      readCounts(table, words);
    } else if (words[0] == "WIDTH") {
      table.width = count32(table, words);
    } else if (words[0] == "HEIGHT") {
      table.height = count32(table, words);
    } else if (words[0] == "POINTS") {
      table.rows = parseCount(table, words.size() > 1 ? words[1] : "", "PCD header: POINTS");
      pointsGiven = true;
    } else if (words[0] == "DATA") {
      checkHeader(table, pointsGiven);
      position = std::min(position, table.bytes.size());
      const std::string kind(words.size() > 1 ? words[1] : "");
      if (kind == "binary") {
        table.layRows(position);
      } else if (kind == "ascii") {
        table.parseTextRows(position);
      } else if (kind == "binary_compressed") {
        readCompressed(table, position);
      } else {
        table.refuse("PCD header: DATA must be ascii, binary or binary_compressed, is '" + kind.substr(0, 40) + "'");
      }
      return table;
    } else {
      table.refuse("is not a PCD file: its header has a line '" + std::string(line.substr(0, 40)) + "'");
    }
  }
  table.refuse("is not a PCD file: its header has no DATA");
}

}  // namespace gnosphere
