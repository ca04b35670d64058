// SPDX-License-Identifier: Apache-2.0
// What every case says of itself, and where it says it.
#pragma once

#include <string>

#include "base/file.hpp"
#include "console.hpp"
#include "json.hpp"

namespace gnosphere::bench {

/// Command, version and device: results without these are worth nothing later.
inline cli::Json resultsHead(const DeviceInfo& device) {
  return {{"command", cli::commandLine()}, {"version", GNOSPHERE_VERSION}, {"device", cli::toJson(device)}};
}

inline void printHead(const DeviceInfo& device) {
  cli::say("device", device.name + ", " + device.type + (device.driver.empty() ? "" : ", " + device.driver));
  cli::say("version", GNOSPHERE_VERSION);
  cli::say("command", cli::commandLine());
}

/// To stdout for "-", nowhere for "".
inline void writeResult(const std::string& file, const std::string& bytes) {
  if (file.empty()) return;
  if (file == "-") {
    std::printf("%s", bytes.c_str());
    return;
  }
  AtomicFile output(file);
  output.write(bytes);
  output.commit();
}

/// Told before the work: throws if a file cannot be written.
inline void checkResult(const std::string& file) {
  if (!file.empty() && file != "-") checkWritable(file);
}

}  // namespace gnosphere::bench
