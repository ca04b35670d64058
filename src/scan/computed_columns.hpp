// SPDX-License-Identifier: Apache-2.0
// Columns that need nothing from the device: the host computes them when a scan is made.
#pragma once

#include <vector>

#include "gnosphere/scan.hpp"

namespace gnosphere {

/// Those of one sensor that are asked for: time, azimuth, elevation, class, ring, beam and the return numbers.
class ComputedColumns {
 public:
  ComputedColumns() = default;
  /// Throws Error(invalidArgument) where `ring` is asked for and does not hold the sensor's channels.
  ComputedColumns(const Sensor& sensor, const std::vector<Field>& fields);

  /// Sets them in a scan of the sensor that has its owners and ranges, and removes those that are not asked for.
  /// `classes` are by instance; an instance beyond their end has the class 0.
  void set(const std::vector<uint16_t>& classes, Scan& scan) const;

 private:
  bool asks(Field field) const;

  std::vector<Field> fields_;
  std::vector<float> times_, azimuths_, elevations_;  // by beam; empty where they are not asked for
};

/// Throws Error(invalidArgument) where a ring's 16 bits do not hold so many channels.
void checkRings(uint32_t channels);
/// Counted from 1; 0 where nothing came back.
uint8_t returnNumberOf(const Scan& scan, size_t entry);
/// How many came back of the entry's beam.
uint8_t returnCountOf(const Scan& scan, size_t entry);

}  // namespace gnosphere
