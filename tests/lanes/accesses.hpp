// SPDX-License-Identifier: Apache-2.0
// Device memory whose accesses are watched. The kernels are compiled with the instrumentation of ThreadSanitizer, which
// calls a function before each load and store; these functions are defined here instead of in its runtime library.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace gnosphere::lanes {

/// Allocates watched memory, aligned to 256 bytes; its name is part of findings.
std::byte* allocate(const char* name, uint64_t bytes);
void release(void* memory);

enum class Access : uint8_t { read, write, atomic };

/// Checks an access of the current lane against those of other lanes in the same dispatch, then lets others run. Ends
/// the dispatch with a finding if they are not ordered: a write with anything, or an atomic with a plain read, unless
/// it is one that the kernels allow, see plainReadsBesideAtomics().
void touch(const void* address, size_t bytes, Access access);

/// Arrays whose elements kernels read plainly while others change them atomically. The value read may be old; each row
/// says why this is right.
struct PlainRead {
  const char* array;
  const char* reason;
};
std::span<const PlainRead> plainReadsBesideAtomics();

}  // namespace gnosphere::lanes
