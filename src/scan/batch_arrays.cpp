// SPDX-License-Identifier: Apache-2.0
#include "scan/batch_arrays.hpp"

#include <algorithm>
#include <cstring>

#include "scan/columns.hpp"
#include "scan/fields.hpp"

namespace gnosphere {
namespace {

bool asks(const std::vector<Field>& fields, Field field) {
  return std::find(fields.begin(), fields.end(), field) != fields.end();
}

template <typename T>
void copyArray(const std::vector<T>& from, size_t view, std::vector<T>& to) {
  if (!to.empty()) std::copy(from.begin(), from.end(), to.begin() + static_cast<ptrdiff_t>(view * from.size()));
}

}  // namespace

void BatchArrays::make(const std::vector<Field>& fields) {
  Scan& all = batch_.entries_;
  const size_t entries = batch_.views * batch_.beams * batch_.returns;
  all.returns = batch_.returns;
  all.ranges.resize(entries);
  const bool points = asks(fields, Field::x) || asks(fields, Field::y) || asks(fields, Field::z);
  all.points.resize(points ? 3 * entries : 0);
  all.triangles.resize(asks(fields, Field::triangle) ? entries : 0);
  all.instances.resize(asks(fields, Field::instance) ? entries : 0);
  ScanColumns columns(all);
  columns.setUnknown(Field::x, !points);
  for (const Field owner : {Field::triangle, Field::instance}) columns.setUnknown(owner, !asks(fields, owner));
  batch_.made_ = true;
  for (size_t i = 0; i < kFieldCount; ++i) {
    const auto field = static_cast<Field>(i);
    if (!isOfEveryScan(field)) columns.make(field, asks(fields, field));
  }
}

void BatchArrays::copy(const Scan& scan, size_t view) {
  Scan& all = batch_.entries_;
  copyArray(scan.ranges, view, all.ranges);
  copyArray(scan.points, view, all.points);
  copyArray(scan.triangles, view, all.triangles);
  copyArray(scan.instances, view, all.instances);
  ScanColumns to(all), from(const_cast<Scan&>(scan));
  for (size_t i = 0; i < kFieldCount; ++i) {
    const auto field = static_cast<Field>(i);
    std::byte* const bytes = isOfEveryScan(field) ? nullptr : to.bytes(field);
    if (!bytes) continue;
    const size_t count = scan.ranges.size() * fieldInfo(field).components * sizeOf(fieldInfo(field).type);
    std::memcpy(bytes + view * count, from.bytes(field), count);
  }
}

}  // namespace gnosphere
