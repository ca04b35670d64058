// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <vector>

#include "gnosphere/scan.hpp"

namespace gnosphere {

/// The results of many shots of one sensor. A shot of a batch is a view, and the arrays hold the entries of the first
/// view, then those of the second, and so on: entry (view * beams + beam) * returns + k is the beam's k-th return in
/// that view. An entry has the bytes that it has in the Scan of the shot. A batch always has ranges; it has the other
/// fields if it was asked for them.
class Batch {
 public:
  std::string sensor;
  uint32_t columns = 0;
  uint32_t channels = 0;
  uint32_t returns = 1;  ///< entries per beam
  size_t views = 0;
  size_t beams = 0;   ///< per view
  Counters counters;  ///< sums over the views
  Timings timings;    ///< of all views together

  std::span<const float> ranges() const { return entries_.ranges; }  ///< metres along the beam
  std::span<const float> points() const { return entries_.points; }  ///< x, y, z per entry, in the sensor frame
  std::span<const uint32_t> triangles() const { return entries_.triangles; }  ///< index within the instance's mesh
  std::span<const uint32_t> instances() const { return entries_.instances; }  ///< index into Scene::instances

  /// Returns the values of one component of a field, as Scan::column() does, of all entries of all views. Throws
  /// Error(invalidArgument) as that does.
  template <typename T>
  ColumnView<T> column(Field field, uint32_t component = 0) const {
    return entries_.column<T>(field, component);
  }
  /// Returns whether column() has the field, also if the batch has no views. A new batch has ranges alone.
  bool has(Field field) const { return field == Field::range || (made_ && entries_.has(field)); }
  size_t entries() const { return entries_.ranges.size(); }

 private:
  friend class BatchArrays;
  Scan entries_;  ///< of all views, as if they were one scan
  bool made_ = false;
};

}  // namespace gnosphere
