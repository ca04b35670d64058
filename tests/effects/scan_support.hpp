// SPDX-License-Identifier: Apache-2.0
// Support for scans with effects: small scenes, a device compared with the reference, and CUDA compared with Vulkan.
#pragma once

#include <algorithm>

#include "cuda/twin.hpp"

namespace gnosphere::test {

/// Options for "reference", or for the Vulkan device with the validation layer.
inline SimulatorOptions optionsOn(const std::string& device) {
  if (device != "reference") needVulkan();
  SimulatorOptions options = vulkanOptions();
  if (device == "reference") options.device = device;
  return options;
}

/// Every field that a device computes for effects.
inline std::vector<Field> effectFields() {
  return {Field::intensity, Field::trueRange, Field::width,    Field::label,      Field::cause,
          Field::normal,    Field::incidence, Field::material, Field::radialSpeed};
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

/// A table with one row that states the reflectance, without the 4 % gloss of a glTF surface.
inline MaterialTable tableOf(const std::string& name, float reflectance) {
  MaterialTable table;
  MaterialTable::Row row;
  row.name = name;
  row.reflectance905 = reflectance;
  row.roughness = 1;
  table.rows.push_back(row);
  return table;
}

/// A sensor with beams in a narrow fan around the x axis: the middle columns of a fine sensor.
inline Sensor fan(uint32_t columns, uint32_t channels, double degrees, double rangeMax) {
  Sensor sensor{"fan", columns, {}, 0, rangeMax};
  for (uint32_t j = 0; j < channels; ++j)
    sensor.channels.push_back({channels == 1 ? 0 : degrees * (2.0 * j / (channels - 1) - 1), 0});
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
  compare("intensity", a.intensities, b.intensities);
  compare("true range", a.trueRanges, b.trueRanges);
  compare("width", a.widths, b.widths);
  compare("label", a.labels, b.labels);
  compare("cause", a.causes, b.causes);
  compare("normal", a.normals, b.normals);
  compare("incidence", a.incidences, b.incidences);
  compare("material", a.materials, b.materials);
  compare("barycentric", a.barycentrics, b.barycentrics);
  compare("velocity", a.velocities, b.velocities);
  compare("radial speed", a.radialSpeeds, b.radialSpeeds);
  compare("count of causes", a.counters.causes, b.counters.causes);
  return result.empty() ? "none" : result;
}

inline bool sameFields(const Scan& a, const Scan& b) {
  return firstBytes(a, b) == "none";
}

/// A simulator on Vulkan, and the same with CUDA: its kernels on the host, and on a CUDA device if there is one.
class Twins {
 public:
  Twins(const Scene& scene, const std::vector<Sensor>& sensors, SimulatorOptions options)
      : vulkan(scene, sensors, options), onHost(scene, sensors, options) {
    // With `standard` a range is a quotient, which a GPU's Vulkan driver may round differently.
    decided_ = options.accuracy == Accuracy::exact || vulkan.device().type == "cpu";
    options.device = "cuda:0";
    if (cudaProblem().empty()) cuda.emplace(scene, sensors, options);
  }

  /// Returns Vulkan's scan, after checking that CUDA's scans have the same bytes.
  Scan scan(const Shot& shot) {
    INFO("CUDA, frame " << shot.frame);
    Scan result, other, onDevice;
    vulkan.scan(shot, result);
    onHost.scan(shot, other);
    if (decided_) CHECK(firstBytes(result, other) == "none");
    if (!cuda) return result;
    cuda->scan(shot, onDevice);
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
inline Scan scanOn(const Scene& scene, const Sensor& sensor, const Shot& shot, const SimulatorOptions& options) {
  if (options.device != "reference") return Twins(scene, {sensor}, options).scan(shot);
  Scan result;
  Simulator(scene, sensor, options).scan(shot, result);
  return result;
}

inline Scan scanOn(const Scene& scene, const Sensor& sensor, const Pose& pose, const SimulatorOptions& options) {
  Shot shot;
  shot.pose = pose;
  return scanOn(scene, sensor, shot, options);
}

/// Counts of differences between two scans of the same shot; doubtful beams are only counted.
struct Differences {
  size_t beams = 0, ties = 0, causes = 0, returns = 0, owners = 0, ranges = 0, points = 0, intensities = 0, widths = 0;
  size_t surfaces = 0, speeds = 0;
  std::string first = "none";  ///< description of the first difference

  size_t all() const { return causes + returns + owners + ranges + points + intensities + widths + surfaces + speeds; }
};

/// Allowed differences.
struct Slack {
  double range = 0;         ///< m, besides the reference's own tolerance
  double intensity = 1e-4;  ///< relative
  double incidence = 2e-3;  ///< rad
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
  for (size_t beam = 0; beam < reference.beamCount(); ++beam) {
    ++sum.beams;
    if (reference.ties[beam * returns]) {
      ++sum.ties;
      continue;
    }
    if (!reference.causes.empty() && reference.causes[beam] != other.causes[beam]) {
      note(sum.causes, beam, "cause", reference.causes[beam], other.causes[beam]);
      continue;
    }
    for (size_t i = beam * returns; i < (beam + 1) * returns; ++i) {
      const double range = reference.ranges[i], tolerance = reference.tolerances[i] + slack.range + 3e-7 * range;
      const bool labelled = !reference.labels.empty();
      if (std::isnan(range) != std::isnan(other.ranges[i]) || (labelled && reference.labels[i] != other.labels[i])) {
        note(sum.returns, i, "range", range, other.ranges[i]);
        break;
      }
      if (std::isnan(range)) continue;
      if (!near(range, other.ranges[i], tolerance)) note(sum.ranges, i, "range", range, other.ranges[i]);
      if (labelled && !near(reference.trueRanges[i], other.trueRanges[i], tolerance))
        note(sum.ranges, i, "true range", reference.trueRanges[i], other.trueRanges[i]);
      for (size_t k = 3 * i; k < 3 * i + 3; ++k)
        if (!near(reference.points[k], other.points[k], tolerance + 1e-6 * range))
          note(sum.points, k, "coordinate", reference.points[k], other.points[k]);
      if (reference.triangles[i] != other.triangles[i] || reference.instances[i] != other.instances[i]) {
        note(sum.owners, i, "triangle", reference.triangles[i], other.triangles[i]);
        continue;
      }
      if (labelled) {
        const double intensity = reference.intensities[i];
        if (!near(intensity, other.intensities[i], slack.intensity * intensity + 1e-6))
          note(sum.intensities, i, "intensity", intensity, other.intensities[i]);
        if (!near(reference.widths[i], other.widths[i], tolerance + 1e-5))
          note(sum.widths, i, "width", reference.widths[i], other.widths[i]);
      }
      if (!reference.normals.empty()) {
        for (size_t k = 3 * i; k < 3 * i + 3; ++k)
          if (!near(reference.normals[k], other.normals[k], 1e-3))
            note(sum.surfaces, k, "normal", reference.normals[k], other.normals[k]);
        if (!near(reference.incidences[i], other.incidences[i], slack.incidence))
          note(sum.surfaces, i, "incidence", reference.incidences[i], other.incidences[i]);
        if (reference.materials[i] != other.materials[i])
          note(sum.surfaces, i, "material", reference.materials[i], other.materials[i]);
      }
      if (!reference.barycentrics.empty())
        for (size_t k = 2 * i; k < 2 * i + 2; ++k)
          if (!near(reference.barycentrics[k], other.barycentrics[k], 5e-3))
            note(sum.surfaces, k, "weight", reference.barycentrics[k], other.barycentrics[k]);
      if (!reference.radialSpeeds.empty() && !near(reference.radialSpeeds[i], other.radialSpeeds[i], 1e-3))
        note(sum.speeds, i, "radial speed", reference.radialSpeeds[i], other.radialSpeeds[i]);
    }
  }
  return sum;
}

}  // namespace gnosphere::test
