// SPDX-License-Identifier: Apache-2.0
// gno_scan and gno_batch: the fields of the results as pointers, and what was counted and timed.
#include <algorithm>

#include "c/handles.hpp"

namespace gnosphere::c {

std::vector<Field> fieldsOf(const gno_field* fields, size_t count) {
  std::vector<Field> result;
  for (const gno_field field : array(fields, count, "fields"))
    result.push_back(enumOf(field, static_cast<Field>(kFieldCount - 1), "the field"));
  return result;
}

namespace {

GNO_SAME_ENUM(Field, {GNO_FIELD_X, x}, {GNO_FIELD_Y, y}, {GNO_FIELD_Z, z}, {GNO_FIELD_RANGE, range},
              {GNO_FIELD_RING, ring}, {GNO_FIELD_BEAM, beam}, {GNO_FIELD_TRIANGLE, triangle},
              {GNO_FIELD_INSTANCE, instance}, {GNO_FIELD_TIE, tie}, {GNO_FIELD_TOLERANCE, tolerance},
              {GNO_FIELD_INTENSITY, intensity}, {GNO_FIELD_TRUE_RANGE, trueRange}, {GNO_FIELD_CAUSE, cause},
              {GNO_FIELD_LABEL, label}, {GNO_FIELD_RETURN_NUMBER, returnNumber}, {GNO_FIELD_RETURN_COUNT, returnCount},
              {GNO_FIELD_WIDTH, width}, {GNO_FIELD_NORMAL, normal}, {GNO_FIELD_INCIDENCE, incidence},
              {GNO_FIELD_MATERIAL, material}, {GNO_FIELD_BARYCENTRICS, barycentrics}, {GNO_FIELD_CLASS_ID, classId},
              {GNO_FIELD_VELOCITY, velocity}, {GNO_FIELD_RADIAL_SPEED, radialSpeed}, {GNO_FIELD_TIME, time},
              {GNO_FIELD_AZIMUTH, azimuth}, {GNO_FIELD_ELEVATION, elevation});
static_assert(kFieldCount == GNO_FIELD_ELEVATION + 1);
GNO_SAME_ENUM(ValueType, {GNO_F32, f32}, {GNO_F64, f64}, {GNO_U8, u8}, {GNO_U16, u16}, {GNO_U32, u32});
GNO_SAME_ENUM(Cause, {GNO_CAUSE_RETURNED, returned}, {GNO_CAUSE_NO_SURFACE, noSurface}, {GNO_CAUSE_WEAK, weak},
              {GNO_CAUSE_ATTENUATED, attenuated}, {GNO_CAUSE_DROPPED_OUT, droppedOut}, {GNO_CAUSE_DEAD, dead},
              {GNO_CAUSE_TOO_NEAR, tooNear}, {GNO_CAUSE_NOT_CHOSEN, notChosen});
static_assert(kCauseCount == GNO_CAUSE_NOT_CHOSEN + 1);
GNO_SAME_ENUM(Label, {GNO_LABEL_NONE, none}, {GNO_LABEL_SOLID, solid}, {GNO_LABEL_SCATTER, scatter});
static_assert(sizeof(gno_counters::causes) / sizeof(uint64_t) == kCauseCount);

template <class T, class Results>
void fill(const Results& results, Field field, gno_column& column) {
  const ColumnView<T> view = results.template column<T>(field);
  column.values = view.data();
  column.entries = view.size();
  column.stride = view.stride();
}

/// Gives the values of a field of a scan or of a batch.
template <class Results>
void getColumn(const Results& from, gno_field field, gno_column* column) {
  const Out to(column, GNO_TYPE(gno_column));
  const Field wanted = fieldsOf(&field, 1)[0];
  const FieldInfo info = fieldInfo(wanted);
  switch (info.type) {
    case ValueType::f32: fill<float>(from, wanted, *to); break;
    case ValueType::u8: fill<uint8_t>(from, wanted, *to); break;
    case ValueType::u16: fill<uint16_t>(from, wanted, *to); break;
    case ValueType::u32:
    case ValueType::f64: fill<uint32_t>(from, wanted, *to); break;  // no field has f64
  }
  to->type = static_cast<gno_value_type>(info.type);
  to->components = info.components;
}

void getCounters(const Counters& from, gno_counters* counters) {
  static_assert(sizeof(gno_counters) == sizeof(size_t) + sizeof(Counters), "every count is copied below");
  const Out to(counters, GNO_TYPE(gno_counters));
  to->beams = from.beams;
  to->hits = from.hits;
  to->misses = from.misses;
  to->triangles = from.triangles;
  to->non_finite = from.nonFinite;
  to->degenerate = from.degenerate;
  to->culled_by_cluster = from.culledByCluster;
  to->reused = from.reused;
  to->culled_by_range = from.culledByRange;
  to->culled_by_face = from.culledByFace;
  to->culled_between_beams = from.culledBetweenBeams;
  to->culled_hidden = from.culledHidden;
  to->projected = from.projected;
  to->candidates = from.candidates;
  to->integer_sides = from.integerSides;
  to->integer_ranges = from.integerRanges;
  to->lost_echoes = from.lostEchoes;
  to->retries = from.retries;
  std::copy(from.causes.begin(), from.causes.end(), to->causes);
}

/// Gives the times of a scan or of a batch. The object of the handle keeps the stages until the next call.
template <class Object>
void getTimings(Object& object, gno_timings* timings) {
  const Out to(timings, GNO_TYPE(gno_timings));
  const Timings& from = object.timings;
  object.stages.clear();
  for (const StageTime& stage : from.stages) object.stages.push_back({stage.name.c_str(), stage.ms});
  to->wall_ms = from.wallMs;
  to->gpu_ms = from.gpuMs;
  to->stages = object.stages.data();
  to->stage_count = object.stages.size();
}

}  // namespace
}  // namespace gnosphere::c

