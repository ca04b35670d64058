// SPDX-License-Identifier: Apache-2.0
// Vec3 and Quaternion are tuples of numbers in Python; every sequence of as many numbers is taken for one.
#pragma once

#include <nanobind/nanobind.h>

#include <gnosphere/scene.hpp>

namespace gnosphere::python {

/// Reads `size` numbers of a sequence. Returns false, without a Python exception, for anything else.
inline bool readNumbers(PyObject* source, Py_ssize_t size, double* numbers) noexcept {
  if (!PySequence_Check(source) || PyUnicode_Check(source) || PySequence_Size(source) != size) {
    PyErr_Clear();
    return false;
  }
  for (Py_ssize_t i = 0; i < size; ++i) {
    PyObject* item = PySequence_GetItem(source, i);
    numbers[i] = item ? PyFloat_AsDouble(item) : 0;
    Py_XDECREF(item);
    if (PyErr_Occurred()) {
      PyErr_Clear();
      return false;
    }
  }
  return true;
}

}  // namespace gnosphere::python

namespace nanobind::detail {

template <>
struct type_caster<gnosphere::Vec3> {
  NB_TYPE_CASTER(gnosphere::Vec3, io_name("numpy.typing.ArrayLike", "tuple[float, float, float]"))
  bool from_python(handle source, uint32_t, cleanup_list*) noexcept {
    double v[3];
    if (!gnosphere::python::readNumbers(source.ptr(), 3, v)) return false;
    value = {v[0], v[1], v[2]};
    return true;
  }
  static handle from_cpp(const gnosphere::Vec3& v, rv_policy, cleanup_list*) noexcept {
    return Py_BuildValue("(ddd)", v.x, v.y, v.z);
  }
};

template <>
struct type_caster<gnosphere::Quaternion> {
  NB_TYPE_CASTER(gnosphere::Quaternion, io_name("numpy.typing.ArrayLike", "tuple[float, float, float, float]"))
  bool from_python(handle source, uint32_t, cleanup_list*) noexcept {
    double q[4];
    if (!gnosphere::python::readNumbers(source.ptr(), 4, q)) return false;
    value = {q[0], q[1], q[2], q[3]};
    return true;
  }
  static handle from_cpp(const gnosphere::Quaternion& q, rv_policy, cleanup_list*) noexcept {
    return Py_BuildValue("(dddd)", q.x, q.y, q.z, q.w);
  }
};

}  // namespace nanobind::detail
