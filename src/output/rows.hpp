// SPDX-License-Identifier: Apache-2.0
// Rows of a scan -> memory: the one way in which pack() and writeCloud() make them.
#pragma once

#include "gnosphere/output.hpp"

namespace gnosphere {

/// Throws Error(invalidArgument) where the scan's arrays do not suit its grid, or it does not have one of the fields.
void checkFields(const Scan& scan, const std::vector<Field>& fields);

/// Which entries of a scan are rows.
class Rows {
 public:
  /// `compact`: what came back; otherwise all.
  Rows(const Scan& scan, bool compact);

  const Scan& scan() const { return scan_; }
  bool compact() const { return compact_; }
  size_t count() const { return count_; }

  /// Writes `count` rows from row `first` on, the first of them to the start of `out`.
  void pack(const RecordLayout& layout, size_t first, size_t count, std::byte* out) const;

 private:
  size_t entryOf(size_t row) const { return compact_ ? entries_[row] : row; }

  const Scan& scan_;
  bool compact_;
  std::vector<size_t> entries_;  // of the rows where `compact`
  size_t count_;
};

}  // namespace gnosphere
