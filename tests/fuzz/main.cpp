// SPDX-License-Identifier: Apache-2.0
#include "readers.hpp"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  gnosphere::fuzzReaders({data, size});
  return 0;
}
