// SPDX-License-Identifier: Apache-2.0
// Requests drawn at random: the device against the reference, and shots together against single scans.
#include "effects/scan_support.hpp"
#include "random/request.hpp"

namespace gnosphere::test {
namespace {

/// Checks that the shots together give the bytes of the single scans, and so does a batch of those of one sensor.
void requireTogether(Simulator& device, const std::vector<Shot>& shots, const std::vector<Scan>& scans) {
  size_t seen = 0;
  device.scanAll(shots, [&](size_t i, const Scan& scan) {
    ++seen;
    CHECK(firstBytes(scans[i], scan) == "none");
  });
  CHECK(seen == shots.size());
  std::vector<Shot> some;
  std::vector<size_t> places;
  for (size_t i = 0; i < shots.size(); ++i)
    if (shots[i].sensor == shots[0].sensor) {
      some.push_back(shots[i]);
      places.push_back(i);
    }
  const Batch batch = device.scanBatch(some, std::vector{Field::triangle, Field::instance});
  size_t entry = 0;
  for (const size_t i : places) {
    const Scan& scan = scans[i];
    const size_t count = scan.ranges.size();
    const auto same = [&](const auto& whole, const auto& part) {
      return std::memcmp(whole.data() + entry, part.data(), count * sizeof part[0]) == 0;
    };
    CHECK((same(batch.ranges(), scan.ranges) && same(batch.triangles(), scan.triangles) &&
           same(batch.instances(), scan.instances)));
    entry += count;
  }
  CHECK(entry == batch.entries());
}

/// Scans earlier shots of one sensor together, which must not change the scans after it.
void disturb(Simulator& device, const std::vector<Shot>& shots) {
  std::vector<Shot> together;
  for (const Shot& shot : shots)
    if (shot.sensor == shots[0].sensor) together.push_back(shot);
  if (!together.empty()) device.scanBatch(together);
}

void requireRequest(uint32_t number) {
  Request request = anyRequest(number);
  INFO("request " << number << ":" << request.text);
  Simulator device(request.scene, request.sensors, request.options);
  request.options.device = DeviceChoice::Kind::reference;
  Simulator truth(request.scene, request.sensors, request.options);
  std::vector<Shot> shots;
  std::vector<Scan> scans(request.steps.size());
  bool changed = false;
  for (size_t i = 0; i < scans.size(); ++i) {
    INFO("shot " << i);
    const Step& step = request.steps[i];
    changed = changed || !step.transforms.empty() || !step.deformations.empty() || !step.added.empty();
    change(truth, step);
    change(device, step);
    if (number % 2 == 0) disturb(device, shots);
    shots.push_back(step.shot);
    Scan expected;
    truth.scanInto(step.shot, expected);
    device.scanInto(step.shot, scans[i]);
    const Differences found = differences(expected, scans[i], {1e-4, 2e-3, 4e-3, 2e-3});
    INFO(found.text());
    CHECK(found.all() == 0);
    CHECK(found.ties < found.beams / 4 + 10);
  }
  if (!changed) requireTogether(device, shots, scans);
}

}  // namespace

TEST_CASE("requests drawn at random equal the reference, and shots together the single scans", "[combinations]") {
  needVulkan();
  for (const uint32_t number : numbersToTry(40)) requireRequest(number);
}

}  // namespace gnosphere::test
