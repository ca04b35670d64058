// SPDX-License-Identifier: Apache-2.0
// Converts the echoes of a beam to its entries in a Scan.
#pragma once

#include "reference/beam.hpp"

namespace gnosphere::reference {

/// Judges the beams of one shot.
class Judge {
 public:
  Judge(const View& view, const Shot& shot, const BeamEffects& effects);
  /// Writes all entries of a beam, and returns the cause of its result. Adds its lost echoes to `lost`.
  Cause judge(size_t index, Scan& scan, uint64_t& lost) const;

 private:
  /// Properties that the entries of a beam share.
  struct Reported;

  void store(const Reported& beam, const Return& value, size_t at, Scan& scan) const;
  void storeSurface(const Reported& beam, const Hit& hit, size_t at, Scan& scan) const;
  void storeMotion(const Reported& beam, const Return& value, size_t at, Scan& scan) const;

  const View& view_;
  const Shot& shot_;
  const BeamEffects& effects_;
  Receiver receiver_;
  std::vector<bool> silent_;  // by beam
  bool deskew_;
};

}  // namespace gnosphere::reference
