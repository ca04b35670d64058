// SPDX-License-Identifier: Apache-2.0
// Calls the library after its static objects have been destroyed, as threads do that still run when main() returns.
#include <cstdio>
#include <cstdlib>
#include <gnosphere/gnosphere.hpp>
#include <string>

namespace {

using namespace gnosphere;

// Returns the tables of the library as one text.
std::string tables() {
  std::string text;
  for (const std::string& name : effectPresets()) text += name + toJson(effectPreset(name)) + '\n';
  for (const std::string& name : effectNames()) text += name + ' ';
  for (const Sensor& sensor : builtinSensors()) text += sensor.name + ' ' + std::to_string(sensor.channels.size());
  for (const CatalogueHead& head : sensorCatalogue()) text += head.name + ' ' + head.source;
  for (const Field field : defaultFields()) text += std::to_string(static_cast<int>(field));
  Simulator simulator({}, SensorRequest(builtinSensor("VLP-16")), {.device = DeviceChoice::Kind::reference});
  text += toJson(simulator.plan());
  return text;
}

std::string& before() {
  static auto& text = *new std::string;
  return text;
}

// Runs after the destructors of the static objects that tables() made.
void callAgain() {
  if (tables() == before()) return;
  std::puts("after the end of main() the library has other tables");
  std::_Exit(1);
}

}  // namespace

int main() {
  std::atexit(callAgain);
  before() = tables();
}
