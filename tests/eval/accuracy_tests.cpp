// SPDX-License-Identifier: Apache-2.0
// The accuracy report: its errors, its histogram, its sample.
#include <catch2/catch_approx.hpp>
#include <catch2/matchers/catch_matchers_exception.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <limits>

#include "columns.hpp"
#include "eval/sample.hpp"
#include "gnosphere/eval/accuracy.hpp"
#include "lists/list_sensors.hpp"
#include "output/comparison_sum.hpp"
#include "support.hpp"
#include "town/town.hpp"

using namespace gnosphere;
using namespace gnosphere::test;
using Catch::Matchers::ContainsSubstring;
using Catch::Matchers::MessageMatches;

namespace {

const Pose kStreet = {{0, 0, 1.8}, {}};

AccuracyOptions quick() {
  AccuracyOptions options;
  options.simulator = vulkanOptions();
  options.runs = 3;
  return options;
}

const AccuracyRow& rowOf(const std::vector<AccuracyRow>& rows, const std::string& name) {
  for (const AccuracyRow& row : rows)
    if (row.name == name) return row;
  FAIL("no row is called " << name);
  return rows.front();
}

Scan cloudOf(const std::vector<Vec3>& points, const std::vector<bool>& hits = {}) {
  Scan scan;
  scan.columns = static_cast<uint32_t>(points.size());
  scan.channels = 1;
  for (size_t i = 0; i < points.size(); ++i) {
    const Vec3& p = points[i];
    for (double value : {p.x, p.y, p.z}) scan.points.push_back(static_cast<float>(value));
    scan.ranges.push_back(static_cast<float>(std::sqrt(p.x * p.x + p.y * p.y + p.z * p.z)));
    const bool hit = hits.empty() || hits[i];
    scan.triangles.push_back(hit ? 0 : kNoTriangle);
    scan.instances.push_back(hit ? 0 : kNoTriangle);
  }
  return scan;
}

double distance(const Scan& a, size_t i, const Scan& b, size_t j) {
  double squared = 0;
  for (size_t axis = 0; axis < 3; ++axis) {
    const double d = double{a.points[3 * i + axis]} - double{b.points[3 * j + axis]};
    squared += d * d;
  }
  return std::sqrt(squared);
}

}  // namespace

