// SPDX-License-Identifier: Apache-2.0
// Vec3 and Quaternion are tuples of numbers in Python; every sequence or array of as many numbers is taken for one.
#pragma once

#include <nanobind/nanobind.h>

#include <array>
#include <exception>
#include <gnosphere/scene.hpp>
#include <string>

#include "faults.hpp"

namespace gnosphere::python {

/// Whether NumPy can make an array of an object that is no sequence, such as a tensor.
inline bool isArray(PyObject* source) {
  return PyObject_HasAttrString(source, "__array__") || PyObject_HasAttrString(source, "__dlpack__") ||
         PyObject_CheckBuffer(source);
}

/// Whether an argument is a masked array of NumPy that has masked entries, whose values mean nothing. Throws
/// only exceptions that isNoFault() is true for.
bool hasMaskedEntries(nanobind::handle object);
/// A NumPy array of an argument, also of an object that knows nothing but DLPack. Throws what NumPy raises, and a
/// ValueError of Python if hasMaskedEntries() is true.
nanobind::object asArray(nanobind::handle object);

/// The numbers of an array as a list, or an object that is not valid if it does not have one dimension. Throws
/// only exceptions that isNoFault() is true for.
inline nanobind::object listOf(PyObject* source) {
  namespace nb = nanobind;
  try {
    const nb::object array = asArray(source);
    if (nb::cast<size_t>(array.attr("ndim")) == 1) return array.attr("tolist")();
  } catch (const nb::python_error& error) {
    if (isNoFault(error)) throw;
  }
  return {};
}

/// Reads the numbers of a sequence. Returns how many it has, or -1 for anything else. If it has not `size` of them,
/// the function reads none, and it throws only exceptions that isNoFault() is true for.
inline Py_ssize_t readNumbers(PyObject* source, Py_ssize_t size, double* numbers) {
  const Py_ssize_t count = PySequence_Size(source);
  if (count < 0) forgetFault();
  if (count != size) return count;
  for (Py_ssize_t i = 0; i < size; ++i) {
    const auto item = nanobind::steal(PySequence_GetItem(source, i));
    numbers[i] = item.is_valid() ? PyFloat_AsDouble(item.ptr()) : 0;
    if (!PyErr_Occurred()) continue;
    forgetFault();
    return -1;
  }
  return count;
}

/// The result of readVector() for an array with masked entries.
inline constexpr Py_ssize_t kMasked = PY_SSIZE_T_MAX;

/// As readNumbers(), of a sequence or an array. A Series of pandas is a sequence whose indices are labels of its own,
/// so what can become an array does.
inline Py_ssize_t readVector(PyObject* source, Py_ssize_t size, double* numbers) {
  if (PyUnicode_Check(source) || PyBytes_Check(source)) return -1;
  if (PyTuple_Check(source) || PyList_Check(source) || !isArray(source)) return readNumbers(source, size, numbers);
  if (hasMaskedEntries(source)) return kMasked;
  const nanobind::object list = listOf(source);
  return list.is_valid() ? readNumbers(list.ptr(), size, numbers) : -1;
}

/// A colour with its alpha.
struct Color {
  std::array<float, 4> rgba = {};
};

/// The names of the numbers of a vector, for messages.
inline const char* namesOf(const Vec3*) {
  return "x, y, z";
}
inline const char* namesOf(const Quaternion*) {
  return "x, y, z, w";
}
inline const char* namesOf(const Color*) {
  return "red, green, blue, alpha";
}
inline void setNumbers(const std::array<double, 3>& from, Vec3& to) {
  to = {from[0], from[1], from[2]};
}
inline void setNumbers(const std::array<double, 4>& from, Quaternion& to) {
  to = {from[0], from[1], from[2], from[3]};
}
inline void setNumbers(const std::array<double, 4>& from, Color& to) {
  for (size_t i = 0; i < 4; ++i) to.rgba[i] = static_cast<float>(from[i]);
}

}  // namespace gnosphere::python

namespace nanobind::detail {

/// Takes `size` numbers for a `Vector`. A sequence of another length is a TypeError that tells the two numbers;
/// anything else does not fit, so that another overload may. Errors are thrown when the called function takes it,
/// because nanobind does not let from_python() throw.
template <typename Vector, Py_ssize_t size>
struct numbers_caster {
  using Value = Vector;
  template <typename T>
  using Cast = movable_cast_t<T>;
  template <typename T>
  static constexpr bool can_cast() {
    return true;
  }

  bool from_python(handle source, uint32_t, cleanup_list*) noexcept {
    std::array<double, size> numbers = {};
    try {
      count = gnosphere::python::readVector(source.ptr(), size, numbers.data());
    } catch (...) {
      error = std::current_exception();
      return true;
    }
    gnosphere::python::setNumbers(numbers, value);
    return count >= 0;
  }
  explicit operator Value*() { return &checked(); }
  explicit operator Value&() { return checked(); }
  explicit operator Value&&() { return static_cast<Value&&>(checked()); }

 private:
  Value& checked() {
    if (error) std::rethrow_exception(error);
    if (count == gnosphere::python::kMasked)
      throw type_error("a vector has masked entries; numpy.ma.filled() gives them values");
    if (count != size)
      throw type_error(("a vector of " + std::to_string(size) + " numbers (" + gnosphere::python::namesOf(&value) +
                        ") is wanted, not one of " + std::to_string(count))
                           .c_str());
    return value;
  }
  Value value;
  Py_ssize_t count = size;
  std::exception_ptr error;
};

template <>
struct type_caster<gnosphere::python::Color> : numbers_caster<gnosphere::python::Color, 4> {
  static constexpr auto Name = const_name("numpy.typing.ArrayLike");
};

template <>
struct type_caster<gnosphere::Vec3> : numbers_caster<gnosphere::Vec3, 3> {
  static constexpr auto Name = io_name("numpy.typing.ArrayLike", "tuple[float, float, float]");
  static handle from_cpp(const gnosphere::Vec3& v, rv_policy, cleanup_list*) noexcept {
    return Py_BuildValue("(ddd)", v.x, v.y, v.z);
  }
};

template <>
struct type_caster<gnosphere::Quaternion> : numbers_caster<gnosphere::Quaternion, 4> {
  static constexpr auto Name = io_name("numpy.typing.ArrayLike", "tuple[float, float, float, float]");
  static handle from_cpp(const gnosphere::Quaternion& q, rv_policy, cleanup_list*) noexcept {
    return Py_BuildValue("(dddd)", q.x, q.y, q.z, q.w);
  }
};

}  // namespace nanobind::detail
