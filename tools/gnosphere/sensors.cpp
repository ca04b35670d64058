// SPDX-License-Identifier: Apache-2.0
// gnosphere sensors: the catalogue, and how a sensor file was understood.
#include <algorithm>
#include <cmath>
#include <memory>

#include "base/file.hpp"
#include "base/number.hpp"
#include "base/path.hpp"
#include "base/units.hpp"
#include "commands.hpp"
#include "console.hpp"
#include "output/pattern_picture.hpp"
#include "output/picture_file.hpp"
#include "scanning.hpp"
#include "sensor/beams.hpp"

namespace gnosphere::cli {
namespace {

struct SensorsOptions {
  std::string name;
  SensorFileOptions file;
  bool json = false;
  std::string fireTimes, beams, image;

  bool completesFile() const {
    return !file.head.empty() || !file.mode.empty() || file.scanRate != 0 || file.columns != 0 ||
           file.beamsPerScan != 0 || !file.fireTimes.empty();
  }
};

constexpr double kMicroseconds = 1e6;

/// The least and the largest of some values.
struct Span {
  double low = 0, high = 0;
  bool empty = true;

  void add(double value) {
    low = empty ? value : std::min(low, value);
    high = empty ? value : std::max(high, value);
    empty = false;
  }
  std::string text(const char* unit) const {
    // Adding 0 turns -0 to 0.
    const std::string first = formatted("%.6g", low + 0.0), last = formatted("%.6g", high + 0.0);
    return (low == high ? first : first + " to " + last) + unit;
  }
};

/// Extremes of the beams of a sensor, over all its patterns.
struct Survey {
  Span azimuth, elevation, time, least, most, x, y, z, ring;
  size_t fired = 0;
};

/// Calls visit(pattern, beam) for every beam that fires.
template <typename Visit>
void eachBeam(const Sensor& sensor, Visit visit) {
  const std::vector<bool> silent = silentBeams(sensor);
  for (uint64_t pattern = 0; pattern < std::max<size_t>(sensor.patterns.size(), 1); ++pattern)
    for (size_t beam = 0; beam < silent.size(); ++beam)
      if (!silent[beam]) visit(pattern, beam);
}

Survey survey(const Sensor& sensor) {
  Survey all;
  eachBeam(sensor, [&](uint64_t pattern, size_t beam) {
    all.azimuth.add(kRadian * azimuthOf(sensor, beam, pattern));
    all.elevation.add(kRadian * elevationOf(sensor, beam, pattern));
    all.time.add(kMicroseconds * timeOf(sensor, beam, pattern));
    const RangeWindow window = rangeWindowOf(sensor, beam, pattern);
    all.least.add(window.least);
    all.most.add(window.most);
    const Vec3 origin = originOf(sensor, beam, pattern);
    all.x.add(origin.x);
    all.y.add(origin.y);
    all.z.add(origin.z);
    all.ring.add(ringOf(sensor, beam, pattern));
    all.fired += pattern == 0;
  });
  return all;
}

std::string turnText(const Sensor& sensor) {
  std::string text =
      formatted("%u columns over %g degrees, %s, from %g degrees on", sensor.columns, std::abs(sensor.azimuthSpanDeg),
                sensor.azimuthSpanDeg < 0 ? "clockwise" : "counter-clockwise", sensor.azimuthStartDeg);
  if (sensor.rotationPeriod > 0) text += formatted(", in %.6g ms", 1000 * sensor.rotationPeriod);
  return text;
}

void describe(const SensorFile& file) {
  const Sensor& sensor = file.sensor;
  const Survey all = survey(sensor);
  say("name", sensor.name);
  if (!file.family.empty()) say("family", file.family);
  std::string beams =
      grouped(all.fired) + " in a cloud of " + grouped(sensor.width()) + " x " + grouped(sensor.height());
  if (sensor.patterns.size() > 1) beams += formatted(", %zu patterns in turn", sensor.patterns.size());
  say("beams", beams + maskedText(maskedBeams(sensor)));
  if (sensor.isGrid()) say("turn", turnText(sensor));
  if (sensor.scanPeriod > 0) say("scans", formatted("one every %.6g ms", 1000 * sensor.scanPeriod));
  say("rings", all.ring.text(""));
  say("azimuth", all.azimuth.text(" degrees"));
  say("elevation", all.elevation.text(" degrees"));
  say("origins", "x " + all.x.text(" m") + ", y " + all.y.text(" m") + ", z " + all.z.text(" m"));
  say("times", all.time.text(" us"));
  say("range", "from " + all.least.text(" m") + ", up to " + all.most.text(" m"));
  say("at 10 %", sensor.rangeAt10Percent > 0 ? formatted("%g m", sensor.rangeAt10Percent) : "not stated");
  if (sensor.divergenceHorizontal > 0 || sensor.divergenceVertical > 0)
    say("divergence",
        formatted("%.4g x %.4g mrad", 1000 * sensor.divergenceHorizontal, 1000 * sensor.divergenceVertical));
  else
    say("divergence", "not stated");
  say("returns", sensor.maxReturns == 1
                     ? "1"
                     : formatted("up to %u a beam; a cloud of several has a row per return, and none "
                                 "for beams without any",
                                 sensor.maxReturns));
  if (sensor.nearHits == NearHits::hide) say("near hits", "hide what is behind");
  for (const std::string& text : file.assumed) say("assumed", text);
  for (const std::string& text : file.ignored) say("ignored", text);
}

void describe(const CatalogueHead& head) {
  say("product", head.product);
  std::string modes;
  for (const std::string& mode : head.modes) modes += (modes.empty() ? "" : ", ") + mode;
  say("modes", modes + (head.modes.size() > 1 ? " (the first is the default)" : ""));
  say("source", head.source);
  if (!head.remarks.empty()) say("remarks", head.remarks);
}

/// Writes every beam that fires as a row.
void writeBeams(const Sensor& sensor, const std::filesystem::path& path) {
  AtomicFile file(path);
  const bool several = sensor.patterns.size() > 1;
  std::string text = "index,ring,azimuth_deg,elevation_deg,origin_x,origin_y,origin_z,time_us,range_min,range_max";
  text += several ? ",pattern\n" : "\n";
  eachBeam(sensor, [&](uint64_t pattern, size_t beam) {
    const Vec3 origin = originOf(sensor, beam, pattern);
    const RangeWindow window = rangeWindowOf(sensor, beam, pattern);
    text +=
        formatted("%zu,%u,%.9f,%.9f,%.9f,%.9f,%.9f,%.6f,%.9g,%.9g", beam, ringOf(sensor, beam, pattern),
                  kRadian * azimuthOf(sensor, beam, pattern), kRadian * elevationOf(sensor, beam, pattern), origin.x,
                  origin.y, origin.z, kMicroseconds * timeOf(sensor, beam, pattern), window.least, window.most);
    if (several) text += "," + std::to_string(pattern);
    text += '\n';
    if (text.size() < (size_t{1} << 20)) return;
    file.write(text);
    text.clear();
  });
  file.write(text);
  file.commit();
}

void listCatalogue() {
  const auto row = [](const Sensor& sensor, const std::string& name, const std::string& about) {
    Span elevation;
    for (size_t beam = 0; beam < sensor.beamCount(); beam += sensor.isGrid() ? sensor.columns : 1)
      elevation.add(kRadian * elevationOf(sensor, beam));
    const uint64_t masked = maskedBeams(sensor);
    return TableRow{name,
                    about,
                    formatted("%u x %u", sensor.width(), sensor.height()),
                    grouped(sensor.beamCount()),
                    masked > 0 ? grouped(masked) : "",
                    formatted("%+.4g..%+.4g deg", elevation.low, elevation.high),
                    formatted("%g..%g m", sensor.rangeMin, sensor.rangeMax)};
  };
  std::vector<TableRow> rows = {{"name", "", "cloud", "beams", "masked", "elevation", "range"}};
  for (const Sensor& sensor : builtinSensors()) rows.push_back(row(sensor, sensor.name, "of the GnoSphere360 paper"));
  for (const CatalogueHead& head : sensorCatalogue())
    rows.push_back(row(builtinSensor(head.name), head.name, head.product));
  printTable(rows, 2);
  std::printf("\n`gnosphere sensors NAME` states the modes and sources of one; `--sensor NAME:MODE` chooses a mode.\n");
}

int runSensors(const SensorsOptions& options) {
  if (options.name.empty()) {
    if (!options.beams.empty() || !options.image.empty() || options.json)
      throw Error(ErrorCode::invalidArgument, "name a sensor or a file; --json, --beams and --image tell of one");
    listCatalogue();
    return 0;
  }
  if (!options.image.empty()) checkPictureFile(pathOf(options.image));
  checkOutputFiles({options.beams, options.image}, {options.name, options.fireTimes});
  const BuiltInHead head = builtInHead(options.name);
  SensorFile file;
  std::error_code missing;
  if (!head.real && !head.ideal && std::filesystem::exists(pathOf(options.name), missing))
    file = readSensorFile(pathOf(options.name), options.file);
  else
    file.sensor = sensorOf(options.name);
  if (file.family.empty() && options.completesFile())
    throw Error(ErrorCode::invalidArgument,
                "--head, --mode, --rate, --columns, --beams-per-scan and --fire-times complete a sensor file, and '" +
                    options.name + "' is built in; NAME:MODE chooses a mode");
  if (!options.beams.empty()) writeBeams(file.sensor, pathOf(options.beams));
  if (!options.image.empty()) writePatternPicture(file.sensor, pathOf(options.image));
  if (options.json) {
    for (const std::string& text : file.assumed) complain("assumed: " + text);
    for (const std::string& text : file.ignored) complain("ignored: " + text);
    std::printf("%s", toJson(file.sensor).c_str());
    return 0;
  }
  describe(file);
  if (head.real) describe(*head.real);
  if (head.ideal) say("source", "Table 2 of the GnoSphere360 paper");
  return 0;
}

/// Returns why the text is no positive number, or nothing.
std::string positive(const std::string& text) {
  double value = 0;
  return parseNumber(text, value) && value > 0 ? "" : "'" + text + "' is not a positive number";
}

}  // namespace

Action addSensors(CLI::App& app) {
  const auto options = std::make_shared<SensorsOptions>();
  app.add_option("SENSOR", options->name, "A built-in sensor, with :MODE if wanted, or a sensor file");
  app.add_flag("--json", options->json, "Print the sensor as JSON that `gnosphere scan --sensor FILE` reads");
  app.add_option("--beams", options->beams, "Write every beam that fires as a row of this CSV file");
  app.add_option("--image", options->image, "Draw the beams of the first scan to this PNG file");
  app.add_option("--head", options->file.head, "The built-in sensor that states what the file does not");
  app.add_option("--mode", options->file.mode,
                 "A lidar mode (Ouster), the name of a sensor (SDF), the id of a scanner (HELIOS++, with :RATE for "
                 "its pulses a second if wanted) or lidar (CARLA), an operational state (firing times of Hesai)");
  app.add_option("--rate", options->file.scanRate, "Scans per second, if the file does not state them")
      ->check(CLI::Validator(positive, ""));
  app.add_option("--columns", options->file.columns, "Columns of a turn, if the file does not state them")
      ->check(CLI::Range(uint32_t{1}, uint32_t{0xffffffff}));
  app.add_option("--beams-per-scan", options->file.beamsPerScan, "Cut a list of beams into scans of that many")
      ->check(CLI::Range(uint32_t{1}, uint32_t{0xffffffff}));
  app.add_option("--fire-times", options->fireTimes, "Hesai's file of firing times for an angle correction");
  app.footer(
      "Without a sensor, the catalogue is listed.\n"
      "Example: gnosphere sensors HDL-64E --json > sensor.json");
  return [options] {
    options->file.fireTimes = pathOf(options->fireTimes);
    return runSensors(*options);
  };
}

}  // namespace gnosphere::cli
