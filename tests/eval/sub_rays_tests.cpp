// SPDX-License-Identifier: Apache-2.0
// Tests what footprints of fewer sub-rays get wrong, compared with the reference with many sub-rays.
#include <algorithm>
#include <catch2/matchers/catch_matchers_exception.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <string>
#include <vector>

#include "gnosphere/eval/sub_rays.hpp"
#include "support.hpp"

using namespace gnosphere;
using namespace gnosphere::test;
using Catch::Matchers::ContainsSubstring;
using Catch::Matchers::MessageMatches;

namespace {

/// A clockwise head with lasers away from the axis, the beams of which have wide footprints.
Sensor head() {
  Sensor sensor = gridSensor(180, 6, -8, 8, 60);
  sensor.azimuthStartDeg = 170;
  sensor.azimuthSpanDeg = -340;
  sensor.divergenceHorizontal = sensor.divergenceVertical = 0.01;
  sensor.maxReturns = 2;
  for (size_t j = 0; j < 6; ++j) {
    sensor.channels[j].azimuthOffsetDeg = static_cast<double>(j % 3) - 1;
    sensor.channels[j].origin = {0.03, 0, 0.02};
  }
  return sensor;
}

SubRayOptions quickSubRays() {
  SubRayOptions options;
  options.simulator = vulkanOptions();
  options.counts = {1, 7};
  options.runs = 1;
  options.sample = 300;
  return options;
}

/// Posts in a room: some footprints lie on a wall, others in part on a post.
Scene posts() {
  MeshBuilder builder;
  builder.box({-22, -17, -9}, {25, 19, 9}, 3);
  for (int i = 0; i < 12; ++i) {
    const double x = 9 * std::cos(0.5 * i), y = 9 * std::sin(0.5 * i);
    builder.box({x, y, -2}, {x + 0.4, y + 0.4, 6}, 1);
  }
  return sceneOf(builder.take());
}

}  // namespace

TEST_CASE("more sub-rays are nearer to the reference with many, where footprints have edges") {
  needVulkan();
  const Scene scene = posts();
  const SubRayReport report = measureSubRays(scene, {head()}, {Pose{}, {{1, 2, 0.5}, {}}}, quickSubRays());
  CHECK(report.beams == 600);
  CHECK(report.sampled);
  CHECK(report.footprint == "the sensor states 10 x 10 mrad");
  REQUIRE(report.rows.size() == 3);
  CHECK(report.rows[0].subRays == 0);
  CHECK(report.rows[0].ratio.median == 1);
  const SubRayRow &one = report.rows[1], &seven = report.rows[2];
  CHECK(one.subRays == 1);
  CHECK(one.beams == 600);  // the room is closed
  CHECK(one.wrongReturns > 0.01);
  CHECK(one.wrongReturns < 0.3);
  CHECK(seven.wrongReturns < one.wrongReturns);
  CHECK(seven.rangeErrorRms < one.rangeErrorRms);
  CHECK(seven.intensityErrorMedian < one.intensityErrorMedian);
  for (const SubRayRow* row : {&one, &seven}) {
    CHECK(row->wrong >= std::max(row->wrongRange, row->wrongReturns));
    CHECK(row->wrong <= row->wrongRange + row->wrongReturns);
    CHECK(row->rangeErrorRms <= row->rangeErrorMax);
    CHECK(row->rangeErrorRms > 0);
    CHECK(row->rangeError999 > 0);
    CHECK(row->rangeError999 <= row->rangeErrorMax);
    CHECK(row->intensityErrorMedian > 0);
    CHECK(row->intensityErrorMedian < row->intensityError99);
    CHECK(row->time().median > 0);
  }
}

TEST_CASE("few sub-rays make one echo of a surface at a grazing angle, as many do") {
  needVulkan();
  Sensor sensor = gridSensor(90, 1, -3, -3, 100);
  sensor.divergenceHorizontal = sensor.divergenceVertical = 0.01;
  sensor.maxReturns = 3;
  MeshBuilder builder;
  builder.quad({-150, -150, -1.8}, {300, 0, 0}, {0, 300, 0}, 2);
  SubRayOptions options = quickSubRays();
  options.sample = 0;
  const SubRayReport report = measureSubRays(sceneOf(builder.take()), {sensor}, {Pose{}}, options);
  CHECK(report.rows[1].wrongReturns == 0);
  CHECK(report.rows[2].wrongReturns == 0);
}

TEST_CASE("random errors of the range are those of the reference, so they are no error of a footprint") {
  needVulkan();
  SensorRequest request = {head()};
  request.effects.rangeNoise = {EffectUse::on, 0, 0.5, 0, 0};
  SubRayOptions options = quickSubRays();
  options.counts = {7};
  const Scene scene = sceneOf(ball(40, 80, 5));
  std::vector<std::string> warnings;
  options.simulator.warn = [&](const std::string& warning) { warnings.push_back(warning); };
  options.simulator.materials.rows = {{"no such", 0.5f}};
  const SubRayReport report = measureSubRays(scene, request, {Pose{}}, options);
  CHECK(std::ranges::count(warnings, "the material table has 'no such', but the scene has no material of that name") ==
        1);  // three simulators have the table
  REQUIRE(report.rows[1].beams == 300);
  CHECK(report.rows[1].wrong == 0);
  CHECK(report.rows[1].rangeErrorMax < 0.01);
  // The error that noise allows grows with the square of the range, too, so that fewer ranges are wrong.
  const auto wrongRanges = [&](double sigmaPerSquareMetre) {
    request.effects.rangeNoise = {.sigma = 1e-6, .sigmaPerSquareMetre = sigmaPerSquareMetre};
    options.tolerance = 1e-6;
    options.counts = {7};
    return measureSubRays(scene, request, {Pose{}}, options).rows[1].wrongRange;
  };
  CHECK(wrongRanges(0) > 0.5);
  CHECK(wrongRanges(0.01) < 0.1);
}

TEST_CASE("a measurement of footprints without a footprint, a pose or a device is refused") {
  needVulkan();
  const Scene scene = posts();
  Sensor line = head();
  line.divergenceHorizontal = line.divergenceVertical = 0;
  const auto refused = [&](const Sensor& sensor, const std::vector<Pose>& poses, const SubRayOptions& options,
                           const char* words) {
    CHECK_THROWS_MATCHES(measureSubRays(scene, {sensor}, poses, options), Error,
                         MessageMatches(ContainsSubstring(words)));
  };
  SubRayOptions options = quickSubRays();
  refused(line, {Pose{}}, options, "the sensor states no divergence");
  refused(head(), {}, options, "pose");
  options.runs = 0;
  refused(head(), {Pose{}}, options, "at least one run");
  options = quickSubRays();
  options.counts.clear();
  refused(head(), {Pose{}}, options, "at least one number of sub-rays");
  options.counts = {62};
  refused(head(), {Pose{}}, options, "a device takes at most 61");
  options = quickSubRays();
  options.simulator.device = DeviceChoice::Kind::reference;
  refused(head(), {Pose{}}, options, "another device");
}
