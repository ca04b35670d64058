// SPDX-License-Identifier: Apache-2.0
// The C interface to messages of ROS 2: what arrives, and an error for every wrong argument.
#include <gnosphere_ros2.h>

#include "c/fails.hpp"
#include "ros2/listening.hpp"

using namespace gnosphere::test;

namespace {

gno_ros2_publisher latched(gno_ros2_type type) {
  loopbackDomain();
  gno_ros2_options options = gno_ros2_options_init();
  options.durability = GNO_ROS2_TRANSIENT_LOCAL;
  gno_ros2_publisher publisher = nullptr;
  REQUIRE(gno_ros2_publisher_create(type, "c", &options, &publisher) == GNO_OK);
  return publisher;
}

std::string received(gno_ros2_publisher publisher, const char* type) {
  int32_t done = 0;
  REQUIRE(gno_ros2_publisher_flush(publisher, 10, &done) == GNO_OK);
  CHECK(done == 1);
  Listener listener({.type = type, .qos = "latched"}, {"rt/c"});
  const std::vector<std::string> lines = listener.lines();
  gno_ros2_counts counts = gno_ros2_counts_init();
  REQUIRE(gno_ros2_publisher_counts(publisher, &counts) == GNO_OK);
  CHECK(counts.published == 1);
  CHECK(counts.sent == 1);
  REQUIRE(gno_ros2_publisher_destroy(publisher) == GNO_OK);
  CHECK(fails(gno_ros2_publisher_destroy(publisher), "there is no publisher"));
  return lines.size() == 1 ? lines[0] : "";
}

}  // namespace

