// SPDX-License-Identifier: Apache-2.0
#include "golden.hpp"

#include <algorithm>

#include "base/sha256.hpp"
#include "town/town.hpp"

namespace gnosphere::bench {
namespace {

const GoldenCloud kTable[] = {
#include "golden_hashes.inc"
};

template <typename T>
void append(std::string& bytes, const T* values, size_t count) {
  bytes.append(reinterpret_cast<const char*>(values), count * sizeof(T));
}

template <typename T>
void appendColumn(std::string& bytes, const Scan& scan, Field field) {
  const ColumnView<T> column = scan.column<T>(field);
  append(bytes, column.data(), column.size() * column.stride());
}

Effects effectsOf(const std::vector<const char*>& assignments) {
  Effects effects = Effects::none();
  for (const char* assignment : assignments) assign(effects, assignment);
  return effects;
}

}  // namespace

Scene goldenScene() {
  Scene scene = makeTown({20'000, 1});
  Material fence;
  fence.name = "fence";
  fence.doubleSided = true;
  fence.alphaMode = AlphaMode::mask;
  fence.alphaImage = static_cast<uint32_t>(scene.alphaImages.size());
  scene.alphaImages.push_back({3, 2, {0, 255, 90, 200, 0, 255}, AlphaImage::Wrap::mirror, AlphaImage::Wrap::repeat});
  Mesh plate;
  plate.positions = {6, 4, 0, 6, -4, 0, 6, -4, 3, 6, 4, 3};
  plate.indices = {0, 1, 2, 0, 2, 3};
  plate.uvs = {-1.5f, 0, 6, 0, 6, 4, -1.5f, 4};
  plate.parts = {{0, 2, static_cast<uint32_t>(scene.materials.size())}};
  scene.materials.push_back(fence);
  scene.instances.push_back({"fence", static_cast<uint32_t>(scene.meshes.size()), {}});
  scene.meshes.push_back(plate);
  return scene;
}

Pose goldenPose() {
  return {{1.25, 0.5, 1.75}, {0.015625, -0.03125, 0.25, 0.96875}};
}

std::vector<GoldenGroup> goldenGroups() {
  const Sensor grid = builtinSensor("VLP-16"), head = builtinSensor("OS1-64"), list = builtinSensor("Avia");
  const std::vector<Field> surfaces = {Field::normal, Field::incidence, Field::material, Field::barycentrics};
  std::vector<Field> signals = {Field::intensity, Field::trueRange, Field::width, Field::label, Field::cause};
  signals.insert(signals.end(), surfaces.begin(), surfaces.end());
  Effects weather = effectsOf({"intensity=on", "detection.range=60", "detection.softness=0.2",
                               "drop-out.general_rate=0.1", "range-noise.sigma=0.02", "intensity-noise.sigma=0.05",
                               "angle-noise.azimuth=0.002", "fog.visibility=150", "rain.rate=20", "snow.rate=2"});
  weather.volumes = {EffectUse::on, {{{3, -5, -1}, {12, 4, 5}, 0.05}}};
  const Effects panes = effectsOf({"intensity=on", "transmission=on", "cut-outs=on", "returns.mode=all",
                                   "returns.count=3", "angle-noise.azimuth=0.001", "angle-noise.at=beam"});
  Effects footprints = panes;
  for (const char* more : {"divergence.sub_rays=7", "divergence.horizontal=0.003", "divergence.vertical=0.0015"})
    assign(footprints, more);
  // A scan with `exact` takes one instant.
  Effects byDefault;
  for (const char* less : {"sensor-motion=off", "object-motion=off"}) assign(byDefault, less);
  return {
      {{"grid", "spinning head", "list"},
       {{grid, Effects::none(), surfaces}, {head, Effects::none()}, {list, Effects::none()}}},
      {{"grid, weather and noise", "grid, panes, holes and echoes", "list, weather and noise"},
       {{grid, weather, signals}, {grid, panes, signals}, {list, weather, {Field::intensity, Field::label}}}},
      {{"grid, footprints of 7", "spinning head by default"},
       {{grid, footprints, signals}, {head, byDefault, {Field::intensity, Field::width, Field::cause}}}},
  };
}

std::string hashOf(const Scan& scan, const std::vector<Field>& fields) {
  std::string bytes;
  append(bytes, scan.points.data(), scan.points.size());
  append(bytes, scan.ranges.data(), scan.ranges.size());
  append(bytes, scan.triangles.data(), scan.triangles.size());
  append(bytes, scan.instances.data(), scan.instances.size());
  for (const Field field : fields) switch (fieldInfo(field).type) {
      case ValueType::u8: appendColumn<uint8_t>(bytes, scan, field); break;
      case ValueType::u16: appendColumn<uint16_t>(bytes, scan, field); break;
      case ValueType::u32: appendColumn<uint32_t>(bytes, scan, field); break;
      default: appendColumn<float>(bytes, scan, field);
    }
  return sha256Text(bytes).substr(0, 16);
}

std::span<const GoldenCloud> goldenTable() {
  return kTable;
}

std::vector<GoldenCloud> scanGolden(SimulatorOptions options, std::span<const GoldenGroup> groups) {
  options.accuracy = Accuracy::exact;
  const Scene scene = goldenScene();
  std::vector<GoldenCloud> clouds;
  for (const GoldenGroup& group : groups) {
    const size_t first = clouds.size();
    for (const std::string& name : group.names) clouds.push_back({name, ""});
    try {
      Simulator simulator(scene, group.requests, options);
      for (size_t i = 0; i < group.names.size(); ++i)
        clouds[first + i].hash = hashOf(simulator.scan(goldenPose(), i), group.requests[i].fields);
    } catch (const Error& error) {  // one group may exceed a device while the others fit
      for (size_t i = first; i < clouds.size(); ++i)
        if (clouds[i].hash.empty()) clouds[i].problem = error.what();
    }
  }
  return clouds;
}

std::vector<std::string> differencesOf(std::span<const GoldenCloud> clouds, std::span<const GoldenCloud> table) {
  std::vector<std::string> differences;
  const auto find = [](std::span<const GoldenCloud> where, const std::string& name) {
    return std::find_if(where.begin(), where.end(), [&](const GoldenCloud& cloud) { return cloud.name == name; });
  };
  for (const GoldenCloud& golden : table) {
    const auto cloud = find(clouds, golden.name);
    if (cloud == clouds.end())
      differences.push_back(golden.name + ": nobody scans it");
    else if (!cloud->problem.empty())
      differences.push_back(golden.name + ": " + cloud->problem);
    else if (cloud->hash != golden.hash)
      differences.push_back(golden.name + ": the hash is " + cloud->hash + ", not " + golden.hash);
  }
  for (const GoldenCloud& cloud : clouds)
    if (find(table, cloud.name) == table.end()) differences.push_back(cloud.name + ": the table has no hash of it");
  return differences;
}

}  // namespace gnosphere::bench
