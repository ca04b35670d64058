// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <charconv>
#include <cstring>
#include <limits>

#include "file.hpp"
#include "gnosphere/error.hpp"
#include "output/fields.hpp"

namespace gnosphere {
namespace {

/// Rows per block: a few megabytes, so a large cloud is neither held twice nor written value by value.
constexpr size_t kBlockRows = size_t{1} << 16;

/// The rows to be written: every beam in order, or those that hit.
struct Rows {
  const Scan& scan;
  const std::vector<Field>& fields;
  std::vector<uint32_t> beams;  ///< where `compact`
  bool compact = false;
  size_t count = 0;

  size_t beam(size_t row) const { return compact ? beams[row] : row; }
};

size_t rowBytes(const std::vector<Field>& fields) {
  size_t bytes = 0;
  for (Field field : fields) bytes += fieldInfo(field).size;
  return bytes;
}

bool isHit(const Scan& scan, size_t beam) {
  return scan.triangles.empty() ? scan.ranges[beam] == scan.ranges[beam] : scan.hit(beam);
}

size_t entries(const Scan& scan, Field field) {
  switch (field) {
    case Field::x:
    case Field::y:
    case Field::z: return scan.points.size() / 3;
    case Field::range: return scan.ranges.size();
    case Field::triangle: return scan.triangles.size();
    case Field::instance: return scan.instances.size();
    case Field::tie: return scan.ties.size();
    case Field::tolerance: return scan.tolerances.size();
    default: break;
  }
  return scan.beamCount();
}

void checkFields(const Scan& scan, const std::vector<Field>& fields) {
  const size_t beamCount = scan.beamCount();
  if (size_t{scan.columns} * scan.channels != beamCount) {
    throw Error(ErrorCode::invalidArgument, "the scan has " + std::to_string(beamCount) + " ranges for " +
                                                std::to_string(scan.columns) + " columns x " +
                                                std::to_string(scan.channels) + " channels");
  }
  if (fields.empty()) throw Error(ErrorCode::invalidArgument, "no field to write was chosen");
  for (Field field : fields) {
    const std::string name = fieldInfo(field).name;
    if (field == Field::ring && scan.channels > 65536) {
      throw Error(ErrorCode::invalidArgument, "field 'ring' is 16 bits wide, the scan has " +
                                                  std::to_string(scan.channels) + " channels; leave it out");
    }
    if (entries(scan, field) == beamCount) continue;
    const bool fromReference = field == Field::tie || field == Field::tolerance;
    throw Error(ErrorCode::invalidArgument,
                "the scan has no field '" + name + "'" + (fromReference ? "; only --device reference gives it" : ""));
  }
}

Rows makeRows(const Scan& scan, const std::vector<Field>& fields, bool compact) {
  Rows rows{scan, fields, {}, compact, scan.beamCount()};
  if (!compact) return rows;
  for (size_t beam = 0; beam < scan.beamCount(); ++beam) {
    if (isHit(scan, beam)) rows.beams.push_back(static_cast<uint32_t>(beam));
  }
  rows.count = rows.beams.size();
  return rows;
}

/// Calls `use` with a function beam -> value, of the field's own type.
template <class Use>
void withField(const Scan& scan, Field field, Use use) {
  switch (field) {
    case Field::x: return use([&](size_t b) { return scan.points[3 * b]; });
    case Field::y: return use([&](size_t b) { return scan.points[3 * b + 1]; });
    case Field::z: return use([&](size_t b) { return scan.points[3 * b + 2]; });
    case Field::range: return use([&](size_t b) { return scan.ranges[b]; });
    case Field::ring: return use([&](size_t b) { return static_cast<uint16_t>(b / scan.columns); });
    case Field::beam: return use([&](size_t b) { return static_cast<uint32_t>(b); });
    case Field::triangle: return use([&](size_t b) { return scan.triangles[b]; });
    case Field::instance: return use([&](size_t b) { return scan.instances[b]; });
    case Field::tie: return use([&](size_t b) { return scan.ties[b]; });
    case Field::tolerance: return use([&](size_t b) { return scan.tolerances[b]; });
    default: break;
  }
}

/// Rows of packed little-endian values, `stride` bytes apart. Field by field, so the inner loop has no branch on it.
void writeBinary(AtomicFile& file, const Rows& rows, size_t stride) {
  std::string block(kBlockRows * stride, '\0');
  for (size_t first = 0; first < rows.count; first += kBlockRows) {
    const size_t count = std::min(kBlockRows, rows.count - first);
    size_t offset = 0;
    for (Field field : rows.fields) {
      withField(rows.scan, field, [&](auto value) {
        char* out = block.data() + offset;
        for (size_t i = 0; i < count; ++i, out += stride) {
          const auto v = value(rows.beam(first + i));
          std::memcpy(out, &v, sizeof(v));
        }
      });
      offset += fieldInfo(field).size;
    }
    file.write(block.data(), count * stride);
  }
}

template <class Number>
char* appendText(char* out, size_t room, Number value) {
  // A NaN may carry a sign, and readers stumble over "-nan".
  if (value != value) return std::copy_n("nan", 3, out);
  return std::to_chars(out, out + room, value).ptr;
}

/// One line per row; every float is the shortest text that reads back to the same bits.
void writeText(AtomicFile& file, const Rows& rows, char separator) {
  constexpr size_t kWidest = 20;
  std::string block(kBlockRows / 16 * rows.fields.size() * kWidest, '\0');
  for (size_t first = 0; first < rows.count; first += kBlockRows / 16) {
    const size_t last = std::min(first + kBlockRows / 16, rows.count);
    char* out = block.data();
    for (size_t row = first; row < last; ++row) {
      const size_t beam = rows.beam(row);
      for (Field field : rows.fields) {
        withField(rows.scan, field, [&](auto value) { out = appendText(out, kWidest, value(beam)); });
        *out++ = separator;
      }
      out[-1] = '\n';
    }
    file.write(block.data(), static_cast<size_t>(out - block.data()));
  }
}

std::string gridComment(const Scan& scan) {
  char text[96];
  std::snprintf(text, sizeof(text), kGridComment, scan.columns, scan.channels);
  std::string name = scan.sensor;
  std::replace_if(
      name.begin(), name.end(), [](unsigned char c) { return c < ' '; }, ' ');
  std::string comment = text;
  if (!name.empty()) comment.append(" sensor ").append(name);
  return comment;
}

/// The fields joined by `text(info)`, each after a space.
template <class Text>
std::string joined(const std::vector<Field>& fields, Text text) {
  std::string out;
  for (Field field : fields) out.append(1, ' ').append(text(fieldInfo(field)));
  return out;
}

std::string pcdHeader(const Rows& rows, bool ascii) {
  const auto number = [](size_t n) { return std::to_string(n); };
  const size_t width = rows.compact ? rows.count : rows.scan.columns;
  const size_t height = rows.compact ? 1 : rows.scan.channels;
  return "# .PCD v0.7 - Point Cloud Data file format\n# " + gridComment(rows.scan) + "\nVERSION 0.7\nFIELDS" +
         joined(rows.fields, [](const FieldInfo& f) { return f.name; }) + "\nSIZE" +
         joined(rows.fields, [&](const FieldInfo& f) { return number(f.size); }) + "\nTYPE" +
         joined(rows.fields, [](const FieldInfo& f) { return std::string(1, f.type); }) + "\nCOUNT" +
         joined(rows.fields, [](const FieldInfo&) { return "1"; }) + "\nWIDTH " + number(width) + "\nHEIGHT " +
         number(height) + "\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + number(rows.count) + "\nDATA " +
         (ascii ? "ascii" : "binary") + "\n";
}

std::string plyHeader(const Rows& rows, bool ascii) {
  std::string header = "ply\nformat " + std::string(ascii ? "ascii" : "binary_little_endian") + " 1.0\ncomment " +
                       gridComment(rows.scan) + "\nelement vertex " + std::to_string(rows.count) + "\n";
  for (Field field : rows.fields) {
    const FieldInfo& info = fieldInfo(field);
    const char* type = info.type == 'F' ? "float" : info.size == 4 ? "uint" : info.size == 2 ? "ushort" : "uchar";
    header.append("property ").append(type).append(" ").append(info.name).append("\n");
  }
  return header + "end_header\n";
}

/// NPY 1.0: magic, version, length of the text, text padded so that the data starts at a multiple of 64 bytes.
std::string npyHeader(const Rows& rows) {
  std::string text = "{'descr': [";
  for (Field field : rows.fields) {
    const FieldInfo& info = fieldInfo(field);
    text.append("('").append(info.name).append(info.size == 1 ? "', '|" : "', '<");
    text.append(info.type == 'F' ? "f" : "u").append(std::to_string(info.size)).append("'), ");
  }
  text.resize(text.size() - 2);
  text += "], 'fortran_order': False, 'shape': (";
  text += rows.compact ? std::to_string(rows.count) + ","
                       : std::to_string(rows.scan.channels) + ", " + std::to_string(rows.scan.columns);
  text += "), }";
  constexpr size_t kFixed = 10;
  text.append(63 - (kFixed + text.size()) % 64, ' ');
  text += '\n';
  std::string header("\x93NUMPY\x01\x00", 8);
  header += static_cast<char>(text.size() & 0xff);
  header += static_cast<char>(text.size() >> 8);
  return header + text;
}

std::string csvHeader(const Rows& rows) {
  std::string header;
  for (Field field : rows.fields) header.append(header.empty() ? "" : ",").append(fieldInfo(field).name);
  return header + "\n";
}

}  // namespace

void writeCloud(const Scan& scan, const std::filesystem::path& file, const CloudOptions& options) {
  static const std::vector<Field> kittiFields = {Field::x, Field::y, Field::z};
  const CloudFormat format = cloudFormat(file);
  const bool kitti = format == CloudFormat::kitti;
  const std::vector<Field>& fields = kitti ? kittiFields : options.fields;
  checkFields(scan, fields);
  const Rows rows = makeRows(scan, fields, options.compact || kitti);

  AtomicFile out(file);
  switch (format) {
    case CloudFormat::pcd: out.write(pcdHeader(rows, options.ascii)); break;
    case CloudFormat::ply: out.write(plyHeader(rows, options.ascii)); break;
    case CloudFormat::npy: out.write(npyHeader(rows)); break;
    case CloudFormat::csv: out.write(csvHeader(rows)); break;
    case CloudFormat::kitti: break;
  }
  if (format == CloudFormat::csv) {
    writeText(out, rows, ',');
  } else if (options.ascii && (format == CloudFormat::pcd || format == CloudFormat::ply)) {
    writeText(out, rows, ' ');
  } else {
    // KITTI's fourth value, the reflectance, stays the zero that the block is born with.
    writeBinary(out, rows, kitti ? 4 * sizeof(float) : rowBytes(fields));
  }
  out.commit();
}

}  // namespace gnosphere
