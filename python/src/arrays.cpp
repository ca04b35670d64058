// SPDX-License-Identifier: Apache-2.0
#include "arrays.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/transform.hpp"
#include "drive/pose_math.hpp"

namespace gnosphere::python {
namespace {

nb::module_ numpy() {
  return nb::module_::import_("numpy");
}

std::string text(nb::handle object) {
  return nb::cast<std::string>(nb::str(object));
}

/// The type and the message of an exception as one line, without the traceback that what() has.
std::string lineOf(const nb::python_error& error) {
  const std::string message = text(error.value());
  return typeName(error.type()) + ": " + message.substr(0, message.find('\n'));
}

/// Makes an array of shape (n, 4, 4) one of shape (n, 3, 4), which lacks the last rows. Throws Error(invalidArgument)
/// that names the first entry whose last row is not 0, 0, 0, 1.
nb::object withoutLastRows(const nb::object& array, const std::string& name) {
  const nb::object all = nb::slice(nb::none(), nb::none(), nb::none());
  const nb::object last = array.attr("__getitem__")(nb::make_tuple(all, 3));
  const nb::object differs = last.attr("__ne__")(nb::make_tuple(0, 0, 0, 1)).attr("any")("axis"_a = 1);
  if (nb::cast<bool>(nb::bool_(differs.attr("any")()))) {
    const nb::object entry = differs.attr("argmax")();
    refuse(name + ": the last row of entry " + text(entry) + " is " +
           text(last.attr("__getitem__")(entry).attr("tolist")()) + "; that of an affine map is [0, 0, 0, 1]");
  }
  return array.attr("__getitem__")(nb::make_tuple(all, nb::slice(nb::none(), nb::int_(3), nb::none())));
}

/// The length of an array along an axis; 0 for an axis that it does not have.
size_t lengthAlong(const nb::object& array, size_t axis) {
  const nb::tuple shape = nb::cast<nb::tuple>(array.attr("shape"));
  return axis < nb::len(shape) ? nb::cast<size_t>(shape[axis]) : 0;
}

size_t dimensionsOf(const nb::object& array) {
  return nb::cast<size_t>(array.attr("ndim"));
}

/// Makes an array of maps, shape (n, 3, 4) or (n, 4, 4), one of shape (n, 12); an empty list has no maps. Returns none
/// for another shape. Throws Error(invalidArgument) as withoutLastRows() does.
nb::object rowsOfMaps(nb::object array, const std::string& name) {
  if (dimensionsOf(array) == 1 && lengthAlong(array, 0) == 0) return array.attr("reshape")(0, 12);
  if (dimensionsOf(array) != 3 || lengthAlong(array, 2) != 4) return nb::none();
  if (lengthAlong(array, 1) == 4) array = withoutLastRows(array, name);
  if (lengthAlong(array, 1) != 3) return nb::none();
  return array.attr("reshape")(lengthAlong(array, 0), 12);
}

/// The quaternion of the linear part of a map; none unless it is a rotation within 0.001.
std::optional<Quaternion> rotationOf(const Transform& map) {
  const auto m = [&](size_t row, size_t column) { return map.rows[4 * row + column]; };
  for (size_t i = 0; i < 3; ++i)
    for (size_t j = 0; j < 3; ++j) {
      const double product = m(0, i) * m(0, j) + m(1, i) * m(1, j) + m(2, i) * m(2, j);
      if (!(std::abs(product - (i == j ? 1 : 0)) <= 1e-3)) return std::nullopt;
    }
  if (!(determinant(map) > 0)) return std::nullopt;
  const auto row = [&](size_t i) { return Vec3{m(i, 0), m(i, 1), m(i, 2)}; };
  return drive::quaternionOf({row(0), row(1), row(2)});
}

}  // namespace

bool hasMaskedEntries(nb::handle object) {
  const nb::object mask = nb::steal(PyObject_GetAttrString(object.ptr(), "mask"));
  if (!mask.is_valid()) {
    forgetFault();
    return false;
  }
  try {
    return nb::cast<bool>(numpy().attr("ma").attr("is_masked")(object));
  } catch (const nb::python_error& error) {
    if (isNoFault(error)) throw;
    return false;
  }
}

nb::object asArray(nb::handle object) {
  const bool onlyDlpack =
      nb::hasattr(object, "__dlpack__") && !nb::hasattr(object, "__array__") && !PyObject_CheckBuffer(object.ptr());
  if (hasMaskedEntries(object)) {
    PyErr_SetString(PyExc_ValueError, "some of its entries are masked; numpy.ma.filled() gives them values");
    throw nb::python_error();
  }
  return numpy().attr(onlyDlpack ? "from_dlpack" : "asarray")(object);
}

nb::object arrayOrRefuse(nb::handle object, const std::string& name, const std::string& wanted) {
  try {
    return asArray(object);
  } catch (const nb::python_error& error) {
    if (isNoFault(error)) throw;
    refuse(name + " cannot be made an array" + wanted + ": " + lineOf(error));
  }
}

bool isSequenceOfObjects(nb::handle object) {
  if (!PySequence_Check(object.ptr()) || PyUnicode_Check(object.ptr())) return false;
  if (nb::hasattr(object, "dtype")) return text(object.attr("dtype")) == "object";
  return !nb::hasattr(object, "__array__");
}

nb::object numberedFromZero(nb::handle object) {
  return nb::hasattr(object, "__array__") ? asArray(object) : nb::borrow(object);
}

nb::object arrayOfShape(const ArrayLike& argument, const std::string& name, size_t width) {
  const std::string wanted = width == 0 ? "(n,)" : width == kAnyWidth ? "(n, m)" : "(n, " + std::to_string(width) + ")";
  const nb::object array = arrayOrRefuse(argument.object, name, " of shape " + wanted);
  const nb::tuple shape = nb::cast<nb::tuple>(array.attr("shape"));
  if (nb::len(shape) == 1 && nb::cast<size_t>(shape[0]) == 0 && width != 0)  // an empty list
    return array.attr("reshape")(0, width == kAnyWidth ? 0 : width);
  const bool fits = width == 0 ? nb::len(shape) == 1
                               : nb::len(shape) == 2 && (width == kAnyWidth || nb::cast<size_t>(shape[1]) == width);
  if (!fits) refuse(name + " has the shape " + text(shape) + "; it must be " + wanted);
  return array;
}

void checkNumbers(nb::handle array, const std::string& name, const char* type, bool integers, double largest) {
  const auto kind = nb::cast<std::string>(array.attr("dtype").attr("kind"));
  const bool empty = nb::cast<size_t>(array.attr("size")) == 0;
  if (kind == "i" || kind == "u" || (kind == "f" && (!integers || empty))) {
    if (!integers || empty || text(array.attr("dtype")) == type) return;
    const double least = nb::cast<double>(nb::float_(array.attr("min")()));
    const double most = nb::cast<double>(nb::float_(array.attr("max")()));
    if (least < 0 || most > largest)
      refuse(name + " holds " + text(least < 0 ? array.attr("min")() : array.attr("max")()) +
             ", which does not fit the type " + type);
    return;
  }
  refuse(name + " has the type " + text(array.attr("dtype")) + "; it must hold " + (integers ? "integers" : "numbers") +
         " that can become " + type);
}

nb::object contiguous(nb::handle array, const char* type) {
  return numpy().attr("ascontiguousarray")(array, type);
}

std::vector<Transform> transformsOf(const TransformsLike& argument, const std::string& name) {
  if (firstIs<Transform>(argument.object)) return entriesOf<Transform>(argument.object, name);
  const nb::object array = arrayOrRefuse(argument.object, name, "");
  const nb::object maps = rowsOfMaps(array, name);
  if (maps.is_none())
    refuse(name + " has the shape " + text(array.attr("shape")) +
           "; it must be (n, 3, 4) or (n, 4, 4), or a sequence of Transform");
  const auto rows = arrayOf<double>({maps}, name, 12);
  std::vector<Transform> result(rows.rows());
  for (size_t i = 0; i < result.size(); ++i)
    std::copy_n(rows.values().begin() + static_cast<ptrdiff_t>(12 * i), 12, result[i].rows.begin());
  return result;
}

Transform transformOf(const ArrayLike& argument, const std::string& name) {
  const nb::object array = arrayOrRefuse(argument.object, name, " of shape (3, 4)");
  const bool fits = dimensionsOf(array) == 2 && lengthAlong(array, 1) == 4 &&
                    (lengthAlong(array, 0) == 3 || lengthAlong(array, 0) == 4);
  if (!fits) refuse(name + " has the shape " + text(array.attr("shape")) + "; it must be (3, 4) or (4, 4)");
  const nb::object maps = rowsOfMaps(array.attr("reshape")(1, lengthAlong(array, 0), 4), name);
  const auto rows = arrayOf<double>({maps}, name, 12);
  Transform result;
  std::copy(rows.values().begin(), rows.values().end(), result.rows.begin());
  return result;
}

MapLike mapLikeOf(nb::handle argument) {
  if (nb::isinstance<Transform>(argument)) return {complete<Transform>(argument)};
  if (!isSequenceOfObjects(argument) && !nb::hasattr(argument, "shape") && !isArray(argument.ptr()))
    throw nb::type_error(
        ("a transform is a Transform, or an array of shape (3, 4) or (4, 4), and not " + aTypeName(argument.type()))
            .c_str());
  return {transformOf({nb::borrow(argument)}, "transform")};
}

std::vector<Pose> posesOfMaps(const nb::object& array, const std::string& name) {
  const nb::object maps = rowsOfMaps(array, name);
  const auto rows = arrayOf<double>({maps}, name, 12);
  std::vector<Pose> poses(rows.rows());
  for (size_t i = 0; i < poses.size(); ++i) {
    Transform map;
    std::copy_n(rows.values().begin() + static_cast<ptrdiff_t>(12 * i), 12, map.rows.begin());
    const std::optional<Quaternion> turn = rotationOf(map);
    if (!turn)
      refuse(name + ": entry " + std::to_string(i) +
             " is no pose; the first three columns of its rows must be a rotation, without scale, shear or mirror");
    poses[i] = {{map.rows[3], map.rows[7], map.rows[11]}, *turn};
  }
  return poses;
}

nb::object transformRows(const TransformsLike& argument, const std::string& name) {
  if (firstIs<Transform>(argument.object)) {
    std::vector<double> values;
    for (const Transform& map : entriesOf<Transform>(argument.object, name))
      values.insert(values.end(), map.rows.begin(), map.rows.end());
    return nb::cast(ownedRows<12>(std::move(values)), kOwned);
  }
  const nb::object array = arrayOrRefuse(argument.object, name, "");
  if (dimensionsOf(array) == 2 && lengthAlong(array, 1) == 7) return array;
  const nb::object maps = rowsOfMaps(array, name);
  if (maps.is_none())
    refuse(name + " has the shape " + text(array.attr("shape")) +
           "; it must be (n, 3, 4), (n, 4, 4) or (n, 7), or a sequence of Transform");
  return maps;
}

bool isFloat32(nb::handle array) {
  return text(array.attr("dtype")) == "float32";
}

}  // namespace gnosphere::python
