// SPDX-License-Identifier: Apache-2.0
// gno_sensor: sensors of the catalogue, from files, grids and lists of beams.
#include "c/handles.hpp"

using namespace gnosphere;
using namespace gnosphere::c;

namespace {

GNO_SAME_ENUM(NearHits, {GNO_NEAR_SEE_THROUGH, seeThrough}, {GNO_NEAR_HIDE, hide});

/// The settings of a sensor, with pointers into it.
gno_sensor_settings settingsOf(const Sensor& sensor) {
  gno_sensor_settings settings = gno_sensor_settings_init();
  settings.name = sensor.name.c_str();
  settings.range_min = sensor.rangeMin;
  settings.range_max = sensor.rangeMax;
  settings.divergence_horizontal = sensor.divergenceHorizontal;
  settings.divergence_vertical = sensor.divergenceVertical;
  settings.max_returns = sensor.maxReturns;
  settings.rotation_period = sensor.rotationPeriod;
  settings.near_hits = static_cast<gno_near_hits>(sensor.nearHits);
  settings.masked_beams = orNull(sensor.maskedBeams);
  settings.masked_beam_count = sensor.maskedBeams.size();
  settings.range_at_10_percent = sensor.rangeAt10Percent;
  settings.scan_period = sensor.scanPeriod;
  return settings;
}

/// Members that a caller of an older version does not know are those of `defaults`.
void apply(const gno_sensor_settings* settings, const gno_sensor_settings& defaults, Sensor& sensor) {
  const gno_sensor_settings& from = sized(settings, defaults, "gno_sensor_settings");
  const auto masked = array(from.masked_beams, from.masked_beam_count, "gno_sensor_settings::masked_beams");
  sensor.name = orEmpty(from.name);
  sensor.rangeMin = from.range_min;
  sensor.rangeMax = from.range_max;
  sensor.divergenceHorizontal = from.divergence_horizontal;
  sensor.divergenceVertical = from.divergence_vertical;
  sensor.maxReturns = from.max_returns;
  sensor.rotationPeriod = from.rotation_period;
  sensor.nearHits = enumOf(from.near_hits, NearHits::hide, "gno_sensor_settings::near_hits");
  sensor.maskedBeams.assign(masked.begin(), masked.end());
  sensor.rangeAt10Percent = from.range_at_10_percent;
  sensor.scanPeriod = from.scan_period;
}

gno_sensor checked(Sensor sensor) {
  validate(sensor);
  return make<gno_sensor>({std::move(sensor), {}, {}, {}, {}});
}

SensorFileOptions optionsOf(const gno_sensor_file_options* options) {
  SensorFileOptions result;
  if (!options) return result;
  const gno_sensor_file_options& from = sized(options, GNO_TYPE(gno_sensor_file_options));
  result.head = orEmpty(from.head);
  result.mode = orEmpty(from.mode);
  result.scanRate = from.scan_rate;
  result.columns = from.columns;
  result.beamsPerScan = from.beams_per_scan;
  result.fireTimes = orEmpty(from.fire_times);
  return result;
}

// The sensor with a report of how its file was understood.
gno_sensor reported(SensorFile read) {
  std::string report = read.family + '\n';
  for (const std::string& text : read.assumed) report += "assumed: " + text + '\n';
  for (const std::string& text : read.ignored) report += "ignored: " + text + '\n';
  return make<gno_sensor>({std::move(read.sensor), std::move(report), {}, {}, {}});
}

std::vector<Vec3> vectors(const double* values, size_t count) {
  std::vector<Vec3> result(values ? count : 0);
  for (size_t i = 0; i < result.size(); ++i) result[i] = vec3(values + 3 * i);
  return result;
}

template <class T>
std::vector<T> values(const T* from, size_t count) {
  return from ? std::vector<T>(from, from + count) : std::vector<T>();
}

BeamList listOf(const gno_beam_list& from) {
  the(from.directions, "gno_beam_list::directions");
  BeamList list;
  list.directions = vectors(from.directions, from.beam_count);
  list.origins = vectors(from.origins, from.beam_count);
  list.times = values(from.times, from.beam_count);
  list.rangeMin = values(from.range_min, from.beam_count);
  list.rangeMax = values(from.range_max, from.beam_count);
  list.rings = values(from.rings, from.beam_count);
  list.width = from.width;
  list.height = from.height;
  return list;
}

std::vector<double> flat(const std::vector<Vec3>& vectors) {
  std::vector<double> result(3 * vectors.size());
  for (size_t i = 0; i < vectors.size(); ++i) set(&result[3 * i], vectors[i]);
  return result;
}

}  // namespace

