// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gnosphere.h>

#include <catch2/catch_test_macros.hpp>
#include <cstring>

namespace gnosphere::test {

/// Whether a call failed with this status, and its sentence has the words.
inline bool fails(gno_status status, const char* words, gno_status expected = GNO_INVALID_ARGUMENT) {
  INFO(status << ": " << gno_last_error());
  CHECK(status == expected);
  CHECK(std::strstr(gno_last_error(), words) != nullptr);
  return status == expected && std::strstr(gno_last_error(), words);
}

}  // namespace gnosphere::test
