// SPDX-License-Identifier: Apache-2.0
// Support for scans with effects: small scenes, a device compared with the reference, and CUDA compared with Vulkan.
#pragma once

#include <algorithm>
#include <catch2/generators/catch_generators.hpp>

#include "columns.hpp"
#include "cuda/twin.hpp"

namespace gnosphere::test {

/// Generates the names of devices for optionsOn(), so that a test runs once with each device.
#define ON_EVERY_DEVICE GENERATE(as<std::string>{}, "reference", "vulkan")

inline constexpr double kPeriod = 0.1;  // seconds of a rotation

/// Options for "reference", or for the Vulkan device with the validation layer.
inline TestOptions optionsOn(const std::string& device) {
  if (device != "reference") needVulkan();
  TestOptions options = vulkanOptions();
  options.device = deviceByName(device == "reference" ? device : "auto");
  return options;
}

/// Every field that a device computes for effects, for tests in which nothing moves. With the radial speed, a device
/// would compile each pipeline a second time, for motion.
inline std::vector<Field> stillFields() {
  return {Field::intensity, Field::trueRange, Field::width,     Field::label,
          Field::cause,     Field::normal,    Field::incidence, Field::material};
}

/// Every field that a device computes for effects.
inline std::vector<Field> effectFields() {
  std::vector<Field> fields = stillFields();
  fields.push_back(Field::radialSpeed);
  return fields;
}

/// A plate of one material, perpendicular to the x axis at a distance, `half` metres to each side.
inline Mesh plate(double distance, double half, uint32_t material = 0) {
  MeshBuilder builder;
  builder.quad({distance, half, -half}, {0, -2 * half, 0}, {0, 0, 2 * half});
  return builder.take(material);
}

/// A diffuse, two-sided material with a reflectance.
inline Material lambertian(float reflectance, const char* name = "dull") {
  Material result;
  result.name = name;
  result.baseColor = {reflectance, reflectance, reflectance, 1};
  return result;
}

/// Adds a fence to a scene: a plate with holes, whose texture repeats and is mirrored. `alpha` is the opacity of its
/// material.
inline void addFence(Scene& scene, Mesh plate, const Transform& placed, float alpha = 1) {
  Material fence = lambertian(0.5f, "fence");
  fence.doubleSided = true;
  fence.alphaMode = AlphaMode::mask;
  fence.alphaImage = static_cast<uint32_t>(scene.alphaImages.size());
  fence.baseColor[3] = alpha;
  scene.alphaImages.push_back({3, 2, {0, 255, 90, 200, 0, 255}, AlphaImage::Wrap::mirror, AlphaImage::Wrap::repeat});
  plate.parts[0].material = static_cast<uint32_t>(scene.materials.size());
  plate.uvs = {-1.7f, 0, 0, 4.5f, 3.1f, 0, 2, 4};
  scene.materials.push_back(fence);
  scene.meshes.push_back(plate);
  scene.instances.push_back({"fence", static_cast<uint32_t>(scene.meshes.size() - 1), placed});
}

/// A sensor of a full turn, whose channels look at most `degrees` up or down.
inline Sensor fan(uint32_t columns, uint32_t channels, double degrees, double rangeMax) {
  Sensor sensor{"fan", columns, {}, 0, rangeMax};
  for (uint32_t j = 0; j < channels; ++j)
    sensor.channels.push_back({channels == 1 ? 0 : degrees * (2.0 * j / (channels - 1) - 1), 0});
  return sensor;
}

/// The same beams of a sensor of a full turn, but for those outside of the `columns` columns round straight ahead.
inline Sensor sector(Sensor sensor, uint32_t columns) {
  const double share = static_cast<double>(columns) / sensor.columns;
  sensor.azimuthStartDeg *= share;
  sensor.azimuthSpanDeg *= share;
  sensor.columns = columns;
  return sensor;
}

/// Index of a channel's beam straight ahead.
inline size_t ahead(const Sensor& sensor, size_t channel = 0) {
  return channel * sensor.columns + sensor.columns / 2;
}

/// Returns which arrays differ, except ties and tolerances, and the first place in each.
inline std::string firstBytes(const Scan& a, const Scan& b) {
  std::string result;
  const auto compare = [&](const char* name, const auto& first, const auto& second) {
    size_t i = 0;
    while (i < first.size() && i < second.size() && std::memcmp(&first[i], &second[i], sizeof first[i]) == 0) ++i;
    if (i == first.size() && i == second.size()) return;
    result += std::string(name) + " " + std::to_string(i);
    if (i < first.size() && i < second.size())
      result += ": " + std::to_string(first[i]) + ", got " + std::to_string(second[i]);
    result += "; ";
  };
  compare("point", a.points, b.points);
  compare("range", a.ranges, b.ranges);
  compare("triangle", a.triangles, b.triangles);
  compare("instance", a.instances, b.instances);
  compare("intensity", valuesOf<float>(a, Field::intensity), valuesOf<float>(b, Field::intensity));
  compare("true range", valuesOf<float>(a, Field::trueRange), valuesOf<float>(b, Field::trueRange));
  compare("width", valuesOf<float>(a, Field::width), valuesOf<float>(b, Field::width));
  compare("label", valuesOf<uint8_t>(a, Field::label), valuesOf<uint8_t>(b, Field::label));
  compare("cause", valuesOf<uint8_t>(a, Field::cause), valuesOf<uint8_t>(b, Field::cause));
  compare("normal", valuesOf<float>(a, Field::normal), valuesOf<float>(b, Field::normal));
  compare("incidence", valuesOf<float>(a, Field::incidence), valuesOf<float>(b, Field::incidence));
  compare("material", valuesOf<uint32_t>(a, Field::material), valuesOf<uint32_t>(b, Field::material));
  compare("barycentric", valuesOf<float>(a, Field::barycentrics), valuesOf<float>(b, Field::barycentrics));
  compare("velocity", valuesOf<float>(a, Field::velocity), valuesOf<float>(b, Field::velocity));
  compare("radial speed", valuesOf<float>(a, Field::radialSpeed), valuesOf<float>(b, Field::radialSpeed));
  compare("count of causes", a.counters.causes, b.counters.causes);
  return result.empty() ? "none" : result;
}

inline bool sameFields(const Scan& a, const Scan& b) {
  return firstBytes(a, b) == "none";
}

/// A simulator on Vulkan, and the same with CUDA: its kernels on the host, and on a CUDA device if there is one.
class Twins {
 public:
  Twins(const Scene& scene, const std::vector<Sensor>& sensors, TestOptions options)
      : vulkan(makeSimulator(scene, sensors, options)), onHost(scene, sensors, options) {
    decided_ = options.accuracy == Accuracy::exact || dividesExactly(vulkan.device());
    options.device = deviceByName("cuda:0");
    if (cudaProblem().empty()) cuda.emplace(makeSimulator(scene, sensors, options));
  }

