// SPDX-License-Identifier: Apache-2.0
#include "drive/made_by.hpp"

#include <nlohmann/json.hpp>

#include "base/hash.hpp"
#include "base/json_text.hpp"
#include "option_table.hpp"

namespace gnosphere::drive {

std::string madeByText(const Drive& drive, SimulatorOptions options, const DeviceInfo& device) {
  using Json = nlohmann::ordered_json;
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
                       {"fingerprint", drive.fingerprint}},
                  1) +
         "\n";
}

}  // namespace gnosphere::drive
