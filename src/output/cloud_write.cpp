// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <numbers>

#include "base/file.hpp"
#include "gnosphere/error.hpp"
#include "output/fields.hpp"
#include "sensor/beams.hpp"

namespace gnosphere {
namespace {

/// Rows per block: a few megabytes, so that a large cloud is neither copied whole nor written value by value.
constexpr size_t kBlockRows = size_t{1} << 16;

/// The rows to be written: every beam in order, or only the returns. A row is an entry of the scan's arrays.
struct Rows {
  const Scan& scan;
  std::vector<ColumnInfo> columns;
  bool compact = false;
  std::vector<size_t> entries;  ///< only if `compact`
  size_t count = 0;

  size_t entry(size_t row) const { return compact ? entries[row] : row; }
};

size_t rowBytes(const Rows& rows) {
  size_t bytes = 0;
  for (const ColumnInfo& column : rows.columns) bytes += column.size;
  return bytes;
}

bool has(const Scan& scan, Field field) {
  const size_t entries = scan.ranges.size();
  switch (field) {
    case Field::x:
    case Field::y:
    case Field::z: return scan.points.size() == 3 * entries;
    case Field::triangle: return scan.triangles.size() == entries;
    case Field::instance: return scan.instances.size() == entries;
    case Field::tie: return scan.ties.size() == entries;
    case Field::tolerance: return scan.tolerances.size() == entries;
    case Field::intensity: return scan.intensities.size() == entries;
    case Field::trueRange: return scan.trueRanges.size() == entries;
    case Field::cause: return scan.causes.size() == scan.beamCount();
    case Field::label: return scan.labels.size() == entries;
    case Field::width: return scan.widths.size() == entries;
    case Field::normal: return scan.normals.size() == 3 * entries;
    case Field::incidence: return scan.incidences.size() == entries;
    case Field::material: return scan.materials.size() == entries;
    case Field::barycentrics: return scan.barycentrics.size() == 2 * entries;
    case Field::velocity: return scan.velocities.size() == 3 * entries;
    case Field::radialSpeed: return scan.radialSpeeds.size() == entries;
    case Field::classId: return scan.classes && scan.instances.size() == entries;
    case Field::time:
    case Field::azimuth:
    case Field::elevation: return scan.model && scan.model->beamCount() == scan.beamCount();
    case Field::range:
    case Field::ring:
    case Field::beam:
    case Field::returnNumber:
    case Field::returnCount: return true;
  }
  return false;
}

std::string wayTo(Field field) {
  if (field == Field::tie || field == Field::tolerance) return "; only --device reference gives it";
  return isAskedFor(field) ? "; it must be asked for before the scan" : "";
}

void checkFields(const Scan& scan, const std::vector<Field>& fields) {
  if (scan.returns == 0 || scan.returns > 255) {
    throw Error(ErrorCode::invalidArgument,
                "the scan has " + std::to_string(scan.returns) + " returns per beam; there must be 1 to 255");
  }
  const size_t beamCount = scan.beamCount();
  if (size_t{scan.columns} * scan.channels != beamCount) {
    throw Error(ErrorCode::invalidArgument, "the scan has " + std::to_string(beamCount) + " ranges for " +
                                                std::to_string(scan.columns) + " columns x " +
                                                std::to_string(scan.channels) + " channels");
  }
  for (Field field : fields) {
    const std::string name = fieldName(field);
    if (field == Field::ring && scan.channels > 65536) {
      throw Error(ErrorCode::invalidArgument, "field 'ring' is 16 bits wide, the scan has " +
                                                  std::to_string(scan.channels) + " channels; leave it out");
    }
    if (has(scan, field)) continue;
    throw Error(ErrorCode::invalidArgument, "the scan has no field '" + name + "'" + wayTo(field));
  }
}

Rows makeRows(const Scan& scan, const std::vector<Field>& fields, bool compact) {
  Rows rows{scan, columnsOf(fields), compact, {}, scan.ranges.size()};
  if (!compact) return rows;
  for (size_t entry = 0; entry < scan.ranges.size(); ++entry) {
    if (scan.returned(entry)) rows.entries.push_back(entry);
  }
  rows.count = rows.entries.size();
  return rows;
}

/// Returns are counted from 1; an entry without a return has 0.
uint8_t returnNumber(const Scan& scan, size_t entry) {
  return static_cast<uint8_t>(scan.returned(entry) ? entry % scan.returns + 1 : 0);
}

uint8_t returnCount(const Scan& scan, size_t beam) {
  int count = 0;
  for (size_t k = 0; k < scan.returns; ++k) count += scan.returned(beam * scan.returns + k);
  return static_cast<uint8_t>(count);
}

uint16_t classOf(const Scan& scan, size_t entry) {
  const uint32_t instance = scan.instances[entry];
  return instance < scan.classes->size() ? (*scan.classes)[instance] : uint16_t{0};
}

/// Calls `use` with a function that maps an entry to its value, in the column's own type.
template <class Use>
void withColumn(const Scan& scan, const ColumnInfo& column, Use use) {
  const size_t returns = scan.returns;
  const auto from = [&](const auto& values) {
    use([&values, n = size_t{column.components}, c = column.component](size_t e) { return values[n * e + c]; });
  };
  switch (column.field) {
    case Field::x:
    case Field::y:
    case Field::z: return from(scan.points);
    case Field::range: return from(scan.ranges);
    case Field::ring: return use([&](size_t e) { return static_cast<uint16_t>(e / returns / scan.columns); });
    case Field::beam: return use([&](size_t e) { return static_cast<uint32_t>(e / returns); });
    case Field::triangle: return from(scan.triangles);
    case Field::instance: return from(scan.instances);
    case Field::tie: return from(scan.ties);
    case Field::tolerance: return from(scan.tolerances);
    case Field::intensity: return from(scan.intensities);
    case Field::trueRange: return from(scan.trueRanges);
    case Field::cause: return use([&](size_t e) { return scan.causes[e / returns]; });
    case Field::label: return from(scan.labels);
    case Field::returnNumber: return use([&](size_t e) { return returnNumber(scan, e); });
    case Field::returnCount: return use([&](size_t e) { return returnCount(scan, e / returns); });
    case Field::width: return from(scan.widths);
    case Field::normal: return from(scan.normals);
    case Field::incidence: return from(scan.incidences);
    case Field::material: return from(scan.materials);
    case Field::barycentrics: return from(scan.barycentrics);
    case Field::classId: return use([&](size_t e) { return classOf(scan, e); });
    case Field::velocity: return from(scan.velocities);
    case Field::radialSpeed: return from(scan.radialSpeeds);
    case Field::time: return use([&](size_t e) { return static_cast<float>(timeOf(*scan.model, e / returns)); });
    case Field::azimuth: return use([&](size_t e) { return static_cast<float>(azimuthOf(*scan.model, e / returns)); });
    case Field::elevation:
      return use([&](size_t e) { return static_cast<float>(elevationOf(*scan.model, e / returns)); });
  }
}

/// Writes rows of packed little-endian values, `stride` bytes apart. The inner loop handles one field, without
/// branches.
void writeBinary(AtomicFile& file, const Rows& rows, size_t stride) {
  std::string block(kBlockRows * stride, '\0');
  for (size_t first = 0; first < rows.count; first += kBlockRows) {
    const size_t count = std::min(kBlockRows, rows.count - first);
    size_t offset = 0;
    for (const ColumnInfo& column : rows.columns) {
      withColumn(rows.scan, column, [&](auto value) {
        char* out = block.data() + offset;
        for (size_t i = 0; i < count; ++i, out += stride) {
          const auto v = value(rows.entry(first + i));
          std::memcpy(out, &v, sizeof(v));
        }
      });
      offset += column.size;
    }
    file.write(block.data(), count * stride);
  }
}

template <class Number>
char* appendText(char* out, size_t room, Number value) {
  // A NaN may be negative, and readers reject "-nan".
  if (value != value) return std::copy_n("nan", 3, out);
  return std::to_chars(out, out + room, value).ptr;
}

/// Writes one line per row; every float is the shortest text that reads back to the same bits.
void writeText(AtomicFile& file, const Rows& rows, char separator) {
  constexpr size_t kWidest = 20;
  std::string block(kBlockRows / 16 * rows.columns.size() * kWidest, '\0');
  for (size_t first = 0; first < rows.count; first += kBlockRows / 16) {
    const size_t last = std::min(first + kBlockRows / 16, rows.count);
    char* out = block.data();
    for (size_t row = first; row < last; ++row) {
      const size_t entry = rows.entry(row);
      for (const ColumnInfo& column : rows.columns) {
        withColumn(rows.scan, column, [&](auto value) { out = appendText(out, kWidest, value(entry)); });
        *out++ = separator;
      }
      out[-1] = '\n';
    }
    file.write(block.data(), static_cast<size_t>(out - block.data()));
  }
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
  if (!name.empty()) comment.append(" sensor ").append(name);
  return comment;
}

/// Joins text(column) of all columns, each after a space.
template <class Text>
std::string joined(const std::vector<ColumnInfo>& columns, Text text) {
  std::string out;
  for (const ColumnInfo& column : columns) out.append(1, ' ').append(text(column));
  return out;
}

std::string pcdHeader(const Rows& rows, bool ascii) {
  const auto number = [](size_t n) { return std::to_string(n); };
  const size_t width = rows.compact ? rows.count : rows.scan.columns;
  const size_t height = rows.compact ? 1 : rows.scan.channels;
  return "# .PCD v0.7 - Point Cloud Data file format\n# " + gridComment(rows.scan) + "\nVERSION 0.7\nFIELDS" +
         joined(rows.columns, [](const ColumnInfo& f) { return f.name; }) + "\nSIZE" +
         joined(rows.columns, [&](const ColumnInfo& f) { return number(f.size); }) + "\nTYPE" +
         joined(rows.columns, [](const ColumnInfo& f) { return std::string(1, f.type); }) + "\nCOUNT" +
         joined(rows.columns, [](const ColumnInfo&) { return "1"; }) + "\nWIDTH " + number(width) + "\nHEIGHT " +
         number(height) + "\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + number(rows.count) + "\nDATA " +
         (ascii ? "ascii" : "binary") + "\n";
}

std::string plyHeader(const Rows& rows, bool ascii) {
  std::string header = "ply\nformat " + std::string(ascii ? "ascii" : "binary_little_endian") + " 1.0\ncomment " +
                       gridComment(rows.scan) + "\nelement vertex " + std::to_string(rows.count) + "\n";
  for (const ColumnInfo& info : rows.columns) {
    // Open3D skips the types ushort and uint.
    const std::string type = info.type == 'F' ? "float" : "uint" + std::to_string(8 * info.size);
    std::string name = info.name;
    for (const PlyName& other : kPlyNames)
      if (name == other.name) name = other.inPly;
    header.append("property ").append(type).append(" ").append(name).append("\n");
  }
  return header + "end_header\n";
}

/// NPY 1.0: magic, version, length of the text, text padded so that the data starts at a multiple of 64 bytes.
std::string npyHeader(const Rows& rows) {
  std::string text = "{'descr': [";
  for (const ColumnInfo& info : rows.columns) {
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
  for (const ColumnInfo& column : rows.columns) header.append(header.empty() ? "" : ",").append(column.name);
  return header + "\n";
}

}  // namespace

void writeCloud(const Scan& scan, const std::filesystem::path& file, const CloudOptions& options) {
  const CloudFormat format = cloudFormat(file);
  const bool kitti = format == CloudFormat::kitti;
  const bool several = scan.returns > 1;
  std::vector<Field> fields = options.fields;
  if (kitti) {
    fields = {Field::x, Field::y, Field::z};
    if (!scan.intensities.empty()) fields.push_back(Field::intensity);
  } else if (fields.empty()) {
    fields = defaultFields();
    if (several) fields.insert(fields.end(), {Field::returnNumber, Field::returnCount});
  }
  checkFields(scan, fields);
  const Rows rows = makeRows(scan, fields, options.compact || several || kitti);

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
    // KITTI's fourth value is the reflectance; it stays 0 if the scan has no intensity.
    writeBinary(out, rows, kitti ? 4 * sizeof(float) : rowBytes(rows));
  }
  out.commit();
}

}  // namespace gnosphere
