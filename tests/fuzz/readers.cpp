// SPDX-License-Identifier: Apache-2.0
#include "readers.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

#include "gnosphere/sensor.hpp"
#include "scene/gltf_accessor.hpp"
#include "scene/readers.hpp"

namespace gnosphere {
namespace {

[[noreturn]] void complain(const char* what, const char* why) {
  std::fprintf(stderr, "%s: %s\n", what, why);
  std::abort();
}

void fuzzScene(SceneFormat format, Bytes bytes) {
  Source source;
  source.name = "'fuzz'";
  // Every file beside this one has the same content, so that readers of buffers and material libraries are tested, too.
  source.sibling = [bytes](const std::string&) {
    FileBytes copy;
    copy.data = std::make_unique_for_overwrite<uint8_t[]>(bytes.size());
    copy.size = bytes.size();
    std::copy(bytes.begin(), bytes.end(), copy.data.get());
    return copy;
  };
  Scene scene;
  try {
    scene = readScene(format, bytes, source);
  } catch (const Error& error) {
    if (error.code() == ErrorCode::invalidArgument) complain("a reader blames the caller", error.what());
    return;
  }
  try {
    validate(scene);
  } catch (const Error& error) {
    complain("a reader returns what is not valid", error.what());
  }
}

/// Calls the Draco decoder without the GLB around it, because mutations break the GLB first.
void fuzzDraco(Bytes bytes) {
  try {
    decodeDraco(bytes, {}, "primitive", {"'fuzz'", nullptr});
  } catch (const std::exception&) {  // readScene turns all of them into Errors
  }
}

void fuzzSensor(std::string_view json) {
  Sensor sensor;
  try {
    sensor = sensorFromJson(json, "'fuzz'");
  } catch (const Error&) {
    return;
  }
  try {
    validate(sensor);
  } catch (const Error& error) {
    complain("the sensor reader returns what is not valid", error.what());
  }
}

void readValid(std::string_view bytes, const std::string& name, const SensorFileOptions& options, bool plain) {
  SensorFile file;
  try {
    file = readSensorFile(bytes, name, options);
  } catch (const Error& error) {
    if (plain && error.code() == ErrorCode::invalidArgument)
      complain("a sensor reader blames the caller", error.what());
    return;
  }
  try {
    validate(file.sensor);
  } catch (const Error& error) {
    complain("a sensor reader returns what is not valid", error.what());
  }
}

/// The family is decided by the content. Options that do not apply to it are refused.
void fuzzSensorFile(std::string_view bytes) {
  readValid(bytes, "fuzz", {}, true);
  readValid(bytes, "fuzz", {.scanRate = 10, .columns = 7}, false);
  readValid(bytes, "fuzz", {.beamsPerScan = 3}, false);
}

/// Reads Hesai's firing times for two channels; they are always in a file.
void fuzzFireTimes(Bytes bytes) {
  static const std::filesystem::path file =
      std::filesystem::temp_directory_path() / ("gnosphere-fuzz-" + std::to_string(::getpid()));
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  for (const char* state : {"", "2"})
    readValid("Channel,Elevation,Azimuth\n1,1,0\n2,-1,5\n", "angles.csv",
              {.mode = state, .scanRate = 10, .columns = 36, .fireTimes = file}, false);
  std::filesystem::remove(file);
}

}  // namespace

void fuzzReaders(std::span<const uint8_t> input) {
  if (input.empty()) return;
  constexpr std::string_view kChoices = "gbopsjdft";
  const size_t named = kChoices.find(static_cast<char>(input[0]));
  const Bytes bytes = input.subspan(1);
  switch (named != kChoices.npos ? named : input[0] % kChoices.size()) {
    case 0:
    case 1: return fuzzScene(SceneFormat::gltf, bytes);
    case 2: return fuzzScene(SceneFormat::obj, bytes);
    case 3: return fuzzScene(SceneFormat::ply, bytes);
    case 4: return fuzzScene(SceneFormat::stl, bytes);
    case 6: return fuzzDraco(bytes);
    case 8: return fuzzFireTimes(bytes);
    case 7: return fuzzSensorFile({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
    default: return fuzzSensor({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  }
}

}  // namespace gnosphere