TEST_CASE("standard and exact lose no beam of a town, and each part of standard is reported alone") {
  needVulkan();
  const Scene town = makeTown({20'000, 1});
  const Sensor sensor = gridSensor(720, 64, -25, 2, 120);
  const AccuracyReport report = measureAccuracy(town, sensor, {kStreet, {{3, -2, 1.6}, {0, 0, 1, 0}}}, quick());
  CHECK(report.beams == 2 * sensor.beamCount());
  CHECK_FALSE(report.sampled);
  REQUIRE(report.settings.size() == 4);
  for (const char* name : {"standard", "exact"}) {
    const AccuracyRow& row = rowOf(report.settings, name);
    CHECK(row.error.missed == 0);
    CHECK(row.error.falseHits == 0);
    CHECK(row.errorBound() < 0.01);
    CHECK(row.error.beams == report.beams);
    CHECK(row.nearest[0] == row.error.hits + row.error.tieFalseHits - row.error.tieMissed);
  }
  CHECK(rowOf(report.settings, "standard").ratio.median == 1);
  CHECK(rowOf(report.settings, "paper").error.missed > 0);
  REQUIRE(report.parts.size() == 4);
  CHECK(rowOf(report.parts, "corner bounds").error.missed > 0);
  for (const auto* rows : {&report.settings, &report.parts}) {
    for (const AccuracyRow& row : *rows) {
      CHECK(row.wallMs.min > 0);
      CHECK(row.wallMs.min <= row.wallMs.p10);
      CHECK(row.wallMs.p10 <= row.wallMs.median);
      CHECK(row.wallMs.median <= row.wallMs.p90);
      CHECK(row.ratio.p10 > 0);
      CHECK(row.ratio.p10 <= row.ratio.median);
      CHECK(row.ratio.median <= row.ratio.p90);
    }
  }
}

TEST_CASE("paper loses returns on a ground of large quads") {
  needVulkan();
  MeshBuilder builder;
  builder.quad({-400, -370, -1.8}, {800, 0, 0}, {0, 800, 0}, 40);
  AccuracyOptions options = quick();
  options.runs = 1;
  options.parts = false;
  const AccuracyReport report =
      measureAccuracy(sceneOf(builder.take()), gridSensor(900, 32, -25, -2, 120), {Pose{}}, options);
  CHECK(rowOf(report.settings, "paper").error.missed > report.beams / 100);
  CHECK(rowOf(report.settings, "standard").error.missed == 0);
  CHECK(std::isinf(rowOf(report.settings, "paper").errorBound()));
}

TEST_CASE("accuracy leaves paper out for elevations at uneven steps, where paper would lose most beams") {
  needVulkan();
  Sensor sensor = gridSensor(90, 9, -25, -1, 120);
  sensor.channels.back().elevationDeg = 15;
  AccuracyOptions options = quick();
  options.runs = 1;
  options.parts = false;
  const AccuracyReport report = measureAccuracy(makeTown({1'000, 1}), sensor, {kStreet}, options);
  CHECK(report.withoutPaper == "the sensor has elevations at uneven steps");
  REQUIRE(report.settings.size() == 3);
  CHECK(report.settings[0].name == "draft");
}

TEST_CASE("a scan of ties alone bounds no error") {
  needVulkan();
  // All beams of one column meet the edge that two triangles share.
  MeshBuilder builder;
  builder.triangle({5, 0, -3}, {5, 4, 3}, {5, 0, 3});
  builder.triangle({5, 0, -3}, {5, 0, 3}, {5, -4, 3});
  BeamList beams;
  for (int i = 0; i < 40; ++i) beams.directions.push_back(directionAt(0, 0.01 * (i - 20)));
  beams.directions.push_back({-1, 0, 0});  // into the sky
  AccuracyOptions options = quick();
  options.runs = 1;
  options.parts = false;
  options.simulator.accuracy = Accuracy::paper;  // is ignored, and could not scan a list
  const AccuracyReport report =
      measureAccuracy(sceneOf(builder.take()), listSensor("line", beams, 50), {Pose{}}, options);
  const AccuracyRow& row = rowOf(report.settings, "standard");
  CHECK(row.error.ties == 40);
  CHECK(std::isinf(row.errorBound()));
}

TEST_CASE("errors on a sample of the beams are part of those on all beams") {
  needVulkan();
  const Scene scene = sceneOf(soup(3, 400, 20, 6));
  const Sensor sensor = gridSensor(333, 16, -40, 30, 100);
  AccuracyOptions options = quick();
  options.runs = 1;
  options.parts = false;
  const AccuracyReport whole = measureAccuracy(scene, sensor, {Pose{}}, options);
  CHECK_FALSE(whole.sampled);
  CHECK(whole.beams == sensor.beamCount());
  options.sample = 1000;
  const AccuracyReport report = measureAccuracy(scene, sensor, {Pose{}}, options);
  CHECK(report.sampled);
  CHECK(report.beams == 1000);
  CHECK(rowOf(report.settings, "standard").error.hits > 100);
  CHECK(rowOf(report.settings, "standard").error.missed == 0);
  CHECK(rowOf(report.settings, "standard").error.wrongRange == 0);
  CHECK(rowOf(report.settings, "standard").nearest == NearestHistogram{});
  CHECK(rowOf(whole.settings, "standard").nearest != NearestHistogram{});
  // The sample has one beam in each of 1,000 equal runs of the 5,328, so a share of errors is about that of all beams.
  const Comparison &some = rowOf(report.settings, "paper").error, &all = rowOf(whole.settings, "paper").error;
  CHECK(some.missed > 0);
  for (const auto count : {&Comparison::hits, &Comparison::missed, &Comparison::falseHits, &Comparison::wrongOwner}) {
    CHECK(some.*count <= all.*count);
    const double expected = 1000 * static_cast<double>(all.*count) / 5328;
    CHECK(std::abs(static_cast<double>(some.*count) - expected) <= 4 * std::sqrt(expected) + 1);
  }
}

TEST_CASE("a sample is the whole sensor, of which only the sampled beams fire") {
  Sensor sensor = gridSensor(77, 5, -30, 30);
  sensor.maskedBeams = {0, 1, 2, 3, 4, 5, 6, 7};
  const BeamSample sample = sampleOf(sensor, 60, 9);
  REQUIRE(sample.beams.size() == 60);
  validate(sample.sensor);
  std::vector<bool> fires(sensor.beamCount(), true);
  for (const uint32_t beam : sample.sensor.maskedBeams) fires[beam] = false;
  for (size_t beam = 0; beam < fires.size(); ++beam) {
    const bool sampled = std::find(sample.beams.begin(), sample.beams.end(), beam) != sample.beams.end();
    CHECK(fires[beam] == (sampled && beam > 7));
  }
  CHECK(sampleOf(sensor, 60, 9).beams == sample.beams);
  CHECK(sampleOf(sensor, 60, 10).beams != sample.beams);
  CHECK(sampleOf(sensor, 385, 9).beams.empty());
}

TEST_CASE("the histogram of nearest neighbours equals that of brute force") {
  Random uniform(5);
  std::vector<Vec3> ours, theirs;
  std::vector<bool> hits, theirHits;
  for (int i = 0; i < 700; ++i) {
    const Vec3 p = {8 * uniform(), 8 * uniform(), 8 * uniform()};
    const double off = uniform() > 0 ? 0.05 : 3;
    ours.push_back(p);
    theirs.push_back({p.x + off * uniform(), p.y + off * uniform(), p.z + off * uniform()});
    hits.push_back(uniform() > -0.9);
    theirHits.push_back(uniform() > 0.4);
  }
  const Scan reference = cloudOf(theirs, theirHits), other = cloudOf(ours, hits);
  NearestHistogram expected{};
  for (size_t i = 0; i < ours.size(); ++i) {
    if (!hits[i]) continue;
    double nearest = 1e9;
    for (size_t j = 0; j < theirs.size(); ++j)
      if (theirHits[j]) nearest = std::min(nearest, distance(other, i, reference, j));
    size_t bin = 0;
    while (bin < kNearestBins.size() && nearest >= kNearestBins[bin]) ++bin;
    ++expected[bin];
  }
  CHECK(nearestHistogram(reference, other) == expected);
  CHECK(expected[3] > 0);
  CHECK(expected.back() > 0);
}

TEST_CASE("against a cloud without points, every point falls into the histogram's last bin") {
  const Scan nothing = cloudOf({{1, 0, 0}}, {false});
  CHECK(nearestHistogram(nothing, cloudOf({{1, 0, 0}})).back() == 1);
  CHECK(nearestHistogram(nothing, nothing) == NearestHistogram{});
}

TEST_CASE("every return of a beam falls into the histogram") {
  Scan twice = cloudOf({{1, 0, 0}, {3, 0, 0}});
  twice.columns = 1;
  twice.returns = 2;
  CHECK(nearestHistogram(twice, twice)[0] == 2);
  CHECK(nearestHistogram(twice, cloudOf({{3, 0, 0}}))[0] == 1);
}

TEST_CASE("a comparison summed over scans equals the comparison of all beams at once") {
  Random uniform(11);
  Scan all[2];
  std::vector<uint8_t> allTies;
  ComparisonSum sum(3 * 20'000, 1e-3);
  for (int part = 0; part < 3; ++part) {
    Scan pair[2];
    std::vector<uint8_t> ties;
    for (Scan& scan : pair) scan.columns = 20'000, scan.channels = 1;
    for (int i = 0; i < 20'000; ++i) {
      const auto range = static_cast<float>(50 + 20 * uniform());
      const float error = static_cast<float>(1e-4 * uniform() * uniform());
      pair[0].ranges.push_back(range);
      pair[1].ranges.push_back(range + error);
      for (Scan& scan : pair) {
        scan.triangles.push_back(uniform() > 0.99 ? kNoTriangle : uniform() > 0.99 ? 1 : 0);
        if (scan.triangles.back() == kNoTriangle) scan.ranges.back() = std::numeric_limits<float>::quiet_NaN();
        scan.instances.push_back(0);
      }
      ties.push_back(uniform() > 0.95);
    }
    setColumn(pair[0], Field::tie, ties);
    allTies.insert(allTies.end(), ties.begin(), ties.end());
    sum.add(pair[0], pair[1]);
    for (int k = 0; k < 2; ++k) {
      all[k].columns += 20'000;
      all[k].channels = 1;
      all[k].ranges.insert(all[k].ranges.end(), pair[k].ranges.begin(), pair[k].ranges.end());
      all[k].triangles.insert(all[k].triangles.end(), pair[k].triangles.begin(), pair[k].triangles.end());
      all[k].instances.insert(all[k].instances.end(), pair[k].instances.begin(), pair[k].instances.end());
    }
  }
  setColumn(all[0], Field::tie, allTies);
  const Comparison a = sum.result(), b = compare(all[0], all[1]);
  CHECK(a.beams == 60'000);
  uint64_t hits = 0, missed = 0, falseHits = 0, wrongOwner = 0;
  for (size_t i = 0; i < all[0].ranges.size(); ++i) {
    hits += all[0].hit(i);
    if (allTies[i]) continue;
    missed += all[0].hit(i) && !all[1].hit(i);
    falseHits += !all[0].hit(i) && all[1].hit(i);
    wrongOwner += all[0].hit(i) && all[1].hit(i) && all[0].triangles[i] != all[1].triangles[i];
  }
  for (const Comparison& found : {a, b}) {
    CHECK(found.hits == hits);
    CHECK(found.missed == missed);
    CHECK(found.falseHits == falseHits);
    CHECK(found.wrongOwner == wrongOwner);
    CHECK(found.ties == static_cast<uint64_t>(std::ranges::count(allTies, 1)));
  }
  CHECK(a.tieMissed + a.tieFalseHits + a.tieWrongOwner == a.tieDifferences);
  CHECK(a.rangeError9999 == b.rangeError9999);
  CHECK(a.rangeErrorMax == b.rangeErrorMax);
  CHECK(a.rangeErrorRms == Catch::Approx(b.rangeErrorRms));
  CHECK(a.hitErrorMax >= a.rangeErrorMax);
  std::vector<double> errors;
  for (size_t i = 0; i < all[0].ranges.size(); ++i)
    if (!allTies[i] && all[0].hit(i) && all[0].triangles[i] == all[1].triangles[i])
      errors.push_back(std::abs(double{all[0].ranges[i]} - double{all[1].ranges[i]}));
  std::sort(errors.begin(), errors.end());
  const double rank = std::ceil(0.9999 * static_cast<double>(errors.size()));
  CHECK(a.rangeError9999 == errors[static_cast<size_t>(rank) - 1]);
}

TEST_CASE("spreads have the median, minimum and percentiles of their values") {
  const Spread spread = spreadOf({9, 1, 8, 2, 7, 3, 6, 4, 5, 10});
  CHECK(spread.median == 5.5);
  CHECK(spread.min == 1);
  CHECK(spread.p10 == 1);
  CHECK(spread.p90 == 9);
  CHECK(spreadOf({}).median == 0);
  CHECK(spreadOf({3}).p90 == 3);
}

TEST_CASE("measuring accuracy without poses, without runs or on the reference is refused") {
  const Scene scene = sceneOf(soup(1, 10, 5, 2));
  const Sensor sensor = gridSensor(36, 2, -10, 10);
  AccuracyOptions options = quick();
  CHECK_THROWS_MATCHES(measureAccuracy(scene, sensor, {}, options), Error, MessageMatches(ContainsSubstring("pose")));
  options.simulator.device = DeviceChoice::Kind::reference;
  CHECK_THROWS_MATCHES(measureAccuracy(scene, sensor, {Pose{}}, options), Error,
                       MessageMatches(ContainsSubstring("another device")));
  options.runs = 0;
  CHECK_THROWS_MATCHES(measureAccuracy(scene, sensor, {Pose{}}, options), Error,
                       MessageMatches(ContainsSubstring("run")));
}

TEST_CASE("a warning about the scene is given once, not by each simulator of the report") {
  needVulkan();
  Scene scene = sceneOf(soup(1, 10, 5, 2));
  scene.instances[0].transform = {{1, 1, 0, 0, 0, 1e-6, 0, 0, 0, 0, 1, 0}};
  AccuracyOptions options = quick();
  options.parts = false;
  std::vector<std::string> warnings;
  options.simulator.warn = [&](const std::string& warning) { warnings.push_back(warning); };
  measureAccuracy(scene, gridSensor(36, 2, -10, 10), {Pose{}}, options);
  REQUIRE(warnings.size() == 1);
  CHECK_THAT(warnings[0], ContainsSubstring("sheared"));
}
