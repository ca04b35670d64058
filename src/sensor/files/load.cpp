// SPDX-License-Identifier: Apache-2.0
// Recognises the family of a sensor file by its content, and calls its reader.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>

#include "base/file.hpp"
#include "base/json_text.hpp"
#include "base/path.hpp"
#include "base/text.hpp"
#include "base/units.hpp"
#include "base/utf8.hpp"
#include "sensor/beams.hpp"
#include "sensor/carla_lidars.hpp"
#include "sensor/files/source.hpp"

namespace gnosphere {
namespace {

using nlohmann::json;

/// Size limit: lists of millions of beams, as JSON.
constexpr size_t kMaxFileBytes = size_t{1} << 30;

constexpr uint32_t kMostColumns = 1'000'000;

/// Options that a reader takes. Of a head that completes a file, families without `head` take the figures that a file
/// of angles and times may lack; see completeFigures().
enum Option : unsigned { head = 1, mode = 2, scanRate = 4, columns = 8, beamsPerScan = 16, fireTimes = 32 };

/// A family of sensor files. JSON is parsed once, for all of its families.
struct Family {
  const char* name;
  const char* endings;  ///< that its files have, each with a space after it
  unsigned options;     ///< of SensorFileOptions, that its reader takes
  bool isJson;
  std::function<bool(std::string_view bytes, const json& root)> recognise;
  std::function<void(SensorSource& source, const json& root)> read;
};

bool has(const json& root, const char* key) {
  return root.is_object() && root.contains(key);
}

std::string_view firstLine(std::string_view bytes) {
  return bytes.substr(0, std::min({bytes.find('\n'), bytes.size(), size_t{1000}}));
}

/// Returns whether the header of a CSV file is that of an angle correction, which has a channel and its angles. The
/// header of a beam table names what such a file lacks: units, rings, times.
bool isAngleTable(std::string_view bytes) {
  const std::string_view line = firstLine(bytes), first = cellsOf(line)[0];
  const auto has = [&](const char* word) { return containsWord(line, word); };
  const bool angles =
      (containsWord(first, "channel") || containsWord(first, "laser")) && has("elevation") && has("azimuth");
  const bool ofBeams = has("_deg") || has("ring") || has("time") || has("origin") || has("range_") || has("pattern");
  return (angles && !ofBeams) || (containsWord(line, "eeff") && containsWord(bytes.substr(0, 2000), "elevation"));
}

bool isRayTable(std::string_view bytes) {
  const std::string_view line = firstLine(bytes);
  return containsWord(line, "azimuth") && (containsWord(line, "zenith") || containsWord(line, "elevation")) &&
         line.find(',') != line.npos && !isAngleTable(bytes);
}

bool isFireTable(std::string_view bytes) {
  const std::string_view line = firstLine(bytes);
  return line.find(',') != line.npos && !isAngleTable(bytes) &&
         (containsWord(line, "fire") || containsWord(line, "operational state") || containsWord(line, "eeff") ||
          containsWord(line, "distance>="));
}

/// Whether the first row is two numbers.
bool isAnglePairs(std::string_view bytes) {
  const std::vector<std::string_view> lines = linesOf(firstLine(bytes));
  const auto cells = cellsOf(lines.empty() ? "" : lines[0]);
  const auto isNumber = [](std::string_view cell) {
    return !cell.empty() && cell.find_first_not_of("+-.0123456789eE") == cell.npos;
  };
  return cells.size() >= 2 && isNumber(cells[0]) && isNumber(cells[1]) &&
         std::all_of(cells.begin() + 2, cells.end(), [](std::string_view cell) { return cell.empty(); });
}

/// Whether the first character that is no space is one of these.
bool beginsWith(std::string_view bytes, std::string_view characters) {
  const size_t start = bytes.find_first_not_of(" \t\r\n");
  return start != bytes.npos && characters.find(bytes[start]) != characters.npos;
}

bool beginsAsJson(std::string_view bytes) {
  return beginsWith(bytes, "{[");
}

bool isXml(std::string_view bytes) {
  return beginsWith(bytes, "<");
}

bool isXmlWith(std::string_view bytes, const char* word) {
  return isXml(bytes) && bytes.find(word) != bytes.npos;
}

bool isVeloView(std::string_view bytes) {
  return isXmlWith(bytes, "<boost_serialization");
}

bool isSdf(std::string_view bytes) {
  return isXmlWith(bytes, "<sensor") && (isXmlWith(bytes, "<lidar") || isXmlWith(bytes, "<ray"));
}

bool isHelios(std::string_view bytes) {
  return isXmlWith(bytes, "<scanner");
}

/// Whether a file consists of poses whose axes are of usual lengths.
bool isRayMatrices(std::string_view bytes) {
  if (bytes.empty() || bytes.size() % 48 != 0) return false;
  for (size_t at = 0; at < std::min<size_t>(bytes.size(), 480); at += 48) {
    float m[12];
    std::memcpy(m, bytes.data() + at, sizeof(m));
    const float square = m[2] * m[2] + m[6] * m[6] + m[10] * m[10];
    if (!(square > 1e-6f && square < 1e6f)) return false;
  }
  return true;
}

[[noreturn]] void refuseFireTimes(SensorSource& source, const json&) {
  source.refuse(
      "is a Hesai file of firing times, which has no angles: read the angle correction file by `gnosphere sensors`, "
      "and name this one with --fire-times");
}

const std::vector<Family>& families() {
  constexpr unsigned kCalibration = head | scanRate | columns, kPattern = head | scanRate | beamsPerScan;
  using Read = void (*)(SensorSource&);
  const auto plain = [](Read read) { return [read](SensorSource& source, const json&) { read(source); }; };
  const auto bytesOnly = [](bool (*test)(std::string_view)) {
    return [test](std::string_view bytes, const json&) { return test(bytes); };
  };
  static const std::vector<Family> list = {
      {"GnoSphere sensor", ".json ", 0, true,
       [](std::string_view, const json& root) {
         return !has(root, "type") &&
                (has(root, "columns") || has(root, "elevation_deg") || has(root, "channels") || has(root, "patterns"));
       },
       [](SensorSource& source, const json&) { source.file.sensor = sensorFromJson(source.bytes, source.name); }},
      {"Ouster metadata", ".json ", mode, true,
       [](std::string_view, const json& root) {
         return has(root, "beam_altitude_angles") || has(root, "beam_intrinsics") || has(root, "lidar_data_format");
       },
       readOuster},
      {"Isaac Sim profile", ".json ", 0, true, [](std::string_view, const json& root) { return has(root, "profile"); },
       readIsaac},
      {"CARLA attributes", ".json ", mode, true, [](std::string_view, const json& root) { return isCarla(root); },
       readCarla},
      {"NumPy array", ".npy ", kPattern, false,
       bytesOnly([](std::string_view bytes) { return bytes.starts_with("\x93NUMPY"); }), plain(readNpy)},
      {"Hesai binary angle correction", ".dat .bin ", scanRate | fireTimes, false,
       bytesOnly([](std::string_view bytes) { return bytes.starts_with("\xee\xff"); }), plain(readHesaiDat)},
      {"VeloView calibration", ".xml ", kCalibration, false, bytesOnly(isVeloView), plain(readVelodyneXml)},
      {"SDF lidar", ".sdf .world .xml .urdf ", mode, false, bytesOnly(isSdf), plain(readSdf)},
      {"HELIOS++ scanner", ".xml ", mode | scanRate | columns, false, bytesOnly(isHelios), plain(readHelios)},
      {"Isaac Sim USD", ".usda .usd .usdc ", 0, false,
       bytesOnly([](std::string_view bytes) { return bytes.starts_with("#usda") || bytes.starts_with("PXR-USDC"); }),
       plain(readIsaacUsd)},
      {"Hesai angle correction", ".csv ", kCalibration | fireTimes | mode, false, bytesOnly(isAngleTable),
       plain(readHesaiCsv)},
      {"Hesai firing times", ".csv ", 0, false, bytesOnly(isFireTable), refuseFireTimes},
      {"RoboSense angles", ".csv ", kCalibration, false, bytesOnly(isAnglePairs), plain(readRobosenseCsv)},
      {"beam table", ".csv ", kPattern, false, bytesOnly(isRayTable), plain(readBeamCsv)},
      {"Velodyne calibration", ".yaml .yml ", kCalibration, false,
       bytesOnly([](std::string_view bytes) { return bytes.find("lasers:") != bytes.npos; }), plain(readVelodyneYaml)},
      {"ray matrices", ".mat3x4f ", kPattern, false, bytesOnly(isRayMatrices), plain(readRayMatrices)},
  };
  return list;
}

std::string endingOf(const std::string& name) {
  return lower(pathOf(name).extension().string());
}

bool mayEndWith(const Family& family, const std::string& ending) {
  return !ending.empty() && std::string(family.endings).find(ending + " ") != std::string::npos;
}

/// Decides which family a file belongs to. Refuses one whose name says otherwise. `jsonProblem` tells why
/// text that begins or is named as JSON is none.
const Family& familyOf(const SensorSource& source, const json& root, const std::string& jsonProblem) {
  const std::string ending = endingOf(source.name);
  const Family* named = nullptr;
  std::string all;
  for (const Family& family : families()) {
    if (!named && mayEndWith(family, ending)) named = &family;
    all.append(all.empty() ? "" : ", ").append(family.name);
  }
  // JSON with a mistake could pass for a table. A name of another family counts, because YAML may begin so, too.
  const bool namedOther = named && !named->isJson;
  if (root.is_discarded() && beginsAsJson(source.bytes) && !namedOther) source.refuse("is not JSON: " + jsonProblem);
  if (lacksCarlaType(root)) source.refuse(kLacksCarlaType);
  for (const Family& family : families()) {
    if (family.isJson == root.is_discarded() || !family.recognise(source.bytes, root)) continue;
    if (named && !mayEndWith(family, ending))
      source.refuse(std::string("looks like a file of the family '") + family.name + "', whose names end with " +
                    std::string(family.endings, std::strlen(family.endings) - 1) + ", not with " + ending);
    return family;
  }
  if (source.bytes.empty()) source.refuse("is empty");
  if (isXml(source.bytes)) {
    SensorSource xml = source;
    refuseXml(xml);
  }
  if (named && named->isJson && root.is_discarded()) source.refuse("is not JSON: " + jsonProblem);
  if (namedOther && root.is_discarded()) return *named;  // its reader says what is missing
  if (!root.is_discarded())
    source.refuse(
        "is JSON, but of no known family: it has neither 'elevation_deg', 'channels' or 'patterns' (ours), "
        "nor 'beam_altitude_angles' (Ouster), 'profile' (Isaac Sim) or the 'type' of a CARLA sensor");
  source.refuse("is of no known family; known are " + all);
}

void checkOptions(const SensorSource& source, const Family& family) {
  const SensorFileOptions& options = source.options;
  const std::pair<unsigned, const char*> given[] = {{options.mode.empty() ? 0u : mode, "--mode"},
                                                    {options.scanRate == 0 ? 0u : scanRate, "--rate"},
                                                    {options.columns == 0 ? 0u : columns, "--columns"},
                                                    {options.beamsPerScan == 0 ? 0u : beamsPerScan, "--beams-per-scan"},
                                                    {options.fireTimes.empty() ? 0u : fireTimes, "--fire-times"}};
  for (const auto& [bit, name] : given)
    if (bit != 0 && (family.options & bit) == 0)
      throw Error(ErrorCode::invalidArgument,
                  source.name + ": " + name + " does not apply to a file of the family '" + family.name + "'");
  if (options.scanRate != 0 && !(options.scanRate >= 0.0001 && options.scanRate <= 1e6))
    throw Error(ErrorCode::invalidArgument, "the scan rate must be 0.0001 to 1,000,000 Hz");
  if (options.columns > kMostColumns)
    throw Error(ErrorCode::invalidArgument, source.name + ": a turn of " + std::to_string(options.columns) +
                                                " columns is more than a million, the most that are read");
}

/// Masks the lasers of a grid that rest in every second column of a built-in head.
void maskRestingLasers(Sensor& sensor, const Sensor& from) {
  const std::vector<bool> rests = silentBeams(from);
  for (size_t row = 0; row < sensor.channels.size(); ++row)
    for (uint32_t column = 0; column < sensor.columns; ++column)
      if (rests[row * from.columns + column % 2])
        sensor.maskedBeams.push_back(static_cast<uint32_t>(row * sensor.columns + column));
}

/// The azimuth offset of a channel without the angle by which the head turns on until the laser fires, in degrees.
double correctionDeg(const Sensor& sensor, size_t row) {
  const Channel& channel = sensor.channels[row];
  const double speed = sensor.rotationPeriod > 0 ? sensor.azimuthSpanDeg / sensor.rotationPeriod : 0;
  return channel.azimuthOffsetDeg - speed * channel.timeOffset;
}

/// Starts the beams of a file that states no origins where those of a head start. A lens is fixed to the head, so it
/// does not turn with the azimuth correction of its laser.
void takeOrigins(Sensor& sensor, const Sensor& from) {
  if (hasOrigins(sensor)) return;
  for (size_t row = 0; row < sensor.channels.size(); ++row) {
    const double turn = kDegree * (correctionDeg(from, row) - correctionDeg(sensor, row));
    const double c = std::cos(turn), s = std::sin(turn);
    const Vec3& origin = from.channels[row].origin;
    sensor.channels[row].origin = {c * origin.x - s * origin.y, s * origin.x + c * origin.y, origin.z};
  }
}

/// Drops the note of a largest range that was assumed. Returns whether there was one.
bool dropAssumedRange(SensorFile& file) {
  return std::erase_if(file.assumed, [](const std::string& text) { return text.starts_with("a largest range"); }) > 0;
}

/// Takes from a built-in head the range at 10 % and the divergence, as far as a file does not state them, and the
/// largest range instead of one that is assumed.
void completeFigures(SensorSource& source, const Sensor& from) {
  Sensor& sensor = source.file.sensor;
  if (sensor.rangeAt10Percent == 0) sensor.rangeAt10Percent = from.rangeAt10Percent;
  if (sensor.divergenceHorizontal == 0 && sensor.divergenceVertical == 0) {
    sensor.divergenceHorizontal = from.divergenceHorizontal;
    sensor.divergenceVertical = from.divergenceVertical;
  }
  if (dropAssumedRange(source.file)) sensor.rangeMax = from.rangeMax;
}

/// Makes a list that states no rate start its scans as often as a head, if its beams have fired by then.
void takeScanPeriod(Sensor& sensor, const Sensor& from) {
  if (const double period = scanPeriodOf(from); lastTimeOf(sensor) <= period) sensor.scanPeriod = period;
}

/// Applies the values of a built-in head that a calibration or a pattern does not state.
void applyHead(SensorSource& source, const Sensor& from, bool sameTurn) {
  Sensor& sensor = source.file.sensor;
  if (sensor.isGrid() && from.isGrid()) {
    if (from.channels.size() != sensor.channels.size())
      source.refuse("has " + std::to_string(sensor.channels.size()) + " channels, the head '" + from.name + "' has " +
                    std::to_string(from.channels.size()));
    takeOrigins(sensor, from);
    if (sameTurn) {
      sensor.azimuthStartDeg = from.azimuthStartDeg;
      sensor.azimuthSpanDeg = from.azimuthSpanDeg;
      sensor.rotationPeriod = from.rotationPeriod;
      sensor.scanPeriod = from.scanPeriod;
    }
    const bool statesTimes = !source.options.fireTimes.empty() || hasTimeOffsets(sensor);
    if (!statesTimes && sensor.rotationPeriod > 0) {
      for (size_t row = 0; row < sensor.channels.size(); ++row)
        delay(sensor.channels[row], from.channels[row].timeOffset, sensor.azimuthSpanDeg / sensor.rotationPeriod);
      if (sensor.maskedBeams.empty() && !from.maskedBeams.empty()) maskRestingLasers(sensor, from);
    }
  }
  if (!sensor.isGrid() && !source.rateAsked) takeScanPeriod(sensor, from);
  sensor.rangeMin = from.rangeMin;
  sensor.rangeMax = from.rangeMax;
  sensor.rangeAt10Percent = from.rangeAt10Percent;
  sensor.divergenceHorizontal = from.divergenceHorizontal;
  sensor.divergenceVertical = from.divergenceVertical;
  sensor.maxReturns = from.maxReturns;
  sensor.nearHits = from.nearHits;
  dropAssumedRange(source.file);
}

/// Says how far a dark target is seen if no range at 10 % is known. Our own files state what they mean.
void noteUnknownReach(SensorSource& source, bool isOurs) {
  const Sensor& sensor = source.file.sensor;
  if (isOurs || sensor.rangeAt10Percent > 0) return;
  source.assume("that a target of 10 % is seen up to the largest range, because its range at 10 % is not stated");
}

}  // namespace

SensorFile readSensorFile(std::string_view bytes, const std::string& name, const SensorFileOptions& options) {
  SensorFile file;
  SensorFileOptions settings = options;
  Sensor from;
  if (!options.head.empty()) from = builtinSensor(options.head);
  // Matrices are the only binary files that may begin with any bytes.
  SensorSource source{isRayMatrices(bytes) ? bytes : textOfFile(bytes, name), name, settings, file};
  json root = json::value_t::discarded;
  std::string problem;
  if (beginsAsJson(source.bytes) || (!source.bytes.empty() && endingOf(name) == ".json")) try {
      root = parseJson(source.bytes);
    } catch (const json::exception& error) {
      problem = readable(error);
    }
  const Family& family = familyOf(source, root, problem);
  file.family = family.name;
  SensorSource asked{source.bytes, name, options, file};
  checkOptions(asked, family);
  const bool completes = !options.head.empty() && (family.options & head);
  if (completes && settings.columns == 0) settings.columns = from.columns;
  if (completes && settings.beamsPerScan == 0 && !from.isGrid())
    settings.beamsPerScan = static_cast<uint32_t>(from.beamCount());
  // The columns of a head need not fill a whole turn, but its scan takes all the time of a list of beams.
  const bool turns = (family.options & beamsPerScan) == 0;
  const double period = from.rotationPeriod > 0 ? from.rotationPeriod : from.scanPeriod;
  if (completes && settings.scanRate == 0 && period > 0)
    settings.scanRate = (turns && from.isGrid() ? std::abs(from.azimuthSpanDeg) / 360 : 1) / period;
  source.rateAsked = options.scanRate > 0;
  source.columnsAsked = options.columns > 0;
  family.read(source, root);
  checkBeamCount(source, file.sensor.columns, file.sensor.channels.size());
  if (completes)
    applyHead(source, from, options.columns == 0 && options.scanRate == 0);
  else if (!options.head.empty())
    completeFigures(source, from);
  noteUnknownReach(source, &family == &families().front());
  if (file.sensor.name.empty()) file.sensor.name = pathOf(name).stem().string();
  try {
    validate(file.sensor);
  } catch (const Error& invalid) {
    source.refuse(invalid.what());
  }
  return file;
}

SensorFile readSensorFile(const std::filesystem::path& file, const SensorFileOptions& options) {
  return readSensorFile(readWholeFile(file, kMaxFileBytes), file.string(), options);
}

}  // namespace gnosphere
