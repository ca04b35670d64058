// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <catch2/catch_test_macros.hpp>
#include <concepts>
#include <string>

#include "gnosphere/error.hpp"

namespace gnosphere::test {

/// Returns the message of the Error with this code that `work` throws, or that nothing was wrong.
template <std::invocable Work>
std::string problemOf(const Work& work, ErrorCode code = ErrorCode::invalidArgument) {
  try {
    work();
  } catch (const Error& error) {
    CHECK(error.code() == code);
    return error.what();
  }
  return "nothing was wrong";
}

}  // namespace gnosphere::test
