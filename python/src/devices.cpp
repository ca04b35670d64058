// SPDX-License-Identifier: Apache-2.0
// Binds what gnosphere/simulator.hpp says of devices and of how a scan is computed.
#include "bind.hpp"

namespace gnosphere::python {
namespace {

nb::bytes bytesOf(const std::array<uint8_t, 16>& uuid) {
  return nb::bytes(reinterpret_cast<const char*>(uuid.data()), uuid.size());
}

void bindAccuracy(nb::module_& m) {
  nb::enum_<Accuracy>(m, "Accuracy", "The accuracy setting: named choices of the parts in AccuracyParts.")
      .value("paper", Accuracy::paper, "Section 3 of the paper to the letter.")
      .value(
          "draft", Accuracy::draft,
          "Exact bounds, but the paper's inside test and range in single precision: beams may slip through at corners.")
      .value("standard", Accuracy::standard,
             "Exact bounds, watertight edges, ranges within the depth interval of the triangle's corners.")
      .value("exact", Accuracy::exact,
             "Exact predicates, one owner per layer, correctly rounded ranges: the same bytes on every device.");
  m.def(
      "name_of", [](Accuracy accuracy) { return std::string(nameOf(accuracy)); }, "accuracy"_a,
      "'paper', 'draft', 'standard' or 'exact'.");

  using Parts = AccuracyParts;
  nb::class_<Parts> parts(m, "AccuracyParts",
                          "The parts of an accuracy setting. It is never changed after it is made.");
  nb::enum_<Parts::Bounds>(parts, "Bounds", "Which beams a triangle is tested against.")
      .value("paper", Parts::Bounds::paper, "The floor of the corners' angles, computed with GLSL's asin and atan.")
      .value(
          "corners", Parts::Bounds::corners,
          "The corners' angles, widened for rounding: misses beams where an edge bulges beyond them and at the poles.")
      .value("exact", Parts::Bounds::exact, "Every beam that can meet the triangle.");
  nb::enum_<Parts::Cull>(parts, "Cull", "Which point of a triangle must be in range.")
      .value("first_corner", Parts::Cull::firstCorner)
      .value("nearest_point", Parts::Cull::nearestPoint);
  nb::enum_<Parts::Inside>(parts, "Inside", "How the inside test decides whether a beam hits a triangle.")
      .value("plain", Parts::Inside::plain, "Signs of the edge normals a x b, equation 2 of the paper.")
      .value("watertight", Parts::Inside::watertight, "No beam slips between triangles that share an edge or a corner.")
      .value("exact", Parts::Inside::exact, "Exact signs; a beam on a shared edge hits exactly one triangle.");
  nb::enum_<Parts::Range>(parts, "Range", "How the range of a hit is computed.")
      .value("plane", Parts::Range::plane, "Equation 4 of the paper.")
      .value("edge_weights", Parts::Range::edgeWeights, "A convex combination of the depths of the corners.")
      .value("exact", Parts::Range::exact, "The exact quotient, correctly rounded; only with Inside.exact.");
  parts
      .def(
          "__init__",
          [](Parts* self, Parts::Bounds bounds, Parts::Cull cull, Parts::Inside inside, Parts::Range range) {
            new (self) Parts{bounds, cull, inside, range};
          },
          "bounds"_a = Parts::Bounds::exact, "cull"_a = Parts::Cull::nearestPoint,
          "inside"_a = Parts::Inside::watertight, "range"_a = Parts::Range::edgeWeights)
      .def_ro("bounds", &Parts::bounds)
      .def_ro("cull", &Parts::cull)
      .def_ro("inside", &Parts::inside)
      .def_ro("range", &Parts::range);
  m.def("accuracy_parts_of", &accuracyPartsOf, "accuracy"_a, "Returns the parts of a named setting.");

  nb::enum_<ReflectingFaces>(m, "ReflectingFaces", "Which faces of a triangle reflect.")
      .value("material", ReflectingFaces::material, "Material.double_sided decides.")
      .value("front", ReflectingFaces::front)
      .value("both", ReflectingFaces::both);
}

void bindTuning(nb::module_& m) {
  nb::enum_<Binning>(m, "Binning", "How the hits of each beam are collected. Every choice gives the same cloud.")
      .value("automatic", Binning::automatic,
             "If only the nearest hit matters: slabs on a CPU, nearest on other devices; otherwise lists.")
      .value("nearest", Binning::nearest,
             "One 64-bit atomic minimum per hit; replaced by lists on devices without that instruction.")
      .value("lists", Binning::lists, "A list of candidates per beam: count, prefix sum, fill.")
      .value(
          "slabs", Binning::slabs,
          "One subgroup owns a slab of columns, so the minimum needs no atomics; replaced by lists as `nearest` is.");
  nb::class_<Culling> culling(
      m, "Culling", "Which triangles are skipped early. The switches affect only the time; the cloud is the same.");
  nb::enum_<Culling::Occlusion>(culling, "Occlusion")
      .value("automatic", Culling::Occlusion::automatic)
      .value("always", Culling::Occlusion::always)
      .value("never", Culling::Occlusion::never);
  culling.def(nb::init<>())
      .def_rw("range", &Culling::range, "Triangles out of range.")
      .def_rw("rows", &Culling::rows, "Triangles between two rows of beams, above or below the field of view.")
      .def_rw("columns", &Culling::columns, "Triangles between two columns of beams.")
      .def_rw("cones", &Culling::cones, "Clusters of one-sided triangles that are all back-facing.")
      .def_rw("occlusion", &Culling::occlusion, "Triangles behind hits nearer to the sensor.");
  nb::class_<Tuning>(m, "Tuning",
                     "How a scan is computed. The choices affect only time and memory; the cloud is the same.")
      .def(nb::init<>())
      .def_rw("binning", &Tuning::binning)
      .def_rw("culling", &Tuning::culling)
      .def_rw(
          "keep_still", &Tuning::keepStill,
          "If true, a sensor that scans repeatedly from one pose keeps the hits on instances that have not moved (8 "
          "bytes per beam, from its second scan from that pose).")
      .def_rw("float64", &Tuning::float64, "If false, double precision is not used even if the device has it.")
      .def_rw(
          "max_buffer_bytes", &Tuning::maxBufferBytes,
          "Upper limit in bytes for any one buffer on a Vulkan device; 0 means the limit of the device. If an array "
          "needs more, the call that needs it raises Error(out_of_memory); the simulator stays usable.");
}

}  // namespace

void bindDevices(nb::module_& m) {
  nb::class_<DeviceInfo>(m, "DeviceInfo")
      .def_ro("name", &DeviceInfo::name)
      .def_ro("type", &DeviceInfo::type, "'discrete', 'integrated', 'virtual', 'cpu', 'other', 'cuda' or 'reference'.")
      .def_ro("driver", &DeviceInfo::driver, "Name and version of the driver.")
      .def_ro("api_version", &DeviceInfo::apiVersion, "Vulkan version; empty for the reference.")
      .def_ro("max_buffer_bytes", &DeviceInfo::maxBufferBytes, "Largest size of one buffer.")
      .def_ro("subgroup_size", &DeviceInfo::subgroupSize)
      .def_ro("usable", &DeviceInfo::usable)
      .def_ro("reason", &DeviceInfo::reason, "Why the device is not usable; empty if it is.")
      .def_prop_ro(
          "uuid", [](const DeviceInfo& self) { return bytesOf(self.uuid); },
          "Identifies the card, 16 bytes; Vulkan and CUDA report the same value. All zeros if the driver reports "
          "none.");
  m.def(
      "list_devices",
      [](std::optional<nb::typed<nb::list, std::string>> vulkanProblem) {
        std::string problem;
        std::vector<DeviceInfo> devices;
        {
          const nb::gil_scoped_release released;
          devices = listDevices(&problem);
        }
        if (vulkanProblem && !problem.empty()) vulkanProblem->append(problem);
        return tupleOf(devices);
      },
      "vulkan_problem"_a = nb::none(),
      "Lists every Vulkan device of this machine, then every CUDA device if CUDA is built in, and the reference last. "
      "A "
      "machine without Vulkan is no error: why no Vulkan device is listed is then appended to the list "
      "`vulkan_problem`, "
      "if given.");

  nb::class_<DeviceChoice> choice(
      m, "DeviceChoice",
      "Which device a simulator runs on; by default the best Vulkan device of the machine. It "
      "is never changed after it is made.");
  nb::enum_<DeviceChoice::Kind>(choice, "Kind")
      .value("vulkan", DeviceChoice::Kind::vulkan)
      .value("cuda", DeviceChoice::Kind::cuda,
             "Only if CUDA is built in: the arithmetic of the shaders, so the clouds have the same bytes.")
      .value("cuda_fast", DeviceChoice::Kind::cudaFast,
             "As `cuda`, but CUDA's compiler may fuse and reorder operations, so bytes may differ.")
      .value("reference", DeviceChoice::Kind::reference,
             "Every beam in double precision on the CPU; the other devices are compared with it.");
  choice
      .def(nb::init<DeviceChoice::Kind, std::string>(), "kind"_a = DeviceChoice::Kind::vulkan, "name"_a = "",
           "name: the number of a Vulkan device in list_devices() or a part of its name, or the number of a CUDA "
           "device; "
           "if empty, the best device.")
      .def(nb::init<const DeviceInfo&>(), "device"_a, "Chooses the given device, if the machine still has it.")
      .def_ro("kind", &DeviceChoice::kind)
      .def_ro("name", &DeviceChoice::name)
      .def_prop_ro(
          "uuid", [](const DeviceChoice& self) { return bytesOf(self.uuid); },
          "DeviceInfo.uuid of the device, in which case `name` is ignored; 16 zeros for any device.");
  m.def("device_by_name", &deviceByName, "text"_a,
        "Parses the choice of a device on a command line: 'auto', the number or a part of the name of a Vulkan device, "
        "'reference', 'cuda:N' or 'cuda-fast:N'.");
  m.def(
      "name_of", [](const DeviceChoice& of) { return nameOf(of); }, "choice"_a,
      "The text that device_by_name() makes this choice of.");
  bindAccuracy(m);
  bindTuning(m);
}

}  // namespace gnosphere::python
