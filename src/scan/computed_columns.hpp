// SPDX-License-Identifier: Apache-2.0
// Columns that the host computes, without data from the device.
#pragma once

#include <vector>

#include "gnosphere/scan.hpp"
#include "scan/class_table.hpp"
#include "scan/image_order.hpp"

namespace gnosphere {

/// Computes the requested columns of one sensor among time, azimuth, elevation, class, ring, beam and the return
/// numbers. A list that states rings always has that column, because they do not follow from the index.
class ComputedColumns {
 public:
  ComputedColumns() = default;
  /// Throws Error(invalidArgument) if `ring` is requested and the sensor has too many channels for it.
  ComputedColumns(const Sensor& sensor, const std::vector<Field>& fields);

  /// Sets the requested columns in a scan whose owners and ranges are complete, and removes the others; sets how its
  /// image lies, too. `frame` is the number of the scan.
  void set(const ClassTable& classes, uint64_t frame, Scan& scan) const;

 private:
  bool asks(Field field) const;

  // Values by beam; empty if not requested.
  struct Values {
    std::vector<float> times, azimuths, elevations;
    std::vector<uint16_t> rings;
  };

  std::vector<Field> fields_;
  ImageOrder order_;
  std::vector<Values> patterns_;  // a grid has one
};

/// Throws Error(invalidArgument) if there are more channels than the 16 bits of `ring` can number.
void checkRings(uint32_t channels);
/// Returns the number of the return within its beam, from 1; 0 for an entry without a return.
uint8_t returnNumberOf(const Scan& scan, size_t entry);
/// Returns the number of returns of the entry's beam.
uint8_t returnCountOf(const Scan& scan, size_t entry);

}  // namespace gnosphere
