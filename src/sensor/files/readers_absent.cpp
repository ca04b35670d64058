// SPDX-License-Identifier: Apache-2.0
// Errors in place of the readers of YAML and XML, in a library built without them.
#include "sensor/files/source.hpp"

namespace gnosphere {

void readVelodyneYaml(SensorSource& source) {
  source.refuse("is YAML, which this library cannot read: it was built with GNOSPHERE_IO=OFF");
}

void refuseXml(SensorSource& source) {
  source.refuse("is XML, which this library cannot read: it was built with GNOSPHERE_IO=OFF");
}

void readVelodyneXml(SensorSource& source) {
  refuseXml(source);
}

void readSdf(SensorSource& source) {
  refuseXml(source);
}

void readHelios(SensorSource& source) {
  refuseXml(source);
}

}  // namespace gnosphere
