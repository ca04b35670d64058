// SPDX-License-Identifier: Apache-2.0
// The extension module. What gnosphere/gnosphere.hpp declares is in it under the same names in snake_case.
#include <utility>

#include "bind.hpp"
#include "vulkan/driver_advice.hpp"

NB_MODULE(_gnosphere, m) {
  using namespace gnosphere::python;
  // The types live as long as the process does, so they cannot be made again.
  static bool imported = false;
  if (std::exchange(imported, true))
    throw nb::import_error(
        "gnosphere._gnosphere cannot be initialised a second time in one process, after it was deleted from "
        "sys.modules or its first import failed; start a new process");
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
