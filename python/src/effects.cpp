// SPDX-License-Identifier: Apache-2.0
// Binds the effects of gnosphere/effects.hpp.
#include "arrays.hpp"

namespace gnosphere::python {
namespace {

/// Binds an effect, a part of Effects: a class, its member `use`, and the property of Effects that has it.
template <typename Effect>
nb::class_<Effect> bindEffect(nb::class_<Effects>& effects, const char* type, const char* property,
                              Effect Effects::*member, const char* doc) {
  nb::class_<Effect> effect(effects, type, doc);
  effect.def(nb::init<>()).def_rw("use", &Effect::use);
  effects.def_rw(property, member, doc);
  return effect;
}

void bindSignal(nb::class_<Effects>& effects) {
  using Intensity = Effects::Intensity;
  auto intensity = bindEffect(effects, "Intensity", "intensity", &Effects::intensity,
                              "Strength of a return from reflectance, incidence and range. Automatic: on if a field or "
                              "another effect needs it.");
  nb::enum_<Intensity::Model>(intensity, "Model")
      .value("physical", Intensity::Model::physical,
             "reflectance * lobe(incidence) / range^2 * exp(-2 extinction range)")
      .value("carla", Intensity::Model::carla, "exp(-attenuation * range), independent of the surface");
  nb::enum_<Intensity::Scale>(intensity, "Scale")
      .value("raw", Intensity::Scale::raw,
             "Received power, relative to a Lambertian target of reflectance 1, square to the beam, at 1 m.")
      .value("unit", Intensity::Scale::unit,
             "0..1: reflectance of the Lambertian target square to the beam that would return as much power from the "
             "same range, cut off at 1.")
      .value(
          "byte", Intensity::Scale::byte,
          "0..255, calibrated reflectivity: 0..100 for diffuse per cent, 101..255 logarithmic for retro-reflectors.");
  intensity.def_rw("model", &Intensity::model)
      .def_rw("scale", &Intensity::scale)
      .def_rw("wavelength", &Intensity::wavelength, "nm; 905 or 1550, selects the column of a material table.")
      .def_rw("attenuation", &Intensity::attenuation, "1/m; only for Model.carla.");

  bindEffect(effects, "Detection", "detection", &Effects::detection,
             "A return is detected only if it is at least as strong as that of a Lambertian target of `reflectance` "
             "square to the beam at `range`.")
      .def_rw("reflectance", &Effects::Detection::reflectance, "0..1")
      .def_rw("range", &Effects::Detection::range, "Metres; 0 means the sensor's range_max.")
      .def_rw("softness", &Effects::Detection::softness,
              "Relative width of the probability curve (logistic in ln power); 0 for a sharp threshold.");

  bindEffect(effects, "DropOut", "drop_out", &Effects::dropOut,
             "Returns that are lost at random, as with CARLA's dropoff_* parameters, and dead beams.")
      .def_rw("general_rate", &Effects::DropOut::generalRate, "0..1, probability for every return.")
      .def_rw("intensity_limit", &Effects::DropOut::intensityLimit,
              "Unit intensity above which zero_intensity_rate has no effect.")
      .def_rw("zero_intensity_rate", &Effects::DropOut::zeroIntensityRate,
              "0..1, probability at intensity 0; falls linearly to 0 at the limit.")
      .def_prop_rw(
          "dead_beams", [](const Effects::DropOut& self) { return copiedColumn(self.deadBeams); },
          [](Effects::DropOut& self, const ArrayLike& beams) {
            self.deadBeams = arrayOf<uint32_t>(beams, "DropOut: dead_beams").copy();
          },
          kOwned,
          "Indices of beams that never return anything, shape (n,), uint32: a read-only copy; assign a new array to "
          "change them.");
}

void bindNoise(nb::class_<Effects>& effects) {
  bindEffect(effects, "RangeNoise", "range_noise", &Effects::rangeNoise,
             "Errors of the range: bias, Gaussian noise and quantisation.")
      .def_rw("bias", &Effects::RangeNoise::bias, "m")
      .def_rw("sigma", &Effects::RangeNoise::sigma, "m, standard deviation")
      .def_rw("sigma_per_metre", &Effects::RangeNoise::sigmaPerMetre,
              "m per m; this times the range is added to sigma.")
      .def_rw("step", &Effects::RangeNoise::step, "m; ranges are rounded to multiples of it; 0 for no quantisation.");

  auto angle =
      bindEffect(effects, "AngleNoise", "angle_noise", &Effects::angleNoise, "Gaussian errors of the beam directions.");
  nb::enum_<Effects::AngleNoise::At>(angle, "At")
      .value("beam", Effects::AngleNoise::At::beam,
             "The beam deviates, but its point is reported in the nominal direction.")
      .value("point", Effects::AngleNoise::At::point,
             "The beam has the nominal direction, but its point is reported in the deviating one.");
  angle.def_rw("azimuth", &Effects::AngleNoise::azimuth, "rad, standard deviation; cut off at 4 sigma.")
      .def_rw("elevation", &Effects::AngleNoise::elevation, "rad, standard deviation; cut off at 4 sigma.")
      .def_rw("at", &Effects::AngleNoise::at);

  bindEffect(effects, "IntensityNoise", "intensity_noise", &Effects::intensityNoise, "Gaussian noise of the intensity.")
      .def_rw("sigma", &Effects::IntensityNoise::sigma, "Standard deviation, on the scale of unit intensity.");
}

void bindEchoes(nb::class_<Effects>& effects) {
  using Returns = Effects::Returns;
  using Mode = Returns::Mode;
  auto divergence =
      bindEffect(effects, "Divergence", "divergence", &Effects::divergence,
                 "An elliptical footprint, sampled by sub-rays that share the candidate triangles of their "
                 "beam.");
  nb::enum_<Effects::Divergence::Profile>(divergence, "Profile")
      .value("uniform", Effects::Divergence::Profile::uniform)
      .value("gaussian", Effects::Divergence::Profile::gaussian);
  divergence.def_rw("sub_rays", &Effects::Divergence::subRays, "1..61; numbers 1 + 6 + 12 + ... lie on rings.")
      .def_rw("profile", &Effects::Divergence::profile)
      .def_rw("horizontal", &Effects::Divergence::horizontal,
              "rad, full angle (to 1/e^2 if gaussian); both angles 0: the sensor's.")
      .def_rw("vertical", &Effects::Divergence::vertical, "rad, as horizontal.");

  auto returns = bindEffect(effects, "Returns", "returns", &Effects::returns,
                            "Which echoes of a beam are returned. Automatic: on if the sensor reports more than one.");
  nb::enum_<Mode>(returns, "Mode")
      .value("first", Mode::first)
      .value("second", Mode::second)
      .value("last", Mode::last)
      .value("strongest", Mode::strongest)
      .value("second_strongest", Mode::secondStrongest)
      .value("first_second", Mode::firstSecond)
      .value("first_last", Mode::firstLast)
      .value("first_strongest", Mode::firstStrongest)
      .value("last_strongest", Mode::lastStrongest)
      .value("strongest_second_strongest", Mode::strongestSecondStrongest)
      .value("all", Mode::all, "Up to `count` echoes in order of range.");
  returns.def_rw("mode", &Returns::mode)
      .def_rw("count", &Returns::count, "Only for Mode.all: 1..5; 0 means Sensor.max_returns.")
      .def_rw("separation", &Returns::separation, "m; echoes that are closer together are merged.")
      .def_rw("pulse_width", &Returns::pulseWidth, "s, full width at half maximum.");

  bindEffect(effects, "Transmission", "transmission", &Effects::transmission,
             "Light that passes through glass: materials with alpha mode BLEND or KHR_materials_transmission.");
  bindEffect(effects, "CutOuts", "cut_outs", &Effects::cutOuts, "Holes in surfaces: materials with alpha mode MASK.");
}

void bindMotion(nb::class_<Effects>& effects) {
  bindEffect(effects, "SensorMotion", "sensor_motion", &Effects::sensorMotion,
             "The sensor moves during the scan as Shot.motion says. Automatic: on if the sensor has a rotation period.")
      .def_rw("deskew", &Effects::SensorMotion::deskew,
              "If true, points are reported in the frame of Shot.pose, otherwise in that of their column.");
  bindEffect(effects, "ObjectMotion", "object_motion", &Effects::objectMotion,
             "Instances move during the scan as Shot.instance_motions says.");
  bindEffect(
      effects, "RadialSpeed", "radial_speed", &Effects::radialSpeed,
      "Radial speed of the surface as an FMCW sensor measures it, in m/s along the beam, positive if the surface "
      "moves away. Automatic: on if Field.radial_speed is requested.");
}

void bindMedium(nb::class_<Effects>& effects) {
  bindEffect(effects, "Fog", "fog", &Effects::fog, "Automatic: on if a visibility is given.")
      .def_rw("visibility", &Effects::Fog::visibility,
              "m, meteorological optical range (5 % contrast, Koschmieder); 0 for no fog.");
  bindEffect(effects, "Rain", "rain", &Effects::rain, "Automatic: on if a rate is given.")
      .def_rw("rate", &Effects::Rain::rate, "mm/h");
  bindEffect(effects, "Snow", "snow", &Effects::snow, "Automatic: on if a rate is given.")
      .def_rw("rate", &Effects::Snow::rate, "mm/h of melted water");
  nb::class_<Effects::Volume>(effects, "Volume",
                              "Dust or spray that fills an axis-aligned box. It is never changed after it is made.")
      .def(
          "__init__",
          [](Effects::Volume* self, Vec3 min, Vec3 max, double extinction) {
            new (self) Effects::Volume{min, max, extinction};
          },
          "min"_a, "max"_a, "extinction"_a)
      .def_ro("min", &Effects::Volume::min, "Metres, world frame.")
      .def_ro("max", &Effects::Volume::max, "Metres, world frame.")
      .def_ro("extinction", &Effects::Volume::extinction, "1/m");
  auto volumes =
      bindEffect(effects, "Volumes", "volumes", &Effects::volumes, "Boxes of dust. Automatic: on if there are any.");
  readWriteTuple(volumes, "boxes", &Effects::Volumes::boxes, "A tuple of copies, assigned whole.");
}

}  // namespace

void bindEffects(nb::module_& m) {
  nb::enum_<EffectUse>(
      m, "EffectUse",
      "Whether an effect is simulated. With `automatic` it is, if the scene, the sensor and the request "
      "can show it; otherwise it is left out, and the Plan gives the reason.")
      .value("off", EffectUse::off)
      .value("on", EffectUse::on)
      .value("automatic", EffectUse::automatic);

  nb::class_<Effects> effects(
      m, "Effects",
      "The effects that a scan simulates beside geometry, each with its parameters. Units are metres, radians, seconds "
      "and 1/m; powers are relative to a Lambertian target of reflectance 1, square to the beam, at 1 m.");
  effects.def(nb::init<>(), "Effects that the scene and the sensor call for.")
      .def_rw(
          "seed", &Effects::seed,
          "Every random number is keyed by (seed, sensor, frame, beam, sub-ray, effect); the same seed gives the same "
          "draws on every device.")
      .def_static("none", &Effects::none, "Returns a value with every effect off: geometry alone.");
  bindSignal(effects);
  bindNoise(effects);
  bindEchoes(effects);
  bindMotion(effects);
  bindMedium(effects);

  auto weather =
      nb::class_<Weather>(m, "Weather",
                          "The medium of one shot. The default is clear air. It is never changed after it is "
                          "made.");
  weather
      .def(
          "__init__",
          [](Weather* self, double visibility, double rain, double snow, std::vector<Effects::Volume> volumes) {
            new (self) Weather{visibility, rain, snow, std::move(volumes)};
          },
          "visibility"_a = 0.0, "rain_rate"_a = 0.0, "snow_rate"_a = 0.0, "volumes"_a = nb::make_tuple())
      .def_ro("visibility", &Weather::visibility, "m; 0 for no fog.")
      .def_ro("rain_rate", &Weather::rainRate, "mm/h")
      .def_ro("snow_rate", &Weather::snowRate, "mm/h of melted water");
  readTuple(weather, "volumes", &Weather::volumes, "Boxes of dust or spray.");

  m.def(
      "effect_names", [] { return tupleOf(effectNames()); }, "Names of the effects in requests, plans and the docs.");
  m.def(
      "validate", [](const Effects& of) { validate(of); }, "effects"_a,
      "Raises Error(invalid_argument) that names the parameter and its range if a parameter is out of range.");
  m.def(
      "effect_presets", [] { return tupleOf(effectPresets()); }, "Names of the built-in presets.");
  m.def("effect_preset", &effectPreset, "name"_a,
        "Returns the preset of that name; case does not matter. Raises Error(invalid_argument) that lists the known "
        "names.");
  m.def(
      "load_effects", &loadEffects, "file"_a,
      "Reads effects from a JSON file. Raises Error(file), or Error(format) that names an unknown effect or parameter "
      "and the names most similar to it.");
  m.def("effects_from_json", &effectsFromJson, "json"_a, "source"_a,
        "Reads effects from JSON; `source` names the text in messages. Raises as for a file.");
  m.def(
      "to_json", [](const Effects& of) { return toJson(of); }, "effects"_a,
      "Writes effects as JSON that effects_from_json() reads.");
  m.def("assign", &assign, "effects"_a, "assignment"_a,
        "Applies one assignment of a command line: 'fog.visibility=200' sets a parameter and turns the effect on; "
        "'divergence=off' sets the EffectUse. Raises Error(invalid_argument).");
}

}  // namespace gnosphere::python
