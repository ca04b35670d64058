// SPDX-License-Identifier: Apache-2.0
// Handles of the C interface. The value of a handle is a number that is used once, and an object is looked up by it, so
// that no value that a caller passes is ever dereferenced.
#pragma once

#include <gnosphere.h>

#include <filesystem>
#include <functional>
#include <gnosphere/gnosphere.hpp>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "base/maker_process.hpp"
#include "base/path.hpp"
#include "c/structs.hpp"

namespace gnosphere::c {

struct SceneObject : Scene {
  SceneObject(Scene from = {}) : Scene(std::move(from)) {}
  bool valid = false;  ///< whether validate() has found it so since it was last changed
};

/// A sensor, and what its file left open.
struct SensorObject {
  Sensor sensor;
  std::string report;
  BeamList beams;  ///< what gno_sensor_get_beams() last handed out
  std::vector<double> directions, origins;
};

struct ScanObject : Scan {
  ScanObject(Scan from = {}) : Scan(std::move(from)) {}
  std::vector<gno_stage_time> stages;  ///< what gno_scan_get_timings() last handed out
};

struct BatchObject : Batch {
  BatchObject(Batch from = {}) : Batch(std::move(from)) {}
  std::vector<gno_stage_time> stages;  ///< what gno_batch_get_timings() last handed out
};

struct SimulatorObject {
  explicit SimulatorObject(Simulator from) : simulator(std::move(from)) {}
  Simulator simulator;
  std::string plan;      ///< what gno_simulator_get_plan() last handed out
  bool running = false;  ///< true while a function of the simulator is called
};

// Which object stands behind each kind of handle, and what messages call it.
template <class Handle>
struct Held;
#define GNO_HELD(handle, Object, name)         \
  template <>                                  \
  struct Held<handle> {                        \
    using Type = Object;                       \
    static constexpr const char* kName = name; \
  };
GNO_HELD(gno_scene, SceneObject, "scene")
GNO_HELD(gno_sensor, SensorObject, "sensor")
GNO_HELD(gno_effects, Effects, "effects")
GNO_HELD(gno_material_table, MaterialTable, "material table")
GNO_HELD(gno_simulator, SimulatorObject, "simulator")
GNO_HELD(gno_scan, ScanObject, "scan")
GNO_HELD(gno_batch, BatchObject, "batch")

/// A simulator, or an object that refers to one, such as a recorder. Threads of the process that has made it work for
/// it.
template <class T>
concept HasSimulator = requires(T& object) {
  object.simulator;
};

/// An object with the lock that its calls wait for.
template <class T>
struct Object {
  explicit Object(T from) : value(std::move(from)) {}
  T value;
  const MakerProcess maker;
  std::recursive_mutex mutex;
  size_t users = 0;  ///< calls that call functions of the caller, which must not change the object meanwhile
};

// The table of live objects, for any kind. `kind` is the name of Held.
uintptr_t keep(const char* kind, std::shared_ptr<void> object);
/// Throws Error(invalidArgument) that says what is wrong with the handle.
std::shared_ptr<void> find(const char* kind, uintptr_t handle);
/// As find(), for an object that is then destroyed. An object that keepBorrowed() has kept is refused.
void forget(const char* kind, uintptr_t handle);
/// As keep(), for an object that only release() destroys: one that the library lends to a function of the caller.
uintptr_t keepBorrowed(const char* kind, std::shared_ptr<void> object);
/// Destroys an object that the library has lent.
void release(uintptr_t handle) noexcept;

template <class Handle>
using Shared = std::shared_ptr<Object<typename Held<Handle>::Type>>;

/// As find(), also for an object of another process.
template <class Handle>
Shared<Handle> findAnyones(Handle handle) {
  return std::static_pointer_cast<Object<typename Held<Handle>::Type>>(
      find(Held<Handle>::kName, reinterpret_cast<uintptr_t>(handle)));
}

/// Returns the object of a handle, but not a simulator of another process. The check comes before the object's lock: if
/// another thread had the lock at a fork, the lock is never free in the forked process, which lacks that thread.
template <class Handle>
Shared<Handle> find(Handle handle) {
  Shared<Handle> object = findAnyones(handle);
  if constexpr (HasSimulator<typename Held<Handle>::Type>) object->maker.check();
  return object;
}

/// Access to the object of a handle, for as long as this lives.
template <class Handle>
class Locked {
 public:
  explicit Locked(Handle handle) : Locked(find(handle)) {}
  explicit Locked(Shared<Handle> object) : object_(std::move(object)), lock_(object_->mutex) {}
  typename Held<Handle>::Type& operator*() { return object_->value; }
  typename Held<Handle>::Type* operator->() { return &object_->value; }

