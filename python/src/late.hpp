// SPDX-License-Identifier: Apache-2.0
// Arguments that a function of ours reads, whose errors name what is wrong instead of listing overloads.
#pragma once

#include <exception>

#include "bind.hpp"

namespace nanobind::detail {

/// The caster of an argument that read() makes of an object. Errors are thrown when the called function takes it,
/// because nanobind does not let from_python() throw.
template <typename T, T (*read)(handle)>
struct late_caster {
  using Value = T;
  template <typename U>
  using Cast = movable_cast_t<U>;
  template <typename U>
  static constexpr bool can_cast() {
    return true;
  }

  bool from_python(handle source, uint32_t, cleanup_list*) noexcept {
    try {
      value = read(source);
    } catch (...) {
      error = std::current_exception();
    }
    return true;
  }
  explicit operator Value*() { return &checked(); }
  explicit operator Value&() { return checked(); }
  explicit operator Value&&() { return static_cast<Value&&>(checked()); }

 private:
  Value& checked() {
    if (error) std::rethrow_exception(error);
    return value;
  }
  Value value;
  std::exception_ptr error;
};

}  // namespace nanobind::detail
