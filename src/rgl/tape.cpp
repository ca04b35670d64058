// SPDX-License-Identifier: Apache-2.0
// Recording calls, and making them again.
#include "rgl/tape.hpp"

#include <rgl/api/extensions/pcl.h>
#include <rgl/api/extensions/ros2.h>
#include <rgl/api/extensions/tape.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <functional>
#include <map>
#include <optional>
#include <system_error>
#include <thread>
#include <tuple>

#include "base/path.hpp"
#include "rgl/call.hpp"
#include "rgl/fields.hpp"
#include "rgl/legacy.hpp"

namespace gnosphere::rgl {

Tape& tape() {
  static Tape theTape;
  return theTape;
}

void Tape::begin(const char* path) {
  if (recording_) throw Failure(RGL_TAPE_ERROR, "the tape is recording already; end that recording first");
  const std::string name = path;
  std::ofstream yaml(pathOf(name + ".yaml"), std::ios::binary), binary(pathOf(name + ".bin"), std::ios::binary);
  if (!yaml || !binary) throw Failure(RGL_INVALID_FILE_PATH, "the tape " + name + " cannot be written");
  yaml_ = std::move(yaml);
  binary_ = std::move(binary);
  whole_ = true;
  offset_ = 0;
  start_ = std::chrono::steady_clock::now();
  recording_ = true;
  const Version told = version();
  record("rgl_get_version_info", told.major, told.minor, told.patch);
}

void Tape::end() {
  if (!recording_) throw Failure(RGL_TAPE_ERROR, "no recording has begun");
  recording_ = false;
  yaml_.close();
  binary_.close();
  if (!whole_ || !yaml_ || !binary_) throw Failure(RGL_TAPE_ERROR, "the tape could not be written to its end");
}

std::string Tape::quoted(const std::string& value) {
  std::string result = "\"";
  for (const char c : value) {
    if (c == '"' || c == '\\') result += '\\';
    result += c;
  }
  return result + '"';
}

std::string Tape::real(double value) {
  char text[32];
  if (std::isnan(value)) return ".nan";
  if (std::isinf(value)) return value > 0 ? ".inf" : "-.inf";
  return {text, std::to_chars(text, text + sizeof text, value).ptr};
}

// Arrays begin at multiples of 16 bytes.
std::string Tape::place(const Array& array) {
  const uint64_t begin = offset_;
  binary_.write(static_cast<const char*>(array.data), static_cast<std::streamsize>(array.bytes));
  const uint64_t padding = (16 - array.bytes % 16) % 16;
  binary_.write("\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0", static_cast<std::streamsize>(padding));
  offset_ += array.bytes + padding;
  return std::to_string(begin);
}

void Tape::write(const char* name, const std::string& arguments) {
  const auto time = std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now() - start_);
  yaml_ << "- " << name << ": {t: " << std::to_string(time.count()) << ", a: [" << arguments << "]}\n";
}

