// SPDX-License-Identifier: Apache-2.0
// The header of every result, and writing result files.
#pragma once

#include <string>

#include "base/file.hpp"
#include "console.hpp"
#include "gnosphere/error.hpp"
#include "json.hpp"

namespace gnosphere::bench {

/// Command, version and device, without which results cannot be interpreted later.
inline cli::Json resultsHead(const DeviceInfo& device) {
  return {{"command", cli::commandLine()}, {"version", GNOSPHERE_VERSION}, {"device", cli::toJson(device)}};
}

inline void printHead(const DeviceInfo& device) {
  cli::say("device", device.name + ", " + device.type + (device.driver.empty() ? "" : ", " + device.driver));
  cli::say("version", GNOSPHERE_VERSION);
  cli::say("command", cli::commandLine());
}

/// Writes to stdout if `file` is "-", and nothing if it is empty.
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

/// Checks the file before the work: throws if it cannot be written.
inline void checkResult(const std::string& file) {
  if (!file.empty() && file != "-") checkWritable(file);
}

/// The same for a plot, whose name must end in .svg.
inline void checkPlot(const std::string& file) {
  if (!file.empty() && !file.ends_with(".svg"))
    throw Error(ErrorCode::invalidArgument, "--plot: " + file + " must end in .svg");
  checkResult(file);
}

}  // namespace gnosphere::bench
