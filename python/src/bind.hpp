// SPDX-License-Identifier: Apache-2.0
// The bindings, by header of include/gnosphere.
//
// Two rules keep Python from reading memory that C++ has given back. An object that stands in a list (a Channel, a
// Stamp, a Volume) is never changed after it is made, and lists are read as tuples of copies and assigned whole. A
// Scene's lists keep their length, so their elements are handed out by reference and can be changed in place.
//
// A call that works without the GIL first copies its arguments, or shares the results among them, while it has the GIL;
// then it makes a ReleasedGil. A Scene is too large for that, so its users must not change it meanwhile.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string_view.h>
#include <nanobind/stl/vector.h>

#include <gnosphere/gnosphere.hpp>

#include "gil.hpp"
#include "text.hpp"
#include "vectors.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace gnosphere::python {

void bindErrors(nb::module_& m);
void bindScene(nb::module_& m);
void bindMesh(nb::module_& m);
void bindAnimation(nb::module_& m);
void bindStates(nb::module_& m);
void bindSensor(nb::module_& m);
void bindEffects(nb::module_& m);
void bindMaterials(nb::module_& m);
void bindPlan(nb::module_& m);
void bindScan(nb::module_& m);
void bindBatch(nb::module_& m);
void bindBatchStream(nb::module_& m);
void bindOutput(nb::module_& m);
void bindDevices(nb::module_& m);
void bindOptions(nb::module_& m);
void bindSimulator(nb::module_& m);
void bindDrive(nb::module_& m);
void bindRos2(nb::module_& m);
void bindCommandLine(nb::module_& m);

[[noreturn]] inline void refuse(const std::string& sentence) {
  throw Error(ErrorCode::invalidArgument, sentence);
}

inline std::string typeName(nb::handle type) {
  return nb::cast<std::string>(type.attr("__name__"));
}

/// Returns the name of a type behind its article, for messages: "a set", "an int".
inline std::string aTypeName(nb::handle type) {
  const std::string name = typeName(type);
  const bool vowel = std::string_view("aeioAEIO").find(name.front()) != std::string_view::npos;
  return (vowel ? "an " : "a ") + name;
}

/// Returns the value in an object of a class of ours, or of one derived from it. Throws a TypeError if it was not made.
template <typename T>
const T& complete(nb::handle object) {
  if (nb::inst_ready(object)) return nb::cast<const T&>(object);
  const std::string name = typeName(object.type());
  throw nb::type_error(
      ("an object of the class " + name + " was not made: " + name + ".__init__() must call super().__init__()")
          .c_str());
}

/// Gives a UserWarning at the line of Python that calls. Where warnings are made errors, it throws.
inline void warnUser(const std::string& sentence) {
  if (PyErr_WarnFormat(PyExc_UserWarning, 1, "%U", nb::cast(sentence).ptr()) != 0) throw nb::python_error();
}

/// tuple[T, ...]
template <typename T>
using Tuple = nb::typed<nb::tuple, T, nb::ellipsis>;

template <typename T, typename Element>
Tuple<T> makeTuple(size_t size, Element&& element) {
  nb::list list;
  for (size_t i = 0; i < size; ++i) list.append(element(i));
  return Tuple<T>(nb::tuple(list));
}

/// Returns copies of the values as a tuple.
template <typename T>
Tuple<T> tupleOf(const std::vector<T>& values) {
  return makeTuple<T>(values.size(), [&](size_t i) { return nb::cast(values[i], nb::rv_policy::copy); });
}

/// A tuple of references to the elements; each keeps the owner alive. The list must never change its length.
template <typename T>
Tuple<T> elementsOf(nb::handle owner, std::vector<T>& values) {
  return makeTuple<T>(values.size(),
                      [&](size_t i) { return nb::cast(values[i], nb::rv_policy::reference_internal, owner); });
}

/// Defines a property that reads a list as a tuple of copies.
template <typename Class, typename T>
void readTuple(nb::class_<Class>& type, const char* name, std::vector<T> Class::*list, const char* doc) {
  type.def_prop_ro(
      name, [list](const Class& self) { return tupleOf(self.*list); }, doc);
}

/// Defines a property that reads a list as a tuple of copies and is assigned whole.
template <typename Class, typename T>
void readWriteTuple(nb::class_<Class>& type, const char* name, std::vector<T> Class::*list, const char* doc) {
  type.def_prop_rw(
      name, [list](const Class& self) { return tupleOf(self.*list); },
      [list](Class& self, std::vector<T> values) { self.*list = std::move(values); }, doc);
}

/// Defines a property that reads a copy of a member and assigns it.
template <typename Class, typename T>
void readWriteCopy(nb::class_<Class>& type, const char* name, T Class::*member, const char* doc) {
  type.def_prop_rw(
      name, [member](const Class& self) { return self.*member; },
      [member](Class& self, T value) { self.*member = std::move(value); }, doc);
}

}  // namespace gnosphere::python
