// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <queue>
#include <vector>

#include "output/cloud_file.hpp"

namespace gnosphere {

/// Accumulates a Comparison over many scans in little memory.
class ComparisonSum {
 public:
  /// All scans together must have no more than `returns` returns: from it follows how many of the largest errors are
  /// kept for the percentile.
  ComparisonSum(uint64_t returns, double tolerance);
  /// Compares two clouds and adds the comparison; throws as compare() does.
  void add(const Scan& reference, const Scan& other);
  /// Compares the clouds of two files; throws as compareFiles() does.
  void add(const CloudFile& reference, const CloudFile& other);
  Comparison result() const;
  /// The number of returns that the range errors cover.
  uint64_t sameOwner() const { return errors_; }

 private:
  /// Whether the reference marks any return of the beam as a tie. Files keep no rows for missing returns.
  bool inTie(size_t beam, size_t returns) const;
  void addBeams(const Scan& reference, const Scan& other);
  void addReturn(const Scan& reference, const Scan& other, size_t beam, size_t k);
  /// Compares the points of two entries, which may be apart by `allowed` metres and their rounding.
  void addPoints(const Scan& reference, const Scan& other, size_t expected, size_t found, double allowed);
  void keep(double error);

  ColumnView<uint8_t> ties_;  // of the reference that is being added; empty where it states none
  ColumnView<float> tolerances_;
  bool points_ = false;  // whether both clouds that are being added have them
  Origin centre_ = {};   // roundingCentre() of the clouds that are being added, from their common origin
  Comparison sum_;
  double tolerance_;
  uint64_t errors_ = 0;
  double squares_ = 0;
  size_t kept_;
  std::priority_queue<double, std::vector<double>, std::greater<>> largest_;
};

}  // namespace gnosphere
