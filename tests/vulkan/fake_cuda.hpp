// SPDX-License-Identifier: Apache-2.0
// A driver of CUDA that has a device of any UUID, and counts what is alive, but maps no memory.
#pragma once

#include <array>
#include <cstdint>

namespace gnosphere::test {

struct FakeCuda {
  std::array<uint8_t, 16> uuid = {};  ///< of its second device; the first one has no UUID
  int failAt = 0;                     ///< the call, counted from 1, that fails; 0 for none
  int calls = 0;
  int retained = 0, pushed = 0, imported = 0, mapped = 0;  ///< contexts, memories and buffers that are alive
  uint64_t bytes = 0;                                      ///< of the memory that was imported last
};

/// An address that the fake driver gives for imported memory.
inline constexpr uint64_t kFakeAddress = 0x7f00'0000'0000;

}  // namespace gnosphere::test

extern "C" gnosphere::test::FakeCuda* fakeCuda();
