// SPDX-License-Identifier: Apache-2.0
// Ouster's metadata, flat (firmware up to 2.x) or nested. Column i of W is measured at the encoder's angle 360 - 360
// i/W degrees, counter-clockwise in the lidar's frame. The origin of the beams turns with the encoder, and a beam
// points to the encoder's angle minus its azimuth angle. The sensor's frame, which is ours, is reached by
// lidar_to_sensor_transform.
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <utility>

#include "base/json_text.hpp"
#include "base/units.hpp"
#include "base/vector.hpp"
#include "sensor/files/source.hpp"

namespace gnosphere {
namespace {

using nlohmann::json;

constexpr double kMillimetre = 1e-3;
using Matrix = std::array<double, 16>;  // row by row, millimetres

/// The metadata, whose keys lie in sections or all at the top.
class Metadata {
 public:
  Metadata(const SensorSource& source, const json& root) : source_(source) {
    for (const char* section : {"sensor_info", "beam_intrinsics", "lidar_intrinsics", "lidar_data_format",
                                "data_format", "config_params", "ouster-sdk"})
      if (const auto found = root.find(section); found != root.end() && found->is_object()) parts_.push_back(&*found);
    parts_.push_back(&root);
  }

  const json* find(const std::string& key) const {
    for (const json* part : parts_)
      if (part->contains(key)) return part;
    return nullptr;
  }
  std::vector<double> numbers(const std::string& key) const { return numbersIn(source_, of(key), key); }
  double number(const std::string& key, double otherwise) const {
    const json* part = find(key);
    return part ? numberIn(source_, *part, key) : otherwise;
  }
  std::string text(const std::string& key) const {
    const json* part = find(key);
    return part ? textIn(*part, key) : "";
  }
  Matrix matrix(const std::string& key) const {
    const std::vector<double> values = numbers(key);
    if (values.size() != 16)
      source_.refuse("'" + key + "' has " + std::to_string(values.size()) + " numbers, expected are 16");
    Matrix m;
    std::copy(values.begin(), values.end(), m.begin());
    return m;
  }

 private:
  const json& of(const std::string& key) const {
    const json* part = find(key);
    if (!part) source_.refuse("'" + key + "' is missing");
    return *part;
  }