namespace {

/// Returns a number of the tape. yaml-cpp alone would expect the decimal signs and the groups of the program's locale.
template <class Number>
Number numberOf(const YAML::Node& node) {
  const std::string text = node.Scalar();
  const char* const end = text.data() + text.size();
  Number value = {};
  const auto read = std::from_chars(text.data(), end, value);
  return read.ec == std::errc() && read.ptr == end ? value : node.as<Number>();
}

/// State of a tape that is played: its arrays, and the handles of now by those of then.
struct Player {
  std::string arrays;
  std::map<uint64_t, uint64_t> handles;
  bool hasLeftOut = false;  ///< whether a call that would write a file has been left out
};

/// An argument of a recorded call. `Type` is that of the function's parameter.
template <class Type>
struct Argument {
  Argument(const YAML::Node& node, Player&) {
    if constexpr (std::is_enum_v<Type>)
      value = static_cast<Type>(numberOf<int32_t>(node));
    else if constexpr (std::is_same_v<Type, bool>)
      value = node.as<bool>();
    else
      value = numberOf<Type>(node);
  }
  Type pass() { return value; }
  void after() {}
  Type value;
};

/// An argument that is a handle.
template <class Object>
struct Argument<Object*> {
  Argument(const YAML::Node& node, Player& player)
      : value(reinterpret_cast<Object*>(player.handles[numberOf<uint64_t>(node)])) {}
  Object* pass() { return value; }
  void after() {}
  Object* value;
};

/// A handle that a call gives or changes.
template <class Object>
struct Argument<Object**> {
  Argument(const YAML::Node& node, Player& of)
      : then(numberOf<uint64_t>(node)), player(of), value(reinterpret_cast<Object*>(of.handles[then])) {}
  Object** pass() { return &value; }
  void after() { player.handles[then] = reinterpret_cast<uintptr_t>(value); }
  uint64_t then;
  Player& player;
  Object* value;
};

/// An argument that is an array.
template <class Element>
struct Argument<const Element*> {
  Argument(const YAML::Node& node, Player& player) {
    const auto offset = numberOf<uint64_t>(node);
    if (offset > player.arrays.size()) throw Failure(RGL_TAPE_ERROR, "an array of the tape is beyond its binary file");
    if (offset % 16 != 0)
      throw Failure(RGL_TAPE_ERROR, "an array of the tape does not begin at a multiple of 16 bytes");
    value = reinterpret_cast<const Element*>(player.arrays.data() + offset);
    room = player.arrays.size() - offset;
  }
  const Element* pass() { return value; }
  void after() {}
  /// Throws unless the file has so many elements; those of an array of unknown type are bytes.
  void need(int64_t count) const {
    constexpr size_t kBytes = sizeof(std::conditional_t<std::is_void_v<Element>, char, Element>);
    if (count > 0 && static_cast<uint64_t>(count) > room / kBytes)
      throw Failure(RGL_TAPE_ERROR, "an array of the tape is longer than its binary file");
  }
  const Element* value;
  size_t room;  // bytes from the first element to the end of the file
};

template <>
struct Argument<const char*> {
  Argument(const YAML::Node& node, Player&) : value(node.as<std::string>()) {}
  const char* pass() { return value.empty() ? nullptr : value.c_str(); }
  void after() {}
  std::string value;
};

/// A place for a result, which is not compared.
template <class Result>
struct Place {
  Place(const YAML::Node&, Player&) {}
  Result* pass() { return &value; }
  void after() {}
  Result value{};
};
template <>
struct Argument<int32_t*> : Place<int32_t> {
  using Place::Place;
};
template <>
struct Argument<bool*> : Place<bool> {
  using Place::Place;
};

// Bytes of a point with these fields.
int64_t bytesOfPoint(const Argument<const rgl_field_t*>& fields, int32_t count) {
  fields.need(count);
  int64_t bytes = 0;
  for (int32_t i = 0; i < count; ++i) bytes += static_cast<int64_t>(sizeOf(fieldOf(fields.value[i])));
  return bytes;
}

// Number of elements of the array that is argument `kArray` of a call: arrays come before their count. Arrays that
// share a count follow one another, and a single struct has no count. An image has two, and points have as many bytes
// as their fields, which follow.
template <size_t kArray, size_t kNext = kArray + 1, class... Arguments>
int64_t elementsOf(const std::tuple<Arguments...>& arguments) {
  if constexpr (kNext >= sizeof...(Arguments)) {
    return 1;
  } else {
    using Array = std::tuple_element_t<kArray, std::tuple<Arguments...>>;
    using Next = std::tuple_element_t<kNext, std::tuple<Arguments...>>;
    const auto& next = std::get<kNext>(arguments);
    if constexpr (std::is_same_v<Next, Argument<int32_t>>) {
      const int64_t count = std::max(next.value, 0);
      if constexpr (std::is_same_v<Array, Argument<const void*>>) {
        using After = std::tuple_element_t<kNext + 1, std::tuple<Arguments...>>;
        if constexpr (std::is_same_v<After, Argument<int32_t>>)
          return count * std::max(std::get<kNext + 1>(arguments).value, 0);
        else
          return count * bytesOfPoint(std::get<kNext + 1>(arguments), std::get<kNext + 2>(arguments).value);
      } else {
        return count;
      }
    } else if constexpr (requires { next.room; }) {
      return elementsOf<kArray, kNext + 1>(arguments);
    } else {
      return 1;
    }
  }
}

template <size_t kPlace, class... Arguments>
void checkArray(const std::tuple<Arguments...>& arguments) {
  if constexpr (requires { std::get<kPlace>(arguments).room; })
    std::get<kPlace>(arguments).need(elementsOf<kPlace>(arguments));
}

using Play = std::function<rgl_status_t(const YAML::Node& arguments, Player&)>;

template <class... Parameters, size_t... kPlaces>
rgl_status_t callWith(rgl_status_t (*function)(Parameters...), const YAML::Node& node, Player& player,
                      std::index_sequence<kPlaces...>) {
  std::tuple<Argument<Parameters>...> arguments{Argument<Parameters>(node[kPlaces], player)...};
  (checkArray<kPlaces>(arguments), ...);
  const rgl_status_t status = function(std::get<kPlaces>(arguments).pass()...);
  (std::get<kPlaces>(arguments).after(), ...);
  return status;
}

template <class... Parameters>
Play playerOf(rgl_status_t (*function)(Parameters...)) {
  return [function](const YAML::Node& node, Player& player) {
    if (node.size() != sizeof...(Parameters))
      throw Failure(RGL_TAPE_ERROR, "a call of the tape has " + std::to_string(node.size()) + " arguments instead of " +
                                        std::to_string(sizeof...(Parameters)));
    return callWith(function, node, player, std::index_sequence_for<Parameters...>());
  };
}

rgl_status_t playResultSize(const YAML::Node& node, Player& player) {
  Argument<rgl_node_t> of(node[0], player);
  int32_t count = 0, size = 0;
  const rgl_status_t status =
      rgl_graph_get_result_size(of.pass(), static_cast<rgl_field_t>(numberOf<int32_t>(node[1])), &count, &size);
  if (count != numberOf<int32_t>(node[2]) || size != numberOf<int32_t>(node[3]))
    log(RGL_LOG_LEVEL_WARN, "the tape had a result of " + node[2].as<std::string>() + " x " +
                                node[3].as<std::string>() + " bytes, now it has " + std::to_string(count) + " x " +
                                std::to_string(size));
  return status;
}

rgl_status_t playResultData(const YAML::Node& node, Player& player) {
  Argument<rgl_node_t> of(node[0], player);
  const auto field = static_cast<rgl_field_t>(numberOf<int32_t>(node[1]));
  int32_t count = 0, size = 0;
  const rgl_status_t status = rgl_graph_get_result_size(of.pass(), field, &count, &size);
  std::string data(size_t(count) * size + 1, '\0');
  return status == RGL_SUCCESS ? rgl_graph_get_result_data(of.pass(), field, data.data()) : status;
}

/// Returns a function that plays a call unless its argument `kPath` names a file: tapes are exchanged, and must not
/// write where they like.
template <size_t kPath, class... Parameters>
Play withoutFile(const char* name, rgl_status_t (*function)(Parameters...)) {
  return [name, play = playerOf(function)](const YAML::Node& node, Player& player) {
    const std::string path = node.size() > kPath ? node[kPath].as<std::string>() : "";
    if (path.empty()) return play(node, player);
    if (!player.hasLeftOut)
      log(RGL_LOG_LEVEL_WARN, std::string("the tape's call of ") + name + " is left out, and so are all that name a " +
                                  "file to write, because a tape may come from anyone: this one names " + path +
                                  "; make the call in the program if the file is wanted");
    player.hasLeftOut = true;
    return RGL_SUCCESS;
  };
}

const std::map<std::string, Play>& players() {
#define PLAY(function) \
  { #function, playerOf(function) }
  static const std::map<std::string, Play> all = {
      PLAY(rgl_get_extension_info),
      PLAY(rgl_cleanup),
      PLAY(rgl_mesh_create),
      PLAY(rgl_mesh_update_vertices),
      PLAY(rgl_mesh_set_texture_coords),
      PLAY(rgl_mesh_set_bone_weights),
      PLAY(rgl_mesh_set_restposes),
      PLAY(rgl_mesh_destroy),
      PLAY(rgl_mesh_is_alive),
      PLAY(rgl_entity_create),
      PLAY(rgl_entity_destroy),
      PLAY(rgl_entity_set_transform),
      PLAY(rgl_entity_set_pose_world),
      PLAY(rgl_entity_set_id),
      PLAY(rgl_entity_set_intensity_texture),
      PLAY(rgl_entity_set_laser_retro),
      PLAY(rgl_entity_apply_external_animation),
      PLAY(rgl_entity_is_alive),
      PLAY(rgl_entity_set_ignored_by_sensor),
      PLAY(rgl_texture_destroy),
      PLAY(rgl_texture_is_alive),
      PLAY(rgl_scene_set_time),
      PLAY(rgl_node_rays_from_mat3x4f),
      PLAY(rgl_node_rays_set_ring_ids),
      PLAY(rgl_node_rays_set_range),
      PLAY(rgl_node_rays_set_time_offsets),
      PLAY(rgl_node_rays_transform),
      PLAY(rgl_node_gaussian_noise_angular_ray),
      PLAY(rgl_node_raytrace),
      PLAY(rgl_node_raytrace_configure_velocity),
      PLAY(rgl_node_raytrace_configure_distortion),
      PLAY(rgl_node_raytrace_configure_non_hits),
      PLAY(rgl_node_raytrace_configure_mask),
      PLAY(rgl_node_raytrace_configure_beam_divergence),
      PLAY(rgl_node_raytrace_configure_default_intensity),
      PLAY(rgl_node_raytrace_configure_return_mode),
      PLAY(rgl_node_raytrace_configure_reflectivity_alpha),
      PLAY(rgl_node_raytrace_configure_id),
      PLAY(rgl_node_multi_return_switch),
      PLAY(rgl_node_points_transform),
      PLAY(rgl_node_points_format),
      PLAY(rgl_node_points_yield),
      PLAY(rgl_node_points_compact_by_field),
      PLAY(rgl_node_points_spatial_merge),
      PLAY(rgl_node_points_temporal_merge),
      PLAY(rgl_node_points_from_array),
      PLAY(rgl_node_points_filter_ground),
      PLAY(rgl_node_gaussian_noise_angular_hitpoint),
      PLAY(rgl_node_gaussian_noise_distance),
      PLAY(rgl_node_points_simulate_snow),
      PLAY(rgl_node_points_radar_postprocess),
      PLAY(rgl_node_points_radar_track_objects),
      PLAY(rgl_node_points_radar_set_classes),
      PLAY(rgl_node_is_alive),
      PLAY(rgl_graph_run),
      PLAY(rgl_graph_destroy),
      PLAY(rgl_graph_node_add_child),
      PLAY(rgl_graph_node_remove_child),
      PLAY(rgl_graph_node_set_priority),
      PLAY(rgl_graph_node_get_priority),
      PLAY(rgl_node_points_downsample),
      PLAY(rgl_node_points_ros2_publish),
      PLAY(rgl_node_points_ros2_publish_with_qos),
      PLAY(rgl_node_publish_ros2_laserscan),
      PLAY(rgl_node_points_remove_ground),
      PLAY(rgl_texture_create),
      {"rgl_graph_get_result_size", playResultSize},
      {"rgl_graph_get_result_data", playResultData},
      {"rgl_configure_logging", withoutFile<1>("rgl_configure_logging", rgl_configure_logging)},
      {"rgl_graph_write_pcd_file", withoutFile<1>("rgl_graph_write_pcd_file", rgl_graph_write_pcd_file)},
      {"rgl_get_version_info", [](const YAML::Node&, Player&) { return RGL_SUCCESS; }},
  };
#undef PLAY
  return all;
}

std::string contentOf(const std::string& path) {
  std::ifstream file(pathOf(path), std::ios::binary);
  if (!file) throw Failure(RGL_INVALID_FILE_PATH, "the tape's file " + path + " cannot be read");
  std::ostringstream content;
  content << file.rdbuf();
  return content.str();
}

// The sentences are RGL's, because programs look for them.
void checkVersion(const YAML::Node& calls) {
  const auto refuse = [](const char* why) { throw Failure(RGL_TAPE_ERROR, why); };
  if (calls.IsNull() || (calls.IsSequence() && calls.size() == 0)) refuse("Invalid Tape: Empty YAML file detected");
  if (!calls.IsSequence()) refuse("Unsupported Tape format: Detected outdated format");
  const YAML::Node first = calls[0]["rgl_get_version_info"];
  if (!first || !first["a"] || first["a"].size() != 3)
    refuse("Unsupported Tape format: Missing version record in the Tape");
  const int made =
      numberOf<int>(first["a"][0]) * 1000000 + numberOf<int>(first["a"][1]) * 1000 + numberOf<int>(first["a"][2]);
  if (made < 16003) refuse("Unsupported Tape Format: Tape version is too old. Required version: 0.16.3.");
}

/// A call of a tape.
struct Call {
  std::string name;
  std::chrono::nanoseconds time;  // after the start of the recording
  YAML::Node arguments;
};

Call callOf(const YAML::Node& node) {
  constexpr int64_t kLongest = int64_t{30} * 24 * 3600 * 1'000'000'000;
  if (!node.IsMap() || node.size() != 1) throw Failure(RGL_TAPE_ERROR, "an entry of the tape is no call");
  const YAML::Node details = node.begin()->second;  // a reference would outlive what begin() returns
  const auto time = numberOf<int64_t>(details["t"]);
  if (time < 0 || time > kLongest)
    throw Failure(RGL_TAPE_ERROR, "the time of a call of the tape is not within 30 days of its start");
  return {node.begin()->first.as<std::string>(), std::chrono::nanoseconds(time), details["a"]};
}

// Makes the calls of a tape at their times. Each call takes the lock for itself, so other threads go on between them. A
// call that fails does not end the tape; the first failure is thrown at its end, because only calls that succeeded were
// recorded.
void play(const std::string& yaml, std::string arrays, const std::string& name) {
  Player player;
  player.arrays = std::move(arrays);
  std::optional<Failure> failure;
  try {
    const YAML::Node calls = YAML::Load(yaml);
    checkVersion(calls);
    const auto start = std::chrono::steady_clock::now();
    for (const YAML::Node& node : calls) {
      const Call call = callOf(node);
      const auto function = players().find(call.name);
      if (function == players().end())
        throw Failure(RGL_TAPE_ERROR, "the tape calls the unknown function " + call.name);
      std::this_thread::sleep_until(start + call.time);
      const rgl_status_t status = function->second(call.arguments, player);
      if (status == RGL_SUCCESS) continue;
      const char* why = nullptr;
      rgl_get_last_error_string(&why);
      const std::string message = "the tape's call of " + call.name + " failed: " + why;
      log(RGL_LOG_LEVEL_WARN, message);
      if (!failure) failure.emplace(status, message);
    }
  } catch (const YAML::Exception& error) {
    throw Failure(RGL_TAPE_ERROR, "the tape " + name + " is no recording: " + error.what());
  }
  if (failure) throw *failure;
}

}  // namespace
}  // namespace gnosphere::rgl

using namespace gnosphere::rgl;

RGL_API rgl_status_t rgl_tape_record_begin(const char* path) {
  return callUnrecorded([&] {
    RGL_CHECK(path != nullptr);
    RGL_CHECK(path[0] != '\0');
    tape().begin(path);
  });
}

RGL_API rgl_status_t rgl_tape_record_end(void) {
  return callUnrecorded([] { tape().end(); });
}

RGL_API rgl_status_t rgl_tape_record_is_active(bool* is_active) {
  return callUnrecorded([&] {
    RGL_CHECK(is_active != nullptr);
    *is_active = tape().recording();
  });
}

RGL_API rgl_status_t rgl_tape_play(const char* path) {
  return callUnlocked([&] {
    RGL_CHECK(path != nullptr);
    RGL_CHECK(path[0] != '\0');
    {
      const std::lock_guard lock(callMutex());
      if (tape().recording()) throw Failure(RGL_TAPE_ERROR, "a tape cannot be played while another one is recorded");
    }
    const std::string name = path, calls = contentOf(name + ".yaml");
    play(calls, contentOf(name + ".bin"), name);
  });
}