extern "C" {

gno_status gno_sensor_builtin(const char* name, gno_sensor* sensor) {
  return giveHandle(sensor, "sensor", [&] { return checked(builtinSensor(&the(name, "name"))); });
}

gno_status gno_sensor_load(const char* file, const gno_sensor_file_options* options, gno_sensor* sensor) {
  return giveHandle(sensor, "sensor", [&] { return reported(readSensorFile(fileOf(file), optionsOf(options))); });
}

gno_status gno_sensor_read(const void* bytes, size_t size, const char* name, const gno_sensor_file_options* options,
                           gno_sensor* sensor) {
  return giveHandle(sensor, "sensor", [&] {
    const auto content = array(static_cast<const char*>(bytes), size, "bytes");
    return reported(readSensorFile({content.data(), content.size()}, &the(name, "name"), optionsOf(options)));
  });
}

gno_status gno_sensor_from_json(const char* json, gno_sensor* sensor) {
  return giveHandle(sensor, "sensor", [&] { return checked(sensorFromJson(&the(json, "json"), "the text")); });
}

gno_status gno_sensor_create_grid(const gno_sensor_settings* settings, const gno_grid* grid, gno_sensor* sensor) {
  return giveHandle(sensor, "sensor", [&] {
    const gno_grid& from = sized(grid, GNO_TYPE(gno_grid));
    Sensor result;
    apply(settings, gno_sensor_settings_init(), result);
    result.columns = from.columns;
    result.azimuthStartDeg = from.azimuth_start_deg;
    result.azimuthSpanDeg = from.azimuth_span_deg;
    for (const gno_channel& channel : array(from.channels, from.channel_count, "gno_grid::channels"))
      result.channels.push_back({channel.elevation_deg, channel.azimuth_offset_deg, vec3(channel.origin),
                                 channel.time_offset, channel.range_min, channel.range_max});
    return checked(std::move(result));
  });
}

gno_status gno_sensor_create_list(const gno_sensor_settings* settings, const gno_beam_list* patterns,
                                  size_t pattern_count, gno_sensor* sensor) {
  return giveHandle(sensor, "sensor", [&] {
    if (pattern_count == 0) refuse("pattern_count is 0; a sensor needs one list of beams at least");
    Sensor result;
    apply(settings, gno_sensor_settings_init(), result);
    forSized(patterns, pattern_count, GNO_TYPE(gno_beam_list), "patterns",
             [&](const gno_beam_list& list) { result.patterns.push_back(listOf(list)); });
    return checked(std::move(result));
  });
}

gno_status gno_sensor_destroy(gno_sensor sensor) {
  return guard([&] { destroy(sensor); });
}

gno_status gno_sensor_get_settings(gno_sensor sensor, gno_sensor_settings* settings) {
  return guard([&] {
    Locked locked(sensor);
    const Out to(settings, GNO_TYPE(gno_sensor_settings));
    *to = settingsOf(locked->sensor);
  });
}

gno_status gno_sensor_set_settings(gno_sensor sensor, const gno_sensor_settings* settings) {
  return guard([&] {
    Locked locked(sensor);
    Sensor changed = locked->sensor;
    apply(settings, settingsOf(locked->sensor), changed);
    validate(changed);
    locked->sensor = std::move(changed);
  });
}

gno_status gno_sensor_get_size(gno_sensor sensor, gno_sensor_size* size) {
  return guard([&] {
    Locked locked(sensor);
    const Out to(size, GNO_TYPE(gno_sensor_size));
    to->beams = locked->sensor.beamCount();
    to->width = locked->sensor.width();
    to->height = locked->sensor.height();
    to->patterns = locked->sensor.patterns.size();
  });
}

gno_status gno_sensor_get_beams(gno_sensor sensor, uint64_t frame, gno_beam_list* beams) {
  return guard([&] {
    Locked locked(sensor);
    const Out to(beams, GNO_TYPE(gno_beam_list));
    const BeamList& list = locked->beams = beamsOf(locked->sensor, frame);
    locked->directions = flat(list.directions);
    locked->origins = flat(list.origins);
    to->beam_count = list.size();
    to->directions = orNull(locked->directions);
    to->origins = orNull(locked->origins);
    to->times = orNull(list.times);
    to->range_min = orNull(list.rangeMin);
    to->range_max = orNull(list.rangeMax);
    to->rings = orNull(list.rings);
    to->width = list.width;
    to->height = list.height;
  });
}

gno_status gno_sensor_to_json(gno_sensor sensor, const char** json) {
  return guard([&] {
    thread_local std::string text;
    text = toJson(Locked(sensor)->sensor);
    the(json, "json") = text.c_str();
  });
}

gno_status gno_sensor_get_report(gno_sensor sensor, const char** lines) {
  return guard([&] { the(lines, "lines") = Locked(sensor)->report.c_str(); });
}

gno_status gno_sensor_names(const char* const** names, size_t* count) {
  return guard([&] {
    static const auto& all = *new auto([] {
      std::vector<const char*> result;
      for (const Sensor& sensor : builtinSensors()) result.push_back(sensor.name.c_str());
      return result;
    }());
    the(names, "names") = all.data();
    the(count, "count") = all.size();
  });
}

gno_status gno_catalogue_count(size_t* count) {
  return guard([&] { the(count, "count") = sensorCatalogue().size(); });
}

gno_status gno_catalogue_get(size_t index, gno_catalogue_head* head) {
  return guard([&] {
    const std::vector<CatalogueHead>& all = sensorCatalogue();
    const Out to(head, GNO_TYPE(gno_catalogue_head));
    if (index >= all.size())
      refuse("head " + std::to_string(index) + " does not exist, there are " + std::to_string(all.size()));
    thread_local std::string modes;
    modes.clear();
    for (const std::string& mode : all[index].modes) modes += (modes.empty() ? "" : ",") + mode;
    to->name = all[index].name.c_str();
    to->product = all[index].product.c_str();
    to->modes = modes.c_str();
    to->source = all[index].source.c_str();
    to->remarks = all[index].remarks.c_str();
    to->range_at_10_percent = all[index].rangeAt10Percent;
  });
}

}  // extern "C"
