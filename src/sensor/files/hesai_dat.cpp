// SPDX-License-Identifier: Apache-2.0
// Hesai's binary angle corrections of heads that do not spin: AT128 (1.3 and 1.5), ATX (4.1 to 4.3), ET25 (3.1
// and 3.2), FT120 (minor versions 0 to 2). Their x axis points forward, z up, and azimuths are clockwise from y, so
// forward is 90 degrees and our azimuth is 90 less theirs. The head's own angle is turned to beams as the vendor's
// decoder does, roundings included.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "base/sha256.hpp"
#include "base/units.hpp"
#include "sensor/files/source.hpp"

namespace gnosphere {
namespace {

/// Reads little-endian numbers one after the other.
class Bytes {
 public:
  explicit Bytes(const SensorSource& source) : source_(source) {}

  template <typename T>
  T next() {
    if (at_ + sizeof(T) > source_.bytes.size())
      source_.refuse("ends after " + std::to_string(source_.bytes.size()) + " bytes, in the middle of its tables");
    T value;
    std::memcpy(&value, source_.bytes.data() + at_, sizeof(T));
    at_ += sizeof(T);
    return value;
  }
  template <typename T>
  std::vector<double> list(size_t count, double scale) {
    std::vector<double> values;
    for (size_t i = 0; i < count; ++i) values.push_back(scale * next<T>());
    return values;
  }
  /// Refuses a file in which the SHA-256 of everything before does not follow.
  void checkHash() const {
    const std::string_view all = source_.bytes;
    if (all.size() - at_ < 32) source_.refuse("ends before its SHA-256, which follows its tables");
    if (sha256(all.substr(0, at_)) != all.substr(at_, 32))
      source_.refuse("is damaged: its content does not have the SHA-256 that the file states");
  }

