// SPDX-License-Identifier: Apache-2.0
// A subscriber of its own, with Cyclone DDS and without GnoSphere. The program prints a line
// per message and the last line "end". listener DOMAIN TYPE QOS COUNT SECONDS SLEEP_MS
//   TOPIC... TYPE is cloud, laser, transforms, imu, odometry, livox or clock; QOS reliable, best-effort or
// latched. The program ends after COUNT messages or after so many seconds, and sleeps between
// messages.
#include <dds/dds.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <thread>
#include <tuple>
#include <utility>
#include <vector>

#include "messages.h"

namespace {

using Clock = std::chrono::steady_clock;

void print(const char* topic, const sensor_msgs_msg_dds__PointCloud2_& m) {
  unsigned sum = 0;
  for (uint32_t i = 0; i < m.data._length; ++i) sum = sum * 31 + m.data._buffer[i];
  std::printf("%s %d.%09u %s %ux%u step %u row %u bytes %u sum %u big %d dense %d", topic, m.header.stamp.sec,
              m.header.stamp.nanosec, m.header.frame_id, m.height, m.width, m.point_step, m.row_step, m.data._length,
              sum, m.is_bigendian, m.is_dense);
  for (uint32_t i = 0; i < m.fields._length; ++i) {
    const auto& field = m.fields._buffer[i];
    std::printf(" %s:%u:%u:%u", field.name, field.offset, field.datatype, field.count);
  }
}

void print(const char* topic, const sensor_msgs_msg_dds__LaserScan_& m) {
  std::printf("%s %d.%09u %s %g %g %g %g %g %g %g ranges", topic, m.header.stamp.sec, m.header.stamp.nanosec,
              m.header.frame_id, m.angle_min, m.angle_max, m.angle_increment, m.time_increment, m.scan_time,
              m.range_min, m.range_max);
  for (uint32_t i = 0; i < m.ranges._length; ++i) std::printf(" %g", m.ranges._buffer[i]);
  std::printf(" intensities");
  for (uint32_t i = 0; i < m.intensities._length; ++i) std::printf(" %g", m.intensities._buffer[i]);
}

void print(const char* topic, const tf2_msgs_msg_dds__TFMessage_& m) {
  std::printf("%s", topic);
  for (uint32_t i = 0; i < m.transforms._length; ++i) {
    const auto& t = m.transforms._buffer[i];
    const auto& [p, q] = t.transform;
    std::printf(" %d.%09u %s>%s %g %g %g %g %g %g %g", t.header.stamp.sec, t.header.stamp.nanosec, t.header.frame_id,
                t.child_frame_id, p.x, p.y, p.z, q.x, q.y, q.z, q.w);
  }
}

void print(const char* topic, const rosgraph_msgs_msg_dds__Clock_& m) {
  std::printf("%s %d.%09u", topic, m.clock.sec, m.clock.nanosec);
}

void print(const char* topic, const livox_ros_driver2_msg_dds__CustomMsg_& m) {
  std::printf("%s %d.%09u %s base %llu points %u id %u", topic, m.header.stamp.sec, m.header.stamp.nanosec,
              m.header.frame_id, static_cast<unsigned long long>(m.timebase), m.point_num, m.lidar_id);
  for (uint32_t i = 0; i < m.points._length; ++i) {
    const auto& p = m.points._buffer[i];
    std::printf(" %u:%g,%g,%g:%u:%u:%u", p.offset_time, p.x, p.y, p.z, p.reflectivity, p.tag, p.line);
  }
}

void print(const char* topic, const sensor_msgs_msg_dds__Imu_& m) {
  const auto& [q, w, a] = std::tie(m.orientation, m.angular_velocity, m.linear_acceleration);
  std::printf("%s %d.%09u %s %g %g %g %g", topic, m.header.stamp.sec, m.header.stamp.nanosec, m.header.frame_id, q.x,
              q.y, q.z, q.w);
  std::printf(" turns %g %g %g accelerates %g %g %g covariances", w.x, w.y, w.z, a.x, a.y, a.z);
  for (const auto& of : {m.orientation_covariance, m.angular_velocity_covariance, m.linear_acceleration_covariance})
    std::printf(" %g..%g", of[0], of[8]);
}

void print(const char* topic, const nav_msgs_msg_dds__Odometry_& m) {
  const auto& [p, q] = m.pose.pose;
  const auto& [v, w] = m.twist.twist;
  std::printf("%s %d.%09u %s>%s %g %g %g %g %g %g %g", topic, m.header.stamp.sec, m.header.stamp.nanosec,
              m.header.frame_id, m.child_frame_id, p.x, p.y, p.z, q.x, q.y, q.z, q.w);
  std::printf(" moves %g %g %g turns %g %g %g covariances %g..%g %g..%g", v.x, v.y, v.z, w.x, w.y, w.z,
              m.pose.covariance[0], m.pose.covariance[35], m.twist.covariance[0], m.twist.covariance[35]);
}

dds_entity_t made(dds_entity_t entity) {
  if (entity >= 0) return entity;
  std::printf("error %s\n", dds_strretcode(-entity));
  std::exit(1);
}

template <class Message>
void listen(const dds_topic_descriptor_t& type, char** arguments) {
  const auto domain = static_cast<dds_domainid_t>(std::atoi(arguments[1]));
  const std::string quality = arguments[3];
  const int count = std::atoi(arguments[4]), pause = std::atoi(arguments[6]);
  const auto end = Clock::now() + std::chrono::milliseconds(std::atoi(arguments[5]) * 1000);
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos, quality == "best-effort" ? DDS_RELIABILITY_BEST_EFFORT : DDS_RELIABILITY_RELIABLE, 0);
  dds_qset_durability(qos, quality == "latched" ? DDS_DURABILITY_TRANSIENT_LOCAL : DDS_DURABILITY_VOLATILE);
  dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 100);
  const dds_entity_t participant = made(dds_create_participant(domain, nullptr, nullptr));
  std::vector<std::pair<const char*, dds_entity_t>> readers;
  for (char** topic = arguments + 7; *topic; ++topic) {
    const dds_entity_t of = made(dds_create_topic(participant, &type, *topic, nullptr, nullptr));
    readers.push_back({*topic, made(dds_create_reader(participant, of, qos, nullptr))});
  }
  for (int received = 0; received < count && Clock::now() < end;) {
    bool any = false;
    for (const auto& [topic, reader] : readers) {
      void* sample = nullptr;
      dds_sample_info_t info;
      if (dds_take(reader, &sample, &info, 1, 1) != 1) continue;
      if (info.valid_data) {
        print(topic, *static_cast<const Message*>(sample));
        std::printf("\n");
        std::fflush(stdout);
        ++received;
        any = true;
      }
      dds_return_loan(reader, &sample, 1);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(pause > 0 ? pause : any ? 0 : 2));
  }
  dds_delete_qos(qos);
  dds_delete(participant);
  std::printf("end\n");
}

}  // namespace

int main(int count, char** arguments) {
  if (count < 8) return 2;
  const std::string type = arguments[2];
  if (type == "cloud") listen<sensor_msgs_msg_dds__PointCloud2_>(sensor_msgs_msg_dds__PointCloud2__desc, arguments);
  if (type == "laser") listen<sensor_msgs_msg_dds__LaserScan_>(sensor_msgs_msg_dds__LaserScan__desc, arguments);
  if (type == "transforms") listen<tf2_msgs_msg_dds__TFMessage_>(tf2_msgs_msg_dds__TFMessage__desc, arguments);
  if (type == "livox")
    listen<livox_ros_driver2_msg_dds__CustomMsg_>(livox_ros_driver2_msg_dds__CustomMsg__desc, arguments);
  if (type == "imu") listen<sensor_msgs_msg_dds__Imu_>(sensor_msgs_msg_dds__Imu__desc, arguments);
  if (type == "odometry") listen<nav_msgs_msg_dds__Odometry_>(nav_msgs_msg_dds__Odometry__desc, arguments);
  if (type == "clock") listen<rosgraph_msgs_msg_dds__Clock_>(rosgraph_msgs_msg_dds__Clock__desc, arguments);
}