 protected:
  size_t& users() { return object_->users; }

 private:
  Shared<Handle> object_;
  std::unique_lock<std::recursive_mutex> lock_;
};

/// Access to an object that is about to change, which is refused while a call uses it that has called a function of the
/// caller. The lock does not keep out that function, because it runs on the thread of the call.
template <class Handle>
class Changing : public Locked<Handle> {
 public:
  explicit Changing(Handle handle) : Locked<Handle>(handle) {
    if (this->users() > 0)
      refuse(
          std::string("this ") + Held<Handle>::kName +
          " is in use by a call of the library; a function that the library calls, such as one that receives scans or "
          "warnings, must not change it");
  }
};

/// Access to an object that functions of the caller cannot change for as long as this lives.
template <class Handle>
class InUse : public Locked<Handle> {
 public:
  explicit InUse(Handle handle) : Locked<Handle>(handle) { ++this->users(); }
  ~InUse() { --this->users(); }
  InUse(const InUse&) = delete;
  InUse& operator=(const InUse&) = delete;
};

/// The simulator of a handle, unless this thread is in a call of it, which calls a function of the caller: one that
/// receives scans or warnings.
class Idle : public Locked<gno_simulator> {
 public:
  explicit Idle(gno_simulator handle) : Idle(find(handle)) {}
  explicit Idle(Shared<gno_simulator> object) : Locked(std::move(object)) {
    if ((**this).running)
      refuse("a function that a simulator calls, such as one that receives scans, must not call it");
    (**this).running = true;
  }
  ~Idle() { (**this).running = false; }
  Idle(const Idle&) = delete;
  Idle& operator=(const Idle&) = delete;
  Simulator& simulator() { return (**this).simulator; }
  Simulator* operator->() { return &simulator(); }
};

/// Access to an object that refers to a simulator, for a call of both, as Idle for the simulator. While the call waits
/// for the simulator it does not keep the object, which a function that the simulator calls may want.
template <class Handle>
class WithSimulator {
 public:
  explicit WithSimulator(Handle handle) : WithSimulator(find(handle)) {}
  typename Held<Handle>::Type* operator->() { return &object_->value; }

 private:
  explicit WithSimulator(Shared<Handle> object)
      : object_(std::move(object)),
        simulator_(live(object_->value.simulator)),
        lock_(object_->mutex, simulator_->mutex),
        idle_(simulator_) {}
  static Shared<gno_simulator> live(gno_simulator handle) { return find(handle); }
  static Shared<gno_simulator> live(Shared<gno_simulator> object) { return object; }

  const Shared<Handle> object_;
  const Shared<gno_simulator> simulator_;
  const std::scoped_lock<std::recursive_mutex, std::recursive_mutex> lock_;
  const Idle idle_;
};

template <class Handle>
Handle make(typename Held<Handle>::Type value) {
  return reinterpret_cast<Handle>(
      keep(Held<Handle>::kName, std::make_shared<Object<typename Held<Handle>::Type>>(std::move(value))));
}

template <class Handle>
void destroy(Handle handle) {
  forget(Held<Handle>::kName, reinterpret_cast<uintptr_t>(handle));
}

/// An object that the library lends to a function of the caller, which can neither change nor destroy it.
template <class Handle>
class Lent {
 public:
  Lent() : object_(std::make_shared<Object<typename Held<Handle>::Type>>(typename Held<Handle>::Type())) {
    object_->users = 1;
    handle_ = keepBorrowed(Held<Handle>::kName, object_);
  }
  Lent(const Lent&) = delete;
  Lent& operator=(const Lent&) = delete;
  ~Lent() { release(handle_); }
  Handle handle() const { return reinterpret_cast<Handle>(handle_); }
  Object<typename Held<Handle>::Type>& object() { return *object_; }