 private:
  const SensorSource& source_;
  size_t at_ = 0;
};

// Values that neither kind of file states: the field of view in the vendor's azimuths, and the step.
constexpr double kFirstDeg = 30, kStepDeg = 0.1;
constexpr uint32_t kColumns = 1200;

/// Appends a pattern, whose beams `add(list, channel, column)` appends one by one, but for their rings: the channels.
template <class Add>
void addPattern(SensorSource& source, size_t channels, uint32_t columns, const Add& add) {
  BeamList list;
  list.width = columns;
  list.height = static_cast<uint32_t>(channels);
  for (size_t channel = 0; channel < channels; ++channel)
    for (uint32_t column = 0; column < columns; ++column) {
      add(list, channel, column);
      list.rings.push_back(static_cast<uint16_t>(channel));
    }
  source.file.sensor.patterns.push_back(std::move(list));
}

/// Returns the unit of angles, in degrees, of a file that divides a degree.
double unitOf(const SensorSource& source, size_t channels, uint16_t division) {
  if (channels == 0 || division == 0)
    source.refuse("states " + std::to_string(channels) + " channels and an angle division of " +
                  std::to_string(division));
  return 1.0 / division;
}

/// Returns the correction at an angle of the head, in degrees. The table has a value per 2 degrees, in hundredths of a
/// degree; the result is interpolated between them and rounded to such hundredths.
double correction(const std::vector<double>& table, size_t channel, double headDeg) {
  constexpr size_t kPerChannel = 180;
  const double step = headDeg / 2;
  const auto i = static_cast<size_t>(step);
  const size_t first = channel * kPerChannel + i;
  const double part = step - static_cast<double>(i);
  const auto at = [&](size_t place) { return place < table.size() ? table[place] : 0.0; };
  return std::round((1 - part) * at(first) + part * at(first + 1)) / 100;
}

void readMirrors(SensorSource& source, Bytes& bytes, bool fine) {
  const auto channels = bytes.next<uint8_t>();
  bytes.next<uint8_t>();  // mirrors
  const auto frames = bytes.next<uint8_t>();
  for (int i = 0; i < 8; ++i) bytes.next<uint8_t>();  // configuration of the frames
  const double resolution = bytes.next<uint8_t>();
  if (channels == 0 || frames == 0 || frames > 8)
    source.refuse("states " + std::to_string(channels) + " channels and " + std::to_string(frames) + " frames");
  const double unit = fine ? resolution / 25600 : 0.01;
  const auto starts = fine ? bytes.list<uint32_t>(frames, unit) : bytes.list<uint16_t>(frames, unit);
  const auto ends = fine ? bytes.list<uint32_t>(frames, unit) : bytes.list<uint16_t>(frames, unit);
  const auto azimuths = fine ? bytes.list<int32_t>(channels, unit) : bytes.list<int16_t>(channels, unit);
  const auto elevations = fine ? bytes.list<int32_t>(channels, unit) : bytes.list<int16_t>(channels, unit);
  const size_t corrections = fine ? size_t{180} * channels : 36000;
  const auto azimuthTable = bytes.list<int8_t>(corrections, fine ? resolution : 1);
  const auto elevationTable = bytes.list<int8_t>(corrections, fine ? resolution : 1);

  const double period = 1 / (source.options.scanRate > 0 ? source.options.scanRate : 10);
  const double headSpeed = 120 / period;  // a turn of the head is three scans, one per mirror face
  for (size_t frame = 0; frame < frames; ++frame) {
    if (!(starts[frame] < 360 && ends[frame] < 360)) source.refuse("a frame starts or ends beyond 360 degrees");
    addPattern(source, channels, kColumns, [&](BeamList& list, size_t channel, uint32_t column) {
      const double turned = (kFirstDeg + kStepDeg * column) / 2;  // the mirror doubles the angle
      const double head = std::fmod(starts[frame] + turned, 360);
      const double azimuth = 2 * turned - azimuths[channel] + correction(azimuthTable, channel, head);
      list.directions.push_back(directionOfAngles(
          source, 90 - azimuth, elevations[channel] + correction(elevationTable, channel, head), list.size()));
      list.times.push_back(kStepDeg / 2 * column / headSpeed);
    });
  }
  source.file.sensor.scanPeriod = period;  // of which the beams of a face take about half
  if (source.options.scanRate == 0)
    source.assume("10 scans per second, three to a turn; `gnosphere sensors --rate` sets another number");
}

void readParity(SensorSource& source, Bytes& bytes, int version) {
  bytes.next<uint16_t>();  // reserved
  const auto channels = bytes.next<uint8_t>();
  const double unit = unitOf(source, channels, bytes.next<uint16_t>());
  std::vector<std::vector<double>> azimuths = {bytes.list<int16_t>(channels, unit)};
  if (version > 1) azimuths.push_back(bytes.list<int16_t>(channels, unit));
  const auto elevations = bytes.list<int16_t>(channels, unit);
  constexpr size_t kAdjustments = 70;
  constexpr double kFirstAdjustedDeg = 20;  // then every 2 degrees
  const auto adjustments = version > 2 ? bytes.list<int16_t>(kAdjustments, unit) : std::vector<double>();
  const auto adjustment = [&](double azimuth) {
    const double step = (azimuth - kFirstAdjustedDeg) / 2;
    if (adjustments.empty() || !(step >= 0 && step <= kAdjustments - 1)) return 0.0;
    const auto i = std::min(static_cast<size_t>(step), kAdjustments - 2);
    const double part = step - static_cast<double>(i);
    return (1 - part) * adjustments[i] + part * adjustments[i + 1];
  };
  const FireTimes times = source.options.fireTimes.empty() ? FireTimes() : readFireTimes(source, channels);
  for (const std::vector<double>& kind : times)
    for (size_t channel = 0; channel < kind.size(); ++channel)
      if (std::isnan(kind[channel]))
        source.refuse("channel " + std::to_string(channel + 1) +
                      " does not fire in the file of firing times, but every channel of an ATX fires");
  const double first = startOfScan(source, times);
  for (size_t kind = 0; kind < azimuths.size(); ++kind)
    addPattern(source, channels, kColumns, [&](BeamList& list, size_t channel, uint32_t column) {
      const double azimuth = kFirstDeg + kStepDeg * column + azimuths[kind][channel];
      list.directions.push_back(
          directionOfAngles(source, 90 - azimuth, elevations[channel] + adjustment(azimuth), list.size()));
      if (!times.empty()) list.times.push_back(times[kind % times.size()][channel] - first);
    });
  source.assume("columns that fire at once, as the speed of the mirror is not stated");
}

/// Corrections of a table over the field of view of an ET25, in degrees, bilinear between its nodes and 0 beyond them.
struct Adjustments {
  double across = 1, up = 1;  ///< degrees from node to node
  size_t columns = 0;
  std::vector<double> values;

