// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <queue>
#include <vector>

#include "gnosphere/output.hpp"

namespace gnosphere {

/// Accumulates a Comparison over many scans in little memory.
class ComparisonSum {
 public:
  /// `beams` is the number of beams in all scans; it decides how many of the largest errors are kept for the
  /// percentile.
  ComparisonSum(uint64_t beams, double tolerance);
  /// Compares two clouds and adds the comparison; throws as compare() does.
  void add(const Scan& reference, const Scan& other);
  Comparison result() const;

 private:
  /// Whether the reference marks any return of the beam as a tie. Files keep no rows for missing returns.
  bool inTie(size_t beam, size_t returns) const;
  void addReturn(const Scan& reference, const Scan& other, size_t beam, size_t k);
  void keep(double error);

  ColumnView<uint8_t> ties_;  // of the reference that is being added; empty where it states none
  ColumnView<float> tolerances_;
  Comparison sum_;
  double tolerance_;
  uint64_t errors_ = 0;
  double squares_ = 0;
  size_t kept_;
  std::priority_queue<double, std::vector<double>, std::greater<>> largest_;
};

}  // namespace gnosphere
