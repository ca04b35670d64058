// SPDX-License-Identifier: Apache-2.0
// The extension module, in which the declarations of gnosphere/gnosphere.hpp have the same names in snake_case.
#include <atomic>

#include "bind.hpp"
#include "vulkan/driver_advice.hpp"

#define PyInit__gnosphere initialiseGnosphere  // the function that NB_MODULE defines, which the one below calls
NB_MODULE(_gnosphere, m) {
  using namespace gnosphere::python;
  // Python's collector does not look into NumPy arrays. An array of a StreamedBatch keeps its stream, so if an object
  // holds such an array and is what SimulatorOptions.warn refers to, all of them live until the program ends, and
  // nanobind would report them as leaks.
  nb::set_leak_warnings(false);
  gnosphere::vulkan::driverAdvice = "pip install 'gnosphere[cpu]' brings one that runs on the CPU";
  m.doc() = "A LiDAR simulator that never casts a ray.";
  m.attr("__version__") = GNOSPHERE_VERSION;
  watchEnd();
  bindErrors(m);
  bindScene(m);  // with bindMesh and bindAnimation
  bindStates(m);
  bindSensor(m);
  bindEffects(m);
  bindMaterials(m);
  bindPlan(m);
  bindScan(m);
  bindBatch(m);
  bindOutput(m);
  bindDevices(m);
  bindOptions(m);
  bindSimulator(m);
  bindBatchStream(m);
  bindDrive(m);
  bindRos2(m);
  bindCommandLine(m);
}
#undef PyInit__gnosphere

/// The function that Python calls for an import. The types live as long as the process does, so they cannot be made
/// again: neither after the module was deleted from sys.modules nor in another interpreter of the process. The function
/// refuses a second import before nanobind replaces what the module in use has.
extern "C" NB_EXPORT PyObject* PyInit__gnosphere(void) {
  static std::atomic<bool> imported = false;
  if (!imported.exchange(true)) return initialiseGnosphere();
  PyErr_SetString(PyExc_ImportError,
                  "gnosphere._gnosphere cannot be initialised a second time in one process, in another interpreter, "
                  "after it was deleted from sys.modules or its first import failed; start a new process");
  return nullptr;
}
