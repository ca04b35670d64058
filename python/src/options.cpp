// SPDX-License-Identifier: Apache-2.0
// Binds the requests, shots and options of gnosphere/simulator.hpp.
#include "options.hpp"

#include <functional>

#include "arrays.hpp"
#include "field_list.hpp"
#include "rows.hpp"
#include "state.hpp"

namespace gnosphere::python {
namespace {

void bindRequest(nb::module_& m) {
  auto request = nb::class_<SensorRequest>(
      m, "SensorRequest", "A sensor, the effects that its scans simulate, and the fields that its scans hold.");
  request
      .def(
          "__init__",
          [](SensorRequest* self, Sensor sensor, Effects effects, FieldList fields, bool variableWeather,
             std::vector<uint32_t> ignoredInstances) {
            new (self) SensorRequest(std::move(sensor), std::move(effects), std::move(fields.fields));
            self->variableWeather = variableWeather;
            self->ignoredInstances = std::move(ignoredInstances);
          },
          "sensor"_a, "effects"_a = Effects(), "fields"_a = nb::make_tuple(), "variable_weather"_a = false,
          "ignored_instances"_a = nb::make_tuple(), "Copies what it is given.")
      .def_rw("sensor", &SensorRequest::sensor, "Its beams, ranges and times.")
      .def_rw("effects", &SensorRequest::effects,
              "By default those that the scene and the sensor call for; Effects.none() is geometry alone.")
      .def_rw("variable_weather", &SensorRequest::variableWeather,
              pythonText(requestOption("variable_weather").parameter.doc).c_str());
  readWriteFields(request, &SensorRequest::fields,
                  "The fields that scans hold beyond points, ranges, triangles and instances; read them by name, as in "
                  "scan[\"intensity\"]. With SimulatorOptions.results_on_device, the fields that batches hold beyond "
                  "ranges. A tuple, assigned whole: names in a text, or a sequence of Field or names.");
  readWriteTuple(request, "ignored_instances", &SensorRequest::ignoredInstances,
                 (pythonText(requestOption("ignored_instances").parameter.doc) + " A tuple, assigned whole.").c_str());
}

void bindShot(nb::module_& m) {
  nb::class_<AddedScene>(m, "AddedScene",
                         "The indices of what Simulator.add_scene() has added, in the order of the scene.")
      .def_prop_ro(
          "materials", [](const AddedScene& self) { return copiedColumn(self.materials); }, kOwned,
          "Shape (n,), uint32.")
      .def_prop_ro(
          "meshes", [](const AddedScene& self) { return copiedColumn(self.meshes); }, kOwned, "Shape (n,), uint32.")
      .def_prop_ro(
          "instances", [](const AddedScene& self) { return copiedColumn(self.instances); }, kOwned,
          "Shape (n,), uint32.");
  nb::class_<MemoryUse> memory(m, "MemoryUse", "Bytes of device memory by purpose.");
  bindState<&MemoryUse::scene, &MemoryUse::sensor, &MemoryUse::work>(memory);
  memory.def_ro("scene", &MemoryUse::scene, "Meshes, instances, and lists whose size follows theirs.")
      .def_ro("sensor", &MemoryUse::sensor, "Tables of the beams.")
      .def_ro("work", &MemoryUse::work, "Results, and the intermediate arrays and lists of the stages.");

  auto motion = nb::class_<SensorMotion>(
      m, "SensorMotion",
      "How the sensor moves during a scan: poses at times after its start. Between stamps the position is interpolated "
      "linearly and the orientation by slerp; before the first and after the last stamp the pose is constant, and "
      "speeds are those of the nearest interval. It is never changed after it is made.");
  nb::class_<SensorMotion::Stamp>(motion, "Stamp", "It is never changed after it is made.")
      .def(
          "__init__",
          [](SensorMotion::Stamp* self, double time, const Pose& pose) {
            new (self) SensorMotion::Stamp{time, pose};
          },
          "time"_a, "pose"_a)
      .def_ro("time", &SensorMotion::Stamp::time, "Seconds after the start of the scan, ascending.")
      .def_ro("pose", &SensorMotion::Stamp::pose, "The pose of the sensor at this time.");
  motion.def(
      "__init__",
      [](SensorMotion* self, std::vector<SensorMotion::Stamp> stamps) { new (self) SensorMotion{std::move(stamps)}; },
      "stamps"_a = nb::make_tuple());
  readTuple(
      motion, "stamps", &SensorMotion::stamps,
      "If empty, the sensor stands still. Several stamps, all before the first or after the last beam, are refused.");

  nb::class_<InstanceMotion>(m, "InstanceMotion",
                             "How an instance moves during a scan: from its own transform at the start to `end`, "
                             "Sensor.rotation_period later, or for a list without a rotation period at the time of its "
                             "last beam. Vertices move along straight lines at constant speed. A shot has at most one "
                             "for each instance. It is never changed after it is made.")
      .def(
          "__init__",
          [](InstanceMotion* self, size_t instance, const MapLike& end) {
            new (self) InstanceMotion{instance, end.map};
          },
          "instance"_a, "end"_a)
      .def_ro("instance", &InstanceMotion::instance, "Index of the instance.")
      .def_ro("end", &InstanceMotion::end, "Its transform when the scan ends.");

  nb::class_<MeshMotion>(m, "MeshMotion",
                         "How a deformable mesh moves during a scan: from its deformation at the start to `end`, as "
                         "InstanceMotion does. Vertices move along straight lines at constant speed, those of every "
                         "instance of the mesh. A shot has at most one for each mesh. It is never changed after it is "
                         "made.")
      .def(
          "__init__",
          [](MeshMotion* self, size_t mesh, const Deformation& end) {
            new (self) MeshMotion{mesh, end};
          },
          "mesh"_a, "end"_a)
      .def_ro("mesh", &MeshMotion::mesh, "Index of the mesh.")
      .def_ro("end", &MeshMotion::end, "Its deformation when the scan ends.");

  nb::class_<Shot> shot(m, "Shot", "One scan of a run.");
  shot.def(
      "__init__",
      [](Shot* self, const Pose& pose, const Whole& sensor, const Whole& frame, SensorMotion sensorMotion,
         std::vector<InstanceMotion> instanceMotions, std::optional<Weather> weather,
         std::vector<MeshMotion> meshMotions, const Whole& world, std::vector<uint32_t> ignoredInstances) {
        new (self) Shot{pose,
                        sensor.of<size_t>("Shot: sensor"),
                        frame.of<uint64_t>("Shot: frame"),
                        world.of<uint32_t>("Shot: world"),
                        std::move(sensorMotion),
                        std::move(instanceMotions),
                        std::move(meshMotions),
                        std::move(weather),
                        std::move(ignoredInstances)};
      },
      "pose"_a = Pose(), "sensor"_a = 0, "frame"_a = 0, "motion"_a = SensorMotion(),
      "instance_motions"_a = nb::make_tuple(), "weather"_a = nb::none(), "mesh_motions"_a = nb::make_tuple(),
      "world"_a = 0, "ignored_instances"_a = nb::make_tuple());
  readWriteWhole(shot, "sensor", &Shot::sensor, "Index of the sensor.");
  readWriteWhole(shot, "frame", &Shot::frame,
                 "Frame number: part of the key of the random numbers, and of a list the number of the pattern.");
  readWriteWhole(shot, "world", &Shot::world,
                 "The shot sees the instances of this world and those of world 0, as if there were no others.");
  readWriteCopy(shot, "pose", &Shot::pose,
                "Of the sensor if `motion` is empty; with `deskew`, points are reported in the frame of this pose.");
  readWriteCopy(
      shot, "motion", &Shot::motion,
      "How the sensor moves during the scan; ignored, with a scan from `pose`, where Effects.sensor_motion is not "
      "planned: see the plan.");
  readWriteCopy(shot, "weather", &Shot::weather,
                "If given, replaces the fog, rain, snow and volumes of the sensor's Effects.");
  readWriteTuple(shot, "instance_motions", &Shot::instanceMotions, "A tuple of copies, assigned whole.");
  readWriteTuple(shot, "mesh_motions", &Shot::meshMotions, "Of deformable meshes: a tuple of copies, assigned whole.");
  readWriteTuple(shot, "ignored_instances", &Shot::ignoredInstances,
                 "Indices of instances that the shot does not see, beside those of SensorRequest.ignored_instances: of "
                 "many robots in one world that share a sensor, the body of the one that carries it. Effects are "
                 "planned as if it saw them. A tuple, assigned whole.");
}

using Function = std::optional<nb::typed<nb::callable, nb::object(std::string)>>;

template <auto kMember>
Function functionOf(const SimulatorOptions& options) {
  const Warn* const warn = (options.*kMember).template target<Warn>();
  if (!warn) return {};
  return nb::cast<nb::typed<nb::callable, nb::object(std::string)>>(warn->function());
}

template <auto kMember>
void setFunction(SimulatorOptions& options, Function function) {
  options.*kMember = nullptr;
  if (function) options.*kMember = Warn(std::move(*function));
}

using CollectedOptions =
    Collected<SimulatorOptions, [](const SimulatorOptions& of) { return handlesOf(functionsOf(of)); }, &dropFunctions>;

void bindSimulatorOptions(nb::module_& m) {
  nb::class_<SimulatorOptions> options(m, "SimulatorOptions", "How a simulator computes, and on which device.",
                                       nb::type_slots(CollectedOptions::slots));
  readWriteChoice(options, "accuracy", &SimulatorOptions::accuracy, pythonText(optionNamed("accuracy").doc).c_str());
  readWriteChoice(options, "faces", &SimulatorOptions::faces, pythonText(optionNamed("faces").doc).c_str());
  options
      .def_prop_rw("warn", &functionOf<&SimulatorOptions::warn>, &setFunction<&SimulatorOptions::warn>,
                   "Receives a sentence about a problem that is no error, for example an effect that is left out. By "
                   "default this is warnings.warn, so the sentence is a UserWarning at the line that calls; None "
                   "silences it. An exception that the function raises is printed, and the call goes on.")
      .def_prop_rw("trace", &functionOf<&SimulatorOptions::trace>, &setFunction<&SimulatorOptions::trace>,
                   "Receives a line per step of each scan on a Vulkan device, with its size and time.")
      .def_rw("tuning", &SimulatorOptions::tuning, "How scans are computed; it changes no cloud.");
  bindOptionRows<[](SimulatorOptions& all) -> SimulatorOptions& { return all; }>(options, "");
  options.def_prop_rw(
      "device", [](const SimulatorOptions& self) { return self.device; },
      [](SimulatorOptions& self, const std::variant<DeviceChoice, DeviceInfo, std::string>& given) {
        const std::string* const text = std::get_if<std::string>(&given);
        const DeviceInfo* const info = std::get_if<DeviceInfo>(&given);
        self.device = text ? deviceByName(*text) : info ? DeviceChoice(*info) : std::get<DeviceChoice>(given);
      },
      "By default the best Vulkan device of the machine. A text is what device_by_name() takes.");
  readWriteCopy(options, "accuracy_parts", &SimulatorOptions::accuracyParts, "If given, replaces `accuracy`.");
  readWriteCopy(options, "materials", &SimulatorOptions::materials,
                "Reflectances by name; they override the scene's materials.");
  bindKeywords(options, "Takes its properties as keywords, in which a choice may be its name.",
               {"device", "accuracy", "accuracy_parts", "faces", "materials", "cache", "warn", "validation", "tuning",
                "trace", "compile_only", "results_on_device"},
               &newOptions);
  m.def(
      "assign", nb::overload_cast<SimulatorOptions&, const std::string&>(&assign), "options"_a, "assignment"_a,
      "Sets an option by its name, as 'accuracy=exact' or 'tuning.binning=lists'. Raises Error(invalid_argument) that "
      "has the nearest known names, or the values that the option takes.");
}

}  // namespace

SimulatorOptions newOptions() {
  SimulatorOptions options;
  options.warn = Warn(nb::object(nb::module_::import_("warnings").attr("warn")));
  return options;
}

std::vector<Warn> functionsOf(const SimulatorOptions& options) {
  std::vector<Warn> functions;
  for (const auto& function : {std::cref(options.warn), std::cref(options.trace)})
    if (const Warn* const warn = function.get().template target<Warn>()) functions.push_back(*warn);
  return functions;
}

void dropFunctions(SimulatorOptions& options) {
  options.warn = nullptr;
  options.trace = nullptr;
}

void ownFunctions(SimulatorOptions& options) {
  for (const auto& function : {std::ref(options.warn), std::ref(options.trace)})
    if (const Warn* const warn = function.get().template target<Warn>()) function.get() = Warn(warn->function());
}

void bindOptions(nb::module_& m) {
  bindRequest(m);
  bindShot(m);
  bindSimulatorOptions(m);
}

}  // namespace gnosphere::python
