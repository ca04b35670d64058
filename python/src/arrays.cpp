// SPDX-License-Identifier: Apache-2.0
#include "arrays.hpp"

#include <algorithm>

namespace gnosphere::python {
namespace {

nb::module_ numpy() {
  return nb::module_::import_("numpy");
}

std::string text(nb::handle object) {
  return nb::cast<std::string>(nb::str(object));
}

}  // namespace

nb::object arrayOfShape(const ArrayLike& argument, const std::string& name, size_t width) {
  const std::string wanted = width == 0 ? "(n,)" : width == kAnyWidth ? "(n, m)" : "(n, " + std::to_string(width) + ")";
  nb::object array;
  try {
    array = numpy().attr("asarray")(argument.object);
  } catch (const nb::python_error& error) {
    refuse(name + " cannot be made an array of shape " + wanted + ": " + error.what());
  }
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
  if (const auto* maps = std::get_if<std::vector<Transform>>(&argument)) return *maps;
  const std::string wanted = "it must be (n, 3, 4), or a sequence of Transform";
  nb::object array;
  try {
    array = numpy().attr("asarray")(std::get<ArrayLike>(argument).object);
  } catch (const nb::python_error& error) {
    refuse(name + " cannot be made an array; " + wanted + ": " + error.what());
  }
  const nb::tuple shape = nb::cast<nb::tuple>(array.attr("shape"));
  if (nb::len(shape) != 3 || nb::cast<size_t>(shape[1]) != 3 || nb::cast<size_t>(shape[2]) != 4)
    refuse(name + " has the shape " + text(shape) + "; " + wanted);
  const auto rows = arrayOf<double>({array.attr("reshape")(-1, 4)}, name, 4);
  std::vector<Transform> maps(rows.rows() / 3);
  for (size_t i = 0; i < maps.size(); ++i)
    std::copy_n(rows.values().begin() + static_cast<ptrdiff_t>(12 * i), 12, maps[i].rows.begin());
  return maps;
}

nb::object transformRows(const ArrayLike& argument, const std::string& name) {
  const std::string wanted = "it must be (n, 3, 4) or (n, 7)";
  nb::object array;
  try {
    array = numpy().attr("asarray")(argument.object);
  } catch (const nb::python_error& error) {
    refuse(name + " cannot be made an array; " + wanted + ": " + error.what());
  }
  const nb::tuple shape = nb::cast<nb::tuple>(array.attr("shape"));
  const auto size = [&](size_t axis) { return nb::cast<size_t>(shape[axis]); };
  if (nb::len(shape) == 3 && size(1) == 3 && size(2) == 4) return array.attr("reshape")(size(0), 12);
  if (nb::len(shape) == 2 && size(1) == 7) return array;
  if (nb::len(shape) == 1 && size(0) == 0) return array.attr("reshape")(0, 12);
  refuse(name + " has the shape " + text(shape) + "; " + wanted);
}

bool isFloat32(nb::handle array) {
  return text(array.attr("dtype")) == "float32";
}

}  // namespace gnosphere::python
