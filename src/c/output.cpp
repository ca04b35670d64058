// SPDX-License-Identifier: Apache-2.0
// Layouts, scans as packed rows and files, and their comparison.
#include "c/handles.hpp"

namespace gnosphere::c {

RecordLayout recordLayoutOf(const gno_layout* layout) {
  const gno_layout& from = sized(layout, GNO_TYPE(gno_layout));
  RecordLayout result;
  result.stride = from.stride;
  result.compact = from.compact != 0;
  for (const gno_layout_value& value : array(from.values, from.value_count, "gno_layout::values"))
    result.values.push_back({fieldsOf(&value.field, 1)[0], value.component, value.offset,
                             enumOf(value.type, ValueType::u32, "gno_layout_value::type"), value.stride});
  return result;
}

void give(const RecordLayout& layout, std::vector<gno_layout_value>& values, gno_layout& to) {
  values.clear();
  for (const RecordLayout::Value& value : layout.values)
    values.push_back({static_cast<gno_field>(value.field), value.component, value.offset,
                      static_cast<gno_value_type>(value.type), value.stride});
  to.values = values.data();
  to.value_count = values.size();
  to.stride = layout.stride;
  to.compact = layout.compact;
}

}  // namespace gnosphere::c

using namespace gnosphere;
using namespace gnosphere::c;

extern "C" {

gno_status gno_layout_of(const gno_field* fields, size_t field_count, gno_layout* layout) {
  return guard([&] {
    const Out to(layout, GNO_TYPE(gno_layout));
    thread_local std::vector<gno_layout_value> values;
    give(layoutOf(fieldsOf(fields, field_count)), values, *to);
  });
}

gno_status gno_layout_bytes_for(const gno_layout* layout, uint64_t rows, uint64_t* bytes) {
  return guard([&] { the(bytes, "bytes") = recordLayoutOf(layout).bytesFor(rows); });
}

gno_status gno_scan_pack(gno_scan scan, const gno_layout* layout, void* rows, size_t bytes, size_t* row_count) {
  return guard([&] {
    const RecordLayout wanted = recordLayoutOf(layout);
    the(row_count, "row_count");
    Locked from(scan);
    static_cast<void>(wanted.bytesFor(from->ranges.size()));  // throws if the bytes of all rows have no number
    *row_count = pack(*from, wanted, array(static_cast<std::byte*>(rows), bytes, "rows"));
  });
}

gno_status gno_scan_write(gno_scan scan, const char* file, const gno_cloud_options* options) {
  return guard([&] {
    CloudOptions wanted;
    if (options) {
      const gno_cloud_options from = sized(options, GNO_TYPE(gno_cloud_options));
      wanted.fields = fieldsOf(from.fields, from.field_count);
      if (from.compact != 0) wanted.compact = true;
      wanted.ascii = from.ascii != 0;
    }
    writeCloud(*Locked(scan), fileOf(file), wanted);
  });
}

gno_status gno_scan_write_picture(gno_scan scan, const char* file) {
  return guard([&] { writePicture(*Locked(scan), fileOf(file)); });
}

gno_status gno_scan_read(const char* file, gno_scan* scan) {
  return giveHandle(scan, "scan", [&] { return make<gno_scan>(readCloud(fileOf(file))); });
}

gno_status gno_scan_compare(gno_scan reference, gno_scan other, double tolerance, gno_comparison* comparison) {
  return guard([&] {
    const Out to(comparison, GNO_TYPE(gno_comparison));
    const auto first = find(reference);
    const auto second = find(other);
    const std::scoped_lock lock(first->mutex, second->mutex);
    const Comparison from = compare(first->value, second->value, tolerance);
    to->beams = from.beams;
    to->hits = from.hits;
    to->missed = from.missed;
    to->false_hits = from.falseHits;
    to->wrong_owner = from.wrongOwner;
    to->wrong_range = from.wrongRange;
    to->ties = from.ties;
    to->tie_differences = from.tieDifferences;
    to->tie_missed = from.tieMissed;
    to->tie_false_hits = from.tieFalseHits;
    to->tie_wrong_owner = from.tieWrongOwner;
    to->tie_error_max = from.tieErrorMax;
    to->range_error_max = from.rangeErrorMax;
    to->range_error_9999 = from.rangeError9999;
    to->range_error_rms = from.rangeErrorRms;
    to->hit_error_max = from.hitErrorMax;
    to->wrong_point = from.wrongPoint;
    to->point_error_max = from.pointErrorMax;
  });
}

}  // extern "C"
