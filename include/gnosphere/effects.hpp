// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "gnosphere/export.hpp"
#include "gnosphere/scene.hpp"

namespace gnosphere {

/// Whether an effect is wanted. `automatic` takes it where the scene, the sensor and the request can show it, and
/// leaves it out, with the reason in the Plan, where they cannot.
enum class EffectUse { off, on, automatic };

/// What a scan simulates beside geometry, each effect a value with its parameters. What is not planned is neither
/// compiled into a pipeline nor allocated nor dispatched. Units: metres, radians, seconds, 1/m; powers are relative to
/// a Lambertian target of reflectance 1, square to the beam, at 1 m.
struct Effects {
  /// Every random number is keyed by (seed, sensor, frame, beam, sub-ray, effect): one effect never changes the draws
  /// of another, and the same seed gives the same draws on every device.
  uint64_t seed = 1;

  /// How strong a return is: reflectance, incidence, range. Automatic: where a field or another effect asks for it.
  struct Intensity {
    EffectUse use = EffectUse::automatic;
    enum class Model {
      physical,  ///< reflectance * lobe(incidence) / range^2 * exp(-2 extinction range)
      carla,     ///< exp(-attenuation * range), whatever the surface
    } model = Model::physical;
    enum class Scale {
      raw,   ///< the relative power received
      unit,  ///< 0..1: what a Lambertian target square to the beam at that range would need as reflectance, cut off at
             ///< 1
      byte,  ///< 0..255 calibrated reflectivity: 0..100 diffuse per cent, 101..255 retro-reflectors, logarithmic
    } scale = Scale::unit;
    double wavelength = 905;     ///< nm; 905 or 1550: the column of a material table
    double attenuation = 0.004;  ///< 1/m, of `carla`
  } intensity;

  /// A return must be strong enough: as strong as that of `reflectance` square to the beam at `range`.
  struct Detection {
    EffectUse use = EffectUse::off;
    double reflectance = 0.1;
    double range = 0;     ///< metres; 0: the sensor's rangeMax
    double softness = 0;  ///< relative width of the probability curve (logistic in ln power); 0: a sharp threshold
  } detection;

  /// Returns lost at random, as CARLA's dropoff_*, and beams that are broken.
  struct DropOut {
    EffectUse use = EffectUse::off;
    double generalRate = 0;           ///< 0..1, whatever the return
    double intensityLimit = 1;        ///< unit intensity above which none is lost for weakness
    double zeroIntensityRate = 0;     ///< 0..1, at intensity 0; linear up to the limit
    std::vector<uint32_t> deadBeams;  ///< beam indices
  } dropOut;

  struct RangeNoise {
    EffectUse use = EffectUse::off;
    double bias = 0;           ///< m
    double sigma = 0;          ///< m
    double sigmaPerMetre = 0;  ///< added to sigma, times the range
    double step = 0;           ///< m: ranges are whole multiples; 0: not quantised
  } rangeNoise;

  struct AngleNoise {
    EffectUse use = EffectUse::off;
    double azimuth = 0;    ///< rad, sigma; cut off at 4 sigma
    double elevation = 0;  ///< rad, sigma; cut off at 4 sigma
    enum class At {
      beam,   ///< the beam goes astray, and is reported where it was meant to go
      point,  ///< the beam goes where it should, and its point is reported astray
    } at = At::beam;
  } angleNoise;

  struct IntensityNoise {
    EffectUse use = EffectUse::off;
    double sigma = 0;  ///< of unit intensity
  } intensityNoise;

  /// An elliptical footprint of sub-rays that share their beam's candidates.
  struct Divergence {
    EffectUse use = EffectUse::automatic;
    uint32_t subRays = 19;  ///< 1..61; 1 + 6 + 12 + ... lie on rings
    enum class Profile { uniform, gaussian } profile = Profile::gaussian;
    double horizontal = 0, vertical = 0;  ///< rad, full angle (1/e^2 of gaussian); both 0: what the sensor states
  } divergence;

  /// Which echoes of a beam are returned. Automatic: where the sensor states more than one.
  struct Returns {
    EffectUse use = EffectUse::automatic;
    enum class Mode {
      first,
      second,
      last,
      strongest,
      secondStrongest,
      firstSecond,
      firstLast,
      firstStrongest,
      lastStrongest,
      strongestSecondStrongest,
      all,  ///< in order of range
    } mode = Mode::all;
    uint32_t count = 0;        ///< of `all`, 1..5; 0: what the sensor states
    double separation = 0.4;   ///< m: nearer echoes are one
    double pulseWidth = 5e-9;  ///< s, full width at half maximum
  } returns;

  /// What glass lets through: alpha BLEND and KHR_materials_transmission.
  struct Transmission {
    EffectUse use = EffectUse::automatic;
  } transmission;

  /// Holes in surfaces: alpha MASK with its texture.
  struct CutOuts {
    EffectUse use = EffectUse::automatic;
  } cutOuts;

