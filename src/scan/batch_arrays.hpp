// SPDX-License-Identifier: Apache-2.0
// Write access to the arrays of a batch.
#pragma once

#include "gnosphere/batch.hpp"
#include "scan/places.hpp"

namespace gnosphere {

class BatchArrays {
 public:
  explicit BatchArrays(Batch& batch) : batch_(batch) {}

  /// Gives the arrays of the fields their size, and removes the others. Memory that exists is reused. The batch has its
  /// numbers of views, beams and returns.
  void make(const std::vector<Field>& fields);
  /// The arrays that every scan has, of all views.
  Places places() { return placesOf(batch_.entries_); }
  /// Copies the batch's fields of a scan to the entries of a view.
  void copy(const Scan& scan, size_t view);

 private:
  Batch& batch_;
};

}  // namespace gnosphere