TEST_CASE("ROS 2 from C: messages arrive") {
  REQUIRE(std::string(gno_ros2_unavailable()).empty());
  const gno_ros2_field field = {"x", 0, 7, 1};
  const float points[] = {1, 2};
  gno_ros2_cloud cloud = gno_ros2_cloud_init();
  cloud.stamp = 1'000'000'002;
  cloud.frame = "c";
  cloud.width = 2;
  cloud.fields = &field;
  cloud.field_count = 1;
  cloud.point_step = 4;
  cloud.data = points;
  cloud.bytes = sizeof(points);
  gno_ros2_publisher publisher = latched(GNO_ROS2_POINT_CLOUD2);
  REQUIRE(gno_ros2_publish_cloud(publisher, &cloud) == GNO_OK);
  CHECK(received(publisher, "cloud").starts_with("rt/c 1.000000002 c 1x2 step 4 row 8 bytes 8 "));

  gno_ros2_laser laser = gno_ros2_laser_init();
  laser.angle_max = 0.5f;
  laser.ranges = laser.intensities = points;
  laser.range_count = 2;
  publisher = latched(GNO_ROS2_LASER_SCAN);
  REQUIRE(gno_ros2_publish_laser(publisher, &laser) == GNO_OK);
  CHECK(received(publisher, "laser") == "rt/c 0.000000000  0 0.5 0 0 0 0 0 ranges 1 2 intensities 1 2");

  const gno_ros2_transform transform = {3, "map", "base", {{1, 2, 3}, {0, 0, 0, 1}}};
  publisher = latched(GNO_ROS2_TRANSFORMS);
  REQUIRE(gno_ros2_publish_transforms(publisher, &transform, 1) == GNO_OK);
  CHECK(received(publisher, "transforms") == "rt/c 0.000000003 map>base 1 2 3 0 0 0 1");

  gno_ros2_imu imu = gno_ros2_imu_init();
  imu.stamp = 4;
  imu.frame = "imu";
  imu.angular_velocity[2] = 0.5;
  imu.linear_acceleration[1] = 2;
  imu.angular_velocity_covariance[8] = 3;
  imu.linear_acceleration_covariance[0] = 4;
  publisher = latched(GNO_ROS2_IMU);
  REQUIRE(gno_ros2_publish_imu(publisher, &imu) == GNO_OK);
  CHECK(received(publisher, "imu") ==
        "rt/c 0.000000004 imu 0 0 0 1 turns 0 0 0.5 accelerates 0 2 0 covariances 0..0 0..3 4..0");

  gno_ros2_odometry odometry = gno_ros2_odometry_init();
  odometry.stamp = 5;
  odometry.frame = "odom";
  odometry.child_frame = "base";
  odometry.pose.position[1] = 2;
  odometry.pose_covariance[35] = 3;
  odometry.linear_velocity[0] = 4;
  odometry.angular_velocity[2] = 6;
  odometry.twist_covariance[0] = 7;
  publisher = latched(GNO_ROS2_ODOMETRY);
  REQUIRE(gno_ros2_publish_odometry(publisher, &odometry) == GNO_OK);
  CHECK(received(publisher, "odometry") ==
        "rt/c 0.000000005 odom>base 0 2 0 0 0 0 1 moves 4 0 0 turns 0 0 6 covariances 0..3 7..0");

  publisher = latched(GNO_ROS2_CLOCK);
  REQUIRE(gno_ros2_publish_clock(publisher, 5'000'000'000) == GNO_OK);
  CHECK(received(publisher, "clock") == "rt/c 5.000000000");
}

TEST_CASE("ROS 2 from C: wrong arguments are errors") {
  loopbackDomain();
  gno_ros2_publisher publisher = nullptr;
  CHECK(fails(gno_ros2_publisher_create(7, "a", nullptr, &publisher), "none of 0..6"));
  CHECK(fails(gno_ros2_publisher_create(0, nullptr, nullptr, &publisher), "topic is null"));
  CHECK(fails(gno_ros2_publisher_create(0, "a b", nullptr, &publisher), "is no name of a topic"));
  CHECK(fails(gno_ros2_publisher_create(0, "a", nullptr, nullptr), "publisher is null"));
  gno_ros2_options options = {};
  CHECK(fails(gno_ros2_publisher_create(0, "a", &options, &publisher), "struct_size"));
  options = gno_ros2_options_init();
  options.reliability = 2;
  CHECK(fails(gno_ros2_publisher_create(0, "a", &options, &publisher), "reliability"));
  options = gno_ros2_options_init();
  options.domain = -2;
  CHECK(fails(gno_ros2_publisher_create(0, "a", &options, &publisher), "domain is -2"));
  options.domain = -1;
  options.localhost_only = 2;
  CHECK(fails(gno_ros2_publisher_create(0, "a", &options, &publisher), "localhost_only is 2"));
  CHECK(fails(gno_ros2_publish_clock(nullptr, 0), "the handle of the publisher is null"));
  // A publisher that is not to stay on this machine is on its networks, whatever the environment says of others.
  setenv("ROS_LOCALHOST_ONLY", "1", 1);
  options = gno_ros2_options_init();
  options.localhost_only = 0;
  REQUIRE(gno_ros2_publisher_create(0, "a", &options, &publisher) == GNO_OK);
  gno_ros2_publisher other = nullptr;
  CHECK(gno_ros2_publisher_create(0, "b", nullptr, &other) != GNO_OK);
  CHECK(std::string(gno_last_error()).find("have another range of discovery") != std::string::npos);
  unsetenv("ROS_LOCALHOST_ONLY");
  REQUIRE(gno_ros2_publisher_destroy(publisher) == GNO_OK);
  REQUIRE(gno_ros2_publisher_create(GNO_ROS2_POINT_CLOUD2, "a", nullptr, &publisher) == GNO_OK);
  gno_ros2_cloud cloud = gno_ros2_cloud_init();
  cloud.bytes = 3;
  CHECK(fails(gno_ros2_publish_cloud(publisher, &cloud), "data is null"));
  CHECK(fails(gno_ros2_publish_cloud(publisher, nullptr), "gno_ros2_cloud is null"));
  CHECK(fails(gno_ros2_publish_clock(publisher, 0), "another type"));
  CHECK(fails(gno_ros2_publish_scan(publisher, nullptr, nullptr, 0, "c", 0), "scan"));
  CHECK(fails(gno_ros2_publish_driver_scan(publisher, nullptr, GNO_ROS2_OUSTER, "c", 0, nullptr), "scan"));
  CHECK(fails(gno_ros2_publish_livox_custom(publisher, nullptr, "c", 0, nullptr), "scan"));
  CHECK(fails(gno_ros2_publish_channel(publisher, nullptr, nullptr, 0, "c", 0), "sensor"));
  CHECK(fails(gno_ros2_publisher_flush(publisher, 1, nullptr), "done is null"));
  REQUIRE(gno_ros2_publisher_destroy(publisher) == GNO_OK);
}
