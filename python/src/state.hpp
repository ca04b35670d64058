// SPDX-License-Identifier: Apache-2.0
// Copying and pickling of results that are plain numbers and texts.
#pragma once

#include <nanobind/stl/tuple.h>

#include <tuple>

#include "bind.hpp"

namespace gnosphere::python {

/// Lets Python copy and pickle objects of a class by the values of these members. The class must have no others.
template <auto... kMembers, typename Class>
void bindState(nb::class_<Class>& type) {
  type.def("__getstate__", [](const Class& self) { return std::make_tuple(self.*kMembers...); });
  type.def("__setstate__", [](Class& self, decltype(std::make_tuple(std::declval<Class&>().*kMembers...)) state) {
    new (&self) Class();
    std::tie(self.*kMembers...) = std::move(state);
  });
}

}  // namespace gnosphere::python
