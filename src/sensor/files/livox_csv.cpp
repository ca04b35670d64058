// SPDX-License-Identifier: Apache-2.0
// Livox's patterns as its simulation plug-in keeps them: a header such as "Time/s,Azimuth/deg,Zenith/deg", then beams
// in firing order. Azimuths are counter-clockwise from x, zenith angles are from z.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "base/decimal_point.hpp"
#include "base/text.hpp"
#include "sensor/files/source.hpp"

namespace gnosphere {
namespace {

/// Where a column is, and what its numbers are multiplied by.
struct Place {
  size_t cell = 0;
  double unit = 1;
};

std::optional<Place> find(const std::vector<std::string_view>& header, std::string_view word) {
  for (size_t i = 0; i < header.size(); ++i) {
    if (!containsWord(header[i], word)) continue;
    const bool radians = containsWord(header[i], "rad");
    const bool micro = containsWord(header[i], "us"), nano = containsWord(header[i], "ns");
    const bool milli = containsWord(header[i], "ms");
    return Place{i, radians ? 180 / std::numbers::pi : micro ? 1e-6 : nano ? 1e-9 : milli ? 1e-3 : 1};
  }
  return {};
}

}  // namespace

void readLivoxCsv(SensorSource& source) {
  const std::vector<std::string_view> lines = linesOf(source.bytes);
  const auto header = cellsOf(lines.empty() ? "" : lines[0]);
  const auto time = find(header, "time"), azimuth = find(header, "azimuth"), zenith = find(header, "zenith");
  const auto elevation = find(header, "elevation"), ring = find(header, "ring");
  if (!azimuth || (!zenith && !elevation))
    source.refuse("line 1 is '" + std::string(lines.empty() ? "" : lines[0].substr(0, 80)) +
                  "', expected is a header such as Time/s,Azimuth/deg,Zenith/deg");
  BeamList list;
  for (size_t i = 1; i < lines.size(); ++i) {
    if (lines[i].find_first_not_of(" \t") == lines[i].npos) continue;
    const auto cells = cellsOf(lines[i]);
    const std::string where = "line " + std::to_string(i + 1);
    if (cells.size() < header.size())
      source.refuse(where + " has " + std::to_string(cells.size()) + " cells, the header " +
                    std::to_string(header.size()));
    refuseSurplus(source, cells, header.size(), where);
    const auto value = [&](const std::optional<Place>& place) {
      return place->unit * numberOf(source, cells[place->cell], where + ", " + std::string(header[place->cell]));
    };
    const double up = zenith ? 90 - value(zenith) : value(elevation);
    list.directions.push_back(directionOfAngles(source, value(azimuth), up, list.size()));
    if (time) list.times.push_back(value(time));
    if (!ring) continue;
    const double id = value(ring);
    if (!(id >= 0 && id <= 65535)) source.refuse(where + ": the ring " + numberText(id) + " is not within 0..65535");
    list.rings.push_back(static_cast<uint16_t>(id));
  }
  // The published table of the Mid-360 counts its beams in the column "Time/s".
  const auto [least, most] = std::minmax_element(list.times.begin(), list.times.end());
  if (!list.times.empty() && (*least < 0 || *most > 10)) {
    const DecimalPoint point;
    source.ignore("times from " + std::to_string(*least) + " to " + std::to_string(*most) +
                  " s, which are not those of one scan");
    list.times.clear();
  }
  setBeams(source, std::move(list));
  assumeRange(source, 200);
}

}  // namespace gnosphere