  double at(double azimuth, double elevation) const {
    const double x = (azimuth + 60) / across, y = (elevation + 12.5) / up;
    if (columns == 0 || !(x >= 0 && y >= 0)) return 0;
    const auto i = static_cast<size_t>(x), j = static_cast<size_t>(y);
    if (i + 1 >= columns || (j + 2) * columns > values.size()) return 0;
    const double u = x - static_cast<double>(i), v = y - static_cast<double>(j);
    const auto row = [&](size_t k) { return (1 - u) * values[k * columns + i] + u * values[k * columns + i + 1]; };
    return (1 - v) * row(j) + v * row(j + 1);
  }
};

/// ET25: lasers that two mirrors lead over 120 x 25 degrees. Packets state the mirrors' angles, files do not.
void readSteered(SensorSource& source, Bytes& bytes, int version) {
  bytes.next<uint16_t>();  // reserved
  const auto channels = bytes.next<uint8_t>();
  bytes.next<uint8_t>();  // mirrors
  const double unit = unitOf(source, channels, bytes.next<uint16_t>());
  const std::vector<double> mirror = bytes.list<int16_t>(3, unit);  // alpha, beta, gamma
  const auto azimuths = bytes.list<int16_t>(channels, unit), elevations = bytes.list<int16_t>(channels, unit);
  Adjustments across, up;
  if (version == 2) {
    const double x = 0.5 * bytes.next<uint8_t>(), y = 0.5 * bytes.next<uint8_t>();
    if (!(x > 0 && y > 0)) source.refuse("states adjustments that are 0 degrees apart");
    const auto count = static_cast<size_t>((120 / x + 1) * (25 / y + 1));
    across = {x, y, static_cast<size_t>(120 / x + 1), bytes.list<int16_t>(count, unit)};
    up = {x, y, across.columns, bytes.list<int16_t>(count, unit)};
  }
  addPattern(source, channels, kColumns, [&](BeamList& list, size_t channel, uint32_t column) {
    // As the vendor's decoder, for a vertical mirror at 0.
    const double turned = kStepDeg * column - 60, phi = azimuths[channel], theta = elevations[channel];
    const double an = kDegree * (mirror[0] + phi), gamma = kDegree * mirror[2];
    const double thetaN = kDegree * theta / std::cos(an);
    const double vertical = std::sin(an) * std::cos(an) * thetaN * thetaN / 2 * 1.016;
    const double eta = kDegree * (phi + mirror[1] + turned / 2) + vertical;
    const double horizontal =
        std::sin(eta) * std::tan(2 * gamma) * std::tan(kDegree * theta) + std::sin(2 * eta) * gamma * gamma;
    double elevation = theta + 2 * mirror[2] * std::cos(eta);
    double azimuth = turned + phi + (horizontal + vertical) / kDegree;  // clockwise from the front
    azimuth += across.at(azimuth, elevation);
    elevation += up.at(azimuth, elevation);
    list.directions.push_back(directionOfAngles(source, -azimuth, elevation, list.size()));
  });
  source.assume("a vertical mirror at 0 and columns that fire at once, as the mirrors' angles are not stated");
}

/// A flash lidar: an azimuth and an elevation per pixel, column by column.
void readFlash(SensorSource& source, Bytes& bytes, int version) {
  bytes.next<uint16_t>();  // reserved
  const uint32_t columns = version < 2 ? bytes.next<uint8_t>() : bytes.next<uint16_t>();
  const uint32_t rows = version < 2 ? bytes.next<uint8_t>() : bytes.next<uint16_t>();
  const double unit = 0.01 * bytes.next<uint8_t>();
  const size_t count = size_t{columns} * rows;
  if (count == 0) source.refuse("states " + std::to_string(columns) + " columns and " + std::to_string(rows) + " rows");
  const auto azimuths = version == 0 ? bytes.list<int16_t>(count, unit) : bytes.list<int32_t>(count, unit);
  const auto elevations = version == 0 ? bytes.list<int16_t>(count, unit) : bytes.list<int32_t>(count, unit);
  addPattern(source, rows, columns, [&](BeamList& list, size_t row, uint32_t column) {
    const size_t place = size_t{column} * rows + row;
    list.directions.push_back(directionOfAngles(source, 90 - azimuths[place], elevations[place], list.size()));
  });
}

}  // namespace

void readHesaiDat(SensorSource& source) {
  Bytes bytes(source);
  if (bytes.next<uint8_t>() != 0xee || bytes.next<uint8_t>() != 0xff)
    source.refuse("does not start with EE FF, as Hesai's angle corrections do");
  const int major = bytes.next<uint8_t>(), minor = bytes.next<uint8_t>();
  const bool flash = minor <= 2 && major != 3 && major != 4;  // the vendor's decoder looks at the minor version alone
  source.refuseOption(!source.options.fireTimes.empty() && major != 4, "--fire-times",
                      "this angle correction; of the binary ones it is for those of an ATX");
  source.takeAskedRate();
  if (flash)
    readFlash(source, bytes, minor);
  else if (major == 1 && (minor == 3 || minor == 5))
    readMirrors(source, bytes, minor == 5);
  else if (major == 3 && (minor == 1 || minor == 2))
    readSteered(source, bytes, minor);
  else if (major == 4 && minor >= 1 && minor <= 3)
    readParity(source, bytes, minor);
  else
    source.refuse("is an angle correction of version " + std::to_string(major) + "." + std::to_string(minor) +
                  ", known are 1.3 and 1.5 (AT128), 3.1 and 3.2 (ET25), 4.1 to 4.3 (ATX) and 0 to 2 behind the dot of "
                  "others (FT120)");
  if (!flash) {
    bytes.checkHash();
    source.assume("1200 columns 0.1 degrees apart over 120 degrees, as the data sheets state");
  }
  assumeRange(source, 200);
}

}  // namespace gnosphere
