// SPDX-License-Identifier: Apache-2.0
// Functions that stand in for pictures in a library that is built without PNG.
#include "gnosphere/error.hpp"
#include "gnosphere/output.hpp"
#include "output/pattern_picture.hpp"

namespace gnosphere {

namespace {

[[noreturn]] void refuse(const std::filesystem::path& file) {
  throw Error(ErrorCode::file, std::string("cannot write '").append(file.string()) +
                                   "': this library is built without PNG; build it with -D GNOSPHERE_IO=ON");
}

}  // namespace

void writePicture(const Scan&, const std::filesystem::path& file) {
  refuse(file);
}

void writePatternPicture(const Sensor&, const std::filesystem::path& file) {
  refuse(file);
}

}  // namespace gnosphere