  /// The sensor moves while it turns: Shot::motion. Automatic: where the shot says so and the sensor takes time.
  struct SensorMotion {
    EffectUse use = EffectUse::automatic;
    bool deskew = false;  ///< points are reported from the pose of the shot, not from that of their own column
  } sensorMotion;

  /// Instances move while the sensor turns: Shot::instanceMotions.
  struct ObjectMotion {
    EffectUse use = EffectUse::automatic;
  } objectMotion;

  struct Fog {
    EffectUse use = EffectUse::automatic;  ///< automatic: where there is a visibility
    double visibility = 0;                 ///< m, meteorological optical range (5 % contrast, Koschmieder); 0: none
  } fog;
  struct Rain {
    EffectUse use = EffectUse::automatic;  ///< automatic: where there is a rate
    double rate = 0;                       ///< mm/h
  } rain;
  struct Snow {
    EffectUse use = EffectUse::automatic;  ///< automatic: where there is a rate
    double rate = 0;                       ///< mm/h, melted
  } snow;
  /// Dust or spray that stands in a box.
  struct Volume {
    Vec3 min, max;          ///< world, metres
    double extinction = 0;  ///< 1/m
  };
  struct Volumes {
    EffectUse use = EffectUse::automatic;  ///< automatic: where there are any
    std::vector<Volume> boxes;
  } volumes;

  /// How fast the surface comes nearer or goes away along the beam (FMCW), m/s, positive going away. Automatic: where
  /// the field is asked for.
  struct RadialSpeed {
    EffectUse use = EffectUse::automatic;
  } radialSpeed;

  /// Nothing but geometry.
  GNOSPHERE_API static Effects none();
};

/// The medium of one shot, with the units of Effects::Fog, Rain, Snow and Volumes. Zero and none: clear air.
struct Weather {
  double visibility = 0;  ///< m
  double rainRate = 0;    ///< mm/h
  double snowRate = 0;    ///< mm/h, melted
  std::vector<Effects::Volume> volumes;
};

/// What an effect is called in a request, a plan and the docs: "intensity", "detection", "drop-out", "range-noise",
/// "angle-noise", "intensity-noise", "divergence", "returns", "transmission", "cut-outs", "sensor-motion",
/// "object-motion", "fog", "rain", "snow", "volumes", "radial-speed"; in this order.
GNOSPHERE_API const std::vector<std::string>& effectNames();

/// Throws Error(invalidArgument) for a parameter out of its range, naming both.
GNOSPHERE_API void validate(const Effects& effects);

/// The ready ones: "clean" (geometry alone), "auto", "carla", "hdl-64e", "os1-rain".
GNOSPHERE_API const std::vector<std::string>& effectPresets();

/// The preset of that name; case does not matter. Throws Error(invalidArgument) with the names that are known.
GNOSPHERE_API Effects effectPreset(const std::string& name);
/// Reads effects from a JSON file. Throws Error(file), or Error(format) that names an unknown effect or parameter and
/// those nearest to it.
GNOSPHERE_API Effects loadEffects(const std::filesystem::path& file);
/// As loadEffects(), of a text; `source` names it in messages.
GNOSPHERE_API Effects effectsFromJson(std::string_view json, const std::string& source);
GNOSPHERE_API std::string toJson(const Effects& effects);
/// One assignment of a command line: "fog.visibility=200" sets a parameter and asks for the effect, "divergence=off" a
/// Use. Throws Error(invalidArgument).
GNOSPHERE_API void assign(Effects& effects, const std::string& assignment);

/// How a material meets a laser. Reflectance is of the wavelength that the effects state.
struct Optics {
  float reflectance = 0;   ///< diffuse (Lambertian), 0..1
  float gloss = 0;         ///< share of the light in the glossy lobe, 0..1
  float roughness = 1;     ///< of that lobe, 0..1
  float retro = 0;         ///< gain of retro-reflection over a Lambertian of reflectance 1; 0: none
  float transmission = 0;  ///< share of the light let through, 0..1
};

/// What a glTF material says: base colour (its red stands for near infrared), metallic, roughness, transmission, alpha.
GNOSPHERE_API Optics opticsOf(const Material& material);

/// Reflectances per material name, over what the materials of a scene say themselves.
struct MaterialTable {
  struct Row {
    std::string name;           ///< of the scene's material; case does not matter
    float reflectance905 = -1;  ///< 0..1; negative: not stated
    float reflectance1550 = -1;
    float roughness = -1, retro = -1, transmission = -1;
  };
  std::vector<Row> rows;
};

/// JSON of ours, or ASAM OpenMATERIAL 3D (.xoma, .xomm or .xomp). Throws Error(file) or Error(format).
GNOSPHERE_API MaterialTable loadMaterialTable(const std::filesystem::path& file);

/// Per material of the scene. A name of the table that no material has is told in `unused`, if given.
GNOSPHERE_API std::vector<Optics> opticsOf(const Scene& scene, const MaterialTable& table, double wavelength,
                                           std::vector<std::string>* unused = nullptr);

}  // namespace gnosphere
