// SPDX-License-Identifier: Apache-2.0
// Binds the effects of gnosphere/effects.hpp.
#include <cctype>

#include "arrays.hpp"
#include "rows.hpp"

namespace gnosphere::python {
namespace {

struct NothingMore {
  void operator()(const auto&) const {}
};

/// Binds an effect, a part of Effects: a class with its member `use`, the parameters of its row and what more(class)
/// binds, and the property of Effects that has it.
template <auto kEffect, typename More = NothingMore>
void bindEffect(nb::class_<Effects>& effects, const std::string& name, const More& more = {}) {
  using Effect = std::remove_reference_t<decltype(std::declval<Effects&>().*kEffect)>;
  const EffectInfo& info = effectNamed(name);
  std::string type;
  for (size_t i = 0; i < name.size(); ++i) {
    if (name[i] == '-') continue;
    type += i == 0 || name[i - 1] == '-' ? static_cast<char>(std::toupper(name[i])) : name[i];
  }
  const std::string doc = pythonText(info.doc);
  nb::class_<Effect> effect(effects, type.c_str(), doc.c_str());
  readWriteChoice(effect, "use", &Effect::use, "Whether it is off, on or automatic.");
  for (const Parameter<Effects>& parameter : info.parameters)
    bindRow<[](Effects& all) -> Effect& { return all.*kEffect; }>(effect, parameter.name, parameter);
  more(effect);
  bindKeywords(effect, "Takes its properties as keywords, in which a choice may be its name.");
  effects.def_rw(pythonName(name).c_str(), kEffect, doc.c_str());
}

/// Binds a parameter whose value is a word: an enum in the class of the effect, and the property.
template <typename Effect, typename Enum>
void bindChoice(nb::class_<Effect>& effect, const std::string& name, const char* parameter, Enum Effect::*member) {
  const Parameter<Effects>& row = parameterOf(name, parameter);
  std::string type = parameter;
  type[0] = static_cast<char>(std::toupper(type[0]));
  bindWords<Enum>(effect, type, row);
  readWriteChoice(effect, parameter, member, pythonText(row.doc).c_str());
}

void bindSignal(nb::class_<Effects>& effects) {
  bindEffect<&Effects::intensity>(effects, "intensity", [](auto& intensity) {
    bindChoice(intensity, "intensity", "model", &Effects::Intensity::model);
    bindChoice(intensity, "intensity", "scale", &Effects::Intensity::scale);
  });
  bindEffect<&Effects::detection>(effects, "detection");
  bindEffect<&Effects::dropOut>(effects, "drop-out", [](auto& dropOut) {
    dropOut.def_prop_rw(
        "dead_beams", [](const Effects::DropOut& self) { return copiedColumn(self.deadBeams); },
        [](Effects::DropOut& self, const ArrayLike& beams) {
          self.deadBeams = arrayOf<uint32_t>(beams, "DropOut: dead_beams").copy();
        },
        kOwned,
        (pythonText(parameterOf("drop-out", "dead_beams").doc) +
         " Shape (n,), uint32: a read-only copy; assign a new array to change them.")
            .c_str());
  });
  bindEffect<&Effects::rangeNoise>(effects, "range-noise");
  bindEffect<&Effects::angleNoise>(effects, "angle-noise", [](auto& angleNoise) {
    bindChoice(angleNoise, "angle-noise", "at", &Effects::AngleNoise::at);
  });
  bindEffect<&Effects::intensityNoise>(effects, "intensity-noise");
}

void bindEchoes(nb::class_<Effects>& effects) {
  bindEffect<&Effects::divergence>(effects, "divergence", [](auto& divergence) {
    bindChoice(divergence, "divergence", "profile", &Effects::Divergence::profile);
    bindChoice(divergence, "divergence", "shape", &Effects::Divergence::shape);
  });
  bindEffect<&Effects::returns>(effects, "returns",
                                [](auto& returns) { bindChoice(returns, "returns", "mode", &Effects::Returns::mode); });
  bindEffect<&Effects::transmission>(effects, "transmission");
  bindEffect<&Effects::cutOuts>(effects, "cut-outs");
}

void bindMotion(nb::class_<Effects>& effects) {
  bindEffect<&Effects::sensorMotion>(effects, "sensor-motion");
  bindEffect<&Effects::objectMotion>(effects, "object-motion");
  bindEffect<&Effects::radialSpeed>(effects, "radial-speed");
}

void bindMedium(nb::class_<Effects>& effects) {
  bindEffect<&Effects::fog>(effects, "fog");
  bindEffect<&Effects::rain>(effects, "rain");
  bindEffect<&Effects::snow>(effects, "snow");
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
  const std::string doc = pythonText(parameterOf("volumes", "boxes").doc) + " A tuple of copies, assigned whole.";
  bindEffect<&Effects::volumes>(effects, "volumes", [&](auto& volumes) {
    readWriteTuple(volumes, "boxes", &Effects::Volumes::boxes, doc.c_str());
  });
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
  bindRow<[](Effects& all) -> Effects& { return all; }>(effects, "seed", seedParameter());
  effects.def_static(
      "none", &Effects::none,
      "Returns a value with every effect off: geometry alone. Nothing moves during a scan, so the motions of a shot "
      "are "
      "ignored without a warning, unless sensor_motion or object_motion is turned on. An effect that is off ignores "
      "its "
      "other values; give it a `use`, too, or a new value: effects.range_noise = Effects.RangeNoise(sigma=0.02).");
  bindSignal(effects);
  bindEchoes(effects);
  bindMotion(effects);
  bindMedium(effects);
  bindKeywords(effects, "Effects that the scene and the sensor call for, but for those that keywords give.");

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
      "load_effects", &loadEffects, "file"_a, "mode"_a = "",
      "Reads effects from a JSON file, or those of a lidar from a file of CARLA's attributes: its intensity, drop-off, "
      "noise and seed, with CARLA's defaults. `mode` is the id of one of several lidars; if it is empty, their effects "
      "must be the same. Raises Error(file), or Error(format) that names an unknown effect or parameter and the names "
      "most similar to it, or the lidars.");
  m.def("effects_from_json", &effectsFromJson, "json"_a, "source"_a,
        "Reads effects from JSON; `source` names the text in messages. Raises as for a file.");
  m.def(
      "to_json", [](const Effects& of) { return toJson(of); }, "effects"_a,
      "Writes effects as JSON that effects_from_json() reads.");
  m.def("assign", nb::overload_cast<Effects&, const std::string&>(&assign), "effects"_a, "assignment"_a,
        "Applies one assignment of a command line: 'fog.visibility=200' sets a parameter and turns the effect on, and "
        "with 0, so nothing, leaves it to auto; 'divergence=off' sets the EffectUse. Raises Error(invalid_argument).");
}

}  // namespace gnosphere::python
