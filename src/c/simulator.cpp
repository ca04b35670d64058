// SPDX-License-Identifier: Apache-2.0
// gno_simulator: scans, and what changes between them.
#include <algorithm>
#include <gnosphere/options.hpp>
#include <mutex>
#include <set>
#include <sstream>

#include "c/handles.hpp"

namespace gnosphere::c {

std::vector<Shot> shotsOf(const gno_shot* shots, size_t count) {
  std::vector<Shot> result;
  forSized(shots, count, GNO_TYPE(gno_shot), "shots", [&](const gno_shot& shot) { result.push_back(shotOf(&shot)); });
  return result;
}

}  // namespace gnosphere::c

using namespace gnosphere;
using namespace gnosphere::c;

namespace {

GNO_SAME_ENUM(Accuracy, {GNO_ACCURACY_PAPER, paper}, {GNO_ACCURACY_DRAFT, draft}, {GNO_ACCURACY_STANDARD, standard},
              {GNO_ACCURACY_EXACT, exact});
GNO_SAME_ENUM(ReflectingFaces, {GNO_FACES_MATERIAL, material}, {GNO_FACES_FRONT, front}, {GNO_FACES_BOTH, both});

SensorRequest requestOf(const gno_request& from) {
  SensorRequest request;
  request.sensor = Locked(from.sensor)->sensor;
  if (from.effects) request.effects = *Locked(from.effects);
  request.fields = fieldsOf(from.fields, from.field_count);
  request.variableWeather = from.variable_weather != 0;
  if (from.layout) {
    request.layout = recordLayoutOf(from.layout);
    if (request.layout.values.empty()) refuse("gno_request::layout has no values; without a layout it is null");
  }
  const auto ignored = array(from.ignored_instances, from.ignored_instance_count, "gno_request::ignored_instances");
  request.ignoredInstances.assign(ignored.begin(), ignored.end());
  return request;
}

SimulatorOptions optionsOf(const gno_options* options) {
  SimulatorOptions result;
  if (!options) return result;
  const gno_options& from = sized(options, GNO_TYPE(gno_options));
  if (from.device) result.device = deviceByName(from.device);
  std::copy_n(from.device_uuid, 16, result.device.uuid.begin());
  if (result.device.uuid != DeviceChoice().uuid && result.device.kind == DeviceChoice::Kind::reference)
    result.device.kind = DeviceChoice::Kind::vulkan;  // the identifier replaces the name
  if (from.adopted) result.device = deviceOf(*from.adopted);
  result.accuracy = enumOf(from.accuracy, accuracySettings().back().accuracy, "gno_options::accuracy");
  result.faces = enumOf(from.faces, ReflectingFaces::both, "gno_options::faces");
  if (from.materials) result.materials = *Locked(from.materials);
  result.cache = orEmpty(from.cache);
  if (from.warn)
    result.warn = [warn = from.warn, user = from.user](const std::string& text) {
      callBack("gno_options::warn", warn, text.c_str(), user);
    };
  result.validation = from.validation != 0;
  std::istringstream assignments(orEmpty(from.assignments));
  for (std::string line; std::getline(assignments, line);) assign(result, line);
  return result;
}

/// Returns the lines of `assignments` that set other options than `assignment` does.
std::string withoutOptionOf(const std::string& assignment, const std::string& assignments) {
  const std::string name = assignment.substr(0, assignment.find('=') + 1);
  std::istringstream lines(assignments);
  std::string others;
  for (std::string line; std::getline(lines, line);)
    if (!line.starts_with(name)) others += line + '\n';
  return others;
}

/// Returns this text, kept until the process ends.
const char* kept(const std::string& text) {
  static std::mutex mutex;
  static auto& texts = *new std::set<std::string>();  // also for threads that outlive static objects
  const std::lock_guard lock(mutex);
  return texts.insert(text).first->c_str();
}

/// Hands a scan over without a copy: the object of a handle has it for as long as this lives.
class Exchanged {
 public:
  Exchanged(Object<ScanObject>& object, Scan& scan) : object_(object), scan_(scan) { exchange(); }
  Exchanged(const Exchanged&) = delete;
  Exchanged& operator=(const Exchanged&) = delete;
  ~Exchanged() { exchange(); }

