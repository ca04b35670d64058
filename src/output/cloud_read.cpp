// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>

#include "file.hpp"
#include "gnosphere/error.hpp"
#include "output/cloud_table.hpp"

namespace gnosphere {
namespace {

/// Beams that a file which holds only some of them may spread over: it bounds what a small, unsound file can make us
/// allocate (450 MiB). Twice the largest model we know; more where the file has a point for one beam in 64.
uint64_t maxSparseBeams(const CloudTable& table) {
  return std::max(uint64_t{1} << 24, uint64_t{64} * table.rows);
}

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

struct Grid {
  uint32_t columns = 0, channels = 0;
};

uint32_t whole(const CloudTable& table, const CloudColumn& column, size_t row) {
  const double value = table.value(column, row);
  if (!(value >= 0 && value <= 4294967295.0)) {
    table.refuse("point " + std::to_string(row) + ": '" + column.name + "' is not a whole number of 32 bits");
  }
  return static_cast<uint32_t>(value);
}

/// Without a word about the grid, the rings may tell: every beam of ring j lies in row j.
Grid gridFromRings(const CloudTable& table, const CloudColumn& beam, uint64_t beams) {
  const Grid line{static_cast<uint32_t>(beams), 1};
  const CloudColumn* ring = table.find("ring");
  if (!ring) return line;
  uint64_t channels = 1;
  for (size_t row = 0; row < table.rows; ++row) channels = std::max(channels, uint64_t{whole(table, *ring, row)} + 1);
  if (beams % channels != 0) return line;
  const uint64_t columns = beams / channels;
  for (size_t row = 0; row < table.rows; ++row) {
    if (whole(table, beam, row) / columns != whole(table, *ring, row)) return line;
  }
  return {static_cast<uint32_t>(columns), static_cast<uint32_t>(channels)};
}

Grid findGrid(const CloudTable& table, const CloudColumn* beam) {
  if (table.rows > 0xfffffffeu) table.refuse("has more points than a 32-bit index holds");
  if (table.gridColumns > 0) {
    const uint64_t beams = uint64_t{table.gridColumns} * table.gridChannels;
    if (beams < table.rows || (beams > table.rows && beams > maxSparseBeams(table))) {
      table.refuse("its grid of " + std::to_string(table.gridColumns) + " columns x " +
                   std::to_string(table.gridChannels) + " channels does not suit " + std::to_string(table.rows) +
                   " points");
    }
    // Fewer points than beams have their place only with `beam`.
    if (beam || beams == table.rows) return {table.gridColumns, table.gridChannels};
  }
  if (table.height > 1) return {table.width, table.height};
  if (!beam) return {static_cast<uint32_t>(table.rows), 1};
  uint64_t beams = table.rows;
  for (size_t row = 0; row < table.rows; ++row) beams = std::max(beams, uint64_t{whole(table, *beam, row)} + 1);
  if (beams > table.rows && beams > maxSparseBeams(table)) {
    table.refuse("has " + std::to_string(table.rows) + " points of at least " + std::to_string(beams) + " beams");
  }
  return gridFromRings(table, *beam, beams);
}

/// Where each row goes; empty if row = beam.
std::vector<uint32_t> placeRows(const CloudTable& table, const CloudColumn* beam, size_t beamCount) {
  std::vector<uint32_t> beams;
  if (!beam) return beams;
  std::vector<bool> taken(beamCount, false);
  beams.reserve(table.rows);
  for (size_t row = 0; row < table.rows; ++row) {
    const uint32_t b = whole(table, *beam, row);
    if (b >= beamCount) {
      table.refuse("point " + std::to_string(row) + " is of beam " + std::to_string(b) + ", the grid has " +
                   std::to_string(beamCount));
    }
    if (taken[b]) table.refuse("beam " + std::to_string(b) + " is there twice");
    taken[b] = true;
    beams.push_back(b);
  }
  return beams;
}

class Placer {
 public:
  Placer(const CloudTable& table, size_t beamCount, std::vector<uint32_t> beams)
      : table_(table), beamCount_(beamCount), beams_(std::move(beams)) {}

