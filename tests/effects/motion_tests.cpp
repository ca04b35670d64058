// SPDX-License-Identifier: Apache-2.0
// Firing times of beams, and positions of sensor and instances at those times.
#include <catch2/catch_approx.hpp>
#include <catch2/catch_test_macros.hpp>
#include <cmath>
#include <numbers>
#include <span>
#include <vector>

#include "base/transform.hpp"
#include "effects/trajectory.hpp"
#include "geometry/instance_table.hpp"
#include "geometry/transform_rows.hpp"
#include "reference/hit.hpp"
#include "sensor/beams.hpp"

namespace gnosphere {
namespace {

using Catch::Approx;

Quaternion yaw(double angle) {
  return {0, 0, std::sin(angle / 2), std::cos(angle / 2)};
}
double yawOf(const Quaternion& q) {
  return 2 * std::atan2(q.z, q.w);
}

const Pose kStanding = {{7, 8, 9}, {}};

SensorMotion drive() {
  return {{{0.1, {{1, 0, 0}, yaw(0)}}, {0.2, {{3, 1, 0}, yaw(1)}}, {0.4, {{3, 1, 4}, yaw(1)}}}};
}

}  // namespace

TEST_CASE("beams fire column by column, and each channel has its own delay") {
  Sensor sensor{"spinning", 10, {}, 0, 100};
  sensor.channels.resize(2);
  sensor.channels[1].timeOffset = 2e-6;
  sensor.rotationPeriod = 0.1;
  CHECK(timeOf(sensor, 0) == 0);
  CHECK(timeOf(sensor, 5) == Approx(0.05));
  CHECK(timeOf(sensor, 10) == 2e-6);
  CHECK(timeOf(sensor, 19) == Approx(0.090002));
  sensor.rotationPeriod = 0;
  CHECK(timeOf(sensor, 5) == 0);
}

TEST_CASE("a sensor without stamps stays at its pose, and stamps are held before the first and after the last") {
  CHECK(poseAt({}, kStanding, 0.3).position.x == 7);
  CHECK(velocityAt({}, 0.3).x == 0);
  CHECK(poseAt(drive(), kStanding, 0).position.x == 1);
  CHECK(poseAt(drive(), kStanding, 1).position.z == 4);
  const SensorMotion one = {{{0.5, {{2, 0, 0}, {}}}}};
  CHECK(poseAt(one, kStanding, 0.5).position.x == 2);
  CHECK(velocityAt(one, 0.5).x == 0);
}

TEST_CASE("between stamps positions are interpolated linearly and orientations at constant angular speed") {
  const Pose pose = poseAt(drive(), kStanding, 0.125);
  CHECK(pose.position.x == Approx(1.5));
  CHECK(pose.position.y == Approx(0.25));
  CHECK(yawOf(pose.orientation) == Approx(0.25));
  CHECK(velocityAt(drive(), 0.125).x == Approx(20));
  CHECK(velocityAt(drive(), 0.1).y == Approx(10));
  CHECK(velocityAt(drive(), 0.2).z == Approx(20));
  CHECK(poseAt(drive(), kStanding, 0.2).position.x == 3);
}

TEST_CASE("stamps at the ends of a scan do not stop the sensor there") {
  CHECK(velocityAt(drive(), 0.05).x == Approx(20));
  CHECK(velocityAt(drive(), 0.4).z == Approx(20));
  CHECK(velocityAt(drive(), 1).z == Approx(20));
  CHECK(angularVelocityAt(drive(), 0).z == Approx(10));
  CHECK(angularVelocityAt(drive(), 1).z == 0);
}

TEST_CASE("a quaternion of any length but 0 is the rotation of its direction") {
  const double angle = 0.7, c = std::cos(angle), s = std::sin(angle);
  const auto isTurned = [&](const Transform& t) {
    const auto& m = t.rows;
    return m[0] == Approx(c) && m[1] == Approx(-s) && m[4] == Approx(s) && m[5] == Approx(c) && m[10] == Approx(1);
  };
  for (const double length : {1.0, 1e-7, 1e-160, 1e-300, 1e-310, 1e7, 1e154, 1e160, 1e308}) {
    INFO("length " << length);
    const Quaternion unit = yaw(angle), q = {0, 0, length * unit.z, length * unit.w};
    CHECK(isTurned(composed({}, q, {1, 1, 1})));
    const Vec3 axis = reference::SensorFrame({{}, q}).axes[0];
    CHECK((axis.x == Approx(c) && axis.y == Approx(s)));
    std::vector<Transform> transforms;
    const double numbers[7] = {1, 2, 3, q.x, q.y, q.z, q.w};
    readTransforms(std::span<const double>(numbers), 1, transforms);
    CHECK(isTurned(transforms[0]));
    const SensorMotion motion = {{{0, {{}, q}}, {1, {{}, {0, 0, 0, length}}}}};
    CHECK(yawOf(poseAt(motion, {}, 0.5).orientation) == Approx(angle / 2));
    CHECK(angularVelocityAt(motion, 0.5).z == Approx(-angle));
  }
}

TEST_CASE("the angular velocity is that of the shorter arc, in the frame of the sensor") {
  // A sensor that lies on its side, so that its x axis points up, and turns about the vertical axis.
  const double half = std::sqrt(0.5);
  const Quaternion side = {0, -half, 0, half};
  const auto turned = [&](double angle, double sign) {
    const Quaternion q = yaw(angle);  // q * side, the rotation of the world last
    return Quaternion{sign * (q.w * side.x - q.z * side.y), sign * (q.w * side.y + q.z * side.x),
                      sign * (q.w * side.z + q.z * side.w), sign * (q.w * side.w - q.z * side.z)};
  };
  for (const double sign : {1.0, -2.0}) {
    const SensorMotion motion = {{{0, {{}, turned(0.3, 1)}}, {0.1, {{}, turned(0.5, sign)}}}};
    const Vec3 w = angularVelocityAt(motion, 0.05);
    CHECK(w.x == Approx(2));
    CHECK(w.y == Approx(0).margin(1e-12));
    CHECK(w.z == Approx(0).margin(1e-12));
  }
  CHECK(angularVelocityAt({}, 0.3).z == 0);
}

TEST_CASE("orientations are interpolated along the shorter arc, whatever the quaternions' signs and lengths") {
  const auto turned = [](const Quaternion& from, const Quaternion& to) {
    return poseAt({{{0, {{}, from}}, {1, {{}, to}}}}, {}, 0.5).orientation;
  };
  const double far = 0.9 * std::numbers::pi;
  const Quaternion end = yaw(far), opposite = {0, 0, -2 * end.z, -2 * end.w};
  for (const Quaternion& to : {end, opposite}) CHECK(yawOf(turned(yaw(0), to)) == Approx(far / 2));
  const Quaternion small = turned(yaw(1), yaw(1 + 1e-7));
  CHECK(yawOf(small) - 1 == Approx(5e-8).epsilon(1e-6));
  CHECK(yawOf(turned(yaw(1), yaw(1))) == Approx(1));
}

TEST_CASE("points of an instance move to their end positions at a constant velocity") {
  const Transform start = {{1, 0, 0, 10, 0, 1, 0, 0, 0, 0, 1, 0}};
  const Transform end = {{0, -1, 0, 12, 1, 0, 0, 0, 0, 0, 1, 1}};
  const Vec3 corner = {1, 2, 3};
  // The corner moves from (11, 2, 3) to (10, 1, 4) in 0.1 s.
  const Vec3 velocity = velocityOf(start, end, 0.1) * corner;
  CHECK(velocity.x == Approx(-10));
  CHECK(velocity.y == Approx(-10));
  CHECK(velocity.z == Approx(10));
}

TEST_CASE("an instance without triangles moves nothing, however it turns") {
  MeshSummary box, none;
  box.triangles = 12;
  box.low = {-1, -1, -1};
  box.high = {1, 1, 1};
  none.low = glm::dvec3(gpu::kCoordinateLimit);  // as PackedGeometry has it
  none.high = -none.low;
  InstanceTable table;
  table.addMesh(box);
  table.addMesh(none);
  table.set(0, 0, {}, 0);
  table.set(1, 1, {}, 0);
  const Transform quarter = {{0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0}};
  const std::vector<InstanceMotion> motions = {{1, quarter}, {0, quarter}};
  MovingInstances moving;
  CHECK(table.findMotions({}, std::span(motions).first(1), {}, 0.1, moving) == 0);
  // The corners of the box are the root of 2 from the axis, about which they turn a quarter.
  CHECK(table.findMotions({}, motions, {}, 0.1, moving) == Approx(2));
}

}  // namespace gnosphere
