// SPDX-License-Identifier: Apache-2.0
#include <ctime>

#include "readers.hpp"

// Tapes make their calls at their times, for which the fuzzer does not wait.
extern "C" int nanosleep(const timespec*, timespec*) {
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  gnosphere::fuzzReaders({data, size});
  return 0;
}
