// SPDX-License-Identifier: Apache-2.0
// Binds gnosphere/error.hpp: an Error becomes a Python exception.
#include <string>

#include "bind.hpp"

namespace gnosphere::python {

void bindErrors(nb::module_& m) {
  nb::enum_<ErrorCode>(
      m, "ErrorCode",
      "The kind of failure that an Error reports. invalid_argument means that the call was wrong; every "
      "other code means that the call was right but could not be carried out.")
      .value("invalid_argument", ErrorCode::invalidArgument)
      .value("file", ErrorCode::file)
      .value("format", ErrorCode::format)
      .value("device", ErrorCode::device)
      .value("out_of_memory", ErrorCode::outOfMemory);

  nb::dict members;
  members["code"] = nb::cast(ErrorCode::invalidArgument);
  members["__module__"] = m.attr("__name__");
  const nb::object type = nb::steal(PyErr_NewExceptionWithDoc(
      "gnosphere.Error",
      "What the library raises. Its message is one sentence that names the cause and the remedy; `code` is its "
      "ErrorCode. An argument of the wrong Python type is a TypeError.",
      PyExc_RuntimeError, members.ptr()));
  m.attr("Error") = type;

  // The type lives as long as the process does.
  nb::register_exception_translator(
      [](const std::exception_ptr& thrown, void* errorType) {
        try {
          std::rethrow_exception(thrown);
        } catch (const Error& error) {
          const nb::handle errors(static_cast<PyObject*>(errorType));
          nb::object exception = errors(std::string(error.what()));
          exception.attr("code") = nb::cast(error.code());
          PyErr_SetObject(errors.ptr(), exception.ptr());
        }
      },
      nb::object(type).release().ptr());
}

}  // namespace gnosphere::python
