// SPDX-License-Identifier: Apache-2.0
// Replaces embree.cpp in builds without Embree.
#include "gnosphere/error.hpp"
#include "rivals/embree.hpp"

namespace gnosphere::bench {

bool haveEmbree() {
  return false;
}

std::unique_ptr<EmbreeRival> makeEmbree(const Scene&, const Vec3&, EmbreeWay) {
  throw Error(ErrorCode::device, "embree: not built in; install libembree-dev and configure again");
}

}  // namespace gnosphere::bench