using namespace gnosphere;
using namespace gnosphere::c;

extern "C" {

gno_status gno_field_describe(gno_field field, gno_field_description* description) {
  return guard([&] {
    const Out to(description, GNO_TYPE(gno_field_description));
    const FieldInfo info = fieldInfo(fieldsOf(&field, 1)[0]);
    to->name = info.name;
    to->type = static_cast<gno_value_type>(info.type);
    to->components = info.components;
  });
}

gno_status gno_fields_parse(const char* names, gno_field* fields, size_t capacity, size_t* count) {
  return guard([&] {
    const std::vector<Field> all = parseFields(&the(names, "names"));
    const auto to = array(fields, capacity, "fields");
    for (size_t i = 0; i < std::min(all.size(), to.size()); ++i) to[i] = static_cast<gno_field>(all[i]);
    the(count, "count") = all.size();
  });
}

gno_status gno_scan_destroy(gno_scan scan) {
  return guard([&] { destroy(scan); });
}

gno_status gno_scan_get_info(gno_scan scan, gno_scan_info* info) {
  return guard([&] {
    Locked from(scan);
    const Out to(info, GNO_TYPE(gno_scan_info));
    to->sensor = from->sensor.c_str();
    to->columns = from->columns;
    to->channels = from->channels;
    to->returns = from->returns;
    to->entries = from->ranges.size();
    to->pose = poseOf(from->pose);
  });
}

gno_status gno_scan_get_column(gno_scan scan, gno_field field, gno_column* column) {
  return guard([&] { getColumn(*Locked(scan), field, column); });
}

gno_status gno_scan_in_world(gno_scan scan, gno_scan* in_world) {
  return giveHandle(in_world, "in_world", [&] { return make<gno_scan>(inWorld(*Locked(scan))); });
}

gno_status gno_scan_get_counters(gno_scan scan, gno_counters* counters) {
  return guard([&] { getCounters(Locked(scan)->counters, counters); });
}

gno_status gno_scan_get_timings(gno_scan scan, gno_timings* timings) {
  return guard([&] { getTimings(*Locked(scan), timings); });
}

gno_status gno_batch_destroy(gno_batch batch) {
  return guard([&] { destroy(batch); });
}

gno_status gno_batch_get_info(gno_batch batch, gno_batch_info* info) {
  return guard([&] {
    Locked from(batch);
    const Out to(info, GNO_TYPE(gno_batch_info));
    to->sensor = from->sensor.c_str();
    to->columns = from->columns;
    to->channels = from->channels;
    to->returns = from->returns;
    to->views = from->views;
    to->beams = from->beams;
    to->entries = from->entries();
  });
}

gno_status gno_batch_get_column(gno_batch batch, gno_field field, gno_column* column) {
  return guard([&] { getColumn(*Locked(batch), field, column); });
}

gno_status gno_batch_get_counters(gno_batch batch, gno_counters* counters) {
  return guard([&] { getCounters(Locked(batch)->counters, counters); });
}

gno_status gno_batch_get_timings(gno_batch batch, gno_timings* timings) {
  return guard([&] { getTimings(*Locked(batch), timings); });
}

}  // extern "C"
