// SPDX-License-Identifier: Apache-2.0
// gno_scan: the fields of a scan as pointers, and what was counted and timed.
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

static_assert(kFieldCount == GNO_FIELD_ELEVATION + 1 && static_cast<int>(Field::classId) == GNO_FIELD_CLASS_ID);
static_assert(static_cast<int>(ValueType::u32) == GNO_U32 && static_cast<int>(ValueType::u8) == GNO_U8);
static_assert(sizeof(gno_counters::causes) / sizeof(uint64_t) == kCauseCount);

template <class T>
void fill(const Scan& scan, Field field, gno_column& column) {
  const ColumnView<T> view = scan.column<T>(field);
  column.values = view.data();
  column.entries = view.size();
  column.stride = view.stride();
}

}  // namespace
}  // namespace gnosphere::c

using namespace gnosphere;
using namespace gnosphere::c;

extern "C" {

gno_status gno_field_describe(gno_field field, gno_field_description* description) {
  return guard([&] {
    gno_field_description& to = sized(description, "gno_field_description");
    const FieldInfo info = fieldInfo(fieldsOf(&field, 1)[0]);
    to.name = info.name;
    to.type = static_cast<gno_value_type>(info.type);
    to.components = info.components;
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
    gno_scan_info& to = sized(info, "gno_scan_info");
    to.sensor = from->sensor.c_str();
    to.columns = from->columns;
    to.channels = from->channels;
    to.returns = from->returns;
    to.entries = from->ranges.size();
    to.pose = poseOf(from->pose);
  });
}

gno_status gno_scan_get_column(gno_scan scan, gno_field field, gno_column* column) {
  return guard([&] {
    Locked from(scan);
    gno_column& to = sized(column, "gno_column");
    const Field wanted = fieldsOf(&field, 1)[0];
    const FieldInfo info = fieldInfo(wanted);
    switch (info.type) {
      case ValueType::f32: fill<float>(*from, wanted, to); break;
      case ValueType::u8: fill<uint8_t>(*from, wanted, to); break;
      case ValueType::u16: fill<uint16_t>(*from, wanted, to); break;
      case ValueType::u32:
      case ValueType::f64: fill<uint32_t>(*from, wanted, to); break;  // no field has f64
    }
    to.type = static_cast<gno_value_type>(info.type);
    to.components = info.components;
  });
}

gno_status gno_scan_get_counters(gno_scan scan, gno_counters* counters) {
  return guard([&] {
    Locked locked(scan);
    const Counters& from = locked->counters;
    gno_counters& to = sized(counters, "gno_counters");
    to.beams = from.beams;
    to.hits = from.hits;
    to.misses = from.misses;
    to.triangles = from.triangles;
    to.non_finite = from.nonFinite;
    to.degenerate = from.degenerate;
    to.culled_by_cluster = from.culledByCluster;
    to.reused = from.reused;
    to.culled_by_range = from.culledByRange;
    to.culled_by_face = from.culledByFace;
    to.culled_between_beams = from.culledBetweenBeams;
    to.culled_hidden = from.culledHidden;
    to.projected = from.projected;
    to.candidates = from.candidates;
    to.integer_sides = from.integerSides;
    to.integer_ranges = from.integerRanges;
    to.lost_echoes = from.lostEchoes;
    to.retries = from.retries;
    std::copy(from.causes.begin(), from.causes.end(), to.causes);
  });
}

gno_status gno_scan_get_timings(gno_scan scan, gno_timings* timings) {
  return guard([&] {
    gno_timings& to = sized(timings, "gno_timings");
    thread_local Timings from;
    thread_local std::vector<gno_stage_time> stages;
    from = Locked(scan)->timings;
    stages.clear();
    for (const StageTime& stage : from.stages) stages.push_back({stage.name.c_str(), stage.ms});
    to.wall_ms = from.wallMs;
    to.gpu_ms = from.gpuMs;
    to.stages = stages.data();
    to.stage_count = stages.size();
  });
}

}  // extern "C"
