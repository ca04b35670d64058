// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <utility>

namespace gnosphere {

/// An object that is never destroyed. Static objects are destroyed when the process ends, while other threads may still
/// call the library.
template <typename T>
const T& lasting(T value) {
  return *new T(std::move(value));
}

}  // namespace gnosphere
