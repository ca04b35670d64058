// SPDX-License-Identifier: Apache-2.0
#include "pipeline/record_tables.hpp"

#include <algorithm>
#include <bit>
#include <initializer_list>

#include "base/limits.hpp"
#include "scan/fields.hpp"
#include "scan/layout.hpp"
#include "sensor/beams.hpp"

namespace gnosphere {
namespace {

static_assert(static_cast<uint32_t>(ValueType::f32) == gpu::kTypeF32);
static_assert(static_cast<uint32_t>(ValueType::f64) == gpu::kTypeF64);
static_assert(static_cast<uint32_t>(ValueType::u8) == gpu::kTypeU8);
static_assert(static_cast<uint32_t>(ValueType::u16) == gpu::kTypeU16);
static_assert(static_cast<uint32_t>(ValueType::u32) == gpu::kTypeU32);
static_assert(sizeof(RecordHeader) == 32);

// The number of a field's first component; those of the others follow.
uint32_t numberOf(Field field) {
  switch (field) {
    case Field::x: return gpu::kValueX;
    case Field::y: return gpu::kValueY;
    case Field::z: return gpu::kValueZ;
    case Field::range: return gpu::kValueRange;
    case Field::ring: return gpu::kValueRing;
    case Field::beam: return gpu::kValueBeam;
    case Field::triangle: return gpu::kValueTriangle;
    case Field::instance: return gpu::kValueInstance;
    case Field::intensity: return gpu::kValueIntensity;
    case Field::trueRange: return gpu::kValueTrueRange;
    case Field::cause: return gpu::kValueCause;
    case Field::label: return gpu::kValueLabel;
    case Field::returnNumber: return gpu::kValueReturnNumber;
    case Field::returnCount: return gpu::kValueReturnCount;
    case Field::width: return gpu::kValueWidth;
    case Field::normal: return gpu::kValueNormalX;
    case Field::incidence: return gpu::kValueIncidence;
    case Field::material: return gpu::kValueMaterial;
    case Field::barycentrics: return gpu::kValueBarycentricU;
    case Field::classId: return gpu::kValueClass;
    case Field::velocity: return gpu::kValueVelocityX;
    case Field::radialSpeed: return gpu::kValueRadialSpeed;
    case Field::time: return gpu::kValueTime;
    case Field::azimuth: return gpu::kValueAzimuth;
    case Field::elevation: return gpu::kValueElevation;
    case Field::tie:
    case Field::tolerance: break;  // checkLayout() refuses them
  }
  return gpu::kValueBeam;
}

gpu::RecordValue packed(const RecordLayout::Value& value, size_t offset) {
  return {numberOf(value.field) + value.component, static_cast<uint32_t>(value.type), static_cast<uint32_t>(offset)};
}

// Whether each value has a word of its own, which holds the bits that the value has anyway.
bool isOfWholeWords(const RecordLayout& layout, uint32_t held) {
  if (static_cast<size_t>(std::popcount(held)) != layout.values.size() || layout.stride % 4 != 0) return false;
  return std::all_of(layout.values.begin(), layout.values.end(), [](const RecordLayout::Value& value) {
    const ValueType own = fieldInfo(value.field).type;
    const bool same = value.type == own || (value.type == ValueType::u32 && own != ValueType::f32);
    return same && sizeOf(value.type) == 4 && value.offset % 4 == 0 && value.stride % 4 == 0;
  });
}

// Finds the place of each value, and the words of a row between them.
void placeWords(const RecordLayout& layout, RecordTables& tables) {
  tables.places.resize(gpu::kValues);
  std::vector<bool> used(layout.stride / 4);
  for (const RecordLayout::Value& value : layout.values) {
    const size_t stride = value.stride > 0 ? value.stride : layout.stride;
    tables.places[numberOf(value.field) + value.component] = {static_cast<uint32_t>(value.offset / 4),
                                                              static_cast<uint32_t>(stride / 4)};
    if (value.stride == 0) used[value.offset / 4] = true;
  }
  for (size_t word = 0; word < used.size(); ++word)
    if (!used[word]) tables.gaps.push_back({static_cast<uint32_t>(word), static_cast<uint32_t>(layout.stride / 4)});
}

bool asks(const RecordLayout& layout, std::initializer_list<Field> fields) {
  return std::any_of(layout.values.begin(), layout.values.end(), [&](const RecordLayout::Value& value) {
    return std::find(fields.begin(), fields.end(), value.field) != fields.end();
  });
}

}  // namespace

RecordTables recordTables(const RecordLayout& layout) {
  RecordTables tables;
  const auto add = [&](size_t start, size_t stride, size_t values, bool column) {
    tables.streams.push_back({static_cast<uint32_t>(start), static_cast<uint32_t>(stride),
                              static_cast<uint32_t>(tables.values.size()), static_cast<uint32_t>(values), column});
  };
  const std::vector<RecordLayout::Value> row = valuesOfRow(layout);
  if (!row.empty()) add(0, layout.stride, row.size(), false);
  for (const RecordLayout::Value& value : row) tables.values.push_back(packed(value, value.offset));
  for (const RecordLayout::Value& value : layout.values) {
    if (value.stride == 0) continue;
    add(value.offset, value.stride, 1, true);
    tables.values.push_back(packed(value, 0));
  }
  for (const gpu::RecordValue& value : tables.values) tables.held |= 1u << value.value;
  if (!layout.empty() && isOfWholeWords(layout, tables.held)) {
    tables.held |= gpu::kWholeWords;
    placeWords(layout, tables);
  }
  return tables;
}

std::vector<uint32_t> beamPlaces(const SensorPlan& plan, const BeamTables& tables) {
  std::vector<uint32_t> places(plan.sensor.beamCount(), gpu::kNone);
  for (uint32_t index = 0; index < tables.frame.beams; ++index)
    if (const uint32_t number = tables.numberOf(index); number != gpu::kNone) places[number] = index;
  return places;
}

std::vector<gpu::uvec4> beamFacts(const SensorPlan& plan, size_t pattern) {
  std::vector<gpu::uvec4> facts;
  if (!asks(plan.layout, {Field::time, Field::azimuth, Field::elevation, Field::ring})) return facts;
  const Sensor& sensor = plan.sensor;
  const auto bits = [](double value) { return std::bit_cast<uint32_t>(static_cast<float>(value)); };
  facts.resize(sensor.beamCount());
  for (size_t beam = 0; beam < facts.size(); ++beam)
    facts[beam] = {bits(timeOf(sensor, beam, pattern)), bits(azimuthOf(sensor, beam, pattern)),
                   bits(elevationOf(sensor, beam, pattern)), ringOf(sensor, beam, pattern)};
  return facts;
}

std::vector<gpu::vec4> beamDirections(const SensorPlan& plan, size_t pattern) {
  std::vector<gpu::vec4> directions;
  if (!asks(plan.layout, {Field::incidence}) || plan.pointsTellDirections()) return directions;
  directions.resize(plan.sensor.beamCount());
  for (size_t beam = 0; beam < directions.size(); ++beam) {
    const Vec3 d = directionOf(plan.sensor, beam, pattern);
    directions[beam] = {static_cast<float>(d.x), static_cast<float>(d.y), static_cast<float>(d.z), 0};
  }
  return directions;
}

void checkLayout(const SensorPlan& plan) {
  if (asks(plan.layout, {Field::tie, Field::tolerance}))
    throw Error(ErrorCode::invalidArgument, "the record layout: only the device 'reference' has 'tie' and 'tolerance'");
  for (const RecordLayout::Value& value : plan.layout.values)
    if (std::max({value.offset, value.stride, plan.layout.stride}) > limits::kMostNumber)
      throw Error(ErrorCode::invalidArgument, "the record layout: offsets and strides on a device have 31 bits");
  if (plan.sensor.beamCount() == 0)
    throw Error(ErrorCode::invalidArgument, "sensor '" + plan.sensor.name + "' has no beams");
  if (asks(plan.layout, {Field::incidence}) && plan.has(gpu::kSensorMotion) && plan.effects.sensorMotion.deskew)
    throw Error(ErrorCode::invalidArgument,
                "sensor '" + plan.sensor.name +
                    "': with deskew the incidence is known only on the host; leave it out of the layout");
  if (plan.sensor.beamCount() * plan.returns > limits::kEntries.most)
    throw Error(ErrorCode::invalidArgument,
                "sensor '" + plan.sensor.name + "' has more returns than 31 bits can number, as a layout needs");
}

}  // namespace gnosphere
