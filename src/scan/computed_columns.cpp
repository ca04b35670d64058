// SPDX-License-Identifier: Apache-2.0
#include "scan/computed_columns.hpp"

#include <algorithm>
#include <type_traits>

#include "gnosphere/error.hpp"
#include "scan/columns.hpp"
#include "sensor/beams.hpp"

namespace gnosphere {
namespace {

/// Fills the column with `valueOf(entry)` if it is wanted; otherwise removes it.
template <typename T, typename ValueOf>
void setColumn(Scan& scan, Field field, bool wanted, const ValueOf& valueOf) {
  ScanColumns columns(scan);
  columns.make(field, wanted);
  if (!wanted) return;
  T* const to = columns.data<T>(field);
  for (size_t entry = 0; entry < scan.ranges.size(); ++entry) to[entry] = static_cast<T>(valueOf(entry));
}

}  // namespace

ComputedColumns::ComputedColumns(const Sensor& sensor, const std::vector<Field>& fields)
    : fields_(fields), order_(imageOrderOf(sensor)) {
  if (asks(Field::ring)) checkRings(static_cast<uint32_t>(sensor.channels.size()));
  patterns_.resize(std::max<size_t>(sensor.patterns.size(), 1));
  for (size_t pattern = 0; pattern < patterns_.size(); ++pattern) {
    const auto fill = [&](Field field, auto of, auto& values) {
      if (!asks(field) && !(field == Field::ring && hasRings(sensor))) return;
      values.resize(sensor.beamCount());
      for (size_t beam = 0; beam < values.size(); ++beam)
        values[beam] = static_cast<std::remove_reference_t<decltype(values[0])>>(of(sensor, beam, pattern));
    };
    Values& values = patterns_[pattern];
    fill(Field::time, timeOf, values.times);
    fill(Field::azimuth, azimuthOf, values.azimuths);
    fill(Field::elevation, elevationOf, values.elevations);
    fill(Field::ring, ringOf, values.rings);
  }
}

bool ComputedColumns::asks(Field field) const {
  return std::find(fields_.begin(), fields_.end(), field) != fields_.end();
}

void ComputedColumns::set(const ClassTable& classes, uint64_t frame, Scan& scan) const {
  scan.firstRowOnTop = order_.firstRowOnTop;
  scan.firstColumnOnLeft = order_.firstColumnOnLeft;
  const uint32_t returns = scan.returns;
  const Values& pattern = patterns_[frame % patterns_.size()];
  const auto setBeams = [&](Field field, const std::vector<float>& values) {
    setColumn<float>(scan, field, asks(field), [&](size_t entry) { return values[entry / returns]; });
  };
  setBeams(Field::time, pattern.times);
  setBeams(Field::azimuth, pattern.azimuths);
  setBeams(Field::elevation, pattern.elevations);
  setColumn<uint16_t>(scan, Field::ring, !pattern.rings.empty(),
                      [&](size_t entry) { return pattern.rings[entry / returns]; });
  setColumn<uint16_t>(scan, Field::classId, asks(Field::classId),
                      [&](size_t entry) { return classes.classOf(scan.instances[entry], scan.triangles[entry]); });
  setColumn<uint32_t>(scan, Field::beam, asks(Field::beam), [&](size_t entry) { return entry / returns; });
  setColumn<uint8_t>(scan, Field::returnNumber, asks(Field::returnNumber),
                     [&](size_t entry) { return returnNumberOf(scan, entry); });
  setColumn<uint8_t>(scan, Field::returnCount, asks(Field::returnCount),
                     [&](size_t entry) { return returnCountOf(scan, entry); });
}

void checkRings(uint32_t channels) {
  if (channels > 65536) {
    throw Error(ErrorCode::invalidArgument,
                "field 'ring' is 16 bits wide, the scan has " + std::to_string(channels) + " channels; leave it out");
  }
}

uint8_t returnNumberOf(const Scan& scan, size_t entry) {
  return static_cast<uint8_t>(scan.returned(entry) ? entry % scan.returns + 1 : 0);
}

uint8_t returnCountOf(const Scan& scan, size_t entry) {
  const size_t first = entry / scan.returns * scan.returns;
  int count = 0;
  for (size_t k = 0; k < scan.returns; ++k) count += scan.returned(first + k);
  return static_cast<uint8_t>(count);
}

}  // namespace gnosphere
