// SPDX-License-Identifier: Apache-2.0
// Stands in for the logger inside of RGL, which the helpers of its tests use.
#include <Logger.hpp>

Logger& Logger::getOrCreate() {
  static Logger logger;
  return logger;
}

Logger::Logger() : mainLogger(spdlog::stdout_color_mt("RGL tests")) {}
