// SPDX-License-Identifier: Apache-2.0
// The built-in presets, with the sources of their figures.
#include <filesystem>

#include "base/file.hpp"
#include "base/json_text.hpp"
#include "base/lasting.hpp"
#include "base/text.hpp"
#include "effects/request.hpp"
#include "sensor/carla_lidars.hpp"

namespace gnosphere {
namespace {

struct Preset {
  const char* name;
  Effects base;
  std::vector<const char*> assignments;
};

const std::vector<Preset>& presets() {
  static const auto& all = lasting(std::vector<Preset>{
      {"clean", Effects::none(), {}},
      {"auto", Effects(), {}},
      // sensor.lidar.ray_cast of CARLA 0.9 with its defaults: atmosphere_attenuation_rate, dropoff_general_rate,
      // dropoff_intensity_limit, dropoff_zero_intensity; its noise_stddev is 0, and it simulates nothing else.
      {"carla",
       Effects::none(),
       {"intensity.model=carla", "intensity.attenuation=0.004", "drop-out.general_rate=0.45",
        "drop-out.intensity_limit=0.8", "drop-out.zero_intensity_rate=0.4"}},
      // Velodyne HDL-64E S3, data sheet and manual 63-HDL64ES3: 50 m at 10 % reflectance, accuracy below 2 cm (one
      // sigma), packets in steps of 2 mm, intensity in a byte. The divergence is the one of HELIOS++ for this sensor.
      {"hdl-64e",
       Effects(),
       {"intensity.scale=byte", "detection.reflectance=0.1", "detection.range=50", "range-noise.sigma=0.02",
        "range-noise.step=0.002", "divergence.horizontal=0.0034", "divergence.vertical=0.0034"}},
      // Ouster OS1-64, data sheet of the first generation: 40 m at 10 % reflectance, repeatability 1.5 cm (one sigma,
      // at a good signal), range resolution 1.2 cm, angles within 0.01 degrees, divergence 0.13 degrees FWHM, which is
      // 3.85 mrad at 1/e^2. Its laser of 850 nm uses the column for 905 nm. The preset adds heavy rain.
      {"os1-rain",
       Effects(),
       {"detection.reflectance=0.1", "detection.range=40", "range-noise.sigma=0.015", "range-noise.step=0.012",
        "angle-noise.azimuth=0.000175", "angle-noise.elevation=0.000175", "divergence.horizontal=0.00385",
        "divergence.vertical=0.00385", "rain.rate=10"}},
  });
  return all;
}

/// A list of all beams of a large sensor takes tens of megabytes; a larger file is not a request.
constexpr size_t kMaxFileBytes = size_t{64} << 20;

}  // namespace

const std::vector<std::string>& effectPresets() {
  static const auto& names = lasting([] {
    std::vector<std::string> all;
    for (const Preset& preset : presets()) all.push_back(preset.name);
    return all;
  }());
  return names;
}

Effects effectPreset(const std::string& name) {
  std::string names;
  for (const Preset& preset : presets()) {
    names += (names.empty() ? "" : ", ") + std::string(preset.name);
    if (!sameWord(preset.name, name)) continue;
    Effects effects = preset.base;
    for (const char* assignment : preset.assignments) assign(effects, assignment);
    return effects;
  }
  throw Error(ErrorCode::invalidArgument, "no preset of effects is called '" + name + "'; known are " + names);
}

Effects loadEffects(const std::filesystem::path& file, const std::string& mode) {
  const std::string name = file.string();
  const nlohmann::json root = parseStrict(readWholeFile(file, kMaxFileBytes), name);
  if (isCarla(root)) return effectsOfCarla(root, name, mode);
  if (!mode.empty())
    throw Error(ErrorCode::invalidArgument,
                name + ": a mode is the id of a CARLA lidar, and the file describes none; leave '" + mode + "' out");
  return effectsFrom(root, name);
}

}  // namespace gnosphere