  const SensorSource& source_;
  std::vector<const json*> parts_;
};

/// Refuses metadata that have some of the sections of nested ones but not all, or a format without its sizes. Sections
/// of which old firmware knows nothing are there, as texts.
bool checkSections(const SensorSource& source, const json& root) {
  std::string missing;
  size_t found = 0;
  for (const char* section : {"sensor_info", "beam_intrinsics", "imu_intrinsics", "lidar_intrinsics",
                              "lidar_data_format", "config_params", "calibration_status"}) {
    found += root.contains(section);
    if (!root.contains(section)) missing.append(missing.empty() ? "'" : "', '").append(section);
  }
  if (found > 0 && !missing.empty()) source.refuse("lacks " + missing + "', which metadata in sections have");
  for (const char* section : {"lidar_data_format", "data_format"})
    if (const auto format = root.find(section); format != root.end() && format->is_object())
      for (const char* key : {"columns_per_frame", "pixels_per_column"})
        if (!format->contains(key)) source.refuse(std::string("'") + key + "' is missing in '" + section + "'");
  return found > 0;
}

/// The columns of a turn and the turns per second that a mode such as "1024x10" names.
struct Mode {
  uint32_t columns = 0;
  double rate = 0;
};
Mode modeOf(const SensorSource& source, const std::string& text) {
  static const std::pair<const char*, Mode> modes[] = {{"512x10", {512, 10}},   {"512x20", {512, 20}},
                                                       {"1024x10", {1024, 10}}, {"1024x20", {1024, 20}},
                                                       {"2048x10", {2048, 10}}, {"4096x5", {4096, 5}}};
  std::string known;
  for (const auto& [name, mode] : modes) {
    if (text == name) return mode;
    known.append(known.empty() ? "" : ", ").append(name);
  }
  source.refuse("the lidar mode is '" + text + "', known are " + known);
}

/// Where the beams start in the lidar's frame while the encoder is at 0.
Vec3 beamOrigin(SensorSource& source, const Metadata& metadata, const std::string& product) {
  if (metadata.find("beam_to_lidar_transform")) {
    const Matrix m = metadata.matrix("beam_to_lidar_transform");
    for (const int i : {0, 1, 2, 4, 5, 6, 8, 9, 10})
      if (m[static_cast<size_t>(i)] != (i % 5 == 0 ? 1 : 0)) {
        source.ignore("the rotation in beam_to_lidar_transform");
        break;
      }
    return {kMillimetre * m[3], kMillimetre * m[7], kMillimetre * m[11]};
  }
  if (metadata.find("lidar_origin_to_beam_origin_mm"))
    return {kMillimetre * metadata.number("lidar_origin_to_beam_origin_mm", 0), 0, 0};
  // As ouster-sdk does for firmware 1.x, which does not state it.
  const double mm = product.starts_with("OS-0-")   ? 27.67
                    : product.starts_with("OS-1-") ? 15.806
                    : product.starts_with("OS-2-") ? 13.762
                                                   : 12.163;
  source.assume("beams that start " + numberText(mm) + " mm off the axis, as ouster-sdk does");
  return {kMillimetre * mm, 0, 0};
}

/// Masks the columns that are not in the window, whose end may be before its start.
void maskColumns(const SensorSource& source, const Metadata& metadata, double statedColumns, Sensor& sensor,
                 std::vector<bool>& masked) {
  if (!metadata.find("column_window")) return;
  const std::vector<double> window = metadata.numbers("column_window");
  if (window.size() != 2 ||
      !(window[0] >= 0 && window[0] < statedColumns && window[1] >= 0 && window[1] < statedColumns))
    source.refuse("'column_window' must be two columns from 0 to " + shownNumber(statedColumns - 1));
  const double scale = statedColumns / sensor.columns;  // if another mode than that of the file is asked for
  for (uint32_t column = 0; column < sensor.columns; ++column) {
    const double stated = std::floor(column * scale);
    const bool begun = stated >= window[0], open = stated <= window[1];
    if (window[0] <= window[1] ? begun && open : begun || open) continue;
    for (size_t ring = 0; ring < sensor.channels.size(); ++ring) masked[ring * sensor.columns + column] = true;
  }
}

/// The number of lasers that a product such as OS-1-16-A0 states, or 0.
size_t lasersOf(const std::string& product) {
  size_t lasers = 0;
  const size_t dash = product.starts_with("OS-") ? product.find('-', 3) : product.npos;
  if (dash != product.npos) std::from_chars(product.data() + dash + 1, product.data() + product.size(), lasers);
  return lasers;
}

/// The pixels of a column. Firmware 1.x does not state them: there are as many as the product has lasers, or else 64.
void checkRows(const SensorSource& source, const Metadata& metadata, bool nested, const std::string& product,
               size_t angles) {
  const bool old = !metadata.find("data_format") && !nested;
  const size_t lasers = lasersOf(product);
  const double rows = metadata.number("pixels_per_column", static_cast<double>(!old ? angles : lasers ? lasers : 64));
  if (rows == static_cast<double>(angles)) return;
  const std::string found = "'beam_altitude_angles' has " + std::to_string(angles) + " entries, ";
  if (old && lasers > 0 && angles > lasers)
    source.refuse(found + "but " + product + " has " + std::to_string(lasers) +
                  " lasers, which ouster-sdk demands, too: leave out the angles of pixels without a laser");
  source.refuse(found + "expected are " + shownNumber(rows) + ", one per pixel of a column");
}

/// The angles of the pixels of a column in degrees: the elevation and the offset in azimuth of each.
struct PixelAngles {
  std::vector<double> altitudes, azimuths;

