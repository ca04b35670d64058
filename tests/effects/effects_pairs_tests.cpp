// SPDX-License-Identifier: Apache-2.0
// Every pair of effects, without and with motion: the device against the reference, in a scene in which all are
// visible.
#include "effects/showroom.hpp"

namespace gnosphere::test {
namespace {

void compare(size_t first, size_t second) {
  static const Sensor sensor = smallSensor();
  requireEffects(sensor, first, second);
}

}  // namespace

TEST_CASE("every effect changes the scan of the scene for the pairs") {
  const Scene scene = showroom();
  TestOptions options = pairOptions(0, 0);
  options.device = DeviceChoice::Kind::reference;
  const auto scanWith = [&](size_t effect) {
    options.effects = pairOptions(0, effect).effects;
    options.fields = {Field::intensity, Field::label};
    if (effectNames()[effect] == "radial-speed") options.fields.push_back(Field::radialSpeed);
    Scan scan;
    makeSimulator(scene, smallSensor(), options).scanInto(shotOf(true), scan);
    return scan;
  };
  const Scan bare = scanWith(0);
  for (size_t effect = 1; effect < effectNames().size(); ++effect) {
    INFO(effectNames()[effect]);
    CHECK(!sameFields(bare, scanWith(effect)));
  }
}

TEST_CASE("every pair of effects equals the reference, without and with motion", "[combinations]") {
  const size_t count = effectNames().size();
  REQUIRE(count == 17);
  // Nine pairs hold every effect.
  if (!everyCombination()) {
    for (size_t first = 0; first <= count / 2; ++first) compare(first, (first + 9) % count);
    return;
  }
  for (size_t first = 0; first < count; ++first)
    for (size_t second = 0; second <= first; ++second) compare(first, second);
}

}  // namespace gnosphere::test
