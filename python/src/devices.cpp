// SPDX-License-Identifier: Apache-2.0
// Binds what gnosphere/simulator.hpp says of devices and of how a scan is computed.
#include <nanobind/stl/array.h>

#include <cstring>

#include "rows.hpp"
#include "state.hpp"

namespace gnosphere::python {
namespace {

nb::bytes bytesOf(const std::array<uint8_t, 16>& uuid) {
  return nb::bytes(reinterpret_cast<const char*>(uuid.data()), uuid.size());
}

std::array<uint8_t, 16> uuidIn(const nb::bytes& bytes) {
  std::array<uint8_t, 16> uuid = {};
  if (bytes.size() != uuid.size())
    refuse("DeviceChoice: uuid has " + std::to_string(bytes.size()) + " bytes; it must have 16");
  std::memcpy(uuid.data(), bytes.c_str(), uuid.size());
  return uuid;
}

void bindAccuracy(nb::module_& m) {
  bindWords<Accuracy>(m, "Accuracy", optionNamed("accuracy"));
  std::string names;
  for (const AccuracySetting& setting : accuracySettings())
    names += (names.empty() ? "'" : ", '") + std::string(setting.name) + "'";
  m.def(
      "name_of", [](Accuracy accuracy) { return std::string(nameOf(accuracy)); }, "accuracy"_a.noconvert(),
      (names + ".").c_str());

  using Parts = AccuracyParts;
  nb::class_<Parts> parts(m, "AccuracyParts",
                          "The parts of an accuracy setting. It is never changed after it is made.");
  bindWords<Parts::Bounds>(parts, "Bounds", optionNamed("accuracy_parts.bounds"));
  bindWords<Parts::Cull>(parts, "Cull", optionNamed("accuracy_parts.cull"));
  bindWords<Parts::Inside>(parts, "Inside", optionNamed("accuracy_parts.inside"));
  bindWords<Parts::Range>(parts, "Range", optionNamed("accuracy_parts.range"));
  parts
      .def(
          "__init__",
          [](Parts* self, const Choice<Parts::Bounds>& bounds, const Choice<Parts::Cull>& cull,
             const Choice<Parts::Inside>& inside, const Choice<Parts::Range>& range) {
            new (self) Parts{chosen(bounds, "AccuracyParts: bounds"), chosen(cull, "AccuracyParts: cull"),
                             chosen(inside, "AccuracyParts: inside"), chosen(range, "AccuracyParts: range")};
          },
          "bounds"_a = Parts::Bounds::exact, "cull"_a = Parts::Cull::nearestPoint,
          "inside"_a = Parts::Inside::watertight, "range"_a = Parts::Range::edgeWeights,
          "Each is an enumerator, or the name of one.")
      .def_ro("bounds", &Parts::bounds, "Which beams a triangle is tested against.")
      .def_ro("cull", &Parts::cull, "Which point of a triangle must be in range.")
      .def_ro("inside", &Parts::inside, "How the inside test decides.")
      .def_ro("range", &Parts::range, "How the range of a hit is computed.");
  m.def("accuracy_parts_of", &accuracyPartsOf, "accuracy"_a.noconvert(), "Returns the parts of a named setting.");
  bindWords<ReflectingFaces>(m, "ReflectingFaces", optionNamed("faces"));
}

void bindTuning(nb::module_& m) {
  const char* keywords = "Takes its properties as keywords, in which a choice may be its name.";
  bindWords<Binning>(m, "Binning", optionNamed("tuning.binning"));
  bindWords<SubRays>(m, "SubRays", optionNamed("tuning.sub_rays"));
  nb::class_<Culling> culling(
      m, "Culling", "Which triangles are skipped early. The switches affect only the time; the cloud is the same.");
  bindWords<Culling::Occlusion>(culling, "Occlusion", optionNamed("tuning.culling.occlusion"));
  bindOptionRows<[](SimulatorOptions& options) -> Culling& { return options.tuning.culling; }>(culling,
                                                                                               "tuning.culling.");
  readWriteChoice(culling, "occlusion", &Culling::occlusion,
                  pythonText(optionNamed("tuning.culling.occlusion").doc).c_str());
  bindKeywords(culling, keywords);
  nb::class_<Tuning> tuning(m, "Tuning",
                            "How a scan is computed. The choices affect only time and memory; the cloud is the same.");
  readWriteChoice(tuning, "binning", &Tuning::binning, pythonText(optionNamed("tuning.binning").doc).c_str());
  readWriteChoice(tuning, "sub_rays", &Tuning::subRays, pythonText(optionNamed("tuning.sub_rays").doc).c_str());
  tuning.def_rw("culling", &Tuning::culling, "Which triangles are skipped early.");
  bindOptionRows<[](SimulatorOptions& options) -> Tuning& { return options.tuning; }>(tuning, "tuning.");
  bindKeywords(tuning, keywords);
}

}  // namespace

void bindDevices(nb::module_& m) {
  nb::class_<DeviceInfo> info(m, "DeviceInfo", "A device of this machine, and whether it can be used.");
  bindState<&DeviceInfo::name, &DeviceInfo::type, &DeviceInfo::driver, &DeviceInfo::apiVersion,
            &DeviceInfo::maxBufferBytes, &DeviceInfo::subgroupSize, &DeviceInfo::usable, &DeviceInfo::reason,
            &DeviceInfo::uuid>(info);
  info.def_ro("name", &DeviceInfo::name, "What the driver calls it.")
      .def_ro("type", &DeviceInfo::type, "'discrete', 'integrated', 'virtual', 'cpu', 'other', 'cuda' or 'reference'.")
      .def_ro("driver", &DeviceInfo::driver, "Name and version of the driver.")
      .def_ro("api_version", &DeviceInfo::apiVersion, "Vulkan version; empty for the reference.")
      .def_ro("max_buffer_bytes", &DeviceInfo::maxBufferBytes, "Largest size of one buffer.")
      .def_ro("subgroup_size", &DeviceInfo::subgroupSize, "Lanes of a subgroup.")
      .def_ro("usable", &DeviceInfo::usable, "Whether a simulator can run on it.")
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
          const ReleasedGil released;
          devices = listDevices(&problem);
        }
        if (vulkanProblem && !problem.empty()) vulkanProblem->append(problem);
        return tupleOf(devices);
      },
      "vulkan_problem"_a = nb::none(),
      "Lists every Vulkan device of this machine, then every CUDA device if CUDA is built in, and the reference last. "
      "A machine without Vulkan is no error: why no Vulkan device is listed is then appended to the list "
      "`vulkan_problem`, if given.");

  nb::class_<DeviceChoice> choice(
      m, "DeviceChoice",
      "Which device a simulator runs on; by default the best Vulkan device of the machine. It "
      "is never changed after it is made.");
  nb::enum_<DeviceChoice::Kind>(choice, "Kind", "Which kind of device.")
      .value("vulkan", DeviceChoice::Kind::vulkan)
      .value("cuda", DeviceChoice::Kind::cuda,
             "Only if CUDA is built in: the arithmetic of the shaders, so the clouds have the same bytes.")
      .value("cuda_fast", DeviceChoice::Kind::cudaFast,
             "As `cuda`, but CUDA's compiler may fuse and reorder operations, so bytes may differ.")
      .value("reference", DeviceChoice::Kind::reference,
             "Every beam in double precision on the CPU; the other devices are compared with it.");
  choice
      .def(
          "__init__",
          [](DeviceChoice* self, const Choice<DeviceChoice::Kind>& kind, std::string name, const nb::bytes& uuid) {
            DeviceChoice made(chosen(kind, "DeviceChoice: kind"), std::move(name));
            made.uuid = uuidIn(uuid);
            new (self) DeviceChoice(std::move(made));
          },
          "kind"_a = DeviceChoice::Kind::vulkan, "name"_a = "", "uuid"_a = bytesOf({}),
          "kind: an enumerator, or the name of one.\n"
          "name: the number of a Vulkan device in list_devices() or a part of its name, or the number of a CUDA "
          "device; if empty, the best device, and with 'gpu' the best Vulkan device that is no CPU.\n"
          "uuid: DeviceInfo.uuid of the device, 16 bytes, in which case `name` is ignored; zeros for any device.")
      .def(nb::init_implicit<const DeviceInfo&>(), "device"_a, "Chooses the given device, if the machine still has it.")
      .def_ro("kind", &DeviceChoice::kind, "Which kind of device.")
      .def_ro("name", &DeviceChoice::name, "Its number or a part of its name; empty for the best device.")
      .def_prop_ro(
          "uuid", [](const DeviceChoice& self) { return bytesOf(self.uuid); },
          "DeviceInfo.uuid of the device, in which case `name` is ignored; 16 zeros for any device.");
  m.def(
      "device_by_name", &deviceByName, "text"_a,
      "Parses the choice of a device on a command line: 'auto', 'gpu' for a Vulkan device that is no CPU, a number in "
      "list_devices(), a part of the name of a Vulkan device or a number in it, 'reference', 'cuda:N' or "
      "'cuda-fast:N'.");
  m.def(
      "name_of", [](const DeviceChoice& of) { return nameOf(of); }, "choice"_a,
      "The text that device_by_name() makes this choice of.");
  bindAccuracy(m);
  bindTuning(m);
}

}  // namespace gnosphere::python
