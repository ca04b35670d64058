// SPDX-License-Identifier: Apache-2.0
// Compares the cost of recorded scans with that of scans to the host, for the sensors of the paper's figure 7, in
// turns: GNOSPHERE_NO_VALIDATION=1 recorder_tests "[.price]".
#include "engine/recorded.hpp"
#include "price.hpp"
#include "town/town.hpp"

namespace gnosphere::test {

TEST_CASE("the price of recorded scans", "[.price]") {
  needVulkan();
  const CommonApp common;
  VulkanApp& app = common.app;
  const Scene town = makeTown({1'000'000, 1, {}});
  const std::vector<Pose> drive = makeDrive();
  const RecordLayout layout = layoutOf({Field::x, Field::y, Field::z, Field::range, Field::triangle, Field::instance});
  for (const Sensor& sensor : builtinSensors()) {
    SimulatorOptions options;
    options.device = {DeviceChoice::Kind::vulkan, app.deviceName()};
    Simulator simulator(town, {sensor, Effects::none()}, options);
    Recorded recorded(app, town, {sensor, Effects::none()}, options, layout, sensor.beamCount());
    Times toHost, toBuffer;
    Scan scan;
    for (size_t frame = 0; frame < 14; ++frame) {
      Shot shot;
      shot.pose = drive[10 * frame];
      Times warm;
      const size_t at = frame % 2;
      (frame < 4 ? warm : toHost).add([&] { simulator.scanInto(shot, scan); });
      (frame < 4 ? warm : toBuffer).add([&] {
        recorded.submit(shot);
        recorded.frame(at).wait();
      });
      if (frame < 4) continue;
      REQUIRE(recorded.headerOf(at).incomplete == 0);
      const std::vector<std::byte> rows = rowsOf(scan, layout);
      REQUIRE(recorded.headerOf(at).rows * layout.stride == rows.size());
      CHECK(std::memcmp(recorded.bytes(at), rows.data(), rows.size()) == 0);
    }
    std::printf("%s, %zu beams\n", sensor.name.c_str(), static_cast<size_t>(sensor.beamCount()));
    toHost.print("scanInto, to the host");
    toBuffer.print("record, to a buffer");
  }
}

}  // namespace gnosphere::test
