// SPDX-License-Identifier: Apache-2.0
// Functions that stand in for the readers of glTF and OBJ, and for the writer of PNG, in a library that is built
// without them.
#include "scene/readers.hpp"

namespace gnosphere {

Scene readGltf(Bytes, const Source& source) {
  source.fail("this library is built without the reader of glTF; build it with -D GNOSPHERE_IO=ON");
}

Scene readObj(Bytes, const Source& source) {
  source.fail("this library is built without the reader of OBJ; build it with -D GNOSPHERE_IO=ON");
}

std::vector<uint8_t> pngOf(const AlphaImage&) {
  throw Error(ErrorCode::invalidArgument,
              "this library is built without PNG, in which glTF has the images of cut-out materials; build it with "
              "-D GNOSPHERE_IO=ON");
}

}  // namespace gnosphere
