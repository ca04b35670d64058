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

/// Whether an effect is simulated. With `automatic` it is, if the scene, the sensor and the request can show it;
/// otherwise it is left out, and the Plan gives the reason.
enum class EffectUse { off, on, automatic };

/// The effects that a scan simulates beside geometry, each with its parameters. For an effect that is not planned no
/// code is compiled into a pipeline, no memory is allocated and no work is dispatched. Units are metres, radians,
/// seconds and 1/m; powers are relative to a Lambertian target of reflectance 1, square to the beam, at 1 m.
struct Effects {
  /// Every random number is keyed by (seed, sensor, frame, beam, sub-ray or echo, effect): one effect never changes the
  /// draws of another, and the same seed gives the same draws on every device.
  uint64_t seed = 1;

  /// Strength of a return from reflectance, incidence and range. Automatic: on if a field or another effect needs it.
  struct Intensity {
    EffectUse use = EffectUse::automatic;
    enum class Model {
      physical,                 ///< reflectance * lobe(incidence) / range^2 * exp(-2 extinction range)
      carla,                    ///< exp(-attenuation * range), independent of the surface
    } model = Model::physical;  ///< what the strength of a return depends on
    enum class Scale {
      raw,   ///< received power, relative as above
      unit,  ///< 0..1: reflectance of the Lambertian target square to the beam that would return as much power from the
             ///< same range, cut off at 1
      byte,  ///< 0..255, calibrated reflectivity: 0..100 for diffuse per cent, 101..255 logarithmic for
             ///< retro-reflectors
    } scale = Scale::unit;       ///< in which values the strength is reported
    double wavelength = 905;     ///< nm; selects the column of a material table, and the extinction of fog and snow
    double attenuation = 0.004;  ///< 1/m; only for the model `carla`
  } intensity;

  /// A return is detected only if it is as strong as that of a Lambertian target of `reflectance`, facing it at
  /// `range`. Automatic: on if a range is given, with weather, or if the sensor has a range at 10 % and a table all
  /// reflectances.
  struct Detection {
    EffectUse use = EffectUse::automatic;
    double reflectance = 0.1;  ///< of the weakest target that is detected, 0..1
    /// m, distance of that target; 0 means 10 % at the range that the sensor states for it, or else at its largest
    /// range
    double range = 0;
    double softness = 0;  ///< relative width of the probability curve (logistic in ln power); 0 for a sharp threshold
  } detection;

  /// Returns that are lost at random, as with CARLA's dropoff_* parameters, and dead beams. Automatic: on if a
  /// rate or a dead beam is given.
  struct DropOut {
    EffectUse use = EffectUse::automatic;
    double generalRate = 0;           ///< probability that a beam is lost with all its returns, 0..1
    double intensityLimit = 1;        ///< unit intensity above which the rate at intensity 0 has no effect
    double zeroIntensityRate = 0;     ///< probability at intensity 0, 0..1; falls linearly to 0 at the limit
    std::vector<uint32_t> deadBeams;  ///< indices of beams that never return anything: channel * columns + column
  } dropOut;

  /// Errors of the range: bias, Gaussian noise and quantisation. Automatic: on if a bias, a sigma or a step is given.
  struct RangeNoise {
    EffectUse use = EffectUse::automatic;
    double bias = 0;                 ///< m, added to every range
    double sigma = 0;                ///< m, standard deviation
    double sigmaPerMetre = 0;        ///< m per m; times the range, added to sigma
    double step = 0;                 ///< m; ranges are rounded to multiples of it; 0 for no quantisation
    double sigmaPerSquareMetre = 0;  ///< 1/m; times the square of the range, added to sigma
    /// m; standard deviation of an error of its own at detection's threshold, which falls with the power of the echo
    double sigmaAtThreshold = 0;
  } rangeNoise;

  /// Gaussian errors of the beam directions. Automatic: on if a standard deviation is given.
  struct AngleNoise {
    EffectUse use = EffectUse::automatic;
    double azimuth = 0;    ///< rad, standard deviation; cut off at 4 sigma
    double elevation = 0;  ///< rad, standard deviation; cut off at 4 sigma
    enum class At {
      beam,           ///< the beam deviates, but its point is reported in the nominal direction
      point,          ///< the beam has the nominal direction, but its point is reported in the deviating one
    } at = At::beam;  ///< what deviates
  } angleNoise;