 private:
  void exchange() {
    const std::lock_guard lock(object_.mutex);
    std::swap(static_cast<Scan&>(object_.value), scan_);
  }

  Object<ScanObject>& object_;
  Scan& scan_;
};

/// Changes the simulator and gives the index of what was added.
template <class Add>
gno_status add(gno_simulator simulator, size_t* index, Add how) {
  return guard([&] {
    Idle idle(simulator);
    const size_t added = how(idle.simulator());
    if (index) *index = added;
  });
}

/// Calls work(simulator, result) for the object of a handle, which is created if the handle is null.
template <class Handle, class Work>
void into(gno_simulator simulator, Handle* handle, const char* name, Work work) {
  if (!the(handle, name)) {
    typename Held<Handle>::Type result;
    work(Idle(simulator).simulator(), result);
    *handle = make<Handle>(std::move(result));
    return;
  }
  const auto from = find(simulator);
  const auto to = find(*handle);
  const std::scoped_lock lock(from->mutex, to->mutex);
  Changing<Handle>{*handle};
  InUse<Handle> result(*handle);
  work(Idle(simulator).simulator(), *result);
}

template <typename T>
gno_status setTransforms(gno_simulator simulator, const uint32_t* instances, size_t count, const T* values,
                         size_t width) {
  return guard([&] {
    if (width != 12 && width != 7) refuse("width is " + std::to_string(width) + "; an instance has 12 or 7 numbers");
    const auto all = array(values, count, width, "values");
    Idle(simulator)->setTransforms(array(instances, count, "instances"), all);
  });
}

}  // namespace

Shot c::shotOf(const gno_shot* shot) {
  const gno_shot& from = sized(shot, GNO_TYPE(gno_shot));
  Shot result;
  result.pose = poseOf(from.pose);
  result.sensor = from.sensor;
  result.frame = from.frame;
  result.world = from.world;
  for (const gno_stamp& stamp : array(from.motion, from.motion_count, "gno_shot::motion"))
    result.motion.stamps.push_back({stamp.time, poseOf(stamp.pose)});
  for (const gno_instance_motion& motion :
       array(from.instance_motions, from.instance_motion_count, "gno_shot::instance_motions"))
    result.instanceMotions.push_back({motion.instance, transformOf(motion.end)});
  for (const gno_mesh_motion& motion : array(from.mesh_motions, from.mesh_motion_count, "gno_shot::mesh_motions"))
    result.meshMotions.push_back({motion.mesh, deformationOf(motion.end)});
  const auto ignored = array(from.ignored_instances, from.ignored_instance_count, "gno_shot::ignored_instances");
  result.ignoredInstances.assign(ignored.begin(), ignored.end());
  if (from.weather) {
    const gno_weather& weather = sized(from.weather, GNO_TYPE(gno_weather));
    result.weather = Weather{weather.visibility, weather.rain_rate, weather.snow_rate, {}};
    for (const gno_volume& box : array(weather.volumes, weather.volume_count, "gno_weather::volumes"))
      result.weather->volumes.push_back({vec3(box.min), vec3(box.max), box.extinction});
  }
  return result;
}

