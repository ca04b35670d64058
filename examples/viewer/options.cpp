// SPDX-License-Identifier: Apache-2.0
#include "options.hpp"

#include <cstdio>
#include <cstdlib>
#include <stdexcept>

namespace viewer {
namespace {

Colouring colouringOf(const std::string& name) {
  if (name == "range") return Colouring::range;
  if (name == "intensity") return Colouring::intensity;
  if (name == "instance") return Colouring::instance;
  if (name == "none") return Colouring::none;
  throw std::runtime_error("--colour " + name + ": the colours are range, intensity, instance and none");
}

uint64_t countOf(const std::string& text) {
  char* end = nullptr;
  const uint64_t count = std::strtoull(text.c_str(), &end, 10);
  if (text.empty() || *end || count == 0 || text[0] == '-')
    throw std::runtime_error("--frames " + text + " is not a number of at least 1");
  return count;
}

// Whether the pattern describes the whole text; it must end with %n, for the number of characters that were read.
template <typename... Values>
bool reads(const std::string& text, const char* pattern, Values*... values) {
  int length = 0;
  return std::sscanf(text.c_str(), pattern, values..., &length) == sizeof...(values) &&
         static_cast<size_t>(length) == text.size();
}

}  // namespace

Options parse(int count, char** arguments) {
  Options options;
  for (int i = 1; i < count; ++i) {
    const std::string argument = arguments[i];
    const auto value = [&]() -> std::string {
      if (++i == count) throw std::runtime_error(argument + " needs a value");
      return arguments[i];
    };
    if (argument == "--help" || argument == "-h") {
      options.help = true;
    } else if (argument == "--validate") {
      options.validate = true;
    } else if (argument == "--sensor") {
      options.sensor = value();
    } else if (argument == "--colour") {
      options.colouring = colouringOf(value());
    } else if (argument == "--frames") {
      options.frames = countOf(value());
    } else if (argument == "--picture") {
      options.picture = value();
      if (!options.picture.ends_with(".png") && !options.picture.ends_with(".ppm"))
        throw std::runtime_error("--picture " + options.picture + " must end with .png or .ppm");
    } else if (argument == "--start") {
      gnosphere::Vec3& start = options.start;
      if (const std::string text = value(); !reads(text, "%lf,%lf,%lf%n", &start.x, &start.y, &start.z))
        throw std::runtime_error("--start " + text + " is not X,Y,Z");
    } else if (argument == "--size") {
      const std::string text = value();
      if (!reads(text, "%5ux%5u%n", &options.width, &options.height) || !options.width || !options.height)
        throw std::runtime_error("--size " + text + " is not WxH, such as 1280x720");
    } else if (argument.starts_with("-") || !options.scene.empty()) {
      throw std::runtime_error("unknown argument " + argument + "; see --help");
    } else {
      options.scene = argument;
    }
  }
  return options;
}

}  // namespace viewer
