// SPDX-License-Identifier: Apache-2.0
// The examples of docs/api.md: everything below the using directive is the text of its C++ blocks, in their order.
// tests/docs/check_page compares the examples with the page.
#pragma once

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <gnosphere/gnosphere.hpp>
#include <numbers>
#include <span>

using namespace gnosphere;

/// Scans a file with an HDL-64E that stands 1.8 m above the origin.
Scan scanOnce(const std::string& file) {
  Simulator simulator(loadScene(file), builtinSensor("HDL-64E"));
  return simulator.scan({{0, 0, 1.8}, {}});
}

/// Reads a calibration of a VLP-16, which states angles only; the catalogue states the rest. Prints what is left open.
Sensor calibrated(const std::string& file) {
  SensorFileOptions options;
  options.head = "Puck:20Hz";
  const SensorFile read = readSensorFile(std::filesystem::path(file), options);
  for (const std::string& text : read.assumed) std::printf("assumed: %s\n", text.c_str());
  for (const std::string& text : read.ignored) std::printf("ignored: %s\n", text.c_str());
  return read.sensor;
}

/// A solid-state lidar that looks ahead: 100 rows of 200 beams, 0.5 degrees apart, which fire within 50 ms.
Sensor solidState() {
  constexpr double kDegree = std::numbers::pi / 180;
  BeamList beams;
  beams.width = 200;
  beams.height = 100;
  for (int row = 0; row < 100; ++row)
    for (int column = 0; column < 200; ++column) {
      const double azimuth = 0.5 * (100 - column) * kDegree, elevation = 0.5 * (row - 50) * kDegree;
      beams.directions.push_back(
          {std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth), std::sin(elevation)});
      beams.times.push_back(0.05 * (200 * row + column) / 20'000);
    }
  Sensor sensor;
  sensor.name = "solid state";
  sensor.rangeMax = 150;
  sensor.patterns = {beams};
  return sensor;
}

/// Two lidars on one scene: one with the noise and footprint of a preset, one that is geometry alone and reports
/// surface normals.
Simulator twoLidars(const Scene& scene) {
  Effects worn = effectPreset("hdl-64e");
  worn.rangeNoise = {EffectUse::on, 0, 0.03};
  const SensorRequest first(builtinSensor("HDL-64E"), worn, {Field::intensity, Field::time});
  const SensorRequest second(builtinSensor("VLP-16"), Effects::none(), {Field::normal});
  return Simulator(scene, {first, second});
}

/// Scans a walking person from beside, eight times a second of the animation `Walk`.
std::vector<Scan> walk(const std::string& file) {
  const Scene scene = loadScene(file);
  const Clip& clip = clipNamed(scene, "Walk");
  Simulator simulator(scene, builtinSensor("VLP-16"));
  std::vector<Scan> scans;
  for (double time = 0; time < clip.duration; time += 0.125) {
    const SceneState state = stateAt(scene, clip, time);
    for (size_t i = 0; i < state.transforms.size(); ++i) simulator.setTransform(i, state.transforms[i]);
    for (size_t i = 0; i < state.deformations.size(); ++i)
      if (scene.meshes[i].deformable()) simulator.setDeformation(i, state.deformations[i]);
    scans.push_back(simulator.scan({{-5, 0, 1}, {}}));
  }
  return scans;
}

/// A car of several parts drives in for one scan.
Scan withCar(Simulator& simulator, const Scene& car, const Transform& place) {
  const AddedScene added = simulator.addScene(car, place);
  Scan scan = simulator.scan({});
  for (const uint32_t instance : added.instances) simulator.removeInstance(instance);
  for (const uint32_t mesh : added.meshes) simulator.removeMesh(mesh);
  for (const uint32_t material : added.materials) simulator.removeMaterial(material);
  return scan;
}

/// Scans a fog that thickens, with a sensor that was added with variableWeather.
void thickeningFog(Simulator& simulator, const std::function<void(const Scan&)>& use) {
  Shot shot;
  Scan scan;  // its arrays are used again
  for (double visibility : {400, 200, 100, 50}) {
    shot.weather = Weather{visibility, 0, 0, {}};
    simulator.scanInto(shot, scan);
    use(scan);
    ++shot.frame;  // other random numbers
  }
}

/// Scans shots of each kind, of each sensor, with what may come into the scene, so that their kernels are compiled.
void warmUp(Simulator& simulator, std::span<const Shot> shots, uint32_t leaves, uint32_t glass) {
  const auto scan = [&] {
    Scan result;
    for (const Shot& shot : shots)
      for (int i = 0; i < 3; ++i) simulator.scanInto(shot, result);
  };
  scan();
  const size_t tree = simulator.addInstance(leaves, {}, 0, 99);
  scan();
  const size_t window = simulator.addInstance(glass, {}, 0, 99);
  scan();
  simulator.removeInstance(tree);
  scan();
  simulator.removeInstance(window);
}

/// The mean intensity of the returns.
double meanIntensity(const Scan& scan) {
  const auto intensities = scan.column<float>(Field::intensity);
  double sum = 0, count = 0;
  for (size_t i = 0; i < intensities.size(); ++i)
    if (scan.returned(i)) sum += intensities[i], ++count;
  return count > 0 ? sum / count : 0;
}

/// The data of a ROS PointCloud2 of x, y, z and intensity, with one point per return.
std::vector<std::byte> pointCloud(const Scan& scan) {
  RecordLayout layout;
  layout.values = {{Field::x, 0, 0}, {Field::y, 0, 4}, {Field::z, 0, 8}, {Field::intensity, 0, 16}};
  layout.stride = 32;
  layout.compact = true;
  std::vector<std::byte> rows(scan.ranges.size() * layout.stride);
  rows.resize(pack(scan, layout, rows) * layout.stride);
  return rows;
}
