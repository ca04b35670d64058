// SPDX-License-Identifier: Apache-2.0
#include "drive/made_by.hpp"

#include <nlohmann/json.hpp>

#include "base/hash.hpp"
#include "base/input_file.hpp"
#include "base/json_text.hpp"
#include "option_table.hpp"

namespace gnosphere::drive {
namespace {

using Json = nlohmann::ordered_json;

/// Returns the files that were read for a drive.
Json inputsOf(const Drive& drive) {
  Json inputs = Json::array();
  for (const auto& [path, place] : drive.inputs) inputs.push_back(inputJson(path, place));
  return inputs;
}

/// Returns the effects that each sensor simulates, with the reasons.
Json effectsOf(const Drive& drive, const Scanner& scanner) {
  Json sensors = Json::array();
  for (size_t s = 0; s < drive.sensors.size(); ++s)
    sensors.push_back(
        {{"sensor", drive.sensors[s].name}, {"effects", parseJson<Json>(toJson(scanner.plan(s)))["effects"]}});
  return sensors;
}

}  // namespace

std::string madeByText(const Drive& drive, SimulatorOptions options, const Scanner& scanner) {
  const DeviceInfo& device = scanner.device();
  for (const std::string& assignment : drive.simulator) assign(options, assignment);
  const bool isFast = options.device.kind == DeviceChoice::Kind::cudaFast;
  // The driver of the reference is a number of threads, which changes no byte.
  return jsonText(Json{{"version", GNOSPHERE_VERSION},
                       {"device", device.name},
                       {"type", isFast ? "cuda-fast" : device.type},
                       {"driver", device.type == "reference" ? "" : device.driver},
                       {"accuracy", nameOf(options.accuracy)},
                       {"options", parseJson<Json>(changedOptions(options))},
                       {"seed", drive.seed},
                       {"drive_file", hashOf(drive.file)},
                       {"fingerprint", drive.fingerprint},
                       {"sensors", effectsOf(drive, scanner)},
                       {"inputs", inputsOf(drive)},
                       {"warnings", drive.warnings}},
                  1) +
         "\n";
}

}  // namespace gnosphere::drive
