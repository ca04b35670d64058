// SPDX-License-Identifier: Apache-2.0
// Reads Hesai's files of angle corrections. Spinning heads have a row per channel: its number from 1 on, elevation and
// azimuth in degrees. Hesai's y axis points forward, and azimuths are clockwise from it; we turn y to x, so azimuths
// only change their sign. Flash lidars have a row per pixel, and x points forward.
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "base/sha256.hpp"
#include "base/text.hpp"
#include "sensor/files/source.hpp"

namespace gnosphere {
namespace {

/// Returns whether the first cell of a row is a checksum. Refuses a file whose lines before that row do not have the
/// SHA-256 that it states. The hash is that of lines that end with CR LF, whatever they end with now.
bool isChecksum(const SensorSource& source, const std::vector<std::string_view>& lines, size_t row,
                std::string_view stated) {
  if (stated.size() < 32 || stated.find_first_not_of("0123456789abcdefABCDEF") != stated.npos) return false;
  if (stated.size() != 64) return true;  // of another kind
  std::string text;
  for (size_t i = 0; i < row; ++i) text.append(lines[i]).append("\r\n");
  if (!sameWord(sha256Text(text), stated))
    source.refuse("is damaged: the lines above line " + std::to_string(row + 1) +
                  " do not have the SHA-256 that it states");
  return true;
}

/// Places of the two angles in a row, and its number of cells. The header may name the angles in either order.
struct Places {
  size_t elevation = 1, azimuth = 2, cells = 3;
};

Places placesOf(const std::vector<std::string_view>& header) {
  Places places;
  places.cells = std::max(places.cells, header.size());
  for (size_t i = 0; i < header.size(); ++i) {
    if (containsWord(header[i], "elevation")) places.elevation = i;
    if (containsWord(header[i], "azimuth")) places.azimuth = i;
  }
  return places;
}

/// A flash lidar, FT120: a row per pixel, with its channel and column, whose azimuths are 90 degrees straight ahead.
void readPixels(SensorSource& source, const std::vector<std::string_view>& lines, size_t header) {
  constexpr const char* kFlash = "a flash lidar, whose file has a row per pixel";
  source.refuseOption(source.columnsAsked, "--columns", kFlash);
  source.refuseOption(!source.options.mode.empty(), "--mode", kFlash);
  source.refuseOption(!source.options.fireTimes.empty(), "--fire-times", kFlash);
  struct Pixel {
    size_t row, column;
    double elevation, azimuth;
  };
  std::vector<Pixel> pixels;
  size_t rows = 0, columns = 0;
  for (size_t i = header + 1; i < lines.size(); ++i) {
    const std::vector<std::string_view> cells = cellsOf(lines[i]);
    if (cells[0].empty() || isChecksum(source, lines, i, cells[0])) continue;
    const std::string where = "line " + std::to_string(i + 1);
    if (cells.size() < 4)
      source.refuse(where + " has " + std::to_string(cells.size()) +
                    " cells, expected are channel, column, elevation, azimuth");
    refuseSurplus(source, cells, 4, where);
    const auto place = [&](size_t cell, const char* what) {
      const double id = numberOf(source, cells[cell], where + what);
      if (!(id >= 1 && id <= 4096) || id != std::floor(id))
        source.refuse(where + what + " is " + std::string(cells[cell]) + ", expected is 1 to 4096");
      return static_cast<size_t>(id) - 1;
    };
    pixels.push_back({place(0, ", channel"), place(1, ", column"), numberOf(source, cells[2], where + ", elevation"),
                      numberOf(source, cells[3], where + ", azimuth")});
    rows = std::max(rows, pixels.back().row + 1);
    columns = std::max(columns, pixels.back().column + 1);
  }
  if (pixels.empty()) source.refuse("there is no pixel");
  if (rows * columns != pixels.size())
    source.refuse("lists " + std::to_string(pixels.size()) + " pixels, but has " + std::to_string(rows) +
                  " channels and " + std::to_string(columns) + " columns");
  std::vector<const Pixel*> places(pixels.size());
  for (const Pixel& pixel : pixels) {
    const Pixel*& place = places[pixel.row * columns + pixel.column];
    if (place)
      source.refuse("channel " + std::to_string(pixel.row + 1) + " of column " + std::to_string(pixel.column + 1) +
                    " was there before");
    place = &pixel;
  }
  BeamList list;
  list.width = static_cast<uint32_t>(columns);
  list.height = static_cast<uint32_t>(rows);
  for (const Pixel* pixel : places) {
    list.directions.push_back(directionOfAngles(source, 90 - pixel->azimuth, pixel->elevation, list.size()));
    list.rings.push_back(static_cast<uint16_t>(pixel->row));
  }
  source.file.sensor.patterns.push_back(std::move(list));
  source.takeAskedRate();
  assumeRange(source, 200);
}

/// Fires the channels of a grid at the times of a head, whose columns may take several kinds in turn. The grid becomes
/// a list if they do.
void applyFireTimes(SensorSource& source, const FireTimes& times) {
  Sensor& sensor = source.file.sensor;
  const double speed = sensor.azimuthSpanDeg / sensor.rotationPeriod;
  if (times.size() == 1 && std::none_of(times[0].begin(), times[0].end(), [](double t) { return std::isnan(t); })) {
    for (size_t row = 0; row < sensor.channels.size(); ++row) delay(sensor.channels[row], times[0][row], speed);
    return;
  }
  const double first = startOfScan(source, times);
  BeamList list;
  list.width = sensor.columns;
  list.height = static_cast<uint32_t>(sensor.channels.size());
  for (size_t row = 0; row < sensor.channels.size(); ++row)
    for (uint32_t column = 0; column < sensor.columns; ++column) {
      double time = times[column % times.size()][row];
      if (std::isnan(time)) {
        sensor.maskedBeams.push_back(static_cast<uint32_t>(list.size()));
        time = 0;
      }
      const double columnTime = sensor.rotationPeriod * column / sensor.columns;
      list.directions.push_back(directionOfAngles(
          source, sensor.azimuthStartDeg + sensor.channels[row].azimuthOffsetDeg + speed * (columnTime + time),
          sensor.channels[row].elevationDeg, list.size()));
      list.times.push_back(columnTime + time - first);
      list.rings.push_back(static_cast<uint16_t>(row));
    }
  sensor.columns = 0;
  sensor.channels.clear();
  sensor.patterns.push_back(std::move(list));
}

}  // namespace

void readHesaiCsv(SensorSource& source) {
  Places places;
  std::vector<std::optional<Channel>> channels;
  const std::vector<std::string_view> lines = linesOf(source.bytes);
  for (size_t i = 0; i < lines.size(); ++i) {
    const std::vector<std::string_view> cells = cellsOf(lines[i]);
    if (cells[0].empty() && cells.size() == 1) continue;
    if (isChecksum(source, lines, i, cells[0]) || sameWord(cells[0], "EEFF")) continue;
    const std::string where = "line " + std::to_string(i + 1);
    if (containsWord(lines[i], "elevation")) {
      if (containsWord(lines[i], "column")) return readPixels(source, lines, i);
      places = placesOf(cells);
      continue;
    }
    if (cells.size() <= std::max(places.elevation, places.azimuth))
      source.refuse(where + " has " + std::to_string(cells.size()) +
                    " cells, expected are channel, elevation, azimuth");
    refuseSurplus(source, cells, places.cells, where);
    const double id = numberOf(source, cells[0], where + ", channel");
    if (!(id >= 1 && id <= 65535) || id != std::floor(id))
      source.refuse(where + ": the channel is " + std::string(cells[0]) + ", expected is 1 to 65535");
    const auto row = static_cast<size_t>(id) - 1;
    if (row >= channels.size()) channels.resize(row + 1);
    if (channels[row]) source.refuse(where + ": channel " + std::string(cells[0]) + " was there before");
    const double elevation = numberOf(source, cells[places.elevation], where + ", elevation");
    if (std::abs(elevation) > 90)
      source.refuse(where + ", elevation is '" + std::string(cells[places.elevation]) + "', expected is -90 to 90");
    channels[row] = Channel{elevation, -numberOf(source, cells[places.azimuth], where + ", azimuth")};
  }
  if (channels.empty()) source.refuse("there is no channel");
  for (size_t row = 0; row < channels.size(); ++row) {
    if (!channels[row]) source.refuse("channel " + std::to_string(row + 1) + " is missing");
    source.file.sensor.channels.push_back(*channels[row]);
  }
  setTurn(source, 0);
  assumeRange(source, 200);
  if (source.options.fireTimes.empty()) {
    if (!source.options.mode.empty())
      throw Error(ErrorCode::invalidArgument, source.name +
                                                  ": --mode is an operational state of --fire-times, which is "
                                                  "missing");
    return;
  }
  checkBeamCount(source, source.file.sensor.columns, channels.size());
  applyFireTimes(source, readFireTimes(source, channels.size()));
}

}  // namespace gnosphere
