// SPDX-License-Identifier: Apache-2.0
// Tables of beams with a header, then a row per beam: the patterns of Livox's simulation plug-in, "Time/s,Azimuth/deg,
// Zenith/deg" in firing order, and what `gnosphere sensors --beams` writes. Azimuths are counter-clockwise from x,
// zenith angles are from z.
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

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
    if (zenith && elevation) source.ignore("the elevations, because there are zenith angles");
    if (originX.has_value() != originY.has_value() || originX.has_value() != originZ.has_value())
      source.refuse("has not all of the columns origin_x, origin_y and origin_z");
    if (least.has_value() != most.has_value()) source.refuse("has only one of the columns range_min and range_max");
  }

  static double unitOf(std::string_view header, std::string_view column) {
    const auto has = [&](const char* unit) { return containsWord(header, unit); };
    if (column == "time") return has("us") ? 1e-6 : has("ns") ? 1e-9 : has("ms") ? 1e-3 : 1;
    if (column.starts_with("origin") || column.starts_with("range")) return has("mm") ? 1e-3 : has("cm") ? 1e-2 : 1;
    return has("rad") ? kRadian : 1;
  }
};

/// The size of an organised cloud; 0 if it is not known.
struct Cloud {
  uint32_t width = 0, height = 0;
};

/// Returns the cloud in which the beams of a list have these indexes, if their rings are its rows. The table does not
/// state its width: that is the only number by which every index, divided and rounded down, is the ring. A single ring
/// is a cloud if no beam is masked.
Cloud cloudOf(const std::vector<uint32_t>& indexes, const std::vector<uint16_t>& rings) {
  if (indexes.size() != rings.size()) return {};
  uint32_t least = 1, most = std::numeric_limits<uint32_t>::max();
  for (size_t i = 0; i < indexes.size(); ++i) {
    least = std::max(least, indexes[i] / (rings[i] + 1u) + 1);
    if (rings[i] > 0) most = std::min(most, indexes[i] / rings[i]);
  }
  const bool isFullRow = most == std::numeric_limits<uint32_t>::max() && least == indexes.size();
  if (least != most && !isFullRow) return {};
  const uint32_t height = *std::max_element(rings.begin(), rings.end()) + 1u;
  constexpr uint64_t kMostPlaces = 64;  // per beam: so few beams of a cloud tell nothing of it
  return uint64_t{least} * height <= kMostPlaces * indexes.size() ? Cloud{least, height} : Cloud{};
}

/// Puts the beams of a list at their places of a cloud. At the other places are copies of the first beam, which must be
/// masked.
void arrange(BeamList& list, const std::vector<uint32_t>& indexes, const Cloud& cloud) {
  const auto move = [&](auto& values) {
    if (values.empty()) return;
    auto moved = values;
    moved.assign(size_t{cloud.width} * cloud.height, values[0]);
    for (size_t i = 0; i < indexes.size(); ++i) moved[indexes[i]] = values[i];
    values = std::move(moved);
  };
  move(list.directions);
  move(list.origins);
  move(list.times);
  move(list.rangeMin);
  move(list.rangeMax);
  list.rings.clear();
  for (uint32_t row = 0; row < cloud.height; ++row)
    list.rings.insert(list.rings.end(), cloud.width, static_cast<uint16_t>(row));
  list.width = cloud.width;
  list.height = cloud.height;
}

/// Organises the beams of a table that `gnosphere sensors --beams` has written, and masks the places without a row.
/// Notes the properties that such a table does not state.
void organise(SensorSource& source, std::vector<BeamList>& patterns,
              const std::vector<std::vector<uint32_t>>& indexes) {
  source.assume("1 return a beam");
  const Cloud cloud = cloudOf(indexes[0], patterns[0].rings);
  const auto isLikeFirst = [&](const auto& each) { return each == indexes[0]; };
  std::vector<bool> fires(size_t{cloud.width} * cloud.height);
  for (const uint32_t index : indexes[0])
    if (index < fires.size()) fires[index] = true;
  const bool once = static_cast<size_t>(std::count(fires.begin(), fires.end(), true)) == indexes[0].size();
  if (cloud.width == 0 || !once || source.options.beamsPerScan > 0 ||
      !std::all_of(indexes.begin(), indexes.end(), isLikeFirst))
    return source.ignore("the index: the beams make one row of a cloud, in which masked beams have no place");
  for (BeamList& list : patterns) arrange(list, indexes[0], cloud);
  for (size_t place = 0; place < fires.size(); ++place)
    if (!fires[place]) source.file.sensor.maskedBeams.push_back(static_cast<uint32_t>(place));
}

}  // namespace

void readBeamCsv(SensorSource& source) {
  const std::vector<std::string_view> lines = linesOf(source.bytes);
  const auto header = cellsOf(lines.empty() ? "" : lines[0]);
  const Columns columns(source, header);
  std::vector<BeamList> patterns(1);
  std::vector<std::vector<uint32_t>> indexes(1);  // of the beams of each pattern
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
    const auto number = [&](const std::optional<Place>& place, const char* what, uint32_t most = 65535) {
      const double id = value(place);
      if (!(id >= 0 && id <= most) || id != std::floor(id))
        source.refuse(where + ": the " + what + " " + numberText(id) + " is not a whole number within 0.." +
                      std::to_string(most));
      return static_cast<uint32_t>(id);
    };
    const size_t pattern = columns.pattern ? number(columns.pattern, "pattern") : 0;
    if (pattern >= patterns.size()) {
      patterns.resize(pattern + 1);
      indexes.resize(pattern + 1);
    }
    if (columns.index) indexes[pattern].push_back(number(columns.index, "index", std::numeric_limits<uint32_t>::max()));
    BeamList& list = patterns[pattern];
    const double up = columns.zenith ? 90 - value(columns.zenith) : value(columns.elevation);
    list.directions.push_back(directionOfAngles(source, value(columns.azimuth), up, list.size()));
    if (columns.time) list.times.push_back(value(columns.time));
    if (columns.ring) list.rings.push_back(static_cast<uint16_t>(number(columns.ring, "ring")));
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
  if (columns.index) organise(source, patterns, indexes);
  if (!columns.pattern) return setBeams(source, std::move(patterns[0]));
  if (source.options.beamsPerScan > 0)
    source.refuse("has a column of patterns, so it cannot be cut into scans of " +
                  std::to_string(source.options.beamsPerScan) + " beams");
  setPatterns(source, std::move(patterns));
}

}  // namespace gnosphere
