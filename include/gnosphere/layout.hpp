// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "gnosphere/scan.hpp"

namespace gnosphere {

/// Describes how a row lies in memory: which values it has, and where each of them is. The bytes of a row that no value
/// has become 0 on a device, and pack() leaves them as they are.
struct RecordLayout {
  struct Value {
    Field field = Field::x;
    uint32_t component = 0;
    size_t offset = 0;  ///< bytes from the start of the row; no alignment is needed
    /// The field's own type, or a type that holds all of its values: f64 holds every type, f32 holds u8 and u16, and an
    /// unsigned integer holds shorter unsigned integers.
    ValueType type = ValueType::f32;
    /// 0 if the value is part of the row. Otherwise the values of all rows form a column that begins at byte `offset`
    /// of the buffer, a multiple of 4, with a value every `stride` bytes: the size of the type, or a larger multiple
    /// of 4, where a value of 1 or 2 bytes takes a word of 4, in which 0 follows. Only results that stay on a device
    /// may have columns; a Scan has Scan::column().
    size_t stride = 0;
  };
  std::vector<Value> values;
  size_t stride = 0;  ///< bytes from row to row; 0 if all values are in columns
  /// If true, only entries with a return become rows; otherwise every entry of the scan does.
  bool compact = false;

  bool empty() const { return values.empty(); }
  /// Returns the bytes that so many rows need on a device: a multiple of 4. Throws Error(invalidArgument) if they are
  /// more than 62 bits number.
  GNOSPHERE_API uint64_t bytesFor(uint64_t rows) const;
};

/// Header of the results of a recorded scan, in device memory. The first four numbers are the arguments of an indirect
/// draw with a vertex per row (VkDrawIndirectCommand).
struct RecordHeader {
  uint32_t rows = 0;           ///< in the buffer
  uint32_t instanceCount = 1;  ///< always 1
  uint32_t firstVertex = 0, firstInstance = 0;
  uint32_t wanted = 0;      ///< rows that the scan has; more than `rows` if the buffer is too small
  uint32_t hits = 0;        ///< returns of all beams, of which one may have several
  uint32_t incomplete = 0;  ///< not 0 if a list was too small, so that hits may be missing
  uint32_t frame = 0;       ///< low 32 bits of Shot::frame
};

}  // namespace gnosphere
