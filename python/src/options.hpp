// SPDX-License-Identifier: Apache-2.0
// Python functions as SimulatorOptions::warn and SimulatorOptions::trace, and what Python's garbage collector is told
// of them.
//
// A function may refer to the object that holds it, as a method of an object that has the simulator does. Python frees
// such a circle only if the types of its objects report every reference that they count, once. So each object of Python
// that holds a function has a reference of its own, which it reports, and the copies that the library makes share that.
#pragma once

#include <exception>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "bind.hpp"
#include "gil.hpp"

namespace gnosphere::python {

/// Calls a Python function that all copies share, so they can be made and destroyed without the GIL.
class Warn {
 public:
  explicit Warn(nb::object function)
      : function_(new nb::object(std::move(function)), [](nb::object* object) {
          const AcquiredGil acquired;
          delete object;
        }) {}
  /// An exception of the function is printed, because the library's call goes on.
  void operator()(const std::string& message) const {
    const AcquiredGil acquired;
    const nb::error_scope raised;            // what is being raised while a simulator is freed
    const nb::object function = *function_;  // lives during the call, even if the collector takes the other away
    if (!function.is_valid()) return;
    try {
      function(message);
    } catch (nb::python_error& error) {
      error.discard_as_unraisable("SimulatorOptions.warn");
    }
  }
  /// The function; clear() takes it away.
  const nb::object& function() const { return *function_; }
  /// Takes the function away from all copies.
  void clear() const { const nb::object last = std::move(*function_); }

 private:
  std::shared_ptr<nb::object> function_;
};

/// Returns the options of a new object of Python: those of C++, but warnings are those of Python (warnings.warn).
SimulatorOptions newOptions();
/// Returns the Python functions of options.
std::vector<Warn> functionsOf(const SimulatorOptions& options);
/// Takes the functions away from options.
void dropFunctions(SimulatorOptions& options);
/// Gives options that will be an object of Python, or part of one, references of their own to their functions.
void ownFunctions(SimulatorOptions& options);

/// An argument of Python that stands for a SensorRequest: a request, a Sensor, which is then the sensor of a request
/// without other settings, or the name of a built-in sensor.
struct RequestLike {
  std::variant<SensorRequest, std::string> given;
};

/// Throws Error(invalidArgument) with the nearest names if no built-in sensor has this one.
inline SensorRequest requestOf(RequestLike like) {
  const auto* name = std::get_if<std::string>(&like.given);
  return name ? SensorRequest(builtinSensor(*name)) : std::get<SensorRequest>(std::move(like.given));
}

/// tp_traverse and tp_clear of a class of `T`, which has its functions as `visit(const T&)`, a list of handles, and
/// loses them by `clear(T&)`. A part of another object, which that one reports, is left alone.
template <typename T, auto visitedOf, auto clear>
struct Collected {
  static int traverse(PyObject* self, visitproc visit, void* arg) {
    Py_VISIT(Py_TYPE(self));
    if (nb::inst_state(self) != std::pair(true, true)) return 0;
    for (const nb::handle function : visitedOf(*nb::inst_ptr<T>(self))) Py_VISIT(function.ptr());
    return 0;
  }
  static int drop(PyObject* self) {
    if (nb::inst_state(self) == std::pair(true, true)) clear(*nb::inst_ptr<T>(self));
    return 0;
  }
  static inline PyType_Slot slots[] = {{Py_tp_traverse, reinterpret_cast<void*>(&traverse)},
                                       {Py_tp_clear, reinterpret_cast<void*>(&drop)},
                                       {0, nullptr}};
};

/// The functions of a list, as Collected wants them.
inline std::vector<nb::handle> handlesOf(const std::vector<Warn>& functions) {
  std::vector<nb::handle> handles;
  for (const Warn& warn : functions) handles.emplace_back(warn.function());
  return handles;
}

}  // namespace gnosphere::python

namespace nanobind::detail {

template <>
struct type_caster<gnosphere::python::RequestLike> {
  NB_TYPE_CASTER(gnosphere::python::RequestLike, make_caster<gnosphere::SensorRequest>::Name + const_name(" | ") +
                                                     make_caster<gnosphere::Sensor>::Name + const_name(" | str"))
  bool from_python(handle source, uint32_t, cleanup_list*) noexcept {
    try {
      if (isinstance<gnosphere::SensorRequest>(source))
        value.given = cast<const gnosphere::SensorRequest&>(source);
      else if (isinstance<gnosphere::Sensor>(source))
        value.given = gnosphere::SensorRequest(cast<const gnosphere::Sensor&>(source));
      else if (isinstance<str>(source))
        value.given = cast<std::string>(source);
      else
        return false;
      return true;
    } catch (const std::exception&) {  // an object that was not made completely, a text with half of a character
      return false;
    }
  }
};

}  // namespace nanobind::detail
