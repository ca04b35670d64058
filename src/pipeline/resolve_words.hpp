// SPDX-License-Identifier: Apache-2.0
// Stage resolve where nothing but geometry is planned: what beams have met, 8 bytes each, becomes the cloud on the
// host, which has to write every byte of it anyway. The device would write it once before.
#pragma once

#include "geometry/instance_table.hpp"
#include "gnosphere/scan.hpp"
#include "pipeline/beam_tables.hpp"

namespace gnosphere {

/// As `bin` leaves it: the bits of the range and the number of the placed triangle; both kNone where nothing was met.
struct Word {
  uint32_t triangle, range;
};

/// `words`: one per beam, row by row. Writes points, ranges and owners of rows first..end - 1, the same bytes as
/// resolve.comp. `exact`: azimuths that are offset lie on the lattice. Returns the hits.
uint64_t resolveWords(const Word* words, const BeamTables& tables, bool exact, const InstanceTable& instances,
                      uint32_t first, uint32_t end, Scan& scan);

}  // namespace gnosphere