  /// Gaussian noise of the intensity. Automatic: on if a sigma is given.
  struct IntensityNoise {
    EffectUse use = EffectUse::automatic;
    double sigma = 0;  ///< standard deviation, on the scale of unit intensity
  } intensityNoise;

  /// A footprint, sampled by sub-rays that share the candidate triangles of their beam.
  struct Divergence {
    EffectUse use = EffectUse::automatic;
    uint32_t subRays = 19;  ///< lines per beam; devices take at most 61; numbers 1 + 6 + 12 + ... lie on rings
    enum class Profile { uniform, gaussian } profile = Profile::gaussian;  ///< energy over the footprint
    double horizontal = 0, vertical = 0;  ///< rad, full angle (to 1/e^2 if gaussian); 0: the sensor's
    enum class Shape { ellipse, rectangle } shape = Shape::ellipse;  ///< in which the sub-rays lie
  } divergence;

  /// Which echoes of a beam are returned. Automatic: on if the sensor reports more than one, or a mode is given. The
  /// separation and the pulse width shape echoes whether it is on or off.
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
      all,                     ///< up to `count` echoes in order of range
      dual,                    ///< the last and the strongest; if these are one echo, the second strongest as well
    } mode = Mode::all;        ///< which echoes are returned
    uint32_t count = 0;        ///< only for the mode `all`: largest number of returns; 0 means the sensor's
    double separation = 0.4;   ///< m; surfaces no farther than this behind the first one of an echo are part of it
    double pulseWidth = 5e-9;  ///< s, full width at half maximum
  } returns;

  /// Light that passes through glass: materials with alpha mode BLEND or KHR_materials_transmission.
  struct Transmission {
    EffectUse use = EffectUse::automatic;
  } transmission;

  /// Holes in surfaces: materials with alpha mode MASK.
  struct CutOuts {
    EffectUse use = EffectUse::automatic;
  } cutOuts;

  /// The sensor moves during the scan as the motion of the shot says. Automatic: on if the sensor states a rotation
  /// period, or if its channels or the beams of a list have times.
  struct SensorMotion {
    EffectUse use = EffectUse::automatic;
    bool deskew =
        false;  ///< if true, points are reported in the frame of the shot's pose, otherwise in that of their column
  } sensorMotion;

  /// Instances and meshes move during the scan as their motions in the shot say.
  struct ObjectMotion {
    EffectUse use = EffectUse::automatic;
  } objectMotion;

  /// Fog: its droplets weaken returns and give some of their own. Automatic: on if a visibility is given.
  struct Fog {
    EffectUse use = EffectUse::automatic;
    double visibility = 0;  ///< m, meteorological optical range (5 % contrast, Koschmieder); 0 for no fog
  } fog;
  /// Rain: its drops weaken returns and give some of their own. Automatic: on if a rate is given.
  struct Rain {
    EffectUse use = EffectUse::automatic;
    double rate = 0;  ///< mm/h; 0 for no rain
  } rain;
  /// Snow: its flakes weaken returns and give some of their own. Automatic: on if a rate is given.
  struct Snow {
    EffectUse use = EffectUse::automatic;
    double rate = 0;  ///< mm/h of melted water; 0 for no snow
  } snow;
  /// Dust or spray that fills an axis-aligned box.
  struct Volume {
    Vec3 min, max;          ///< metres, world frame
    double extinction = 0;  ///< 1/m
  };
  /// Boxes of dust or spray, which weakens returns and gives some of its own. Automatic: on if there are boxes.
  struct Volumes {
    EffectUse use = EffectUse::automatic;
    std::vector<Volume> boxes;  ///< in the world frame
  } volumes;

  /// Radial speed of the surface as an FMCW sensor measures it, in m/s along the beam, positive if the surface moves
  /// away. Automatic: on if the field radial_speed is requested.
  struct RadialSpeed {
    EffectUse use = EffectUse::automatic;
    double sigma = 0;  ///< m/s; standard deviation of the Gaussian error of each return
  } radialSpeed;

  /// Returns a value with every effect off: geometry alone. Nothing moves during a scan, so the motions of a shot are
  /// ignored without a warning, unless SensorMotion or ObjectMotion is turned on. An effect that is off ignores other
  /// values; give it a `use`, too, or a new value: `effects.rangeNoise = {.sigma = 0.02}`.
  GNOSPHERE_API static Effects none();
};

