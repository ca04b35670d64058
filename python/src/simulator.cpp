// SPDX-License-Identifier: Apache-2.0
// Binds the simulator of gnosphere/simulator.hpp.
#include "simulator.hpp"

#include <limits>
#include <new>
#include <stdexcept>

#include "batch.hpp"
#include "field_list.hpp"
#include "whole.hpp"

namespace gnosphere::python {
namespace {

using Self = SimulatorWithFunctions;

// Scenes, meshes and shots are copied before the GIL is released, because another Python thread may change the
// originals.
void construct(Self* self, Scene scene, std::vector<RequestLike> sensors, SimulatorOptions options) {
  ownFunctions(options);
  const ReleasedGil released;
  std::vector<SensorRequest> requests;
  for (RequestLike& sensor : sensors) requests.push_back(requestOf(std::move(sensor)));
  new (self) Self(scene, requests, options);
}

SharedScan scan(Self& self, const Pose& pose, const Whole& sensor) {
  const Pose chosen = pose;
  const auto number = sensor.of<size_t>("scan: sensor");
  return {std::make_shared<Scan>(self.use([&](Simulator& simulator) { return simulator.scan(chosen, number); }))};
}

/// The result that a call takes out of an object and gives back.
template <typename Result>
class Taken {
 public:
  explicit Taken(Shared<Result>& from) : from_(from), value_(from.take()) {}
  Taken(const Taken&) = delete;
  Taken& operator=(const Taken&) = delete;
  ~Taken() { from_.give(std::move(value_)); }
  Result& operator*() { return *value_; }

