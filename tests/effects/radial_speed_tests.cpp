// SPDX-License-Identifier: Apache-2.0
// Radial speeds and velocities of what a sensor meets that moves, or that things move past.
#include "deformable.hpp"
#include "effects/moving_room.hpp"
#include "lists/list_sensors.hpp"

namespace gnosphere::test {

TEST_CASE("a turning sensor measures no speed in a still world") {
  const std::string device = ON_EVERY_DEVICE;
  Shot shot;
  shot.motion.stamps = {{0, {}}, {kPeriod, {{}, yaw(3)}}};
  const Scan scan = scanned(device, room(), spinning(), shot);
  CHECK(scan.counters.hits == scan.beamCount());
  for (float speed : scan.column<float>(Field::radialSpeed)) CHECK(speed == 0);
}

TEST_CASE("an approaching wall appears slanted, and its speed is measured") {
  const std::string device = ON_EVERY_DEVICE;
  Scene scene = sceneOf(plate(0, 12));
  scene.instances[0].transform = translation(15, 0, 0);
  Shot shot;
  const double speed = -30;
  shot.instanceMotions = {{0, translation(15 + speed * kPeriod, 0, 0)}};
  const Sensor sensor = spinning();
  const Scan scan = scanned(device, scene, sensor, shot);
  size_t hits = 0;
  for (size_t i = 0; i < scan.beamCount(); ++i) {
    if (!scan.hit(i)) continue;
    ++hits;
    const Vec3 d = sensor.direction(i);
    CHECK(scan.points[3 * i] == Approx(15 + speed * timeOfColumn(sensor, i)).epsilon(1e-5));
    CHECK(scan.column<float>(Field::radialSpeed)[i] == Approx(speed * d.x).margin(1e-3));
    CHECK(scan.column<float>(Field::velocity)[i] == Approx(speed).margin(1e-3));
    CHECK(scan.column<float>(Field::normal)[i] == Approx(-1).margin(1e-5));
  }
  CHECK(hits > 300);
}

TEST_CASE("velocities are in the frame of the points, while the sensor drives and turns in a room that moves") {
  const std::string device = ON_EVERY_DEVICE;
  const bool deskew = GENERATE(false, true);
  const Vec3 velocity = {5, -10, 2};
  Shot shot = driving();
  shot.instanceMotions = {{0, translation(kPeriod * velocity.x, kPeriod * velocity.y, kPeriod * velocity.z)}};
  const Sensor sensor = spinning();
  const Scan scan = scanned(device, room(), sensor, shot, deskew);
  for (size_t i = 0; i < scan.beamCount(); ++i) {
    const double time = timeOfColumn(sensor, i);
    const Vec3 d = turned(kTurn * time, sensor.direction(i));
    const Vec3 inRoom = {kSpeed * time - velocity.x * time, -velocity.y * time, -velocity.z * time};
    REQUIRE(scan.ranges[i] == Approx(toWalls(inRoom, d)).epsilon(1e-5));
    const Vec3 expected = deskew ? velocity : turned(-kTurn * time, velocity);
    CHECK(scan.column<float>(Field::velocity, 0)[i] == Approx(expected.x).margin(2e-3));
    CHECK(scan.column<float>(Field::velocity, 1)[i] == Approx(expected.y).margin(2e-3));
    CHECK(scan.column<float>(Field::velocity, 2)[i] == Approx(expected.z).margin(2e-3));
    const double away = (velocity.x - kSpeed) * d.x + velocity.y * d.y + velocity.z * d.z;
    CHECK(scan.column<float>(Field::radialSpeed)[i] == Approx(away).margin(2e-3));
  }
}

TEST_CASE("the velocity of a fast turning plate or wire is that of the point that the beam meets") {
  const std::string device = ON_EVERY_DEVICE;
  const bool wire = GENERATE(false, true);  // 1 mm thick: weights of its corners would be far off
  MeshBuilder builder;
  builder.quad({0, -5, -0.0005}, {0, 10, 0}, {0, 0, 0.001}, 1);
  Scene scene = sceneOf(wire ? builder.take() : plate(0, 12));
  scene.instances[0].transform = translation(15, 0, 0);
  const double angle = 0.8, c = std::cos(angle), s = std::sin(angle);
  Shot shot;
  shot.instanceMotions = {{0, {{c, -s, 0, 15, s, c, 0, 0, 0, 0, 1, 0}}}};
  Sensor sensor = spinning();
  if (GENERATE(false, true))
    for (Channel& channel : sensor.channels) channel.origin = {0.3, -0.2, 0};
  const Scan scan = scanned(device, scene, sensor, shot);
  size_t hits = 0;
  for (size_t i = 0; i < scan.beamCount(); ++i) {
    if (!scan.hit(i)) continue;
    ++hits;
    // A corner at (x, y) of the plate goes straight from (x, y) to (c x - s y, s x + c y), about the plate's centre.
    // The map at the time of the beam is inverted, which gives the point of the plate that the beam meets.
    const double share = timeOfColumn(sensor, i) / kPeriod, cosine = 1 - share + share * c, sine = share * s;
    const double px = scan.points[3 * i] - 15, py = scan.points[3 * i + 1], square = cosine * cosine + sine * sine;
    const double x = (cosine * px + sine * py) / square, y = (cosine * py - sine * px) / square;
    CHECK(scan.column<float>(Field::velocity, 0)[i] == Approx(((c - 1) * x - s * y) / kPeriod).margin(1e-3));
    CHECK(scan.column<float>(Field::velocity, 1)[i] == Approx((s * x + (c - 1) * y) / kPeriod).margin(1e-3));
  }
  CHECK(hits > (wire ? 20 : 300));
}

TEST_CASE("the velocity of a turning plate is that of the point that a deviating beam meets") {
  Scene scene = sceneOf(plate(0, 12));
  scene.instances[0].transform = translation(15, 0, 0);
  const double c = std::cos(1.5), s = std::sin(1.5);
  Shot shot;
  shot.instanceMotions = {{0, {{c, -s, 0, 15, s, c, 0, 0, 0, 0, 1, 0}}}};
  TestOptions options = optionsOn("auto");
  options.effects.objectMotion.use = options.effects.intensity.use = EffectUse::automatic;
  options.effects.radialSpeed.use = EffectUse::automatic;
  options.effects.angleNoise = {EffectUse::on, 5e-3, 5e-3, Effects::AngleNoise::At::beam};
  options.fields = {Field::velocity, Field::radialSpeed};
  Scan found, expected;
  makeSimulator(scene, spinning(), options).scanInto(shot, found);
  options.device = deviceByName("reference");
  makeSimulator(scene, spinning(), options).scanInto(shot, expected);
  size_t hits = 0;
  for (size_t i = 0; i < found.beamCount(); ++i) {
    if (!found.hit(i) || !expected.hit(i)) continue;
    ++hits;
    for (uint32_t axis = 0; axis < 3; ++axis)
      CHECK(found.column<float>(Field::velocity, axis)[i] ==
            Approx(expected.column<float>(Field::velocity, axis)[i]).margin(2e-3));
    CHECK(found.column<float>(Field::radialSpeed)[i] ==
          Approx(expected.column<float>(Field::radialSpeed)[i]).margin(2e-3));
  }
  CHECK(hits > 200);
}

TEST_CASE("a sensor that moves with its target measures no speed and no distortion") {
  const std::string device = ON_EVERY_DEVICE;
  Scene scene = sceneOf(plate(0, 12));
  scene.instances[0].transform = translation(15, 0, 0);
  Shot shot;
  shot.motion.stamps = {{0, {}}, {kPeriod, {{3, 1, 0}, {}}}};
  shot.instanceMotions = {{0, translation(18, 1, 0)}};
  const Scan scan = scanned(device, scene, spinning(), shot);
  CHECK(scan.counters.hits > 300);
  for (size_t i = 0; i < scan.beamCount(); ++i) {
    if (!scan.hit(i)) continue;
    CHECK(scan.points[3 * i] == Approx(15).epsilon(1e-5));
    CHECK(scan.column<float>(Field::radialSpeed)[i] == Approx(0).margin(1e-4));
  }
}

TEST_CASE("the speed of a laser beside the sensor's origin has the turning of the sensor in it") {
  const std::string device = ON_EVERY_DEVICE;
  const bool listed = GENERATE(true, false);
  Sensor sensor = gridSensor(16, 2, 5, 5, 100);
  const Vec3 lasers[] = {{0.3, -0.2, 0.1}, {-0.1, 0.4, 0.05}};
  for (size_t i = 0; i < 2; ++i) sensor.channels[i].origin = lasers[i];
  sensor.rotationPeriod = kPeriod;
  if (listed) {
    Sensor list = listSensor("list", beamsOf(sensor));
    list.rangeMax = 100;
    list.rotationPeriod = kPeriod;
    for (Vec3& origin : list.patterns[0].origins) origin.x += 2;  // far from all others and from the origin
    sensor = list;
  }
  const Scan scan = scanned(device, room(), sensor, driving());
  const auto laserAt = [&](size_t beam, double time) {
    const Vec3 at = turned(kTurn * time, originOf(sensor, beam));
    return Vec3{kSpeed * time + at.x, at.y, at.z};
  };
  for (size_t i = 0; i < sensor.beamCount(); ++i) {
    const double time = timeOf(sensor, i), step = 1e-6;
    const Vec3 d = turned(kTurn * time, directionOf(sensor, i)), from = laserAt(i, time);
    const double range = toWalls(from, d);
    REQUIRE(scan.ranges[i] == Approx(range).epsilon(1e-5));
    const auto distanceAt = [&](double at) {
      const Vec3 p = laserAt(i, at);
      return std::hypot(from.x + range * d.x - p.x, from.y + range * d.y - p.y, from.z + range * d.z - p.z);
    };
    const double expected = (distanceAt(time + step) - distanceAt(time - step)) / (2 * step);
    CHECK(scan.column<float>(Field::radialSpeed)[i] == Approx(expected).margin(2e-3));
  }
}

TEST_CASE("beams that fire up to the last stamp and after it measure the sensor's speed") {
  const std::string device = ON_EVERY_DEVICE;
  Sensor sensor = gridSensor(360, 4, 0, 0, 100);
  sensor.rotationPeriod = kPeriod;
  for (size_t i = 0; i < 4; ++i) sensor.channels[i].timeOffset = 0.3 * static_cast<double>(i) * kPeriod / 360;
  sensor.channels[3].timeOffset = 1.7 * kPeriod / 360;
  Shot shot;
  shot.motion.stamps = {{0, {}}, {kPeriod, {{kSpeed * kPeriod, 0, 0}, {}}}};
  const Scan scan = scanned(device, room(), sensor, shot);
  for (size_t i = 0; i < scan.beamCount(); ++i)
    CHECK(scan.column<float>(Field::radialSpeed)[i] == Approx(-kSpeed * directionOf(sensor, i).x).margin(1e-3));
}

TEST_CASE("fog and drops are at rest: their radial speed is that of the sensor") {
  const std::string device = ON_EVERY_DEVICE;
  TestOptions options = optionsOn(device);
  options.effects = Effects::none();
  options.effects.intensity.use = EffectUse::automatic;
  options.effects.radialSpeed.use = options.effects.sensorMotion.use = EffectUse::on;
  options.effects.fog = {EffectUse::on, 30};
  options.effects.rain.use = EffectUse::on;
  options.effects.rain.rate = 20;
  options.fields = {Field::radialSpeed, Field::velocity, Field::label};
  Sensor sensor = gridSensor(720, 8, -20, 20, 60);
  sensor.rotationPeriod = kPeriod;
  Shot shot;
  shot.motion.stamps = {{0, {}}, {kPeriod, {{kSpeed * kPeriod, 0, 0}, {}}}};
  const Scan scan = scanOn(sceneOf(plate(40, 30)), sensor, shot, options);
  size_t scattered = 0;
  for (size_t i = 0; i < scan.beamCount(); ++i) {
    const float speed = scan.column<float>(Field::radialSpeed)[i];
    const auto label = static_cast<Label>(scan.column<uint8_t>(Field::label)[i]);
    if (label == Label::none) CHECK(std::isnan(speed));
    if (label != Label::scatter) continue;
    ++scattered;
    CHECK(std::abs(speed + kSpeed * scan.points[3 * i] / scan.ranges[i]) < 1e-3);
    CHECK(scan.column<float>(Field::velocity)[i] == 0);
  }
  CHECK(scattered > 500);
}

TEST_CASE("radial speeds have a Gaussian error of the stated sigma, another one for each return") {
  const std::string device = ON_EVERY_DEVICE;
  constexpr double kSigma = 0.05;
  Scene scene = sceneOf(plate(20, 30));
  scene.materials[0].transmission = 0.5f;
  scene.meshes.push_back(plate(40, 60, 1));
  scene.materials.push_back(lambertian(0.5f));
  scene.instances.push_back({"", 1, {}});
  const Sensor sensor = gridSensor(720, 8, -10, 10, 100);
  const auto scan = [&](const std::string& with, double sigma) {
    TestOptions options = optionsOn(with);
    options.effects = Effects::none();
    options.effects.intensity.use = options.effects.transmission.use = EffectUse::automatic;
    options.effects.returns = {EffectUse::on, Effects::Returns::Mode::all, 3};
    options.effects.fog = {EffectUse::on, 300};
    options.effects.radialSpeed = {EffectUse::on, sigma};
    options.fields = {Field::radialSpeed, Field::velocity, Field::label};
    return scanOn(scene, sensor, Shot(), options);
  };
  const Scan noisy = scan(device, kSigma), exact = scan(device, 0), expected = scan("reference", kSigma);
  CHECK(sameBytes(noisy.ranges, exact.ranges));
  const auto speeds = noisy.column<float>(Field::radialSpeed), known = expected.column<float>(Field::radialSpeed);
  double sum = 0, squares = 0, products = 0, count = 0, pairs = 0, beyondTwo = 0;
  size_t scattered = 0;
  for (size_t i = 0; i < noisy.beamCount() * noisy.returns; ++i) {
    if (!noisy.returned(i)) {
      CHECK(std::isnan(speeds[i]));
      continue;
    }
    CHECK(exact.column<float>(Field::radialSpeed)[i] == 0);
    CHECK(noisy.column<float>(Field::velocity)[i] == 0);
    CHECK(std::abs(speeds[i] - known[i]) < 1e-5);
    sum += speeds[i];
    squares += speeds[i] * speeds[i];
    if (std::abs(speeds[i]) > 2 * kSigma) ++beyondTwo;
    scattered += static_cast<Label>(noisy.column<uint8_t>(Field::label)[i]) == Label::scatter;
    ++count;
    if (i % noisy.returns == 0 || !noisy.returned(i - 1)) continue;
    products += speeds[i] * speeds[i - 1];
    ++pairs;
  }
  REQUIRE(count > 2000);
  CHECK(scattered > 20);
  CHECK(std::abs(sum / count) < 4 * kSigma / std::sqrt(count));
  CHECK(std::sqrt(squares / count) == Approx(kSigma).epsilon(0.05));
  CHECK(beyondTwo / count == Approx(0.0455).margin(0.015));
  CHECK(std::abs(products / pairs) < 4 * kSigma * kSigma / std::sqrt(pairs));
}

}  // namespace gnosphere::test