 private:
  Shared<Handle> object_;
  uintptr_t handle_;
};

/// Thrown when a function of the caller ends a call.
struct Cancelled {
  std::string why;
};

/// Throws Cancelled for the exception that is being handled, which a function of the caller has thrown. The name of
/// that function begins the sentence.
[[noreturn]] void cancelAfterException(const char* function);

/// Calls a function of the caller, whose exceptions are not taken for errors of the library.
template <class Function, class... Arguments>
auto callBack(const char* name, Function function, Arguments... arguments) {
  try {
    return function(arguments...);
  } catch (...) {
    cancelAfterException(name);
  }
}

/// The status of the exception that is being handled; its sentence becomes gno_last_error().
gno_status statusOfException() noexcept;

/// Runs the body of a function of the interface; an exception becomes a status.
template <class Body>
gno_status guard(Body body) noexcept {
  try {
    body();
    return GNO_OK;
  } catch (...) {
    return statusOfException();
  }
}

/// The path of an argument that names a file, in UTF-8.
inline std::filesystem::path fileOf(const char* file) {
  return pathOf(&the(file, "file"));
}

/// Runs the body of a function that makes an object: writes the handle that make() returns to a place of the caller,
/// which is checked before anything is made.
template <class Handle, class Make>
gno_status giveHandle(Handle* place, const char* name, Make make) noexcept {
  return guard([&] {
    Handle& to = the(place, name);
    to = make();
  });
}

/// Returns the scene; one that is not valid is an error that says why.
const Scene& valid(SceneObject& scene);
/// Adds what is made of an argument to a list of the scene, and gives its index unless `index` is null.
template <class List, class Make, class From>
gno_status addTo(gno_scene scene, List list, Make make, const From* from, uint32_t* index) {
  return guard([&] {
    Changing to(scene);
    auto& values = std::invoke(list, *to);
    values.push_back(make(from));
    if (index) *index = static_cast<uint32_t>(values.size() - 1);
    to->valid = false;
  });
}

Pose poseOf(const gno_pose& pose);
gno_pose poseOf(const Pose& pose);
Transform transformOf(const gno_transform& transform);
inline const gno_transform* transformsOf(const std::vector<Transform>& transforms) {
  static_assert(sizeof(gno_transform) == sizeof(Transform));
  return reinterpret_cast<const gno_transform*>(orNull(transforms));
}

// Conversions that several files need.
Mesh meshOf(const gno_mesh* mesh);
Deformation deformationOf(const gno_deformation& deformation);
/// The pointers lead into `deformation`.
gno_deformation deformationOf(const Deformation& deformation);
Material materialOf(const gno_material* material);
AlphaImage alphaImageOf(const gno_alpha_image* image);
Instance instanceOf(const gno_instance* instance);
std::vector<Field> fieldsOf(const gno_field* fields, size_t count);
RecordLayout recordLayoutOf(const gno_layout* layout);
/// Gives a layout, whose values `values` keeps.
void give(const RecordLayout& layout, std::vector<gno_layout_value>& values, gno_layout& to);
Shot shotOf(const gno_shot* shot);
std::vector<Shot> shotsOf(const gno_shot* shots, size_t count);
/// Adopts a Vulkan device of the caller.
DeviceChoice deviceOf(const gno_vulkan_adopted_device& device);
void describe(const DeviceInfo& device, gno_device_info& info);

}  // namespace gnosphere::c
