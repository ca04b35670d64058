// SPDX-License-Identifier: Apache-2.0
// NumPy arrays that come in, and views of our memory that go out.
#pragma once

#include <nanobind/ndarray.h>
#include <nanobind/stl/variant.h>

#include <limits>
#include <span>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

#include "late.hpp"

namespace gnosphere::python {

/// An argument that NumPy can make an array of.
struct ArrayLike {
  nb::object object;
};

/// The values of an argument, in C order; it holds the array that has them.
template <typename T>
class ArrayIn {
 public:
  ArrayIn(nb::object array, size_t rows) : array_(nb::cast<Values>(array)), rows_(rows) {}
  std::span<const T> values() const { return {array_.data(), array_.size()}; }
  size_t rows() const { return rows_; }
  size_t width() const { return array_.ndim() == 2 ? array_.shape(1) : 1; }
  std::vector<T> copy() const { return {values().begin(), values().end()}; }

 private:
  using Values = nb::ndarray<const T, nb::device::cpu, nb::c_contig>;
  Values array_;
  size_t rows_;
};

/// Whether a NumPy array holds numbers that fit `T`: any numbers for a float, integers within its limits otherwise.
/// Throws Error(invalidArgument) that begins with `name`.
void checkNumbers(nb::handle array, const std::string& name, const char* type, bool integers, double largest);
/// Rows of any one width.
inline constexpr size_t kAnyWidth = std::numeric_limits<size_t>::max();
/// Makes a NumPy array of any object, or throws Error(invalidArgument), "<name> cannot be made an array<wanted>: ...".
nb::object arrayOrRefuse(nb::handle object, const std::string& name, const std::string& wanted);
/// Makes a NumPy array of shape (n,), or (n, width) if width is not 0, or throws Error(invalidArgument).
nb::object arrayOfShape(const ArrayLike& argument, const std::string& name, size_t width);
nb::object contiguous(nb::handle array, const char* type);

template <typename T>
constexpr const char* dtypeName() {
  if (std::is_same_v<T, float>) return "float32";
  if (std::is_same_v<T, double>) return "float64";
  if (std::is_same_v<T, uint8_t>) return "uint8";
  if (std::is_same_v<T, uint16_t>) return "uint16";
  static_assert(std::is_floating_point_v<T> || std::is_unsigned_v<T>);
  return "uint32";
}

/// Takes an argument as an array of `T`, of shape (n,), or (n, width) if width is not 0; see kAnyWidth. An array that
/// already has the type and C order is not copied. Throws Error(invalidArgument) that begins with `name`.
template <typename T>
ArrayIn<T> arrayOf(const ArrayLike& argument, const std::string& name, size_t width = 0) {
  const nb::object array = arrayOfShape(argument, name, width);
  checkNumbers(array, name, dtypeName<T>(), std::is_integral_v<T>, static_cast<double>(std::numeric_limits<T>::max()));
  return ArrayIn<T>(contiguous(array, dtypeName<T>()), nb::len(array));
}

/// An argument that is a sequence of one of the types, or what NumPy can make an array of.
template <typename... Types>
struct SequenceOrArray {
  nb::object object;
};

/// Whether an argument is a sequence, and neither a text nor an array or a table of numbers.
bool isSequenceOfObjects(nb::handle object);
/// A sequence of which isSequenceOfObjects() is true, with the indices from 0 on. A Series of pandas has labels of its
/// own, so an array is made of it.
nb::object numberedFromZero(nb::handle object);

/// Whether an argument is a sequence whose first entry is a `T`.
template <typename T>
bool firstIs(nb::handle argument) {
  if (!isSequenceOfObjects(argument) || nb::len(argument) == 0) return false;
  return nb::isinstance<T>(nb::object(numberedFromZero(argument)[nb::int_(0)]));
}

/// The entries of a sequence of which firstIs() says that it is one of `T`. Throws a TypeError that begins with `name`
/// and names the first entry of another type.
template <typename T>
std::vector<T> entriesOf(nb::handle argument, const std::string& name) {
  const nb::object sequence = numberedFromZero(argument);
  std::vector<T> entries;
  const size_t size = nb::len(sequence);
  entries.reserve(size);
  for (size_t i = 0; i < size; ++i) {
    const nb::object entry = sequence[nb::int_(i)];
    if (!nb::isinstance<T>(entry))
      throw nb::type_error((name + ": entry 0 is of the type " + typeName(nb::type<T>()) + ", but entry " +
                            std::to_string(i) + " of the type " + typeName(entry.type()) + "; all must be of one type")
                               .c_str());
    entries.push_back(complete<T>(entry));
  }
  return entries;
}

/// An argument that is a list of maps: of Transforms, or an array of shape (n, 3, 4), or (n, 4, 4) whose last rows are
/// 0, 0, 0, 1.
using TransformsLike = SequenceOrArray<Transform>;
/// Throws Error(invalidArgument), or a TypeError, that begins with `name`.
std::vector<Transform> transformsOf(const TransformsLike& argument, const std::string& name);
/// One map, of shape (3, 4) or (4, 4); the errors are those of transformsOf().
Transform transformOf(const ArrayLike& argument, const std::string& name);

/// An argument that is one map: a Transform, or an array of shape (3, 4) or (4, 4).
struct MapLike {
  Transform map;
};
/// Throws Error(invalidArgument), or a TypeError.
MapLike mapLikeOf(nb::handle argument);

/// The poses of rigid maps, an array of shape (n, 3, 4) or (n, 4, 4). Throws Error(invalidArgument) that begins with
/// `name` and names the first entry that is not a rotation and a shift.
std::vector<Pose> posesOfMaps(const nb::object& array, const std::string& name);

/// Makes maps, or an array of poses of shape (n, 7), an array of shape (n, 12) or (n, 7); the errors
/// are those of transformsOf().
nb::object transformRows(const TransformsLike& argument, const std::string& name);
bool isFloat32(nb::handle array);

/// Views, as NumPy arrays of shape (n,) and (n, width), which are read-only if `T` is const.
template <typename T>
using Column = nb::ndarray<nb::numpy, T, nb::ndim<1>>;
template <typename T, size_t width>
using Rows = nb::ndarray<nb::numpy, T, nb::shape<-1, width>>;

/// Returns the array that make.operator()<T>() makes, where T is the type of a field's values.
template <typename Make>
nb::object arrayOfType(ValueType type, const Make& make) {
  switch (type) {
    case ValueType::u8: return make.template operator()<uint8_t>();
    case ValueType::u16: return make.template operator()<uint16_t>();
    case ValueType::u32: return make.template operator()<uint32_t>();
    default: return make.template operator()<float>();
  }
}

/// For properties that return arrays, which have their owner already.
inline constexpr auto kOwned = nb::rv_policy::reference;

/// A view of memory that `owner` keeps.
template <typename T>
Column<T> columnView(T* data, size_t size, nb::handle owner) {
  return Column<T>(data, {size}, owner);
}
template <size_t width, typename T>
Rows<T, width> rowsView(T* data, size_t rows, nb::handle owner) {
  return Rows<T, width>(data, {rows, width}, owner);
}

/// A read-only view of rows whose width only the owner knows.
template <typename T>
nb::ndarray<nb::numpy, const T, nb::ndim<2>> tableView(const T* data, size_t rows, size_t width, nb::handle owner) {
  return nb::ndarray<nb::numpy, const T, nb::ndim<2>>(data, {rows, width}, owner);
}
/// A read-only view of maps, as an array of shape (n, 3, 4).
inline nb::ndarray<nb::numpy, const double, nb::shape<-1, 3, 4>> transformsView(const std::vector<Transform>& maps,
                                                                                nb::handle owner) {
  static_assert(sizeof(Transform) == 12 * sizeof(double), "a list of maps is an array of doubles");
  return nb::ndarray<nb::numpy, const double, nb::shape<-1, 3, 4>>(maps.empty() ? nullptr : maps[0].rows.data(),
                                                                   {maps.size(), 3, 4}, owner);
}

/// Deletes the values when no array shows them any more.
template <typename T>
nb::capsule ownerOf(std::vector<T>* values) {
  return nb::capsule(values, [](void* memory) noexcept { delete static_cast<std::vector<T>*>(memory); });
}
/// An array that has the values as its own.
template <size_t width, typename T>
Rows<T, width> ownedRows(std::vector<T> values) {
  auto* own = new std::vector<T>(std::move(values));
  return Rows<T, width>(own->data(), {own->size() / width, width}, ownerOf(own));
}
template <typename T>
Column<T> ownedColumn(std::vector<T> values) {
  auto* own = new std::vector<T>(std::move(values));
  return Column<T>(own->data(), {own->size()}, ownerOf(own));
}
/// A read-only array with a copy of the values.
template <typename T>
Column<const T> copiedColumn(const std::vector<T>& values) {
  auto* copy = new std::vector<T>(values);
  return Column<const T>(copy->data(), {copy->size()}, ownerOf(copy));
}

}  // namespace gnosphere::python

