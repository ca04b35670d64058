// SPDX-License-Identifier: Apache-2.0
// A scene built by hand and scanned, by a library without GNOSPHERE_IO, which says what is not built in.
#include <functional>
#include <gnosphere/gnosphere.hpp>
#include <iostream>
#include <string>

namespace {

/// Whether the call fails with an Error that names the option.
bool namesTheOption(const std::function<void()>& call) {
  try {
    call();
  } catch (const gnosphere::Error& error) {
    std::cout << error.what() << '\n';
    return std::string(error.what()).find("GNOSPHERE_IO=ON") != std::string::npos;
  }
  return false;
}

}  // namespace

int main(int, char** argv) {
  try {
    gnosphere::Mesh wall;  // 10 m ahead of the sensor, 40 m wide and 20 m high
    wall.positions = {10, -20, -10, 10, 20, -10, 10, 20, 10, 10, -20, 10};
    wall.indices = {0, 1, 2, 0, 2, 3};
    wall.parts = {{0, 2, 0}};
    gnosphere::Scene scene;
    scene.materials.emplace_back();
    scene.materials[0].doubleSided = true;
    scene.meshes.push_back(wall);
    scene.instances.emplace_back();

    gnosphere::Simulator simulator(scene, gnosphere::builtinSensor("VLP-16"));
    const gnosphere::Scan scan = simulator.scan({});
    std::cout << scan.counters.hits << " of " << scan.beamCount() << " beams hit on " << simulator.device().name
              << '\n';
    gnosphere::writeCloud(scan, "cloud.pcd");

    const bool said = namesTheOption([&] { gnosphere::loadScene(argv[1]); }) &&
                      namesTheOption([&] { gnosphere::writePicture(scan, "cloud.png"); });
    return scan.counters.hits > 0 && said ? 0 : 1;
  } catch (const gnosphere::Error& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
}