/// The medium of one shot, in the units of Effects::Fog, Rain, Snow and Volumes. The default is clear air.
struct Weather {
  double visibility = 0;  ///< m
  double rainRate = 0;    ///< mm/h
  double snowRate = 0;    ///< mm/h of melted water
  std::vector<Effects::Volume> volumes;
};

/// Names of the effects in requests, plans and the docs: "intensity", "detection", "drop-out", "range-noise",
/// "angle-noise", "intensity-noise", "divergence", "returns", "transmission", "cut-outs", "sensor-motion",
/// "object-motion", "fog", "rain", "snow", "volumes", "radial-speed"; in this order.
GNOSPHERE_API const std::vector<std::string>& effectNames();

/// Throws Error(invalidArgument) that names the parameter and its range if a parameter is out of range.
GNOSPHERE_API void validate(const Effects& effects);

/// Names of the built-in presets: "clean" (geometry alone), "auto", "carla", "hdl-64e", "os1-rain".
GNOSPHERE_API const std::vector<std::string>& effectPresets();

/// The preset of that name; case does not matter. Throws Error(invalidArgument) that lists the known names.
GNOSPHERE_API Effects effectPreset(const std::string& name);
/// Reads effects from a JSON file, or those of a lidar from a file of CARLA's attributes: its intensity, drop-off,
/// noise and seed, with CARLA's defaults. `mode` is the id of one of several lidars; if it is empty, their effects must
/// be the same. Throws Error(file), or Error(format) that names an unknown effect or parameter and the names most
/// similar to it, or the lidars.
GNOSPHERE_API Effects loadEffects(const std::filesystem::path& file, const std::string& mode = {});
/// Reads effects from JSON; `source` names the text in messages. Throws Error(format) as loadEffects() does, which
/// names the source instead of a file.
GNOSPHERE_API Effects effectsFromJson(std::string_view json, const std::string& source);
/// Writes effects as JSON that effectsFromJson() reads.
GNOSPHERE_API std::string toJson(const Effects& effects);
/// Applies one assignment of a command line: "fog.visibility=200" sets a parameter and turns the effect on, and with 0,
/// so nothing, leaves it to auto; "divergence=off" sets the EffectUse. Throws Error(invalidArgument) for unknown words.
GNOSPHERE_API void assign(Effects& effects, const std::string& assignment);

/// Optical properties of a material at the wavelength of Effects::Intensity.
struct Optics {
  float reflectance = 0;   ///< diffuse (Lambertian), 0..1
  float gloss = 0;         ///< share of the light that the glossy lobe reflects, 0..1
  float roughness = 1;     ///< roughness of the glossy lobe, 0..1
  float retro = 0;         ///< gain of retro-reflection over a Lambertian surface of reflectance 1; 0 for none
  float transmission = 0;  ///< share of the light that passes through, 0..1
};

/// Derives optics from the glTF properties base colour (red stands for near infrared), metallic, roughness,
/// transmission and alpha. docs/effects/intensity.md has the formulas.
GNOSPHERE_API Optics opticsOf(const Material& material);

/// Optical properties by material name, which override those of the scene's materials. A stated reflectance is that of
/// a Lambertian surface; if the row states a roughness, too, the gloss of the scene's material is added.
struct MaterialTable {
  struct Row {
    std::string name;           ///< name of the scene's material; case does not matter
    float reflectance905 = -1;  ///< 0..1; a negative value in any member means not stated
    float reflectance1550 = -1;
    float roughness = -1, retro = -1, transmission = -1;
  };
  std::vector<Row> rows;
};

/// Reads a material table in the JSON format of GnoSphere or in ASAM OpenMATERIAL 3D (.xoma, .xomm or .xomp). Throws
/// Error(file) or Error(format) if the file cannot be read or is invalid.
GNOSPHERE_API MaterialTable loadMaterialTable(const std::filesystem::path& file);

/// Returns the optics of every material of the scene at `wavelength`, 905 or 1550 nm. Names in the table that no
/// material has are appended to `unused`, if given. Throws Error(invalidArgument) for another wavelength, if a value of
/// the table is NaN or beyond its limit, and if names in the table differ in case alone.
GNOSPHERE_API std::vector<Optics> opticsOf(const Scene& scene, const MaterialTable& table, double wavelength,
                                           std::vector<std::string>* unused = nullptr);

}  // namespace gnosphere
