// SPDX-License-Identifier: Apache-2.0
#include <gnosphere/gnosphere.hpp>
#include <iostream>

int main(int argc, char** argv) {
  try {
    const gnosphere::Scene scene = gnosphere::loadScene(argc > 1 ? argv[1] : "town.glb");
    const gnosphere::Sensor sensor = gnosphere::builtinSensor("HDL-64E");
    gnosphere::Simulator simulator(scene, {sensor, gnosphere::Effects::none()});  // geometry alone
    const gnosphere::Scan scan = simulator.scan({{0, 0, 1.8}, {}});

    std::cout << scan.counters.hits << " of " << scan.beamCount() << " beams hit on " << simulator.device().name
              << '\n';
    for (size_t beam = 0; beam < scan.beamCount(); beam += 36'000)
      if (scan.hit(beam))
        std::cout << "beam " << beam << " meets " << scene.instances[scan.instances[beam]].name << " after "
                  << scan.ranges[beam] << " m\n";
    gnosphere::writeCloud(scan, "cloud.pcd");
  } catch (const gnosphere::Error& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
}