 private:
  Shared<Result>& from_;
  std::shared_ptr<Result> value_;
};

SharedScan scanShot(Self& self, const Shot& shot) {
  const Shot chosen = shot;
  auto result = std::make_shared<Scan>();
  self.use([&](Simulator& simulator) { simulator.scanInto(chosen, *result); });
  return {std::move(result)};
}

void scanInto(Self& self, const Shot& shot, SharedScan& result) {
  const Shot chosen = shot;
  Taken taken(result);
  self.use([&](Simulator& simulator) { simulator.scanInto(chosen, *taken); });
}

void scanAll(Self& self, const std::vector<Shot>& shots,
             const nb::typed<nb::callable, nb::object(size_t, SharedScan)>& receive) {
  std::shared_ptr<Scan> memory = std::make_shared<Scan>();
  self.use([&](Simulator& simulator) {
    simulator.scanAll(shots, [&](size_t shot, const Scan& made) {
      // The simulator's own Scan is not const, and it writes the next result into whatever arrays it finds there. So
      // Python gets the arrays of this result without a copy, and the simulator gets them back unless Python keeps
      // them.
      Scan& own = const_cast<Scan&>(made);
      std::swap(own, *memory);
      const AcquiredGil acquired;
      receive(shot, SharedScan{memory});
      if (memory.use_count() == 1)
        std::swap(own, *memory);
      else
        memory = std::make_shared<Scan>();
    });
  });
}

// One number for all of `count` entries, or a number for each.
std::vector<uint32_t> numbersOf(const NumbersLike& given, size_t count, const std::string& name) {
  if (const auto* all = std::get_if<uint32_t>(&given)) return std::vector<uint32_t>(count, *all);
  const nb::object array = arrayOrRefuse(std::get<ArrayLike>(given).object, name, "");
  if (nb::cast<size_t>(array.attr("ndim")) == 0)  // one of NumPy's numbers, or one that is refused
    return std::vector<uint32_t>(count, arrayOf<uint32_t>({array.attr("reshape")(1)}, name).values()[0]);
  const auto each = arrayOf<uint32_t>({array}, name);
  if (each.rows() != count)
    refuse(name + " has " + std::to_string(each.rows()) + " entries; it must be one number, or have " +
           std::to_string(count));
  return each.copy();
}

// A list of indices for each of `count` entries, without the NO_TRIANGLE that pads it.
std::vector<std::vector<uint32_t>> indexListsOf(const IndexListsLike& given, size_t count, const std::string& name) {
  std::vector<std::vector<uint32_t>> lists;
  if (isSequenceOfObjects(given.object)) {
    const nb::object sequence = numberedFromZero(given.object);
    for (size_t i = 0; i < nb::len(sequence); ++i) {
      const nb::object list = sequence[nb::int_(i)];
      lists.push_back(arrayOf<uint32_t>({list}, name + ": entry " + std::to_string(i)).copy());
    }
  } else {
    const auto rows = arrayOf<uint32_t>({given.object}, name, kAnyWidth);
    for (size_t i = 0; i < rows.rows(); ++i) {
      const auto row = rows.values().subspan(i * rows.width(), rows.width());
      lists.emplace_back(row.begin(), row.end());
    }
  }
  for (std::vector<uint32_t>& list : lists) std::erase(list, kNoTriangle);
  if (!lists.empty() && lists.size() != count)
    refuse(name + " has " + std::to_string(lists.size()) + " entries; it must have " + std::to_string(count));
  lists.resize(count);
  return lists;
}

/// Calls work(shots), which makes a batch. Throws Error(outOfMemory) if its results do not fit into the host's memory.
template <typename Work>
void withMemory(const std::vector<Shot>& shots, const Work& work) {
  const auto refuseMemory = [&] {
    throw Error(ErrorCode::outOfMemory, "scan_batch: the host has no memory for the results of " +
                                            std::to_string(shots.size()) +
                                            " views; scan fewer at once, or ask for fewer `fields`");
  };
  try {
    work(shots);
  } catch (const std::bad_alloc&) {
    refuseMemory();
  } catch (const std::length_error&) {
    refuseMemory();
  }
}

SharedBatch scanBatch(Self& self, const ShotsLike& given, const Whole& sensor, const NumbersLike& worlds,
                      const Whole& frame, const FieldList& list, const IndexListsLike& ignored) {
  SharedBatch result;
  const auto number = sensor.of<size_t>("scan_batch: sensor");
  withMemory(shotsOf(given, {sensor, worlds, frame, ignored}, "scan_batch"), [&](const std::vector<Shot>& shots) {
    self.use([&](Simulator& simulator) {
      simulator.scanBatchInto(shots, *result.value, list.fields, SeesSignals(), number);
    });
  });
  return result;
}

void scanBatchInto(Self& self, const ShotsLike& given, SharedBatch& result, const Whole& sensor,
                   const NumbersLike& worlds, const Whole& frame, const FieldList& list,
                   const IndexListsLike& ignored) {
  const auto number = sensor.of<size_t>("scan_batch: sensor");
  withMemory(shotsOf(given, {sensor, worlds, frame, ignored}, "scan_batch"), [&](const std::vector<Shot>& shots) {
    Taken taken(result);
    self.use([&](Simulator& simulator) { simulator.scanBatchInto(shots, *taken, list.fields, SeesSignals(), number); });
  });
}

nb::object addInstances(Self& self, const NumbersLike& meshes, const TransformsLike& transforms,
                        const NumbersLike& worlds, const NumbersLike& classes) {
  const auto rows =
      arrayOf<double>({transformRows(transforms, "add_instances: transforms")}, "add_instances: transforms", kAnyWidth);
  const std::vector<uint32_t> ofMesh = numbersOf(meshes, rows.rows(), "add_instances: meshes"),
                              ofWorld = numbersOf(worlds, rows.rows(), "add_instances: worlds"),
                              ofClass = numbersOf(classes, rows.rows(), "add_instances: class_ids");
  std::vector<Instance> instances(rows.rows());
  for (size_t i = 0; i < instances.size(); ++i) {
    if (ofClass[i] > 0xffff)
      refuse("add_instances: class_ids holds " + std::to_string(ofClass[i]) + "; 65535 is the most");
    instances[i].mesh = ofMesh[i];
    instances[i].classId = static_cast<uint16_t>(ofClass[i]);
    instances[i].world = ofWorld[i];
  }
  std::vector<uint32_t> added = self.use([&](Simulator& of) {
    std::vector<uint32_t> indices = of.addInstances(instances);
    try {
      of.setTransforms(indices, rows.values());
    } catch (...) {
      for (size_t i = indices.size(); i > 0; --i) of.removeInstance(indices[i - 1]);
      throw;
    }
    return indices;
  });
  return nb::cast(ownedColumn(std::move(added)));
}

/// The poses of a batch: a sequence of Pose, or an array of shape (n, 7), (n, 4, 4) or (n, 3, 4).
std::vector<Pose> posesOf(const nb::object& given, const std::string& name) {
  if (firstIs<Pose>(given)) return entriesOf<Pose>(given, name + ": shots");
  if (!isSequenceOfObjects(given) && !nb::hasattr(given, "shape") && !isArray(given.ptr()))
    throw nb::type_error((name + ": shots is " + aTypeName(given.type()) +
                          "; it must be a sequence, such as a list, of Shot or of Pose, or an array of shape (n, 7)")
                             .c_str());
  const nb::object array = arrayOrRefuse(given, name + ": shots", " of shape (n, 7)");
  if (nb::cast<size_t>(array.attr("ndim")) == 3 && nb::cast<size_t>(array.attr("shape")[2]) == 4)
    return posesOfMaps(array, name + ": shots");
  const auto rows = arrayOf<double>({array}, name + ": shots", 7);
  std::vector<Pose> poses(rows.rows());
  for (size_t i = 0; i < poses.size(); ++i) {
    const double* v = rows.values().data() + 7 * i;
    poses[i] = {{v[0], v[1], v[2]}, {v[3], v[4], v[5], v[6]}};
  }
  return poses;
}

void dropFunctionsOfSimulator(Self& self) {
  for (const Warn& function : self.functions()) function.clear();
}

using CollectedSimulator =
    Collected<Self, [](const Self& of) { return handlesOf(of.functions()); }, &dropFunctionsOfSimulator>;

constexpr const char* kScanBatch =
    "Makes the scans of many shots of one sensor, each with the same result as scan_into(), and collects them in "
    "arrays with the view (the index into `shots`) as their first dimension, without holding the GIL. `shots` is a "
    "sequence of Shot, a sequence of Pose, or an array of poses of shape (n, 7): position x, y, z (metres) and "
    "orientation x, y, z, w (MuJoCo puts w first); or of shape (n, 4, 4) or (n, 3, 4): rotations and shifts that map "
    "to "
    "the world. Poses are completed by `sensor`, `worlds` (one number, or one for "
    "each view), `frame`: the frame number of the first view, which those of the others follow, and "
    "`ignored_instances`: the indices of instances that a view does not see, as an array of shape (n, m) or a sequence "
    "of n lists, in which NO_TRIANGLE is skipped: it fills up the rows of views that ignore fewer. Random numbers "
    "depend on the frame number. Without `frame`, which is 0 then, a second call with the same poses has the same "
    "noise; count it up by the number "
    "of views from call to call to have other noise. A sensor of several patterns fires pattern `frame` modulo their "
    "number. `fields` are those that the batch has beside the ranges; without any it has all that a Scan of the sensor "
    "has. Without shots the batch has no views, but the fields and the shape of `sensor`. Ctrl-C ends the batch. "
    "Raises "
    "Error(invalid_argument) that names the first shot which is not valid, before anything runs, Error(out_of_memory) "
    "if the results do not fit into the memory, and TypeError for shots of several types.";

void bindScans(nb::class_<Self>& simulator) {
  simulator
      .def("scan_batch", &scanBatch, "shots"_a, "sensor"_a = 0, "worlds"_a = 0, "frame"_a = 0,
           "fields"_a = nb::make_tuple(), "ignored_instances"_a = IndexListsLike{nb::make_tuple()}, kScanBatch)
      .def("scan_batch_into", &scanBatchInto, "shots"_a, "result"_a, "sensor"_a = 0, "worlds"_a = 0, "frame"_a = 0,
           "fields"_a = nb::make_tuple(), "ignored_instances"_a = IndexListsLike{nb::make_tuple()},
           "As scan_batch(), into an existing Batch, whose memory is used again unless an array of it is still held. "
           "While "
           "the call works the Batch is empty for other threads.");
  simulator
      .def("scan", &scan, "pose"_a, "sensor"_a = 0,
           "Makes one scan from the fixed pose `pose`, without holding the GIL. Its frame number is 0, and random "
           "numbers depend on it, so a second scan from the pose has the same noise: scan(Shot(pose, frame=n)) has "
           "that of frame n. Raises Error(invalid_argument) for a pose that is not finite or an unknown sensor, "
           "Error(device) or Error(out_of_memory) if the device fails.")
      .def("scan", &scanShot, "shot"_a,
           "Makes one scan of a shot, with motion, weather and frame number. Raises as scan() of a pose does, and "
           "Error(invalid_argument) for weather that is not planned (see SensorRequest.variable_weather).")
      .def("scan_into", &scanInto, "shot"_a, "result"_a,
           "As scan() of a shot, into an existing Scan, without holding the GIL. Its arrays are reused, so nothing is "
           "allocated once they have their size, unless a view of them is still held: then the scan gets new ones. "
           "While the call works the Scan is empty for other threads.")
      .def(
          "scan_all", &scanAll, "shots"_a, "receive"_a,
          "Makes many scans, each with the same result as scan_into(), pipelined: while Python receives one scan, the "
          "device works on the next. `receive` gets the index into `shots` and the scan, in order and on the calling "
          "thread. Keep the scan or views of it, if you like; what is not kept is reused. All shots are checked before "
          "the first scan. An exception of `receive` ends the run and is raised. `receive` can read from "
          "this simulator, but neither change it nor scan.");
}

void setTransforms(Self& self, const ArrayLike& instances, const TransformsLike& transforms) {
  const auto indices = arrayOf<uint32_t>(instances, "set_transforms: instances");
  const auto move = [&](const auto& rows) {
    if (rows.rows() != indices.rows())
      refuse("set_transforms: there are " + std::to_string(indices.rows()) + " instances, but " +
             std::to_string(rows.rows()) + " transforms");
    self.use([&](Simulator& of) { of.setTransforms(indices.values(), rows.values()); });
  };
  const nb::object rows = transformRows(transforms, "set_transforms: transforms");
  if (isFloat32(rows))
    move(arrayOf<float>({rows}, "set_transforms: transforms", kAnyWidth));
  else
    move(arrayOf<double>({rows}, "set_transforms: transforms", kAnyWidth));
}

void bindChanges(nb::class_<Self>& simulator) {
  const auto removal = [&](const char* name, void (Simulator::*remove)(size_t), const char* argument, const char* doc) {
    simulator.def(
        name,
        [remove, what = std::string(name) + ": " + argument](Self& self, const Whole& index) {
          self.use([&, number = index.of<size_t>(what)](Simulator& of) { (of.*remove)(number); });
        },
        nb::arg(argument), doc);
  };
  simulator.def(
      "add_sensor",
      [](Self& self, const RequestLike& given) {
        return self.use([&](Simulator& of) { return of.addSensor(requestOf(given)); });
      },
      "request"_a, "Adds a sensor and returns its index. A name stands for a built-in sensor.");
  removal("remove_sensor", &Simulator::removeSensor, "sensor", "Removes a sensor.");
  simulator.def(
      "add_material",
      [](Self& self, const Material& material, const AlphaImage* image) {
        const std::optional<AlphaImage> alpha = image ? std::optional(*image) : std::nullopt;
        return self.use(
            [&, copy = material](Simulator& of) { return of.addMaterial(copy, alpha ? &*alpha : nullptr); });
      },
      "material"_a, "image"_a = nb::none(),
      "Adds a material and returns its index. `image` is the alpha channel of its texture, for AlphaMode.mask; the "
      "material's own alpha_image is ignored.");
  simulator.def(
      "set_material",
      [](Self& self, const Whole& index, const Material& material, const AlphaImage* image) {
        const std::optional<AlphaImage> alpha = image ? std::optional(*image) : std::nullopt;
        const auto number = index.of<size_t>("set_material: index");
        self.use([&, copy = material](Simulator& of) { of.setMaterial(number, copy, alpha ? &*alpha : nullptr); });
      },
      "index"_a, "material"_a, "image"_a = nb::none(),
      "Replaces a material, also of meshes in use; `image` as in add_material(). Of a material that a mesh uses "
      "double_sided and class_id must stay as they are, and whether it has an image.");
  removal("remove_material", &Simulator::removeMaterial, "material", "Removes a material; no mesh may use it.");
  simulator.def(
      "add_mesh",
      [](Self& self, const Mesh& mesh) { return self.use([copy = mesh](Simulator& of) { return of.addMesh(copy); }); },
      "mesh"_a, "Adds a mesh and returns its index. Its parts refer to materials by index.");
  removal("remove_mesh", &Simulator::removeMesh, "mesh", "Removes a mesh; no instance may place it.");
  simulator.def(
      "set_positions",
      [](Self& self, const Whole& mesh, const ArrayLike& positions) {
        const auto array = arrayOf<float>(positions, "set_positions: positions", 3);
        const auto number = mesh.of<size_t>("set_positions: mesh");
        self.use([&](Simulator& of) { of.setPositions(number, array.values()); });
      },
      "mesh"_a, "positions"_a,
      "Moves the vertices of a mesh. positions: shape (vertices, 3), float32, metres relative to Mesh.origin, for as "
      "many vertices as the mesh has; in C order they are read where they are. The mesh must not be deformable. Within "
      "a "
      "scan its shape stands still, and has no velocity.");
  simulator.def(
      "set_deformation",
      [](Self& self, const Whole& mesh, const Deformation& deformation) {
        const auto number = mesh.of<size_t>("set_deformation: mesh");
        self.use([&, copy = deformation](Simulator& of) { of.setDeformation(number, copy); });
      },
      "mesh"_a, "deformation"_a,
      "Moves the joints and morph targets of a deformable mesh, whose vertices then are at deformed_positions(). An "
      "empty deformation puts them back to Mesh.positions.");
  simulator.def(
      "add_instance",
      [](Self& self, const Whole& mesh, const MapLike& transform, const Whole& classId, const Whole& world) {
        const auto number = mesh.of<uint32_t>("add_instance: mesh"),
                   ofWorld = world.of<uint32_t>("add_instance: world");
        const auto ofClass = classId.of<uint16_t>("add_instance: class_id");
        return self.use([&](Simulator& of) { return of.addInstance(number, transform.map, ofClass, ofWorld); });
      },
      "mesh"_a, "transform"_a, "class_id"_a = 0, "world"_a = 0,
      "Adds an instance to a world and returns its index, which Scan.instances uses. World 0 is everyone's.");
  simulator.def(
      "add_instances", &addInstances, "meshes"_a, "transforms"_a, "worlds"_a = 0, "class_ids"_a = 0,
      nb::sig("def add_instances(self, meshes: int | numpy.typing.ArrayLike, transforms: "
              "collections.abc.Sequence[Transform] | numpy.typing.ArrayLike, worlds: int | "
              "numpy.typing.ArrayLike = 0, class_ids: int | "
              "numpy.typing.ArrayLike = 0) -> numpy.typing.NDArray[numpy.uint32]"),
      "Adds many instances in one call and returns their indices, uint32 of shape (n,). `transforms` are as those of "
      "set_transforms(); the others are one number, or have the shape (n,).");
  simulator.def(
      "add_scene",
      [](Self& self, const Scene& scene, const MapLike& transform) {
        return self.use([&](Simulator& of) { return of.addScene(scene, transform.map); });
      },
      "scene"_a, "transform"_a = MapLike(),
      "Adds the materials, meshes and instances of a scene, for example of a vehicle with several parts, moved by "
      "`transform`. To move it again, set the transforms of its instances to the new one times those that `scene` "
      "states. The scene must not be changed meanwhile.");
  removal("remove_instance", &Simulator::removeInstance, "instance", "Removes an instance.");
  simulator.def(
      "remove_instances",
      [](Self& self, const ArrayLike& instances) {
        const auto indices = arrayOf<uint32_t>(instances, "remove_instances: instances");
        self.use([&](Simulator& of) { of.removeInstances(indices.values()); });
      },
      "instances"_a,
      "Removes many instances in one call. `instances` has the shape (n,), integers. The next instances that are added "
      "get their indices, in this order. Everything is checked before anything changes: the Error names the first "
      "entry of `instances` that does not exist, or that an entry before it names, too.");
  simulator.def(
      "set_transform",
      [](Self& self, const Whole& instance, const MapLike& transform) {
        const auto number = instance.of<size_t>("set_transform: instance");
        self.use([&](Simulator& of) { of.setTransform(number, transform.map); });
      },
      "instance"_a, "transform"_a,
      "Moves an instance: mesh frame to world frame, as a Transform or an array of shape (3, 4) or (4, 4).");
  simulator.def(
      "set_transforms", &setTransforms, "instances"_a, "transforms"_a,
      "Moves many instances in one call. `instances` has the shape (n,), integers; `transforms` is a sequence of "
      "Transform, or has the shape (n, 3, 4), as Transform has it, (n, 4, 4) with the last rows 0, 0, 0, 1, or (n, 7): "
      "the position x, y, z (metres) of the mesh frame in the world frame, and its orientation as a "
      "quaternion x, y, z, w of any length but zero (MuJoCo puts w first). float32 and float64 of shape (n, 3, 4) or "
      "(n, 7) in C order are read where they are. Of equal indices the last one counts. Everything is checked before "
      "anything changes: the Error names the first entry of "
      "`instances` that does not exist, or whose values are not finite.");
}

void bindAnswers(nb::class_<Self>& simulator) {
  simulator
      .def(
          "plan",
          [](Self& self, const Whole& sensor, const Whole& views) {
            const auto number = sensor.of<size_t>("plan: sensor"), count = views.of<size_t>("plan: views");
            return self.use([&](Simulator& of) { return of.plan(number, count); });
          },
          "sensor"_a = 0, "views"_a = 1,
          "Describes what a scan of the sensor computes, and why; with `views`, what so many scans do that are made "
          "together in one submission, as those of scan_batch are. Plan.views says how many fit.")
      .def(
          "device", [](Self& self) { return self.use([](Simulator& of) { return DeviceInfo(of.device()); }); },
          "The device that it runs on.")
      .def(
          "memory", [](Self& self) { return self.use([](Simulator& of) { return of.memory(); }); },
          "Bytes of device memory by purpose.")
      .def(
          "cluster_count", [](Self& self) { return self.use([](Simulator& of) { return of.clusterCount(); }); },
          "Number of clusters of all meshes; 0 on the reference.");
}

}  // namespace

std::vector<Shot> shotsOf(const ShotsLike& given, const PoseArguments& arguments, const std::string& name) {
  const auto sensor = arguments.sensor.of<size_t>(name + ": sensor");
  const auto frame = arguments.firstFrame.of<uint64_t>(name + ": frame");
  if (firstIs<Shot>(given.object)) {
    const uint32_t* const world = std::get_if<uint32_t>(&arguments.worlds);
    if (sensor != 0 || frame != 0 || !world || *world != 0 || nb::len(arguments.ignoredInstances.object) > 0)
      refuse(name +
             ": each Shot has its own sensor, world, frame and ignored instances; `sensor`, `worlds`, `frame` and "
             "`ignored_instances` are for poses");
    return entriesOf<Shot>(given.object, name + ": shots");
  }
  const std::vector<Pose> poses = posesOf(given.object, name);
  const std::vector<uint32_t> numbers = numbersOf(arguments.worlds, poses.size(), name + ": worlds");
  std::vector<std::vector<uint32_t>> ignored =
      indexListsOf(arguments.ignoredInstances, poses.size(), name + ": ignored_instances");
  std::vector<Shot> shots(poses.size());
  if (!shots.empty() && frame > std::numeric_limits<uint64_t>::max() - (shots.size() - 1))
    refuse(name + ": frame is " + std::to_string(frame) + ", so that of the last of " + std::to_string(shots.size()) +
           " views is beyond the largest, 18446744073709551615");
  for (size_t i = 0; i < shots.size(); ++i) {
    shots[i].pose = poses[i];
    shots[i].sensor = sensor;
    shots[i].frame = frame + i;
    shots[i].world = numbers[i];
    shots[i].ignoredInstances = std::move(ignored[i]);
  }
  return shots;
}

void bindSimulator(nb::module_& m) {
  nb::class_<Self> simulator(
      m, "Simulator", nb::type_slots(CollectedSimulator::slots), nb::is_weak_referenceable(),
      "A scene and sensors on a device. Materials, meshes, instances and sensors can be added and removed between "
      "scans. Only changes are uploaded, and the plans of the sensors are adapted to the scene. Indices are stable; "
      "the index of a removed object is given to the next one added.\n\nA call that raises Error(invalid_argument) or "
      "Error(out_of_memory) leaves the simulator as it was; a change that names an index that does not exist or was "
      "removed, or a value that is not valid, is such a call. One thread at a time may use a simulator; a second one "
      "gets an Error. Several simulators may be used by several threads at once: no call holds the GIL while it "
      "works.");
  simulator
      .def(
          "__init__",
          [](Self* self, const Scene& scene, const RequestLike& sensor, const SimulatorOptions& options) {
            construct(self, scene, {sensor}, options);  // copies of all three
          },
          "scene"_a, "sensor"_a, "options"_a = newOptions(),
          "A simulator with one sensor. A name stands for a built-in sensor, as in builtin_sensor().")
      .def("__init__", &construct, "scene"_a, "sensors"_a, "options"_a = newOptions(),
           "Uploads the scene and compiles the stages; on a CPU the first scan that needs a stage compiles it. Raises "
           "Error(invalid_argument) for an invalid argument, "
           "Error(device) that gives the reason per device if no device is suitable, Error(out_of_memory).");
  bindScans(simulator);
  bindChanges(simulator);
  bindAnswers(simulator);
}

}  // namespace gnosphere::python
