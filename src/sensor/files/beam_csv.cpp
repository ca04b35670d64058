// SPDX-License-Identifier: Apache-2.0
// Tables of beams with a header, then a row per beam: the patterns of Livox's simulation plug-in, "Time/s,Azimuth/deg,
// Zenith/deg" in firing order, and what `gnosphere sensors --beams` writes. Azimuths are counter-clockwise from x,
// zenith angles are from z.
#include <algorithm>
#include <cmath>
#include <optional>

#include "base/text.hpp"
#include "base/units.hpp"
#include "sensor/files/source.hpp"

namespace gnosphere {
namespace {

/// Where a column is, and what its numbers are multiplied by.
struct Place {
  size_t cell = 0;
  double unit = 1;
};

/// The columns of a table, of which azimuth and zenith or elevation must be there.
struct Columns {
  std::optional<Place> time, azimuth, zenith, elevation, ring, pattern, originX, originY, originZ, least, most, index;
  size_t count = 0;

  Columns(SensorSource& source, const std::vector<std::string_view>& header) : count(header.size()) {
    const std::pair<const char*, std::optional<Place>*> names[] = {
        {"origin_x", &originX}, {"origin_y", &originY}, {"origin_z", &originZ}, {"range_min", &least},
        {"range_max", &most},   {"azimuth", &azimuth},  {"zenith", &zenith},    {"elevation", &elevation},
        {"time", &time},        {"ring", &ring},        {"pattern", &pattern},  {"index", &index}};
    for (size_t i = 0; i < header.size(); ++i) {
      const auto name = std::find_if(std::begin(names), std::end(names),
                                     [&](const auto& each) { return containsWord(header[i], each.first); });
      if (name != std::end(names) && !*name->second)
        *name->second = Place{i, unitOf(header[i], name->first)};
      else if (!header[i].empty())
        source.ignore("the column '" + std::string(header[i]) + "'");
    }
    if (!azimuth || (!zenith && !elevation))
      source.refuse("line 1 is '" + std::string(linesOf(source.bytes)[0].substr(0, 80)) +
                    "', expected is a header such as Time/s,Azimuth/deg,Zenith/deg");
    if (index) noteIndex(source);
    if (zenith && elevation) source.ignore("the elevations, because there are zenith angles");
    if (originX.has_value() != originY.has_value() || originX.has_value() != originZ.has_value())
      source.refuse("has not all of the columns origin_x, origin_y and origin_z");
    if (least.has_value() != most.has_value()) source.refuse("has only one of the columns range_min and range_max");
  }

  /// Says what a table that `gnosphere sensors --beams` has written does not bring back.
  static void noteIndex(SensorSource& source) {
    source.ignore("the index: the beams make one row of a cloud, in which masked beams have no place");
    source.assume("1 return a beam");
  }

  static double unitOf(std::string_view header, std::string_view column) {
    const auto has = [&](const char* unit) { return containsWord(header, unit); };
    if (column == "time") return has("us") ? 1e-6 : has("ns") ? 1e-9 : has("ms") ? 1e-3 : 1;
    if (column.starts_with("origin") || column.starts_with("range")) return has("mm") ? 1e-3 : has("cm") ? 1e-2 : 1;
    return has("rad") ? kRadian : 1;
  }
};

}  // namespace

void readBeamCsv(SensorSource& source) {
  const std::vector<std::string_view> lines = linesOf(source.bytes);
  const auto header = cellsOf(lines.empty() ? "" : lines[0]);
  const Columns columns(source, header);
  std::vector<BeamList> patterns(1);
  for (size_t i = 1; i < lines.size(); ++i) {
    if (lines[i].find_first_not_of(" \t") == lines[i].npos) continue;
    const auto cells = cellsOf(lines[i]);
    const std::string where = "line " + std::to_string(i + 1);
    if (cells.size() < columns.count)
      source.refuse(where + " has " + std::to_string(cells.size()) + " cells, the header " +
                    std::to_string(columns.count));
    refuseSurplus(source, cells, columns.count, where);
    const auto value = [&](const std::optional<Place>& place) {
      return place->unit * numberOf(source, cells[place->cell], where + ", " + std::string(header[place->cell]));
    };
    /// A number that counts something.
    const auto number = [&](const std::optional<Place>& place, const char* what) {
      const double id = value(place);
      if (!(id >= 0 && id <= 65535) || id != std::floor(id))
        source.refuse(where + ": the " + what + " " + numberText(id) + " is not a whole number within 0..65535");
      return static_cast<uint16_t>(id);
    };
    const size_t pattern = columns.pattern ? number(columns.pattern, "pattern") : 0;
    if (pattern >= patterns.size()) patterns.resize(pattern + 1);
    BeamList& list = patterns[pattern];
    const double up = columns.zenith ? 90 - value(columns.zenith) : value(columns.elevation);
    list.directions.push_back(directionOfAngles(source, value(columns.azimuth), up, list.size()));
    if (columns.time) list.times.push_back(value(columns.time));
    if (columns.ring) list.rings.push_back(number(columns.ring, "ring"));
    if (columns.originX)
      list.origins.push_back({value(columns.originX), value(columns.originY), value(columns.originZ)});
    if (!columns.least) continue;
    list.rangeMin.push_back(static_cast<float>(value(columns.least)));
    list.rangeMax.push_back(static_cast<float>(value(columns.most)));
  }
  if (!columns.least) {
    assumeRange(source, 200);
  } else {
    Sensor& sensor = source.file.sensor;
    sensor.rangeMax = 0;
    for (const BeamList& list : patterns)
      for (const float most : list.rangeMax) sensor.rangeMax = std::max<double>(sensor.rangeMax, most);
  }
  if (!columns.pattern) return setBeams(source, std::move(patterns[0]));
  if (source.options.beamsPerScan > 0)
    source.refuse("has a column of patterns, so it cannot be cut into scans of " +
                  std::to_string(source.options.beamsPerScan) + " beams");
  setPatterns(source, std::move(patterns));
}

}  // namespace gnosphere