  void floats(const char* name, std::vector<float>& out, size_t stride = 1, size_t offset = 0) const {
    const CloudColumn* column = table_.find(name);
    if (!column) return;
    out.resize(beamCount_ * stride, kNaN);
    for (size_t row = 0; row < table_.rows; ++row) {
      out[beam(row) * stride + offset] = static_cast<float>(table_.value(*column, row));
    }
  }
  void indices(const char* name, std::vector<uint32_t>& out) const {
    const CloudColumn* column = table_.find(name);
    if (!column) return;
    out.resize(beamCount_, kNoTriangle);
    for (size_t row = 0; row < table_.rows; ++row) out[beam(row)] = whole(table_, *column, row);
  }
  void flags(const char* name, std::vector<uint8_t>& out) const {
    const CloudColumn* column = table_.find(name);
    if (!column) return;
    out.resize(beamCount_, 0);
    for (size_t row = 0; row < table_.rows; ++row) out[beam(row)] = table_.value(*column, row) != 0;
  }

 private:
  size_t beam(size_t row) const { return beams_.empty() ? row : beams_[row]; }

  const CloudTable& table_;
  size_t beamCount_;
  std::vector<uint32_t> beams_;
};

CloudTable readTable(CloudFormat format, std::string bytes, const std::string& source) {
  switch (format) {
    case CloudFormat::pcd: return readPcd(std::move(bytes), source);
    case CloudFormat::ply: return readPly(std::move(bytes), source);
    case CloudFormat::npy: return readNpy(std::move(bytes), source);
    case CloudFormat::csv: return readCsv(std::move(bytes), source);
    case CloudFormat::kitti: break;
  }
  throw Error(ErrorCode::invalidArgument,
              source + ": a KITTI cloud does not say which beams its points are of; read .pcd, .ply, .npy or .csv");
}

}  // namespace

CloudTable readCsv(std::string bytes, const std::string& source) {
  CloudTable table;
  table.source = source;
  table.bytes = std::move(bytes);
  size_t position = 0;
  std::string_view line;
  if (!nextLine(table.bytes, position, line)) table.refuse("is empty, a CSV cloud starts with the names of its fields");
  for (std::string_view name : splitWords(line)) table.columns.push_back({std::string(name)});
  position = std::min(position, table.bytes.size());
  for (size_t at = position; nextLine(table.bytes, at, line);) table.rows += !splitWords(line).empty();
  table.parseTextRows(position);
  return table;
}

Scan readCloudBytes(CloudFormat format, std::string bytes, const std::string& source) {
  const CloudTable table = readTable(format, std::move(bytes), source);
  const bool hasPoints = table.find("x") && table.find("y") && table.find("z");
  if (!hasPoints && !table.find("range")) table.refuse("has neither x, y, z nor range: not a cloud");
  const CloudColumn* beam = table.find("beam");
  const Grid grid = findGrid(table, beam);

  Scan scan;
  scan.sensor = table.sensor;
  scan.columns = grid.columns;
  scan.channels = grid.channels;
  const size_t beamCount = size_t{grid.columns} * grid.channels;
  const Placer place(table, beamCount, placeRows(table, beam, beamCount));
  if (hasPoints) {
    place.floats("x", scan.points, 3, 0);
    place.floats("y", scan.points, 3, 1);
    place.floats("z", scan.points, 3, 2);
  }
  place.floats("range", scan.ranges);
  if (scan.ranges.empty()) {
    scan.ranges.reserve(beamCount);
    for (size_t b = 0; b < beamCount; ++b) {
      const float* p = &scan.points[3 * b];
      scan.ranges.push_back(static_cast<float>(std::hypot(double{p[0]}, double{p[1]}, double{p[2]})));
    }
  }
  place.indices("triangle", scan.triangles);
  place.indices("instance", scan.instances);
  place.flags("tie", scan.ties);
  place.floats("tolerance", scan.tolerances);

  scan.counters.beams = beamCount;
  for (float range : scan.ranges) scan.counters.hits += !std::isnan(range);
  scan.counters.misses = beamCount - scan.counters.hits;
  return scan;
}

Scan readCloud(const std::filesystem::path& file) {
  const CloudFormat format = cloudFormat(file);
  // Not a byte is read of a cloud that cannot be placed.
  std::string bytes = format == CloudFormat::kitti ? "" : readWholeFile(file);
  return readCloudBytes(format, std::move(bytes), file.string());
}

}  // namespace gnosphere
