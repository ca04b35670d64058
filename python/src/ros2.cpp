// SPDX-License-Identifier: Apache-2.0
// Binds gnosphere/ros2.hpp, as the module gnosphere.ros2.
#include <nanobind/stl/array.h>
#include <nanobind/stl/variant.h>

#include <algorithm>
#include <array>
#include <gnosphere/ros2.hpp>
#include <memory>
#include <string>

#include "arrays.hpp"
#include "field_list.hpp"
#include "rows.hpp"
#include "scan.hpp"

namespace gnosphere::python {

using namespace ros2;

namespace {

using Bytes = nb::ndarray<const uint8_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

void bindQos(nb::module_& m) {
  nb::class_<Qos> qos(m, "Qos", "Quality of service. Messages beyond `depth` replace the oldest ones.");
  nb::enum_<Qos::Reliability>(qos, "Reliability", "Whether messages that were lost are sent again.")
      .value("reliable", Qos::Reliability::reliable)
      .value("best_effort", Qos::Reliability::bestEffort);
  nb::enum_<Qos::Durability>(qos, "Durability", "Whether subscribers that come late get the last messages.")
      .value("volatile_data", Qos::Durability::volatileData)
      .value("transient_local", Qos::Durability::transientLocal, "who subscribes late gets the last messages");
  qos.def(
      "__init__",
      [](Qos* self, const Choice<Qos::Reliability>& reliability, const Choice<Qos::Durability>& durability,
         uint32_t depth) {
        new (self) Qos{chosen(reliability, "Qos: reliability"), chosen(durability, "Qos: durability"), depth};
      },
      "reliability"_a = Qos::Reliability::reliable, "durability"_a = Qos::Durability::volatileData, "depth"_a = 5,
      "reliability, durability: their enumerators, or the names of these.");
  readWriteChoice(qos, "reliability", &Qos::reliability, "Whether messages that were lost are sent again.");
  readWriteChoice(qos, "durability", &Qos::durability, "Whether subscribers that come late get the last messages.");
  qos.def_rw("depth", &Qos::depth, "How many messages are kept.");
}

void bindCloud(nb::module_& m) {
  nb::class_<PointField> field(m, "PointField", "A field of a PointCloud2.");
  nb::enum_<PointField::Type>(field, "Type", "With the numbers that ROS gives them.")
      .value("i8", PointField::Type::i8)
      .value("u8", PointField::Type::u8)
      .value("i16", PointField::Type::i16)
      .value("u16", PointField::Type::u16)
      .value("i32", PointField::Type::i32)
      .value("u32", PointField::Type::u32)
      .value("f32", PointField::Type::f32)
      .value("f64", PointField::Type::f64);
  field
      .def(
          "__init__",
          [](PointField* self, std::string name, uint32_t offset, PointField::Type type, uint32_t count) {
            new (self) PointField{std::move(name), offset, type, count};
          },
          "name"_a, "offset"_a, nb::arg("type").noconvert() = PointField::Type::f32, "count"_a = 1)
      .def_ro("name", &PointField::name, "Such as x.")
      .def_ro("offset", &PointField::offset, "Bytes from the start of the point.")
      .def_ro("type", &PointField::type, "The type of its numbers.")
      .def_ro("count", &PointField::count, "How many numbers it has.");

  nb::class_<PointCloud2> cloud(m, "PointCloud2", "sensor_msgs/PointCloud2.");
  cloud
      .def(
          "__init__",
          [](PointCloud2* self, Bytes data, std::vector<PointField> fields, uint32_t step, uint32_t width,
             uint32_t height, std::string frame, int64_t stamp, bool dense) {
            new (self) PointCloud2{stamp,
                                   std::move(frame),
                                   height,
                                   width,
                                   std::move(fields),
                                   step,
                                   {data.data(), data.data() + data.size()},
                                   dense};
          },
          "data"_a, "fields"_a, "point_step"_a, "width"_a, "height"_a = 1, "frame"_a = "", "stamp"_a = 0,
          "dense"_a = true,
          "`data` is an array of uint8, which is copied. cloud_of_array() makes a message of records.")
      .def_rw("stamp", &PointCloud2::stamp, "Nanoseconds since 1970, or since the start of a simulated clock.")
      .def_rw("frame", &PointCloud2::frame, "The frame of the points.")
      .def_ro("height", &PointCloud2::height, "Rows; 1 for a cloud that is not organised.")
      .def_ro("width", &PointCloud2::width, "Points in a row.")
      .def_ro("point_step", &PointCloud2::pointStep, "Bytes of a point.")
      .def_rw("dense", &PointCloud2::dense, "Whether every point is a number.")
      .def_prop_ro(
          "data",
          [](const PointCloud2& self) {
            return nb::bytes(reinterpret_cast<const char*>(self.data.data()), self.data.size());
          },
          "A copy of height * width points, little-endian.");
  readTuple(cloud, "fields", &PointCloud2::fields, "The fields of a point.");
}

void bindLaserScan(nb::module_& m) {
  nb::class_<LaserScan>(m, "LaserScan", "sensor_msgs/LaserScan.")
      .def(nb::init<>())
      .def_rw("stamp", &LaserScan::stamp, "Of the first ray, nanoseconds.")
      .def_rw("frame", &LaserScan::frame, "The frame of the rays.")
      .def_rw("angle_min", &LaserScan::angleMin, "Radians, counter-clockwise from the x axis.")
      .def_rw("angle_max", &LaserScan::angleMax, "Radians, of the last ray.")
      .def_rw("angle_increment", &LaserScan::angleIncrement, "Radians between rays; negative if they turn clockwise.")
      .def_rw("time_increment", &LaserScan::timeIncrement, "Seconds between rays.")
      .def_rw("scan_time", &LaserScan::scanTime, "Seconds between scans.")
      .def_rw("range_min", &LaserScan::rangeMin, "Metres.")
      .def_rw("range_max", &LaserScan::rangeMax, "Metres.")
      .def_rw("ranges", &LaserScan::ranges,
              "Metres; a list that is assigned whole; inf where nothing is hit, see laser_scan_of().")
      .def_rw("intensities", &LaserScan::intensities, "One per range, or none; a list that is assigned whole.");
}

/// The numbers of a covariance of `side` rows. Throws Error(invalidArgument) that begins with `name`.
template <size_t side>
std::array<double, side * side> covarianceOf(const std::optional<ArrayLike>& given, const std::string& name) {
  std::array<double, side* side> covariance = {};
  if (!given) return covariance;
  nb::object array = arrayOrRefuse(given->object, name, "");
  if (array.attr("shape").equal(nb::make_tuple(side, side))) array = array.attr("reshape")(-1);
  const auto numbers = arrayOf<double>({array}, name);
  if (numbers.rows() != covariance.size())
    refuse(name + " has " + std::to_string(numbers.rows()) + " numbers; it must have " +
           std::to_string(covariance.size()) + ", or the shape (" + std::to_string(side) + ", " + std::to_string(side) +
           ")");
  std::ranges::copy(numbers.values(), covariance.begin());
  return covariance;
}

void bindImu(nb::module_& m) {
  using Covariance = std::optional<ArrayLike>;
  nb::class_<Imu>(m, "Imu",
                  "sensor_msgs/Imu. A covariance has nine numbers, row by row, or the shape (3, 3); zeros, and None, "
                  "mean that it is unknown.")
      .def(
          "__init__",
          [](Imu* self, int64_t stamp, std::string frame, const Quaternion& orientation, const Vec3& angularVelocity,
             const Vec3& linearAcceleration, const Covariance& ofOrientation, const Covariance& ofVelocity,
             const Covariance& ofAcceleration) {
            new (self) Imu{stamp,
                           std::move(frame),
                           orientation,
                           covarianceOf<3>(ofOrientation, "Imu: orientation_covariance"),
                           angularVelocity,
                           covarianceOf<3>(ofVelocity, "Imu: angular_velocity_covariance"),
                           linearAcceleration,
                           covarianceOf<3>(ofAcceleration, "Imu: linear_acceleration_covariance")};
          },
          "stamp"_a, "frame"_a, "orientation"_a = Quaternion(), "angular_velocity"_a = Vec3(),
          "linear_acceleration"_a = Vec3(), "orientation_covariance"_a = nb::none(),
          "angular_velocity_covariance"_a = nb::none(), "linear_acceleration_covariance"_a = nb::none())
      .def_ro("stamp", &Imu::stamp, "Nanoseconds.")
      .def_ro("frame", &Imu::frame, "The frame of the unit.")
      .def_ro("orientation", &Imu::orientation, "Maps the frame of the unit to the world.")
      .def_ro("orientation_covariance", &Imu::orientationCovariance, "rad^2, row by row.")
      .def_ro("angular_velocity", &Imu::angularVelocity, "rad/s about the axes of the unit.")
      .def_ro("angular_velocity_covariance", &Imu::angularVelocityCovariance, "(rad/s)^2, row by row.")
      .def_ro("linear_acceleration", &Imu::linearAcceleration, "m/s^2 along the axes of the unit; upwards 9.8 at rest.")
      .def_ro("linear_acceleration_covariance", &Imu::linearAccelerationCovariance, "(m/s^2)^2, row by row.");
}

void bindOdometry(nb::module_& m) {
  using Covariance = std::optional<ArrayLike>;
  nb::class_<Odometry>(m, "Odometry",
                       "nav_msgs/Odometry. A covariance has 36 numbers, row by row, or the shape (6, 6): x, y, z, and "
                       "about these axes. Zeros, and None, mean that it is unknown.")
      .def(
          "__init__",
          [](Odometry* self, int64_t stamp, std::string frame, std::string childFrame, const Pose& pose,
             const Vec3& linearVelocity, const Vec3& angularVelocity, const Covariance& ofPose,
             const Covariance& ofTwist) {
            new (self) Odometry{stamp,
                                std::move(frame),
                                std::move(childFrame),
                                pose,
                                covarianceOf<6>(ofPose, "Odometry: pose_covariance"),
                                linearVelocity,
                                angularVelocity,
                                covarianceOf<6>(ofTwist, "Odometry: twist_covariance")};
          },
          "stamp"_a, "frame"_a, "child_frame"_a, "pose"_a = Pose(), "linear_velocity"_a = Vec3(),
          "angular_velocity"_a = Vec3(), "pose_covariance"_a = nb::none(), "twist_covariance"_a = nb::none())
      .def_ro("stamp", &Odometry::stamp, "Nanoseconds.")
      .def_ro("frame", &Odometry::frame, "The frame in which the pose is.")
      .def_ro("child_frame", &Odometry::childFrame, "The frame whose pose it is.")
      .def_ro("pose", &Odometry::pose, "Maps the child frame to the frame.")
      .def_ro("pose_covariance", &Odometry::poseCovariance, "m^2 and rad^2, row by row.")
      .def_ro("linear_velocity", &Odometry::linearVelocity, "m/s along the axes of the child frame.")
      .def_ro("angular_velocity", &Odometry::angularVelocity, "rad/s about the axes of the child frame.")
      .def_ro("twist_covariance", &Odometry::twistCovariance, "(m/s)^2 and (rad/s)^2, row by row.");
}

void bindLivoxCustom(nb::module_& m) {
  nb::class_<LivoxPoint>(m, "LivoxPoint", "A point of a LivoxCustom.")
      .def_ro("offset_time", &LivoxPoint::offsetTime, "Nanoseconds after the stamp.")
      .def_ro("x", &LivoxPoint::x, "Metres.")
      .def_ro("y", &LivoxPoint::y, "Metres.")
      .def_ro("z", &LivoxPoint::z, "Metres.")
      .def_ro("reflectivity", &LivoxPoint::reflectivity, "100 for a diffuse white surface.")
      .def_ro("tag", &LivoxPoint::tag, "The number of the return, from 0 on, in bits 4 and 5.")
      .def_ro("line", &LivoxPoint::line, "The channel.");
  nb::class_<LivoxCustom> custom(
      m, "LivoxCustom", "livox_ros_driver2/CustomMsg, whose timebase is the stamp: livox_custom_of() makes it.");
  custom.def_rw("stamp", &LivoxCustom::stamp, "Nanoseconds.")
      .def_rw("frame", &LivoxCustom::frame, "The frame of the points.")
      .def_rw("lidar_id", &LivoxCustom::lidarId, "The number of the sensor.");
  readTuple(custom, "points", &LivoxCustom::points, "The points in the order of their times.");
}

void bindPublisher(nb::module_& m) {
  nb::class_<PublisherCounts>(m, "PublisherCounts", "What has become of the messages of a publisher.")
      .def_ro("published", &PublisherCounts::published, "Messages that were given to publish().")
      .def_ro("sent", &PublisherCounts::sent, "Published messages that went to the network.")
      .def_ro("dropped", &PublisherCounts::dropped,
              "Published messages that newer ones replaced before they were sent, or that the network refused.")
      .def_ro("waiting", &PublisherCounts::waiting, "Published messages that wait to be sent.")
      .def_ro("subscribers", &PublisherCounts::subscribers, "Subscribers at this moment.");
  nb::class_<Publisher>(m, "Publisher",
                        "Publishes the messages of one topic. A thread of its own sends them, so that publish() never "
                        "waits for subscribers or for the network.")
      .def(
          "__init__",
          [](Publisher* self, MessageType type, const std::string& topic, const Qos& qos,
             std::optional<uint32_t> domain, std::optional<bool> localhostOnly) {
            const ReleasedGil released;
            new (self) Publisher(type, topic, {qos, domain, localhostOnly});
          },
          "type"_a.noconvert(), "topic"_a, "qos"_a = Qos(), "domain"_a = nb::none(), "localhost_only"_a = nb::none(),
          "`topic` is a name of ROS, such as \"points\" or \"/front/points\"; the domain is that of ROS_DOMAIN_ID "
          "unless given. Raises Error(device) that says what is missing if GnoSphere was built without Cyclone DDS.")
      .def("publish", &Publisher::publish, "message"_a,
           "Hands over a copy of a message, to be sent. A sequence of StampedTransform is a message of transforms. "
           "Raises Error(invalid_argument) for a message of another type than the topic's, and for one whose sizes "
           "contradict each other.")
      .def(
          "flush",
          [](Publisher& self, double seconds) {
            const ReleasedGil released;
            return self.flush(seconds);
          },
          "seconds"_a, "Waits until all messages have been given to the network. Returns False if that takes longer.")
      .def("counts", &Publisher::counts, "What has become of the messages.");
}

}  // namespace

void bindRos2(nb::module_& parent) {
  nb::module_ m = parent.def_submodule("_ros2", "Publishes messages that nodes of ROS 2 receive, without ROS.");
  nb::enum_<MessageType>(m, "MessageType", "The type of the messages of a topic.")
      .value("point_cloud2", MessageType::pointCloud2)
      .value("laser_scan", MessageType::laserScan)
      .value("transforms", MessageType::transforms)
      .value("clock", MessageType::clock)
      .value("imu", MessageType::imu)
      .value("livox_custom", MessageType::livoxCustom)
      .value("odometry", MessageType::odometry);
  bindQos(m);
  bindCloud(m);
  bindLaserScan(m);
  nb::class_<StampedTransform>(m, "StampedTransform", "The pose of a frame in its parent.")
      .def(
          "__init__",
          [](StampedTransform* self, int64_t stamp, std::string from, std::string child, const Pose& pose) {
            new (self) StampedTransform{stamp, std::move(from), std::move(child), pose};
          },
          "stamp"_a, "parent"_a, "child"_a, "pose"_a = Pose())
      .def_ro("stamp", &StampedTransform::stamp, "Nanoseconds.")
      .def_ro("parent", &StampedTransform::parent, "The frame in which the pose is.")
      .def_ro("child", &StampedTransform::child, "The frame whose pose it is.")
      .def_ro("pose", &StampedTransform::pose, "Maps the child to the parent.");
  nb::class_<Clock>(m, "Clock", "rosgraph_msgs/Clock.")
      .def(
          "__init__", [](Clock* self, int64_t time) { new (self) Clock{time}; }, "time"_a)
      .def_ro("time", &Clock::time, "Nanoseconds.");
  bindImu(m);
  bindOdometry(m);
  bindLivoxCustom(m);
  bindPublisher(m);
  m.def("unavailable", &unavailable, "Why nothing can be published; an empty text if messages can be.");
  m.def(
      "cloud_of",
      [](const SharedScan& scan, const FieldList& list, const std::string& frame, int64_t stamp) {
        const std::shared_ptr<Scan> shared = scan.value;
        const ReleasedGil released;
        return cloudOf(*shared, list.fields, frame, stamp);
      },
      "scan"_a, "fields"_a, "frame"_a, "stamp"_a,
      "The returns of a scan as a cloud with these fields and without gaps; `stamp` is in nanoseconds. Raises "
      "Error(invalid_argument) for a field that the scan does not have.");
  nb::enum_<Driver>(m, "Driver", "Drivers of ROS 2, whose point layouts nodes for localisation and mapping read.")
      .value("velodyne", Driver::velodyne, "velodyne_pointcloud: time in seconds")
      .value("ouster", Driver::ouster, "ouster-ros, \"original\": t in nanoseconds, range in millimetres")
      .value("hesai", Driver::hesai, "HesaiLidar_ROS_2.0: timestamp in seconds since 1970")
      .value("robosense", Driver::robosense, "rslidar_sdk, XYZIRT: as hesai")
      .value("livox", Driver::livox, "livox_ros_driver2, xfer_format 0: timestamp in nanoseconds since 1970")
      .value("autoware", Driver::autoware,
             "PointXYZIRCAEDT of Autoware: time_stamp in nanoseconds, azimuth in the sense in which the head turns");
  m.def(
      "driver_cloud_of",
      [](const SharedScan& scan, const Choice<Driver>& driver, const std::string& frame, int64_t stamp,
         const Effects& effects) {
        const std::shared_ptr<Scan> shared = scan.value;
        const Driver layout = chosen(driver, "driver_cloud_of: driver");
        const Effects copy = effects;
        const ReleasedGil released;
        return driverCloudOf(*shared, layout, frame, stamp, copy);
      },
      "scan"_a, "driver"_a, "frame"_a, "stamp"_a, "effects"_a = Effects(),
      "The returns of a scan as a driver publishes them, in the order of their times, which count from `stamp` (in "
      "nanoseconds). `driver` is an enumerator, or the name of one. `effects` are those of the scan: the scale of its "
      "intensities, and the mode of its returns. Raises Error(invalid_argument) for a scan without the field time, and "
      "for values that the driver's types do "
      "not hold.");
  m.def(
      "livox_custom_of",
      [](const SharedScan& scan, const std::string& frame, int64_t stamp, const Effects& effects) {
        const std::shared_ptr<Scan> shared = scan.value;
        const Effects copy = effects;
        const ReleasedGil released;
        return livoxCustomOf(*shared, frame, stamp, copy);
      },
      "scan"_a, "frame"_a, "stamp"_a, "effects"_a = Effects(),
      "The returns of a scan as Livox's driver publishes them in a message of its own (xfer_format 1), which FAST-LIO "
      "reads; otherwise as driver_cloud_of() with Driver.livox.");
  m.def("has_laser_scan", &hasLaserScan, "sensor"_a, "channel"_a = 0,
        "Whether laser_scan_of() takes this channel of a sensor: a row of a grid, or a row of a list with one pattern "
        "whose beams are evenly spaced in azimuth. Beams straight up or down have no azimuth.");
  m.def(
      "laser_scan_of",
      [](const Sensor& sensor, const SharedScan& scan, const Whole& channel, const std::string& frame, int64_t stamp) {
        const std::shared_ptr<Scan> shared = scan.value;
        const auto row = channel.of<uint32_t>("laser_scan_of: channel");
        const Sensor copy = sensor;
        const ReleasedGil released;
        return laserScanOf(copy, *shared, row, frame, stamp);
      },
      "sensor"_a, "scan"_a, "channel"_a, "frame"_a, "stamp"_a,
      "The first returns of one channel, from the first column to the last; `stamp` is in nanoseconds. A beam without "
      "a return is inf, as REP 117 wants it. A beam that the sensor masks is NaN. With the field cause, -inf is a beam "
      "that a surface nearer than its least range blocks (NearHits.hide), and NaN also one that is dead, whose return "
      "was lost at random, or whose echoes Effects.Returns.mode does not choose. Raises Error(invalid_argument) for a "
      "channel that there is not, for a scan of another sensor, and unless has_laser_scan().");
}

}  // namespace gnosphere::python
