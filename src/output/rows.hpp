// SPDX-License-Identifier: Apache-2.0
// Packs rows of a scan into memory, for both pack() and writeCloud().
#pragma once

#include "gnosphere/output.hpp"

namespace gnosphere {

/// Throws Error(invalidArgument) if the sizes of the scan's arrays do not match its grid, or if it lacks a field.
void checkFields(const Scan& scan, const std::vector<Field>& fields);

/// The entries of a scan that become rows.
class Rows {
 public:
  /// If `compact`, only entries with a return become rows; otherwise all do. With `ties`, a beam without a return that
  /// the reference has marked as a tie has a row, too.
  Rows(const Scan& scan, bool compact, bool ties = false);

  const Scan& scan() const { return scan_; }
  bool compact() const { return compact_; }
  size_t count() const { return count_; }

  /// Writes the rows first..first + count - 1 to the start of `out`.
  void pack(const RecordLayout& layout, size_t first, size_t count, std::byte* out) const;

 private:
  size_t entryOf(size_t row) const { return compact_ ? entries_[row] : row; }

  const Scan& scan_;
  bool compact_;
  std::vector<size_t> entries_;  // entry of each row if `compact`; otherwise empty
  size_t count_;
};

}  // namespace gnosphere
