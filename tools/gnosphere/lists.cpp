// SPDX-License-Identifier: Apache-2.0
// gnosphere devices, gnosphere effects, gnosphere options: list what can be chosen.
#include <algorithm>
#include <cstdio>
#include <memory>

#include "base/path.hpp"
#include "base/text.hpp"
#include "commands.hpp"
#include "console.hpp"
#include "effect_options.hpp"
#include "effects/effect_table.hpp"
#include "effects/parameter_text.hpp"
#include "gnosphere/simulator.hpp"
#include "json.hpp"
#include "option_table.hpp"
#include "scanning.hpp"

namespace gnosphere::cli {
namespace {

void printDevicesJson(const std::vector<DeviceInfo>& devices, const std::string& problem) {
  Json json;
  json["devices"] = Json::array();
  for (const DeviceInfo& device : devices) {
    Json& entry = json["devices"].emplace_back(toJson(device));
    entry["usable"] = device.usable;
    entry["reason"] = device.reason;
  }
  json["vulkan_problem"] = problem.empty() ? Json() : Json(problem);
  std::printf("%s", dump(json).c_str());
}

int runDevices(bool json) {
  std::string problem;
  const std::vector<DeviceInfo> devices = listDevices(&problem);
  if (json) {
    printDevicesJson(devices, problem);
    return 0;
  }
  size_t nameWidth = 4;
  for (const DeviceInfo& device : devices) nameWidth = std::max(nameWidth, device.name.size());
  for (size_t i = 0; i < devices.size(); ++i) {
    const DeviceInfo& device = devices[i];
    std::string about = device.apiVersion.empty() ? "" : "Vulkan " + device.apiVersion + ", ";
    about += device.driver.empty() ? "" : device.driver + ", ";
    about += device.usable ? "usable" : "not usable: " + device.reason;
    std::printf("%2zu  %-*s  %-10s  %s\n", i, static_cast<int>(nameWidth), device.name.c_str(), device.type.c_str(),
                about.c_str());
  }
  if (!problem.empty()) complain("Vulkan cannot be used: " + problem);
  return 0;
}

/// Prints a text whose lines begin with `indent` blanks and fit the terminal.
void printWrapped(size_t indent, const std::string& text) {
  std::printf("%s%s\n", std::string(indent, ' ').c_str(), wrapped(text, textColumns(), indent).c_str());
}

/// Prints a parameter: name, default, `more`, allowed values and meaning.
template <class Owner>
void printParameter(const Parameter<Owner>& parameter, const std::string& more = "") {
  std::printf("\n");
  printWrapped(2, std::string(parameter.name) + ", default " + defaultText(parameter) + more);
  printWrapped(4, allowedText(parameter));
  printWrapped(4, parameter.doc);
  if (const auto* choice = std::get_if<ChoiceParameter<Owner>>(&parameter.kind))
    for (const ChoiceWord& word : choice->words)
      if (*word.doc) printWrapped(6, std::string(word.name) + ": " + word.doc);
}

/// Returns the words about the value 0 in the sentence of a parameter, such as "0 for no fog"; empty without any.
std::string zeroText(const std::string& doc) {
  const size_t begin = std::min({doc.find("0 for "), doc.find("0 means "), doc.find("both 0: ")});
  if (begin == doc.npos) return "";
  const size_t end = doc.find_first_of(";,.", begin);
  return doc.substr(begin, end - begin);
}

std::string allowedWithZero(const Parameter<Effects>& parameter) {
  const std::string zero = zeroText(parameter.doc);
  return allowedText(parameter) + (zero.empty() ? "" : "; " + zero);
}

/// Prints what an effect is, its parameters, and where its page is.
void printEffect(const EffectInfo& info) {
  Effects defaults;
  std::printf("%s (%s)\n", info.name, kUseWords[static_cast<size_t>(info.use(defaults))]);
  printWrapped(2, info.doc);
  for (const Parameter<Effects>& parameter : info.parameters) printParameter(parameter);
  std::printf("\nThe formula and its sources: docs/effects/%s.md\n", info.name);
}

/// Whether an effect or a preset has this name.
bool isBuiltIn(const std::string& name) {
  const auto is = [&](const std::string& known) { return sameWord(known, name); };
  return std::ranges::any_of(effectPresets(), is) ||
         std::ranges::any_of(effectTable(), [&](const EffectInfo& info) { return is(info.name); });
}

/// Lists every effect with its parameters: name, default and allowed values.
int runEffects(const std::string& name, const std::string& mode) {
  if (mode.empty())
    for (const EffectInfo& info : effectTable())
      if (sameWord(info.name, name)) {
        printEffect(info);
        return 0;
      }
  if (!mode.empty() && isBuiltIn(name))
    throw Error(ErrorCode::invalidArgument,
                "--mode chooses a lidar of a file of CARLA's attributes, and '" + name + "' is built in");
  if (!name.empty()) {
    std::printf("%s", toJson(mode.empty() ? presetOrFile(name) : loadEffects(pathOf(name), mode)).c_str());
    return 0;
  }
  std::printf("presets:");
  for (const std::string& preset : effectPresets()) std::printf(" %s", preset.c_str());
  std::printf("\n");
  Effects defaults;
  for (const EffectInfo& info : effectTable()) {
    std::printf("\n%s (%s)\n", info.name, kUseWords[static_cast<size_t>(info.use(defaults))]);
    for (const Parameter<Effects>& parameter : info.parameters) {
      std::printf("  %-20s %-14s %s\n", parameter.name, valueText(parameter, defaults).c_str(),
                  allowedWithZero(parameter).c_str());
    }
  }
  return 0;
}

template <class Owner>
void printOptions(const char* title, const std::vector<Option<Owner>>& table) {
  std::printf("%s\n", title);
  for (const auto& [parameter, changes] : table)
    printParameter(parameter, std::string("; another value changes ") + kChanges[static_cast<size_t>(changes)]);
}

/// Lists every option of --set: name, default, allowed values and meaning.
int runOptions() {
  printOptions("options of a simulator", simulatorOptionTable());
  printOptions("\noptions of a sensor", requestOptionTable());
  return 0;
}

}  // namespace

Action addOptions(CLI::App& app) {
  app.footer("Example: gnosphere scan town.glb --set tuning.binning=lists -o cloud.pcd");
  return runOptions;
}

Action addDevices(CLI::App& app) {
  const auto json = std::make_shared<bool>(false);
  app.add_flag("--json", *json, "Print JSON");
  app.footer(
      "`gnosphere scan --device` takes the number or a part of the name, `auto`, `gpu`, `cuda:N`, `cuda-fast:N` or "
      "`reference`.\n"
      "Example: gnosphere devices --json");
  return [json] { return runDevices(*json); };
}

Action addEffects(CLI::App& app) {
  const auto name = std::make_shared<std::string>(), mode = std::make_shared<std::string>();
  CLI::Option* const named = app.add_option(
      "NAME", *name,
      "Tell of this effect, or print this preset (or JSON file) as JSON that `gnosphere scan --effects FILE` reads");
  app.add_option("--mode", *mode, "The id of one of several lidars that a file of CARLA's attributes has")
      ->needs(named);
  app.footer(
      "`gnosphere scan --effect NAME.PARAMETER=VALUE` sets a parameter; NAME=on, off or auto sets the whole effect.\n"
      "Example: gnosphere effects os1-rain > effects.json");
  return [name, mode] { return runEffects(*name, *mode); };
}

}  // namespace gnosphere::cli