namespace nanobind::detail {

template <>
struct type_caster<gnosphere::python::ArrayLike> {
  NB_TYPE_CASTER(gnosphere::python::ArrayLike, const_name("numpy.typing.ArrayLike"))
  bool from_python(handle source, uint32_t, cleanup_list*) noexcept {
    value.object = borrow(source);
    return true;
  }
  static handle from_cpp(const gnosphere::python::ArrayLike& array, rv_policy, cleanup_list*) noexcept {
    return array.object.inc_ref();
  }
};

template <>
struct type_caster<gnosphere::python::MapLike>
    : late_caster<gnosphere::python::MapLike, &gnosphere::python::mapLikeOf> {
  static constexpr auto Name = make_caster<gnosphere::Transform>::Name + const_name(" | numpy.typing.ArrayLike");
  static handle from_cpp(const gnosphere::python::MapLike& given, rv_policy, cleanup_list* cleanup) noexcept {
    return make_caster<gnosphere::Transform>::from_cpp(given.map, rv_policy::copy, cleanup);
  }
};

template <typename... Types>
struct type_caster<gnosphere::python::SequenceOrArray<Types...>> {
  using Argument = gnosphere::python::SequenceOrArray<Types...>;
  NB_TYPE_CASTER(Argument,
                 ((const_name("collections.abc.Sequence[") + make_caster<Types>::Name + const_name("] | ")) + ...) +
                     const_name("numpy.typing.ArrayLike"))
  bool from_python(handle source, uint32_t, cleanup_list*) noexcept {
    value.object = borrow(source);
    return true;
  }
  static handle from_cpp(const Argument& argument, rv_policy, cleanup_list*) noexcept {
    return argument.object.inc_ref();
  }
};

}  // namespace nanobind::detail