extern "C" {

gno_status gno_options_set(gno_options* options, const char* assignment) {
  return guard([&] {
    const Out filled(options, GNO_TYPE(gno_options));
    the(assignment, "assignment");
    const std::string text = assignment;
    if (options->struct_size < offsetof(gno_options, assignments) + sizeof options->assignments)
      refuse("these gno_options cannot keep what gno_options_set() sets");
    if (text.find('\n') != text.npos) refuse("an assignment is one line");
    SimulatorOptions checked;
    assign(checked, text);
    (*filled).assignments = kept(withoutOptionOf(text, orEmpty((*filled).assignments)) + text);
  });
}

gno_status gno_simulator_create(gno_scene scene, const gno_request* sensors, size_t sensor_count,
                                const gno_options* options, gno_simulator* simulator) {
  return giveHandle(simulator, "simulator", [&] {
    std::vector<SensorRequest> requests;
    forSized(sensors, sensor_count, GNO_TYPE(gno_request), "sensors",
             [&](const gno_request& request) { requests.push_back(requestOf(request)); });
    const SimulatorOptions wanted = optionsOf(options);
    InUse from(scene);
    return make<gno_simulator>(SimulatorObject(Simulator(*from, requests, wanted)));
  });
}

gno_status gno_simulator_destroy(gno_simulator simulator) {
  return guard([&] {
    if (!findAnyones(simulator)->maker.isParent()) Idle{simulator};
    destroy(simulator);
  });
}

gno_status gno_simulator_scan(gno_simulator simulator, const gno_shot* shot, gno_scan* scan) {
  return guard([&] {
    const Shot wanted = shotOf(shot);
    into(simulator, scan, "scan", [&](Simulator& with, Scan& result) { with.scanInto(wanted, result); });
  });
}

gno_status gno_simulator_scan_batch(gno_simulator simulator, const gno_shot* shots, size_t shot_count,
                                    const gno_field* fields, size_t field_count, gno_batch* batch) {
  return guard([&] {
    const std::vector<Shot> wanted = shotsOf(shots, shot_count);
    const std::vector<Field> asked = fieldsOf(fields, field_count);
    into(simulator, batch, "batch", [&](Simulator& with, Batch& result) { with.scanBatchInto(wanted, result, asked); });
  });
}

gno_status gno_simulator_scan_all(gno_simulator simulator, const gno_shot* shots, size_t shot_count,
                                  int32_t (*receive)(size_t shot, gno_scan scan, void* user), void* user) {
  return guard([&] {
    the(receive, "receive");
    const std::vector<Shot> wanted = shotsOf(shots, shot_count);
    Idle idle(simulator);
    SimulatorObject& object = *idle;
    Lent<gno_scan> received;
    object.simulator.scanAll(wanted, [&](size_t index, const Scan& scan) {
      const Exchanged exchanged(received.object(), const_cast<Scan&>(scan));
      if (callBack("the function that receives scans", receive, index, received.handle(), user) != 0)
        throw Cancelled{"the function that receives scans has ended the run"};
    });
  });
}

gno_status gno_simulator_add_sensor(gno_simulator simulator, const gno_request* request, size_t* index) {
  return add(simulator, index,
             [&](Simulator& to) { return to.addSensor(requestOf(sized(request, GNO_TYPE(gno_request)))); });
}

gno_status gno_simulator_remove_sensor(gno_simulator simulator, size_t index) {
  return guard([&] { Idle(simulator)->removeSensor(index); });
}

gno_status gno_simulator_add_material(gno_simulator simulator, const gno_material* material,
                                      const gno_alpha_image* image, size_t* index) {
  return add(simulator, index, [&](Simulator& to) {
    if (!image) return to.addMaterial(materialOf(material));
    const AlphaImage alpha = alphaImageOf(image);
    return to.addMaterial(materialOf(material), &alpha);
  });
}

gno_status gno_simulator_set_material(gno_simulator simulator, size_t index, const gno_material* material,
                                      const gno_alpha_image* image) {
  return guard([&] {
    Idle to(simulator);
    if (!image) return to->setMaterial(index, materialOf(material));
    const AlphaImage alpha = alphaImageOf(image);
    to->setMaterial(index, materialOf(material), &alpha);
  });
}

gno_status gno_simulator_remove_material(gno_simulator simulator, size_t index) {
  return guard([&] { Idle(simulator)->removeMaterial(index); });
}

gno_status gno_simulator_add_mesh(gno_simulator simulator, const gno_mesh* mesh, size_t* index) {
  return add(simulator, index, [&](Simulator& to) { return to.addMesh(meshOf(mesh)); });
}

gno_status gno_simulator_remove_mesh(gno_simulator simulator, size_t index) {
  return guard([&] { Idle(simulator)->removeMesh(index); });
}

gno_status gno_simulator_set_positions(gno_simulator simulator, size_t mesh, const float* positions,
                                       size_t vertex_count) {
  return guard([&] { Idle(simulator)->setPositions(mesh, array(positions, vertex_count, 3, "positions")); });
}

gno_status gno_simulator_set_deformation(gno_simulator simulator, size_t mesh, const gno_deformation* deformation) {
  return guard(
      [&] { Idle(simulator)->setDeformation(mesh, deformation ? deformationOf(*deformation) : Deformation()); });
}

gno_status gno_simulator_add_instance(gno_simulator simulator, const gno_instance* instance, size_t* index) {
  return add(simulator, index, [&](Simulator& to) {
    const Instance from = instanceOf(instance);
    return to.addInstance(from.mesh, from.transform, from.classId, from.world);
  });
}

gno_status gno_simulator_add_instances(gno_simulator simulator, const gno_instance* instances, size_t count,
                                       uint32_t* indices) {
  return guard([&] {
    std::vector<Instance> wanted;
    forSized(instances, count, GNO_TYPE(gno_instance), "instances",
             [&](const gno_instance& instance) { wanted.push_back(instanceOf(&instance)); });
    const std::vector<uint32_t> added = Idle(simulator)->addInstances(wanted);
    if (indices) std::copy(added.begin(), added.end(), indices);
  });
}

gno_status gno_simulator_add_scene(gno_simulator simulator, gno_scene scene, const gno_transform* transform,
                                   uint32_t* materials, uint32_t* meshes, uint32_t* instances) {
  return guard([&] {
    const Transform placed = transform ? transformOf(*transform) : Transform();
    const auto from = find(scene);
    const auto to = find(simulator);
    const std::scoped_lock lock(from->mutex, to->mutex);  // in no order, as a receiver of scans may read the scene
    const InUse used(scene);
    const AddedScene added = Idle(simulator)->addScene(from->value, placed);
    if (materials) std::ranges::copy(added.materials, materials);
    if (meshes) std::ranges::copy(added.meshes, meshes);
    if (instances) std::ranges::copy(added.instances, instances);
  });
}

gno_status gno_simulator_remove_instance(gno_simulator simulator, size_t index) {
  return guard([&] { Idle(simulator)->removeInstance(index); });
}

gno_status gno_simulator_remove_instances(gno_simulator simulator, const uint32_t* instances, size_t count) {
  return guard([&] { Idle(simulator)->removeInstances(array(instances, count, "instances")); });
}

gno_status gno_simulator_set_transform(gno_simulator simulator, size_t instance, const gno_transform* transform) {
  return guard([&] { Idle(simulator)->setTransform(instance, transformOf(the(transform, "transform"))); });
}

gno_status gno_simulator_set_transforms(gno_simulator simulator, const uint32_t* instances, size_t count,
                                        const double* values, size_t width) {
  return setTransforms(simulator, instances, count, values, width);
}

gno_status gno_simulator_set_transforms_float(gno_simulator simulator, const uint32_t* instances, size_t count,
                                              const float* values, size_t width) {
  return setTransforms(simulator, instances, count, values, width);
}

gno_status gno_simulator_get_plan(gno_simulator simulator, size_t sensor, const char** json) {
  return guard([&] {
    the(json, "json");
    Idle idle(simulator);
    std::string& text = (*idle).plan;
    text = toJson(idle->plan(sensor));
    *json = text.c_str();
  });
}

gno_status gno_simulator_get_device(gno_simulator simulator, gno_device_info* device) {
  return guard([&] {
    Idle idle(simulator);
    describe(idle->device(), *Out<gno_device_info>(device, GNO_TYPE(gno_device_info)));
  });
}

gno_status gno_simulator_get_memory(gno_simulator simulator, gno_memory_use* use) {
  return guard([&] {
    const Out to(use, GNO_TYPE(gno_memory_use));
    const MemoryUse from = Idle(simulator)->memory();
    to->scene = from.scene;
    to->sensor = from.sensor;
    to->work = from.work;
  });
}

gno_status gno_simulator_get_cluster_count(gno_simulator simulator, size_t* count) {
  return guard([&] { the(count, "count") = Idle(simulator)->clusterCount(); });
}

}  // extern "C"
