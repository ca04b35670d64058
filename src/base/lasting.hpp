// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <utility>

// GCC from 13 on takes a reference that a function returns for one into its argument, if it is not told otherwise.
#if __has_cpp_attribute(gnu::no_dangling)
#define GNO_NO_DANGLING [[gnu::no_dangling]]
#else
#define GNO_NO_DANGLING
#endif

namespace gnosphere {

/// An object that is never destroyed. Static objects are destroyed when the process ends, while other threads may still
/// call the library.
template <typename T>
GNO_NO_DANGLING const T& lasting(T value) {
  return *new T(std::move(value));
}

}  // namespace gnosphere
