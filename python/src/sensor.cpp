// SPDX-License-Identifier: Apache-2.0
// Binds the declarations of gnosphere/sensor.hpp.
#include "arrays.hpp"
#include "base/limits.hpp"
#include "rows.hpp"
#include "whole.hpp"

namespace gnosphere::python {
namespace {

static_assert(sizeof(Vec3) == 3 * sizeof(double), "a list of vectors is an array of doubles");

std::vector<Vec3> vectors(const ArrayLike& argument, const char* name) {
  const auto array = arrayOf<double>(argument, name, 3);
  const auto* first = reinterpret_cast<const Vec3*>(array.values().data());
  return {first, first + array.rows()};
}

/// A read-only view of an array of `owner`, which never changes.
Rows<const double, 3> view(const std::vector<Vec3>& list, nb::handle owner) {
  return rowsView<3>(reinterpret_cast<const double*>(list.data()), list.size(), owner);
}
template <typename T>
Column<const T> view(const std::vector<T>& list, nb::handle owner) {
  return columnView<const T>(list.data(), list.size(), owner);
}

/// Defines a property that reads a list as a read-only view, which keeps the BeamList alive.
template <typename T>
void readView(nb::class_<BeamList>& type, const char* name, std::vector<T> BeamList::*list, const char* doc) {
  type.def_prop_ro(
      name, [list](const BeamList& self) { return view(self.*list, nb::find(self)); }, kOwned, doc);
}

void bindBeams(nb::module_& m) {
  nb::class_<Channel>(m, "Channel", "One laser of a spinning sensor. It is never changed after it is made.")
      .def(
          "__init__",
          [](Channel* self, double elevation, double azimuthOffset, Vec3 origin, double time, double rangeMin,
             double rangeMax) { new (self) Channel{elevation, azimuthOffset, origin, time, rangeMin, rangeMax}; },
          "elevation_deg"_a = 0.0, "azimuth_offset_deg"_a = 0.0, "origin"_a = Vec3(), "time_offset"_a = 0.0,
          "range_min"_a = 0.0, "range_max"_a = 0.0)
      .def_ro("elevation_deg", &Channel::elevationDeg, "Above the horizon, -90..90.")
      .def_ro("azimuth_offset_deg", &Channel::azimuthOffsetDeg, "Added to the column's azimuth.")
      .def_ro("origin", &Channel::origin,
              "Where the laser leaves the head, in metres: x points forward along the beam's azimuth, y left, z up.")
      .def_ro("time_offset", &Channel::timeOffset, "Seconds between the column's time and the firing of this laser.")
      .def_ro("range_min", &Channel::rangeMin, "Metres; if greater than 0, replaces the sensor's.")
      .def_ro("range_max", &Channel::rangeMax, "Metres; if greater than 0, replaces the sensor's.");

  auto beams = nb::class_<BeamList>(m, "BeamList",
                                    "Beams in any directions, in the order in which a scan lists them: the beam in row "
                                    "r and column c of the organised "
                                    "cloud has the index r * width + c. `directions` has one entry per beam; every "
                                    "other array has as many or none. It "
                                    "is never changed after it is made.");
  beams
      .def(
          "__init__",
          [](BeamList* self, const ArrayLike& directions, const std::optional<ArrayLike>& origins,
             const std::optional<ArrayLike>& times, const std::optional<ArrayLike>& rangeMin,
             const std::optional<ArrayLike>& rangeMax, const std::optional<ArrayLike>& rings, const Whole& width,
             const Whole& height) {
            BeamList made;
            made.directions = vectors(directions, "BeamList: directions");
            if (origins) made.origins = vectors(*origins, "BeamList: origins");
            if (times) made.times = arrayOf<double>(*times, "BeamList: times").copy();
            if (rangeMin) made.rangeMin = arrayOf<float>(*rangeMin, "BeamList: range_min").copy();
            if (rangeMax) made.rangeMax = arrayOf<float>(*rangeMax, "BeamList: range_max").copy();
            if (rings) made.rings = arrayOf<uint16_t>(*rings, "BeamList: rings").copy();
            made.width = width.of<uint32_t>("BeamList: width");
            made.height = height.of<uint32_t>("BeamList: height");
            new (self) BeamList(std::move(made));
          },
          "directions"_a, "origins"_a = nb::none(), "times"_a = nb::none(), "range_min"_a = nb::none(),
          "range_max"_a = nb::none(), "rings"_a = nb::none(), "width"_a = 0, "height"_a = 0,
          "directions: shape (beams, 3), float64, unit vectors in the sensor's frame.\n"
          "origins: shape (beams, 3), float64, metres in the sensor's frame; if not given, the frame's origin.\n"
          "times: shape (beams,), float64, seconds after the start of the scan, 0..10, the last one 0 or at "
          "least 1e-9; if not given, 0.\n"
          "range_min, range_max: shape (beams,), float32, metres; if not given, the sensor's.\n"
          "rings: shape (beams,), uint16, values of Field.ring; if not given, 0.\n"
          "width, height: of the organised cloud; if 0, it has one row of all beams.\n"
          "The arrays are copied once. Raises Error(invalid_argument) for arrays of another shape or type.")
      .def_ro("width", &BeamList::width, "Columns of the organised cloud; if 0, it has one row of all beams.")
      .def_ro("height", &BeamList::height, "Rows of the organised cloud.")
      .def("size", &BeamList::size, "Number of beams.");
  readView(beams, "directions", &BeamList::directions,
           "Shape (beams, 3), float64, unit vectors: a read-only view, which keeps the list alive.");
  readView(beams, "origins", &BeamList::origins,
           "Shape (beams, 3) or (0, 3), float64, metres: a read-only view, which keeps the list alive.");
  readView(beams, "times", &BeamList::times,
           "Shape (beams,) or (0,), float64, seconds: a read-only view, which keeps the list alive.");
  readView(beams, "range_min", &BeamList::rangeMin,
           "Shape (beams,) or (0,), float32, metres: a read-only view, which keeps the list alive.");
  readView(beams, "range_max", &BeamList::rangeMax,
           "Shape (beams,) or (0,), float32, metres: a read-only view, which keeps the list alive.");
  readView(beams, "rings", &BeamList::rings,
           "Shape (beams,) or (0,), uint16: a read-only view, which keeps the list alive.");

  nb::enum_<NearHits>(m, "NearHits", "What happens to a surface that is nearer than a beam's least range.")
      .value("see_through", NearHits::seeThrough, "The beam passes through and hits what is behind.")
      .value("hide", NearHits::hide, "The surface blocks the beam, which has no return.");
}

void bindSensorItself(nb::module_& m) {
  auto sensor = nb::class_<Sensor>(
      m, "Sensor",
      "A lidar: a grid of beams, or lists of beams.\n\nIn a grid, the beam in column i of channel j has the elevation "
      "channels[j].elevation_deg and the azimuth azimuth_start_deg + azimuth_span_deg * i / columns + "
      "channels[j].azimuth_offset_deg (degrees, counter-clockwise seen from above, 0 = x axis). Beam index = channel * "
      "columns + column: the organised cloud has one row per channel.\n\nIf `patterns` is not empty, the beams are "
      "those of a list: scan number n (Shot.frame) uses pattern n modulo their number. All patterns have the same "
      "number of beams; columns and channels must be 0 and empty.");
  sensor.def_rw("name", &Sensor::name, "Scans and messages have it.");
  readWriteWhole(sensor, "columns", &Sensor::columns, "Columns of a grid; 0 for lists of beams.");
  sensor.def_rw("range_min", &Sensor::rangeMin, "Metres; a hit counts if range_min <= range <= range_max.")
      .def_rw("range_max", &Sensor::rangeMax, "Metres.")
      .def_rw("range_at_10_percent", &Sensor::rangeAt10Percent,
              "Metres from which on a Lambertian target that reflects 10 % is no longer detected; 0 if not stated.")
      .def_rw(
          "divergence_horizontal", &Sensor::divergenceHorizontal,
          "Full angle of a beam's elliptical footprint in radians (to 1/e^2 if its profile is gaussian); 0 makes it a "
          "line.")
      .def_rw("divergence_vertical", &Sensor::divergenceVertical, "Radians, as divergence_horizontal.");
  readWriteWhole(sensor, "max_returns", &Sensor::maxReturns,
                 "Number of echoes that the sensor reports per beam, 1..15.");
  sensor
      .def_rw(
          "rotation_period", &Sensor::rotationPeriod,
          "Seconds in which a grid sweeps azimuth_span_deg, in a sector less than those of a turn; column i fires at "
          "i / columns of it. If 0, all columns fire at once.")
      .def_rw(
          "scan_period", &Sensor::scanPeriod,
          "Seconds from the start of a scan to that of the next, at least those in which its beams fire; if 0, this "
          "is not stated, and the scans of a grid follow each other every rotation_period.")
      .def_rw("azimuth_start_deg", &Sensor::azimuthStartDeg, "Azimuth of column 0, counter-clockwise from the x axis.")
      .def_rw("azimuth_span_deg", &Sensor::azimuthSpanDeg,
              "Azimuths that the columns cover, at most 360 degrees; negative if the head turns clockwise.");
  readWriteChoice(sensor, "near_hits", &Sensor::nearHits,
                  "What happens to a surface that is nearer than a beam's least range.");
  sensor
      .def_prop_rw(
          "masked_beams", [](const Sensor& self) { return copiedColumn(self.maskedBeams); },
          [](Sensor& self, const ArrayLike& beams) {
            self.maskedBeams = arrayOf<uint32_t>(beams, "Sensor: masked_beams").copy();
          },
          kOwned,
          "Indices of beams that never fire, shape (n,), uint32: a read-only copy; assign a new array to change them.")
      .def("is_grid", &Sensor::isGrid, "Whether the beams are those of channels and columns, and not of lists.")
      .def("beam_count", &Sensor::beamCount, "Number of beams of a scan.")
      .def("width", &Sensor::width, "Columns of the organised cloud.")
      .def("height", &Sensor::height, "Rows of the organised cloud: the channels of a grid.")
      .def(
          "direction",
          [](const Sensor& self, const Whole& given) {
            const auto beam = given.of<size_t>("Sensor: beam");
            if (beam >= self.beamCount())
              refuse("Sensor: there is no beam " + std::to_string(beam) + "; it has " +
                     std::to_string(self.beamCount()));
            return self.direction(beam);
          },
          "beam"_a, "Unit vector of a beam in the sensor's frame, for a list in its first pattern.");
  readWriteTuple(sensor, "channels", &Sensor::channels, "The lasers of a grid: a tuple of copies, assigned whole.");
  readWriteTuple(sensor, "patterns", &Sensor::patterns, "The lists of beams: a tuple of copies, assigned whole.");
  bindKeywords(sensor, "Takes its properties as keywords, in which a choice may be its name.");

  m.def(
      "beams_of",
      [](const Sensor& of, const Whole& frame) {
        limits::kBeams.check(of.beamCount(), "beams_of: the columns and channels make");
        return beamsOf(of, frame.of<uint64_t>("beams_of: frame"));
      },
      "sensor"_a, "frame"_a = 0,
      "Returns the beams that scan number `frame` fires, for any sensor, in its own frame: unit vectors, origins and "
      "ranges in metres, times in seconds after the start of the scan. The arrays origins, times, range_min and "
      "range_max are empty if all beams have the value that an empty array stands for. gnosphere.adapter.rays_of() has "
      "the rays of a shot in the world. Raises Error(invalid_argument) for more beams than a sensor may have.");
  m.def(
      "validate", [](const Sensor& of) { validate(of); }, "sensor"_a,
      "Raises Error(invalid_argument) that names the field if a sensor cannot be scanned with: angles, ranges, times "
      "and origins out of bounds, or lists of unequal lengths.");
}

void bindCatalogue(nb::module_& m) {
  m.def(
      "builtin_sensors", [] { return tupleOf(builtinSensors()); },
      "Returns the five models of Table 2 of the GnoSphere360 paper.");
  auto head = nb::class_<CatalogueHead>(
      m, "CatalogueHead",
      "A real head of the catalogue. An empty text or a 0 means that its source does not state it.");
  head.def_ro("name", &CatalogueHead::name, "Such as 'OS1-64'; builtin_sensor() takes it, or 'OS1-64:2048x10'.")
      .def_ro("product", &CatalogueHead::product, "Vendor and product.")
      .def_ro("source", &CatalogueHead::source, "Documents from which the figures are.")
      .def_ro("remarks", &CatalogueHead::remarks, "What the model simplifies, and what the source does not state.")
      .def_ro("range_at_10_percent", &CatalogueHead::rangeAt10Percent, "Metres, on a surface that reflects 10 %.");
  readTuple(head, "modes", &CatalogueHead::modes, "The first one is the default; none if the head has one mode only.");
  m.def(
      "sensor_catalogue", [] { return tupleOf(sensorCatalogue()); }, "Returns the real heads that are built in.");
  m.def(
      "builtin_sensor", &builtinSensor, "name"_a,
      "Returns the built-in model of that name, of builtin_sensors() or of sensor_catalogue(), the latter with ':MODE' "
      "if wanted; case does not matter. Raises Error(invalid_argument) with the nearest names, or the modes that are "
      "known.");
}

/// Returns the path of a file, empty for no file: Python's Path of an empty text is that of the folder '.'.
std::filesystem::path fileOrNone(std::filesystem::path file) {
  return file == "." ? std::filesystem::path() : file;
}

/// Reads a sensor file, and warns of what it leaves open and of what it states in vain.
Sensor loadTold(const std::filesystem::path& path, std::string head, std::string mode, double scanRate,
                uint32_t columns, uint32_t beamsPerScan, std::filesystem::path fireTimes) {
  const SensorFileOptions options = {std::move(head), std::move(mode), scanRate,
                                     columns,         beamsPerScan,    fileOrNone(std::move(fireTimes))};
  SensorFile file;
  {
    const ReleasedGil released;
    file = readSensorFile(path, options);
  }
  const auto warn = [&](const char* what, const std::vector<std::string>& texts) {
    for (const std::string& text : texts) warnUser(path.string() + what + text);
  };
  warn(": assumed: ", file.assumed);
  warn(": ignored: ", file.ignored);
  return std::move(file.sensor);
}

void bindSensorFiles(nb::module_& m) {
  nb::class_<SensorFileOptions>(m, "SensorFileOptions", "What a sensor file leaves open.")
      .def(
          "__init__",
          [](SensorFileOptions* self, std::string head, std::string mode, double scanRate, uint32_t columns,
             uint32_t beamsPerScan, std::filesystem::path fireTimes) {
            new (self) SensorFileOptions{std::move(head), std::move(mode), scanRate,
                                         columns,         beamsPerScan,    fileOrNone(std::move(fireTimes))};
          },
          "head"_a = "", "mode"_a = "", "scan_rate"_a = 0.0, "columns"_a = 0, "beams_per_scan"_a = 0,
          "fire_times"_a = "")
      .def_rw("head", &SensorFileOptions::head,
              "Name of a built-in sensor. Calibration files state angles only, so they take its ranges, divergence and "
              "returns; of a grid with as many channels also the columns, the rotation, the firing times, and the "
              "origins if they have none; of a list the beams per scan. Other files take the range at 10 % and the "
              "divergence that they do not state.")
      .def_rw(
          "mode", &SensorFileOptions::mode,
          "One of several that a file describes: a lidar mode (Ouster), the name of a sensor (SDF), the id of a "
          "scanner (HELIOS++), with ':RATE' for its pulses a second if wanted, or of a lidar (CARLA), an operational "
          "state (firing times of Hesai). If empty, that of the file, or its first.")
      .def_rw("scan_rate", &SensorFileOptions::scanRate,
              "Scans per second; if 0, what the file or the head states, or else 10. Of a mirror that sweeps lines "
              "(HELIOS++) a scan is one period if this is 0.")
      .def_rw(
          "columns", &SensorFileOptions::columns,
          "Columns of a turn, or pulses in a mirror's period; if 0, what the file or the head states, or else 1800.")
      .def_rw("beams_per_scan", &SensorFileOptions::beamsPerScan,
              "Cuts a list of beams into patterns of that many; if 0, a scan fires all of them.")
      .def_prop_rw(
          "fire_times", [](const SensorFileOptions& self) { return self.fireTimes; },
          [](SensorFileOptions& self, std::filesystem::path file) { self.fireTimes = fileOrNone(std::move(file)); },
          "Hesai's file of firing times that goes with an angle correction file; none if it is '' or Path('.').");
  auto file = nb::class_<SensorFile>(m, "SensorFile", "A sensor file, and how it was understood.");
  file.def_ro("sensor", &SensorFile::sensor, "The sensor that the file describes.")
      .def_ro("family", &SensorFile::family, "Such as 'Ouster metadata'.");
  readTuple(file, "assumed", &SensorFile::assumed, "What the file does not state, and the value that was taken.");
  readTuple(file, "ignored", &SensorFile::ignored, "What the file states, and a Sensor does not hold.");

  m.def(
      "read_sensor_file",
      [](nb::bytes content, const std::string& name, const SensorFileOptions& options) {
        const SensorFileOptions chosen = options;
        const ReleasedGil released;
        return readSensorFile(std::string_view(content.c_str(), content.size()), name, chosen);
      },
      "content"_a, "name"_a, "options"_a = SensorFileOptions(),
      "Reads a sensor file from memory; the ending of `name` says what it is expected to be.");
  m.def(
      "read_sensor_file",
      [](const std::filesystem::path& path, const SensorFileOptions& options) {
        const SensorFileOptions chosen = options;
        const ReleasedGil released;
        return readSensorFile(path, chosen);
      },
      "file"_a, "options"_a = SensorFileOptions(),
      "Reads a sensor file of any family that docs/sensors.md lists. The content decides which family it is. Raises "
      "Error(file) if it cannot be read, and Error(format) if its content is bad or belies the ending of its name.");
  m.def(
      "load_sensor", &loadTold, "file"_a, nb::kw_only(), "head"_a = "", "mode"_a = "", "scan_rate"_a = 0.0,
      "columns"_a = 0, "beams_per_scan"_a = 0, "fire_times"_a = "",
      "Returns the sensor of read_sensor_file() with these SensorFileOptions. A UserWarning tells each value that was "
      "assumed, and each that the file states and a Sensor does not hold.");
  m.def(
      "to_json", [](const Sensor& of) { return toJson(of); }, "sensor"_a,
      "Writes a sensor as JSON that sensor_from_json() reads.");
  m.def("sensor_from_json", &sensorFromJson, "json"_a, "source"_a,
        "Reads a sensor from JSON; `source` names the text in messages. Raises Error(format).");
}

}  // namespace

void bindSensor(nb::module_& m) {
  bindBeams(m);
  bindSensorItself(m);
  bindCatalogue(m);
  bindSensorFiles(m);
}

}  // namespace gnosphere::python
