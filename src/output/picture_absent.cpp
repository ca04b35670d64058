// SPDX-License-Identifier: Apache-2.0
// What stands in for pictures in a library that is built without PNG.
#include "gnosphere/error.hpp"
#include "gnosphere/output.hpp"

namespace gnosphere {

void writePicture(const Scan&, const std::filesystem::path& file) {
  throw Error(ErrorCode::file, std::string("cannot write '").append(file.string()) +
                                   "': this library is built without PNG; build it with -D GNOSPHERE_IO=ON");
}

}  // namespace gnosphere
