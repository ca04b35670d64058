/* SPDX-License-Identifier: Apache-2.0
 *
 * The part of GnoSphere's C interface (see gnosphere.h) that publishes messages for ROS 2, without ROS: docs/ros2.md.
 */
#ifndef GNOSPHERE_ROS2_H
#define GNOSPHERE_ROS2_H

#include <gnosphere.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct gno_ros2_publisher_object* gno_ros2_publisher; /* the messages of one topic */

/* The type of the messages of a topic, and its quality of service. */
typedef int32_t gno_ros2_type;
enum {
  GNO_ROS2_POINT_CLOUD2 = 0,
  GNO_ROS2_LASER_SCAN = 1,
  GNO_ROS2_TRANSFORMS = 2,
  GNO_ROS2_CLOCK = 3,
  GNO_ROS2_IMU = 4,
  GNO_ROS2_LIVOX_CUSTOM = 5,
  GNO_ROS2_ODOMETRY = 6
};
typedef int32_t gno_ros2_reliability;
enum { GNO_ROS2_RELIABLE = 0, GNO_ROS2_BEST_EFFORT = 1 };
typedef int32_t gno_ros2_durability;
enum { GNO_ROS2_VOLATILE = 0, GNO_ROS2_TRANSIENT_LOCAL = 1 };

/* Drivers of ROS 2, whose point layouts nodes for localisation and mapping read: docs/ros2.md. */
typedef int32_t gno_ros2_driver;
enum {
  GNO_ROS2_VELODYNE = 0,
  GNO_ROS2_OUSTER = 1,
  GNO_ROS2_HESAI = 2,
  GNO_ROS2_ROBOSENSE = 3,
  GNO_ROS2_LIVOX = 4,
  GNO_ROS2_AUTOWARE = 5
};

/* How a publisher sends. */
typedef struct gno_ros2_options {
  size_t struct_size;
  gno_ros2_reliability reliability;
  gno_ros2_durability durability;
  uint32_t depth;         /* of the queue; newer messages replace the oldest ones. The default is 5 */
  int32_t domain;         /* 0 to 232; -1, the default: what ROS_DOMAIN_ID says, or 0 */
  int32_t localhost_only; /* 0 or 1; -1, the default: what ROS_LOCALHOST_ONLY and
                             ROS_AUTOMATIC_DISCOVERY_RANGE say */
} gno_ros2_options;

/* A field of a cloud. `type` has ROS's numbers: 1 int8, 2 uint8, 3 int16, 4 uint16, 5 int32, 6 uint32, 7 float32,
 * 8 float64. */
typedef struct gno_ros2_field {
  const char* name;
  uint32_t offset;
  uint8_t type;
  uint32_t count;
} gno_ros2_field;

/* sensor_msgs/PointCloud2, little-endian. Stamps are nanoseconds since 1970. */
typedef struct gno_ros2_cloud {
  size_t struct_size;
  int64_t stamp;
  const char* frame;
  uint32_t height, width;
  const gno_ros2_field* fields;
  size_t field_count;
  uint32_t point_step; /* bytes of a point */
  const void* data;    /* height * width points */
  size_t bytes;
  int32_t dense; /* not 0, the default: every point is a number */
} gno_ros2_cloud;

/* sensor_msgs/LaserScan; radians, seconds and metres. */
typedef struct gno_ros2_laser {
  size_t struct_size;
  int64_t stamp;
  const char* frame;
  float angle_min, angle_max, angle_increment, time_increment, scan_time, range_min, range_max;
  const float* ranges;
  const float* intensities; /* one per range, or null */
  size_t range_count;
} gno_ros2_laser;

/* geometry_msgs/TransformStamped: the pose of the frame `child` in the frame `parent`. */
typedef struct gno_ros2_transform {
  int64_t stamp;
  const char* parent;
  const char* child;
  gno_pose pose;
} gno_ros2_transform;

/* sensor_msgs/Imu. Covariances are matrices of three rows; all zeros, the default, mean unknown ones. */
typedef struct gno_ros2_imu {
  size_t struct_size;
  int64_t stamp;
  const char* frame;
  double orientation[4]; /* qx, qy, qz, qw: maps the frame of the unit to the world */
  double orientation_covariance[9];
  double angular_velocity[3]; /* rad/s about the axes of the unit */
  double angular_velocity_covariance[9];
  double linear_acceleration[3]; /* m/s^2 along the axes of the unit; upwards 9.8 at rest */
  double linear_acceleration_covariance[9];
} gno_ros2_imu;

