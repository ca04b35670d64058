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

#include "drive/drive.hpp"
#include "drive/manifest.hpp"
#include "gnosphere/effects.hpp"
#include "gnosphere/sensor.hpp"
#include "output/cloud_format.hpp"
#include "output/cloud_table.hpp"
#include "scene/gltf_accessor.hpp"
#include "scene/readers.hpp"
#include "town/opendrive/network.hpp"
#include "vulkan/pipeline_cache.hpp"

namespace gnosphere {

void complain(const char* what, const char* why) {
  std::fprintf(stderr, "%s: %s\n", what, why);
  std::abort();
}

namespace {

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

/// A file with these bytes, which its destructor removes.
class InputFile {
 public:
  explicit InputFile(Bytes bytes, const char* name = "gnosphere-fuzz-")
      : file_(std::filesystem::temp_directory_path() / (name + std::to_string(::getpid()))) {
    std::ofstream(file_, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  }
  ~InputFile() { std::filesystem::remove(file_); }
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;
  const std::filesystem::path& path() const { return file_; }

 private:
  std::filesystem::path file_;
};

/// Calls a reader, which may refuse its input with an Error, but must not blame the caller.
template <typename Read>
void mayRefuse(const Read& read) {
  try {
    read();
  } catch (const Error& error) {
    if (error.code() == ErrorCode::invalidArgument) complain("a reader blames the caller", error.what());
  }
}

/// Reads Hesai's firing times for two channels; they are always in a file.
void fuzzFireTimes(Bytes bytes) {
  const InputFile file(bytes);
  for (const char* state : {"", "2"})
    readValid("Channel,Elevation,Azimuth\n1,1,0\n2,-1,5\n", "angles.csv",
              {.mode = state, .scanRate = 10, .columns = 36, .fireTimes = file.path()}, false);
}

/// Reads a cloud in the format that the first byte chooses, and the hit of every entry.
void fuzzCloud(Bytes bytes) {
  if (bytes.empty()) return;
  const CloudFormat& format = cloudFormats()[bytes[0] % cloudFormats().size()];
  if (!format.read) return;
  mayRefuse([&] {
    const Scan scan = readCloudBytes(format, {bytes.begin() + 1, bytes.end()}, "'fuzz'").scan;
    for (size_t entry = 0; entry < scan.ranges.size(); ++entry) scan.hit(static_cast<uint32_t>(entry));
  });
}

/// Reads a trajectory in the format that the first byte chooses. One pose of KITTI has a time.
void fuzzTrajectory(Bytes bytes) {
  constexpr const char* kFormats[] = {"tum", "kitti", "euroc", "nuscenes", "carla", "carla-route"};
  if (bytes.empty()) return;
  constexpr uint8_t kTime[] = {'7'};
  const InputFile file(bytes.subspan(1)), times(kTime, "gnosphere-fuzz-times-");
  mayRefuse([&] {
    drive::readTrajectory(file.path(), kFormats[bytes[0] % std::size(kFormats)],
                          {.times = times.path(), .route = {}, .speed = 10});
  });
}

/// Reads the manifest of the only frame of a drive.
void fuzzManifest(Bytes bytes) {
  static const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("gnosphere-fuzz-drive-" + std::to_string(::getpid()));
  drive::Drive drive;
  drive.duration = 1 / drive.rate;
  {
    const drive::Manifest manifest(drive, folder);
    std::filesystem::create_directories(folder / "manifest/frames");
    std::ofstream(folder / "manifest/frames/000000.json", std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    mayRefuse([&] { manifest.summaryOf(0, true); });
  }
  std::filesystem::remove_all(folder);
}

/// Reads the content of a cache of pipelines as that of a device whose description has the bytes 1, 2, 3 and so on.
void fuzzPipelines(std::string_view bytes) {
  VkPhysicalDeviceProperties properties = {};
  properties.vendorID = 0x04030201;
  properties.deviceID = 0x08070605;
  for (uint8_t i = 0; i < VK_UUID_SIZE; ++i) properties.pipelineCacheUUID[i] = static_cast<uint8_t>(i + 9);
  const std::string file(bytes), pipelines = vulkan::pipelinesIn(file, properties);
  if (!pipelines.empty() && !file.ends_with(pipelines)) complain("the cache of pipelines", "is not what the file has");
}

}  // namespace

void fuzzReaders(std::span<const uint8_t> input) {
  if (input.empty()) return;
  const Bytes bytes = input.subspan(1);
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  constexpr std::string_view kChoices = "gbopsjdftceymvnxkrw";
  const size_t named = kChoices.find(static_cast<char>(input[0]));
  switch (kChoices[named != kChoices.npos ? named : input[0] % kChoices.size()]) {
    case 'g':
    case 'b': return fuzzScene(SceneFormat::gltf, bytes);
    case 'o': return fuzzScene(SceneFormat::obj, bytes);
    case 'p': return fuzzScene(SceneFormat::ply, bytes);
    case 's': return fuzzScene(SceneFormat::stl, bytes);
    case 'j': return fuzzSensor(text);
    case 'd': return fuzzDraco(bytes);
    case 'f': return fuzzSensorFile(text);
    case 't': return fuzzFireTimes(bytes);
    case 'c': return fuzzCloud(bytes);
    case 'e': return mayRefuse([&] { effectsFromJson(text, "'fuzz'"); });
    case 'y': return fuzzTrajectory(bytes);
    case 'm': return mayRefuse([&] { loadMaterialTable(InputFile(bytes).path()); });
    case 'v': return mayRefuse([&] { drive::readDrive(InputFile(bytes).path()); });
    case 'n': return fuzzManifest(bytes);
    case 'k': return fuzzPipelines(text);
    case 'r':
#ifdef GNOSPHERE_FUZZ_TAPES
      return fuzzTape(bytes);
#else
      return;
#endif
    case 'w': return fuzzView(bytes);
    default: return mayRefuse([&] { town::opendrive::readNetwork(InputFile(bytes).path()); });
  }
}

}  // namespace gnosphere
