// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <charconv>
#include <cstring>
#include <functional>
#include <string_view>

#include "base/file.hpp"
#include "base/npy.hpp"
#include "base/quaternion.hpp"
#include "output/cloud_bytes.hpp"
#include "output/cloud_format.hpp"
#include "output/cloud_rows.hpp"

namespace gnosphere {
namespace {

/// Rows per block: a block takes a few megabytes, so a large cloud is not copied whole, and writes are not small.
constexpr size_t kBlockRows = size_t{1} << 16;

/// Calls `use` for each block with the packed rows and their number.
template <class Use>
void forBlocks(const CloudRows& table, size_t blockRows, const Use& use) {
  const size_t count = table.rows.count();
  std::vector<std::byte> block(std::min(blockRows, count) * table.layout.stride);
  for (size_t first = 0; first < count; first += blockRows) {
    const size_t rows = std::min(blockRows, count - first);
    table.rows.pack(table.layout, first, rows, block.data());
    use(block.data(), rows);
  }
}

/// Takes the bytes of a file one part after the other.
using Sink = std::function<void(std::string_view bytes)>;

/// Writes the packed rows unchanged, which are little-endian.
void writeBinary(const Sink& write, const CloudRows& table) {
  forBlocks(table, kBlockRows, [&](const std::byte* rows, size_t count) {
    write({reinterpret_cast<const char*>(rows), count * table.layout.stride});
  });
}

template <class Number>
char* appendText(char* out, size_t room, Number value) {
  // A NaN may have a sign, but many readers do not accept "-nan".
  if (value != value) return std::copy_n("nan", 3, out);
  return std::to_chars(out, out + room, value).ptr;
}

template <class Number>
char* appendText(char* out, size_t room, const std::byte* at) {
  Number value;
  std::memcpy(&value, at, sizeof(value));
  return appendText(out, room, value);
}

char* appendText(char* out, size_t room, ValueType type, const std::byte* at) {
  switch (type) {
    case ValueType::f32: return appendText<float>(out, room, at);
    case ValueType::f64: return appendText<double>(out, room, at);
    case ValueType::u8: return appendText<uint8_t>(out, room, at);
    case ValueType::u16: return appendText<uint16_t>(out, room, at);
    case ValueType::u32: break;
  }
  return appendText<uint32_t>(out, room, at);
}

/// Writes one line per row; every float is the shortest text that reads back to the same bits.
void writeText(const Sink& write, const CloudRows& table, char separator) {
  constexpr size_t kWidest = 20;
  constexpr size_t kRows = kBlockRows / 16;
  std::string text(kRows * table.layout.values.size() * kWidest, '\0');
  forBlocks(table, kRows, [&](const std::byte* row, size_t count) {
    char* out = text.data();
    for (size_t i = 0; i < count; ++i, row += table.layout.stride) {
      for (const RecordLayout::Value& value : table.layout.values) {
        out = appendText(out, kWidest, value.type, row + value.offset);
        *out++ = separator;
      }
      out[-1] = '\n';
    }
    write({text.data(), static_cast<size_t>(out - text.data())});
  });
}

std::string gridComment(const Scan& scan) {
  char text[96];
  const bool several = scan.returns > 1;
  std::snprintf(text, sizeof(text), several ? kGridCommentReturns : kGridComment, scan.columns, scan.channels,
                scan.returns);
  std::string name = scan.sensor;
  std::replace_if(
      name.begin(), name.end(), [](unsigned char c) { return c < ' '; }, ' ');
  std::string comment = text;
  if (scan.skewed) comment.append(kSkewed);
  if (!name.empty()) comment.append(" sensor ").append(name);
  return comment;
}

/// Concatenates `text(column)` of all columns, each after a space.
template <class Text>
std::string joined(const std::vector<ColumnInfo>& columns, Text text) {
  std::string out;
  for (const ColumnInfo& column : columns) out.append(1, ' ').append(text(column));
  return out;
}

/// Refuses fields that files of a fixed layout do not have.
void checkFixed(const CloudFormat& format, const std::vector<Field>& fields) {
  constexpr Field kFixed[] = {Field::x, Field::y, Field::z, Field::intensity};
  for (const Field field : fields)
    if (std::ranges::count(kFixed, field) == 0)
      throw Error(ErrorCode::invalidArgument, std::string("files of ") + format.name + " (" + format.ending +
                                                  ") always have x, y, z and the intensity; they cannot have '" +
                                                  fieldInfo(field).name + "'");
}

/// Returns the rows and columns of a file of this format. Throws Error(invalidArgument) if the scan lacks a field.
CloudRows rowsOf(const Scan& scan, const CloudFormat& format, const CloudOptions& options) {
  const bool several = scan.returns > 1;
  checkOnce(options.fields);
  if (format.layout) {
    checkFixed(format, options.fields);
    return {Rows(scan, true), format.layout(scan), {}};
  }
  std::vector<Field> fields = options.fields;
  if (fields.empty()) {
    fields = defaultFields();
    if (several) fields.insert(fields.end(), {Field::returnNumber, Field::returnCount});
  }
  checkFields(scan, fields);
  // compare() must know of a tie also where the reference has no return and the other cloud may have one.
  const bool compact = options.compact.value_or(several);
  const bool ties = compact && several && std::ranges::count(fields, Field::tie) > 0;
  return {Rows(scan, compact, ties), layoutOf(fields), columnsOf(fields)};
}

void writeRows(const CloudRows& rows, const CloudFormat& format, bool ascii, const Sink& write) {
  if (format.header) write(format.header(rows, ascii));
  if (format.text == CloudFormat::Text::always || (ascii && format.text == CloudFormat::Text::ifAsked))
    writeText(write, rows, format.separator);
  else
    writeBinary(write, rows);
}

/// Returns the pose of the sensor as PCD writes it: x y z, then the unit quaternion, real part first.
std::string viewpointOf(const Pose& pose) {
  const Vec3& p = pose.position;
  const Quaternion q = unitOf(pose.orientation);
  std::string text;
  for (const double value : {p.x, p.y, p.z, q.w, q.x, q.y, q.z}) text.append(" ").append(numberText(value));
  return text;
}

}  // namespace

std::string pcdHeader(const CloudRows& table, bool ascii) {
  const auto number = [](size_t n) { return std::to_string(n); };
  const Scan& scan = table.rows.scan();
  const size_t width = table.rows.compact() ? table.rows.count() : size_t{scan.columns} * scan.returns;
  const size_t height = table.rows.compact() ? 1 : scan.channels;
  return "# .PCD v0.7 - Point Cloud Data file format\n# " + gridComment(scan) + "\nVERSION 0.7\nFIELDS" +
         joined(table.columns, [](const ColumnInfo& f) { return f.name; }) + "\nSIZE" +
         joined(table.columns, [&](const ColumnInfo& f) { return number(sizeOf(f.type)); }) + "\nTYPE" +
         joined(table.columns, [](const ColumnInfo& f) { return std::string(1, letterOf(f.type)); }) + "\nCOUNT" +
         joined(table.columns, [](const ColumnInfo&) { return "1"; }) + "\nWIDTH " + number(width) + "\nHEIGHT " +
         number(height) + "\nVIEWPOINT" + viewpointOf(scan.pose) + "\nPOINTS " + number(table.rows.count()) +
         "\nDATA " + (ascii ? "ascii" : "binary") + "\n";
}

std::string plyHeader(const CloudRows& table, bool ascii) {
  std::string header = "ply\nformat " + std::string(ascii ? "ascii" : "binary_little_endian") + " 1.0\ncomment " +
                       gridComment(table.rows.scan()) + "\nelement vertex " + std::to_string(table.rows.count()) + "\n";
  for (const ColumnInfo& info : table.columns) {
    const size_t size = sizeOf(info.type);
    // Open3D skips the types ushort and uint.
    const std::string type = letterOf(info.type) == 'F' ? "float" : "uint" + std::to_string(8 * size);
    std::string name = info.name;
    for (const PlyName& other : kPlyNames)
      if (name == other.name) name = other.inPly;
    header.append("property ").append(type).append(" ").append(name).append("\n");
  }
  return header + "end_header\n";
}

std::string npyHeader(const CloudRows& table, bool) {
  std::string types = "[";
  for (const ColumnInfo& info : table.columns) {
    types.append("('").append(info.name).append(sizeOf(info.type) == 1 ? "', '|" : "', '<");
    types.append(letterOf(info.type) == 'F' ? "f" : "u").append(std::to_string(sizeOf(info.type))).append("'), ");
  }
  types.replace(types.size() - 2, 2, "]");
  if (table.rows.compact()) return npyHeaderOf(types, "(" + std::to_string(table.rows.count()) + ",)");
  const Scan& scan = table.rows.scan();
  const std::string returns = scan.returns > 1 ? ", " + std::to_string(scan.returns) : "";
  return npyHeaderOf(types, "(" + std::to_string(scan.channels) + ", " + std::to_string(scan.columns) + returns + ")");
}

std::string csvHeader(const CloudRows& table, bool) {
  std::string header;
  for (const ColumnInfo& column : table.columns) header.append(header.empty() ? "" : ",").append(column.name);
  return header + "\n";
}

RecordLayout kittiLayout(const Scan& scan) {
  std::vector<Field> fields = {Field::x, Field::y, Field::z};
  if (scan.has(Field::intensity)) fields.push_back(Field::intensity);
  checkFields(scan, fields);
  RecordLayout layout = layoutOf(fields);
  layout.stride = 4 * sizeof(float);  // without intensity the fourth value stays 0, because blocks start with zeros
  layout.compact = true;
  return layout;
}

void writeCloud(const Scan& scan, const std::filesystem::path& file, const CloudOptions& options) {
  const CloudFormat& format = cloudFormat(file);
  const CloudRows rows = rowsOf(scan, format, options);
  AtomicFile out(file);
  writeRows(rows, format, options.ascii, [&](std::string_view bytes) { out.write(bytes.data(), bytes.size()); });
  out.commit();
}

std::string cloudBytes(const Scan& scan, const std::string& ending, const CloudOptions& options) {
  const CloudFormat& format = cloudFormat("cloud." + ending);
  std::string result;
  writeRows(rowsOf(scan, format, options), format, options.ascii, [&](std::string_view bytes) { result += bytes; });
  return result;
}

}  // namespace gnosphere
