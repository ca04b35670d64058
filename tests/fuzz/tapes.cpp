// SPDX-License-Identifier: Apache-2.0
#include <rgl/api/core.h>
#include <rgl/api/extensions/tape.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

#include "readers.hpp"

namespace gnosphere {

void fuzzTape(std::span<const uint8_t> input) {
  static const bool ready = [] {
    setenv("GNOSPHERE_RGL_DEVICE", "reference", 1);
    setenv("GNOSPHERE_RGL_SEED", "1", 1);
    return rgl_configure_logging(RGL_LOG_LEVEL_OFF, nullptr, false) == RGL_SUCCESS;
  }();
  if (!ready) complain("a tape", "logs cannot be switched off");
  const std::string_view text(reinterpret_cast<const char*>(input.data()), input.size());
  const std::string_view calls = text.substr(0, text.find('\0'));
  constexpr size_t kMostText = 4096;  // longer ones make calls that take long
  if (calls.size() > kMostText) return;
  for (const std::string_view name : {"pcd_file", "logging", "ros2"})
    if (calls.find(name) != calls.npos) return;
  const std::string path =
      (std::filesystem::temp_directory_path() / ("gnosphere-fuzz-tape-" + std::to_string(::getpid()))).string();
  std::ofstream(path + ".yaml") << calls;
  std::ofstream(path + ".bin", std::ios::binary) << text.substr(std::min(calls.size() + 1, text.size()));
  const rgl_status_t status = rgl_tape_play(path.c_str());
  const char* why = nullptr;
  rgl_get_last_error_string(&why);
  // An exception of the standard library tells nobody what is wrong with the tape.
  const std::string_view sentence = why;
  if (status == RGL_INTERNAL_EXCEPTION && sentence.find(' ') == sentence.npos) complain("a tape", why);
  if (rgl_cleanup() != RGL_SUCCESS) complain("a tape", "what it has made stays");
  for (const char* ending : {".yaml", ".bin"}) std::filesystem::remove(path + ending);
}

}  // namespace gnosphere
