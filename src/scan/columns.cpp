// SPDX-License-Identifier: Apache-2.0
#include "scan/columns.hpp"

#include "gnosphere/error.hpp"
#include "scan/fields.hpp"

namespace gnosphere {

namespace {

/// The size of a column of a scan that has it: without entries one byte, which tells it from a column that is missing.
size_t bytesOfColumn(Field field, size_t entries) {
  const FieldInfo info = fieldInfo(field);
  return std::max<size_t>(entries * info.components * sizeOf(info.type), 1);
}

}  // namespace

void ScanColumns::make(Field field, bool wanted) {
  scan_.columns_[static_cast<size_t>(field)].resize(wanted ? bytesOfColumn(field, scan_.ranges.size()) : 0);
}

void refuseMissing(Field field) {
  const std::string name = std::string("the scan has no field '") + fieldInfo(field).name + "'";
  if (field == Field::tie || field == Field::tolerance)
    throw Error(ErrorCode::invalidArgument, name + ": only the device 'reference' gives it");
  // These fields are missing only in scans that were read from a file.
  if (isOfEveryScan(field)) throw Error(ErrorCode::invalidArgument, name);
  throw Error(ErrorCode::invalidArgument, name + ": it was not asked for; add it to the fields of the sensor");
}

void Timings::add(const std::string& stage, double ms) {
  const auto found =
      std::find_if(stages.begin(), stages.end(), [&](const StageTime& other) { return other.name == stage; });
  if (found == stages.end())
    stages.push_back({stage, ms});
  else
    found->ms += ms;
}

Counters& Counters::operator+=(const Counters& other) {
  const auto add = [&]<typename... Members>(Members... members) {
    static_assert(sizeof...(members) * sizeof(uint64_t) + sizeof(causes) == sizeof(Counters), "every count is added");
    ((this->*members += other.*members), ...);
  };
  add(&Counters::beams, &Counters::hits, &Counters::misses, &Counters::triangles, &Counters::nonFinite,
      &Counters::degenerate, &Counters::culledByCluster, &Counters::reused, &Counters::culledByRange,
      &Counters::culledByFace, &Counters::culledBetweenBeams, &Counters::culledHidden, &Counters::projected,
      &Counters::candidates, &Counters::integerSides, &Counters::integerRanges, &Counters::lostEchoes,
      &Counters::retries);
  for (size_t i = 0; i < causes.size(); ++i) causes[i] += other.causes[i];
  return *this;
}

bool Scan::has(Field field) const {
  const size_t entries = ranges.size();
  switch (field) {
    case Field::x:
    case Field::y:
    case Field::z: return points.size() == 3 * entries && columns_[static_cast<size_t>(Field::x)].empty();
    case Field::range: return true;
    case Field::triangle: return triangles.size() == entries && columns_[static_cast<size_t>(field)].empty();
    case Field::instance: return instances.size() == entries && columns_[static_cast<size_t>(field)].empty();
    default: break;
  }
  return columns_[static_cast<size_t>(field)].size() == bytesOfColumn(field, entries);
}

Scan::RawColumn Scan::find(Field field, uint32_t component, ValueType type) const {
  const FieldInfo info = fieldInfo(field);
  if (type != info.type) {
    throw Error(ErrorCode::invalidArgument, std::string("the values of field '") + info.name + "' are " +
                                                cppNameOf(info.type) + ", not " + cppNameOf(type));
  }
  if (component >= info.components) {
    throw Error(ErrorCode::invalidArgument, std::string("field '") + info.name + "' has no component " +
                                                std::to_string(component) + "; it has " +
                                                std::to_string(info.components) + ", counted from 0");
  }
  if (!has(field)) refuseMissing(field);
  switch (field) {
    case Field::x: return {points.data(), 3};
    case Field::y: return {points.data() + 1, 3};
    case Field::z: return {points.data() + 2, 3};
    case Field::range: return {ranges.data(), 1};
    case Field::triangle: return {triangles.data(), 1};
    case Field::instance: return {instances.data(), 1};
    default: return {columns_[static_cast<size_t>(field)].data() + component * sizeOf(info.type), info.components};
  }
}

}  // namespace gnosphere