  /// Returns Vulkan's scan, after checking that CUDA's scans have the same bytes.
  Scan scan(const Shot& shot) {
    INFO("CUDA, frame " << shot.frame);
    Scan result, other, onDevice;
    vulkan.scanInto(shot, result);
    onHost.scanInto(shot, other);
    if (decided_) CHECK(firstBytes(result, other) == "none");
    if (!cuda) return result;
    cuda->scanInto(shot, onDevice);
    CHECK(firstBytes(other, onDevice) == "none");
    return result;
  }

  Simulator vulkan;
  CudaOnHost onHost;
  std::optional<Simulator> cuda;

 private:
  bool decided_;
};

/// Scans on the options' device; if that is Vulkan's, checks that CUDA gives the same bytes.
inline Scan scanOn(const Scene& scene, const Sensor& sensor, const Shot& shot, const TestOptions& options) {
  if (options.device.kind != DeviceChoice::Kind::reference) return Twins(scene, {sensor}, options).scan(shot);
  Scan result;
  makeSimulator(scene, sensor, options).scanInto(shot, result);
  return result;
}

inline Scan scanOn(const Scene& scene, const Sensor& sensor, const Pose& pose, const TestOptions& options) {
  Shot shot;
  shot.pose = pose;
  return scanOn(scene, sensor, shot, options);
}

/// Returns a rotation about the vertical axis, in radians.
inline Quaternion yaw(double angle) {
  return {0, 0, std::sin(angle / 2), std::cos(angle / 2)};
}

/// Counts of differences between two scans of the same shot; doubtful beams are only counted.
struct Differences {
  size_t beams = 0, ties = 0, causes = 0, returns = 0, owners = 0, ranges = 0, points = 0, intensities = 0, widths = 0;
  size_t surfaces = 0, speeds = 0;  ///< speeds: radial ones and velocities
  std::string first = "none";       ///< description of the first difference

