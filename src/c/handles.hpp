// SPDX-License-Identifier: Apache-2.0
// Handles of the C interface. The value of a handle is a number that is used once, and an object is looked up by it, so
// that no value that a caller passes is ever dereferenced.
#pragma once

#include <gnosphere.h>

#include <cstring>
#include <filesystem>
#include <functional>
#include <gnosphere/gnosphere.hpp>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <vector>

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

/// An object with the lock that its calls wait for.
template <class T>
struct Object {
  explicit Object(T from) : value(std::move(from)) {}
  T value;
  std::recursive_mutex mutex;
};

[[noreturn]] void refuse(const std::string& why);

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

template <class Handle>
Shared<Handle> find(Handle handle) {
  return std::static_pointer_cast<Object<typename Held<Handle>::Type>>(
      find(Held<Handle>::kName, reinterpret_cast<uintptr_t>(handle)));
}

/// Access to the object of a handle, for as long as this lives.
template <class Handle>
class Locked {
 public:
  explicit Locked(Handle handle) : Locked(find(handle)) {}
  explicit Locked(Shared<Handle> object) : object_(std::move(object)), lock_(object_->mutex) {}
  typename Held<Handle>::Type& operator*() { return object_->value; }
  typename Held<Handle>::Type* operator->() { return &object_->value; }

 private:
  Shared<Handle> object_;
  std::unique_lock<std::recursive_mutex> lock_;
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

template <class Handle>
Handle make(typename Held<Handle>::Type value) {
  return reinterpret_cast<Handle>(
      keep(Held<Handle>::kName, std::make_shared<Object<typename Held<Handle>::Type>>(std::move(value))));
}

template <class Handle>
void destroy(Handle handle) {
  forget(Held<Handle>::kName, reinterpret_cast<uintptr_t>(handle));
}

/// An object that the library lends to a function of the caller, which cannot destroy it.
template <class Handle>
class Lent {
 public:
  Lent()
      : object_(std::make_shared<Object<typename Held<Handle>::Type>>(typename Held<Handle>::Type())),
        handle_(keepBorrowed(Held<Handle>::kName, object_)) {}
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
struct Cancelled {};

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

/// Returns what a pointer leads to; a null pointer is an error that names it.
template <class T>
T& the(T* pointer, const char* name) {
  if (!pointer) refuse(std::string(name) + " is null");
  return *pointer;
}

/// The path of an argument that names a file, in UTF-8.
inline std::filesystem::path fileOf(const char* file) {
  const std::string_view text = &the(file, "file");
  return std::u8string(text.begin(), text.end());
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

/// Refuses the size of a struct that has none, or that is of a newer version than this library.
void checkSize(size_t given, size_t known, const char* type);

/// The two arguments by which sized() and Out know a struct that begins with its size: the default values of this
/// version's gno_..._init(), and the name.
#define GNO_TYPE(type) type##_init(), #type

/// A struct of the caller that begins with its size. A caller that was compiled with an older version has a smaller
/// one: the members that it lacks keep their default values.
template <class T>
T sized(const T* pointer, T value, const char* type) {
  const size_t given = the(pointer, type).struct_size;
  checkSize(given, sizeof(T), type);
  std::memcpy(&value, pointer, given);
  value.struct_size = sizeof(T);
  return value;
}

/// Checks an array of the caller, which may be null if it is empty.
template <class T>
std::span<T> array(T* values, size_t count, const char* name) {
  if (!values && count > 0) refuse(std::string(name) + " is null, but its count is " + std::to_string(count));
  return {values, count};
}

/// An array of structs of the caller that begin with their sizes, which are as far apart as the first one says.
template <class T>
std::vector<T> sizedArray(const T* values, size_t count, const T& defaults, const char* type, const char* name) {
  array(values, count, name);
  std::vector<T> result;
  for (size_t i = 0; i < count; ++i)
    result.push_back(sized(reinterpret_cast<const T*>(reinterpret_cast<const char*>(values) + i * values->struct_size),
                           defaults, type));
  return result;
}

/// A struct of the caller that a function fills, as far as the caller knows its members.
template <class T>
class Out {
 public:
  Out(T* pointer, const T& defaults, const char* type) : to_(pointer), value_(sized(pointer, defaults, type)) {}
  Out(const Out&) = delete;
  Out& operator=(const Out&) = delete;
  ~Out() {
    const size_t given = to_->struct_size;
    std::memcpy(to_, &value_, given);
    to_->struct_size = given;
  }
  T& operator*() const { return value_; }
  T* operator->() const { return &value_; }

 private:
  T* to_;
  mutable T value_;
};

/// The enumerator of a number; `last` is the greatest there is.
template <class Enum>
Enum enumOf(int32_t number, Enum last, const char* name) {
  if (number < 0 || number > static_cast<int32_t>(last))
    refuse(std::string(name) + " is " + std::to_string(number) + ", which is none of 0.." +
           std::to_string(static_cast<int32_t>(last)));
  return static_cast<Enum>(number);
}

inline std::string orEmpty(const char* text) {
  return text ? text : "";
}

inline Vec3 vec3(const double* v) {
  return {v[0], v[1], v[2]};
}
inline void set(double* to, const Vec3& v) {
  to[0] = v.x, to[1] = v.y, to[2] = v.z;
}
template <class T>
const T* orNull(const std::vector<T>& values) {
  return values.empty() ? nullptr : values.data();
}
/// Returns the value at a caller's index; an index that does not exist is an error that names the noun.
template <class T>
const T& at(const std::vector<T>& values, size_t index, const char* noun) {
  if (index >= values.size())
    refuse(std::string(noun) + " " + std::to_string(index) + " does not exist, there are " +
           std::to_string(values.size()));
  return values[index];
}
/// Returns the scene; one that is not valid is an error that says why.
const Scene& valid(SceneObject& scene);
/// Adds what is made of an argument to a list of the scene, and gives its index unless `index` is null.
template <class List, class Make, class From>
gno_status addTo(gno_scene scene, List list, Make make, const From* from, uint32_t* index) {
  return guard([&] {
    Locked to(scene);
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