/* nav_msgs/Odometry. Covariances are matrices of six rows: x, y, z, and about these axes. */
typedef struct gno_ros2_odometry {
  size_t struct_size;
  int64_t stamp;
  const char* frame;
  const char* child_frame;
  gno_pose pose; /* of the child frame in the frame */
  double pose_covariance[36];
  double linear_velocity[3];  /* m/s along the axes of the child frame */
  double angular_velocity[3]; /* rad/s about the axes of the child frame */
  double twist_covariance[36];
} gno_ros2_odometry;

/* What has become of the messages of a publisher. */
typedef struct gno_ros2_counts {
  size_t struct_size;
  uint64_t published; /* messages that were given to the functions below */
  uint64_t sent;      /* published messages that went to the network */
  uint64_t dropped;   /* published messages that newer ones replaced before, or that the network refused */
  uint64_t waiting;   /* published messages that wait to be sent */
  uint32_t subscribers;
} gno_ros2_counts;

/* Why nothing can be published; an empty text if messages can be. */
GNO_API const char* gno_ros2_unavailable(void);

/* Makes the publisher of a topic such as "points" or "/front/points". Null options are the default ones. A missing
 * libgnosphere_ros2 or Cyclone DDS is GNO_DEVICE, with a sentence that names the package. */
GNO_API gno_status gno_ros2_publisher_create(gno_ros2_type type, const char* topic, const gno_ros2_options* options,
                                             gno_ros2_publisher* publisher);
/* Messages that wait are dropped. */
GNO_API gno_status gno_ros2_publisher_destroy(gno_ros2_publisher publisher);

/* Messages are copied. None of these functions waits for subscribers or for the network. */
GNO_API gno_status gno_ros2_publish_cloud(gno_ros2_publisher publisher, const gno_ros2_cloud* cloud);
GNO_API gno_status gno_ros2_publish_laser(gno_ros2_publisher publisher, const gno_ros2_laser* laser);
GNO_API gno_status gno_ros2_publish_transforms(gno_ros2_publisher publisher, const gno_ros2_transform* transforms,
                                               size_t count);
GNO_API gno_status gno_ros2_publish_clock(gno_ros2_publisher publisher, int64_t nanoseconds);
GNO_API gno_status gno_ros2_publish_imu(gno_ros2_publisher publisher, const gno_ros2_imu* imu);
GNO_API gno_status gno_ros2_publish_odometry(gno_ros2_publisher publisher, const gno_ros2_odometry* odometry);
/* The returns of a scan with these fields, as a cloud. */
GNO_API gno_status gno_ros2_publish_scan(gno_ros2_publisher publisher, gno_scan scan, const gno_field* fields,
                                         size_t field_count, const char* frame, int64_t stamp);
/* The returns of a scan as a driver publishes them, in the order of their times. The scan needs GNO_FIELD_TIME.
 * `effects` are those of the scan, or null for automatic ones: the scale of its intensities, and the mode of its
 * returns. */
GNO_API gno_status gno_ros2_publish_driver_scan(gno_ros2_publisher publisher, gno_scan scan, gno_ros2_driver driver,
                                                const char* frame, int64_t stamp, gno_effects effects);
/* The returns of a scan in a livox_ros_driver2/CustomMsg, which FAST-LIO reads; otherwise as the function before. */
GNO_API gno_status gno_ros2_publish_livox_custom(gno_ros2_publisher publisher, gno_scan scan, const char* frame,
                                                 int64_t stamp, gno_effects effects);
/* The first returns of one channel of a grid of beams, as a laser scan. */
GNO_API gno_status gno_ros2_publish_channel(gno_ros2_publisher publisher, gno_sensor sensor, gno_scan scan,
                                            uint32_t channel, const char* frame, int64_t stamp);

/* Waits until all messages have been given to the network; `done` is 0 if that takes longer. */
GNO_API gno_status gno_ros2_publisher_flush(gno_ros2_publisher publisher, double seconds, int32_t* done);
GNO_API gno_status gno_ros2_publisher_counts(gno_ros2_publisher publisher, gno_ros2_counts* counts);

/* ---------------------------------------------------------------------------------------- default values */

GNO_INIT(gno_ros2_options, value.depth = 5; value.domain = -1; value.localhost_only = -1;)
GNO_INIT(gno_ros2_cloud, value.height = 1; value.dense = 1;)
GNO_INIT(gno_ros2_laser, )
GNO_INIT(gno_ros2_imu, value.orientation[3] = 1;)
GNO_INIT(gno_ros2_odometry, value.pose.orientation[3] = 1;)
GNO_INIT(gno_ros2_counts, )

#ifdef __cplusplus
}
#endif

#endif