  size_t all() const { return causes + returns + owners + ranges + points + intensities + widths + surfaces + speeds; }
  std::string text() const {
    std::string result;
    const std::pair<size_t, const char*> counts[] = {{causes, "causes"}, {returns, "returns"},
                                                     {owners, "owners"}, {ranges, "ranges"},
                                                     {points, "points"}, {intensities, "intensities"},
                                                     {widths, "widths"}, {surfaces, "surfaces"},
                                                     {speeds, "speeds"}, {ties, "ties"}};
    for (const auto& [count, name] : counts) result += std::to_string(count) + " " + name + ", ";
    return result + "of " + std::to_string(beams) + " beams; first: " + first;
  }
};

/// Differences allowed between two scans.
struct Slack {
  double range = 0;         ///< m, besides the reference's own tolerance
  double intensity = 1e-4;  ///< relative
  double incidence = 2e-3;  ///< rad
  double trueRange = 0;     ///< m, more than for the range, whose own noise may be in steps and so hide an error
};

inline Differences differences(const Scan& reference, const Scan& other, const Slack& slack = {}) {
  Differences sum;
  const auto near = [](double a, double b, double most) {
    return (std::isnan(a) && std::isnan(b)) || std::abs(a - b) <= most;
  };
  const auto note = [&](size_t& count, size_t entry, const char* what, double expected, double got) {
    if (++count == 1 && sum.first == "none")
      sum.first = std::string(what) + " of entry " + std::to_string(entry) + ": " + std::to_string(expected) +
                  ", got " + std::to_string(got);
  };
  const uint32_t returns = reference.returns;
  const auto ties = reference.column<uint8_t>(Field::tie);
  const auto tolerances = reference.column<float>(Field::tolerance);
  // Fields of surfaces and the weights come and go together; so do the signals but for the intensity.
  const auto bothOf = [&](Field field) {
    return std::pair(valuesOf<float>(reference, field), valuesOf<float>(other, field));
  };
  const auto causes = std::pair(valuesOf<uint8_t>(reference, Field::cause), valuesOf<uint8_t>(other, Field::cause));
  const auto labels = std::pair(valuesOf<uint8_t>(reference, Field::label), valuesOf<uint8_t>(other, Field::label));
  const auto materials =
      std::pair(valuesOf<uint32_t>(reference, Field::material), valuesOf<uint32_t>(other, Field::material));
  const auto trueRanges = bothOf(Field::trueRange), intensities = bothOf(Field::intensity),
             widths = bothOf(Field::width);
  const auto normals = bothOf(Field::normal), incidences = bothOf(Field::incidence);
  const auto barycentrics = bothOf(Field::barycentrics), radialSpeeds = bothOf(Field::radialSpeed);
  const auto velocities = bothOf(Field::velocity);
  for (size_t beam = 0; beam < reference.beamCount(); ++beam) {
    ++sum.beams;
    if (ties[beam * returns]) {
      ++sum.ties;
      continue;
    }
    if (!causes.first.empty() && causes.first[beam * returns] != causes.second[beam * returns]) {
      note(sum.causes, beam, "cause", causes.first[beam * returns], causes.second[beam * returns]);
      continue;
    }
    for (size_t i = beam * returns; i < (beam + 1) * returns; ++i) {
      const double range = reference.ranges[i], tolerance = tolerances[i] + slack.range + 3e-7 * range;
      const bool labelled = !labels.first.empty();
      if (std::isnan(range) != std::isnan(other.ranges[i]) || (labelled && labels.first[i] != labels.second[i])) {
        note(sum.returns, i, "range", range, other.ranges[i]);
        break;
      }
      if (std::isnan(range)) continue;
      if (!near(range, other.ranges[i], tolerance)) note(sum.ranges, i, "range", range, other.ranges[i]);
      if (labelled && !near(trueRanges.first[i], trueRanges.second[i], tolerance + slack.trueRange))
        note(sum.ranges, i, "true range", trueRanges.first[i], trueRanges.second[i]);
      for (size_t k = 3 * i; k < 3 * i + 3; ++k)
        if (!near(reference.points[k], other.points[k], tolerance + 1e-6 * range))
          note(sum.points, k, "coordinate", reference.points[k], other.points[k]);
      if (reference.triangles[i] != other.triangles[i] || reference.instances[i] != other.instances[i]) {
        note(sum.owners, i, "triangle", reference.triangles[i], other.triangles[i]);
        continue;
      }
      if (!intensities.first.empty()) {
        const double intensity = intensities.first[i];
        if (!near(intensity, intensities.second[i], slack.intensity * intensity + 1e-6))
          note(sum.intensities, i, "intensity", intensity, intensities.second[i]);
      }
      if (labelled && !near(widths.first[i], widths.second[i], tolerance + 1e-5))
        note(sum.widths, i, "width", widths.first[i], widths.second[i]);
      if (!normals.first.empty()) {
        for (size_t k = 3 * i; k < 3 * i + 3; ++k)
          if (!near(normals.first[k], normals.second[k], 1e-3))
            note(sum.surfaces, k, "normal", normals.first[k], normals.second[k]);
        if (!near(incidences.first[i], incidences.second[i], slack.incidence))
          note(sum.surfaces, i, "incidence", incidences.first[i], incidences.second[i]);
        if (materials.first[i] != materials.second[i])
          note(sum.surfaces, i, "material", materials.first[i], materials.second[i]);
      }
      if (!barycentrics.first.empty())
        for (size_t k = 2 * i; k < 2 * i + 2; ++k)
          if (!near(barycentrics.first[k], barycentrics.second[k], 5e-3))
            note(sum.surfaces, k, "weight", barycentrics.first[k], barycentrics.second[k]);
      if (!radialSpeeds.first.empty() && !near(radialSpeeds.first[i], radialSpeeds.second[i], 1e-3))
        note(sum.speeds, i, "radial speed", radialSpeeds.first[i], radialSpeeds.second[i]);
      if (!velocities.first.empty())
        for (size_t k = 3 * i; k < 3 * i + 3; ++k)
          if (!near(velocities.first[k], velocities.second[k], 5e-3))
            note(sum.speeds, k, "velocity", velocities.first[k], velocities.second[k]);
    }
  }
  return sum;
}

/// Checks that a device's scan of a shot differs from the reference's in doubtful beams alone, and that more than one
/// in `oneIn` of its beams hits.
inline void checkBesideReference(Simulator& device, Simulator& reference, const Shot& shot, const Slack& slack,
                                 uint64_t oneIn) {
  Scan found, expected;
  device.scanInto(shot, found);
  reference.scanInto(shot, expected);
  CHECK(found.counters.hits > found.beamCount() / oneIn);
  const Differences result = differences(expected, found, slack);
  INFO(result.text());
  CHECK(result.all() == 0);
}

}  // namespace gnosphere::test