  bool isZero(size_t row) const { return altitudes[row] == 0 && azimuths[row] == 0; }
};
PixelAngles readAngles(const SensorSource& source, const Metadata& metadata) {
  const PixelAngles angles = {metadata.numbers("beam_altitude_angles"), metadata.numbers("beam_azimuth_angles")};
  const size_t rows = angles.altitudes.size();
  if (rows == 0) source.refuse("'beam_altitude_angles' is empty");
  if (rows > 65535) source.refuse("'beam_altitude_angles' has more than 65535 entries");
  if (rows != angles.azimuths.size())
    source.refuse("'beam_altitude_angles' has " + std::to_string(rows) + " entries, 'beam_azimuth_angles' " +
                  std::to_string(angles.azimuths.size()));
  const auto zero = [](double angle) { return angle == 0; };
  if (rows > 1 && std::all_of(angles.altitudes.begin(), angles.altitudes.end(), zero))
    source.refuse("all 'beam_altitude_angles' are 0, which is no calibration");
  return angles;
}

void placeBeams(SensorSource& source, const Metadata& metadata, const PixelAngles& angles, const Vec3& origin) {
  Sensor& sensor = source.file.sensor;
  Matrix m = {-1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1, 36.18, 0, 0, 0, 1};
  if (metadata.find("lidar_to_sensor_transform"))
    m = metadata.matrix("lidar_to_sensor_transform");
  else
    source.assume("the usual lidar_to_sensor_transform: half a turn, 36.18 mm up");
  // A grid turns about z, on the z axis of the sensor.
  const bool upright = m[2] == 0 && m[6] == 0 && m[8] == 0 && m[9] == 0 && m[10] == 1 && m[3] == 0 && m[7] == 0 &&
                       m[0] == m[5] && m[1] == -m[4] && std::abs(lengthOf(m[0], m[4]) - 1) < 1e-9;
  if (!upright) source.refuse("'lidar_to_sensor_transform' is more than a turn about z and a shift along z");
  // Half a turn is exact.
  const double turnDeg = m[4] == 0 ? (m[0] < 0 ? 180 : 0) : std::atan2(m[4], m[0]) / kDegree;
  sensor.azimuthStartDeg = turnDeg;
  sensor.azimuthSpanDeg = -360;
  for (size_t row = 0; row < angles.altitudes.size(); ++row) {
    Channel channel;
    channel.elevationDeg = angles.altitudes[row];
    channel.azimuthOffsetDeg = -angles.azimuths[row];
    const double azimuth = kDegree * angles.azimuths[row], c = std::cos(azimuth), s = std::sin(azimuth);
    channel.origin = {c * origin.x - s * origin.y, s * origin.x + c * origin.y, origin.z + kMillimetre * m[11]};
    sensor.channels.push_back(channel);
  }
}

/// Sets the columns and the period of the mode that the caller asks for, or else that of the file. Returns the number
/// of columns that the file states.
double readMode(SensorSource& source, const Metadata& metadata) {
  const std::string stated = metadata.text("lidar_mode"), &asked = source.options.mode;
  if (stated.empty() && asked.empty()) source.refuse("'lidar_mode' is missing");
  const Mode mode = modeOf(source, asked.empty() ? stated : asked);
  const double columns =
      metadata.number("columns_per_frame", stated.empty() ? mode.columns : modeOf(source, stated).columns);
  if (!(columns >= 1)) source.refuse("'columns_per_frame' must be 1 or more, is " + shownNumber(columns));
  if (asked.empty() && columns != mode.columns)
    source.refuse("'columns_per_frame' is " + shownNumber(columns) + ", which does not suit the 'lidar_mode' " +
                  stated);
  source.file.sensor.columns = mode.columns;
  source.file.sensor.rotationPeriod = 1 / mode.rate;
  return columns;
}

/// Masks the rows of pixels without a laser. Files of firmware 1.x that name no product may list them, with zeros.
void maskRows(const PixelAngles& angles, uint32_t columns, std::vector<bool>& masked) {
  if (std::count(angles.altitudes.begin(), angles.altitudes.end(), 0.0) < 2) return;
  for (size_t row = 0; row < angles.altitudes.size(); ++row)
    if (angles.isZero(row)) std::fill_n(masked.begin() + static_cast<std::ptrdiff_t>(row * columns), columns, true);
}

/// Returns the head of the catalogue that has the figures of a product such as OS-1-64-U1, or null. The heads of a line
/// differ in their number of lasers only.
const CatalogueHead* headOf(const std::string& product) {
  if (!product.starts_with("OS-") || product.size() < 5) return nullptr;
  const std::string line = std::string("OS") + product[3] + "-", name = line + std::to_string(lasersOf(product));
  const CatalogueHead* head = nullptr;
  for (const CatalogueHead& candidate : sensorCatalogue())
    if (candidate.name == name || (!head && candidate.name.starts_with(line))) head = &candidate;
  return head;
}

/// Takes the figures of the catalogue for a product. Metadata tell neither them nor the generation of the head. A head
/// that the caller names states them itself.
void assumeFigures(SensorSource& source, const std::string& product) {
  const CatalogueHead* const head = headOf(product);
  if (!head || !source.options.head.empty())
    return assumeRange(source, product.starts_with("OS-DOME") ? 45 : 170,
                       product.starts_with("OS-DOME") ? ", as the data sheet of the OSDome has it" : "");
  const Sensor figures = builtinSensor(head->name);
  Sensor& sensor = source.file.sensor;
  sensor.rangeAt10Percent = figures.rangeAt10Percent;
  sensor.divergenceHorizontal = figures.divergenceHorizontal;
  sensor.divergenceVertical = figures.divergenceVertical;
  assumeRange(source, figures.rangeMax,
              ", " + shownNumber(figures.rangeAt10Percent) + " m at 10 % and a divergence of " +
                  shownNumber(std::round(1e5 * figures.divergenceHorizontal) / 100) + " mrad, as the catalogue's " +
                  head->name + " has them");
}

void readRanges(SensorSource& source, const Metadata& metadata, const std::string& product) {
  if (const double centimetres = metadata.number("min_range_threshold_cm", 0); centimetres > 0)
    source.file.sensor.rangeMin = centimetres / 100;
  assumeFigures(source, product);
  source.ignore(
      "that Ouster counts ranges from the lidar's axis: they are larger than ours by the radius of the origins");
}

}  // namespace

void readOuster(SensorSource& source, const json& root) {
  const Metadata metadata(source, root);
  const bool nested = checkSections(source, root);
  const std::string product = metadata.text("prod_line");
  const PixelAngles angles = readAngles(source, metadata);
  checkRows(source, metadata, nested, product, angles.altitudes.size());
  const double statedColumns = readMode(source, metadata);
  placeBeams(source, metadata, angles, beamOrigin(source, metadata, product));

  Sensor& sensor = source.file.sensor;
  std::vector<bool> masked(sensor.beamCount());
  maskRows(angles, sensor.columns, masked);
  maskColumns(source, metadata, statedColumns, sensor, masked);
  for (size_t beam = 0; beam < masked.size(); ++beam)
    if (masked[beam]) sensor.maskedBeams.push_back(static_cast<uint32_t>(beam));

  if (metadata.text("udp_profile_lidar").ends_with("_DUAL")) {
    sensor.maxReturns = 2;
    source.assume(
        "the two nearest echoes of a beam; the effect returns.mode=strongest-second-strongest gives the two strongest, "
        "as Ouster's dual return is");
  }
  readRanges(source, metadata, product);
  for (const char* key :
       {"imu_to_sensor_transform", "pixel_shift_by_row", "signal_multiplier", "return_order", "azimuth_window"})
    if (metadata.find(key)) source.ignore(key);
  const Matrix identity = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  if (const json* part = metadata.find("extrinsic"); part && part->at("extrinsic") != json(identity))
    source.ignore("the extrinsic: give the pose of the sensor's mounting with each scan");
}

}  // namespace gnosphere
