// SPDX-License-Identifier: Apache-2.0
#include "gnosphere/sensor.hpp"

#include "sensor/beams.hpp"

namespace gnosphere {

uint32_t Sensor::width() const {
  if (isGrid()) return columns;
  return patterns[0].width > 0 ? patterns[0].width : static_cast<uint32_t>(patterns[0].size());
}

uint32_t Sensor::height() const {
  if (isGrid()) return static_cast<uint32_t>(channels.size());
  return patterns[0].width > 0 ? patterns[0].height : 1;
}

Vec3 Sensor::direction(size_t beam) const {
  return directionOf(*this, beam, 0);
}

}  // namespace gnosphere
