// SPDX-License-Identifier: Apache-2.0
// Tests of the traces of ASAM OSI. Traces are read with protozero, by the numbers that the .proto files of OSI 3.7.0
// give the fields.
#include <catch2/matchers/catch_matchers_floating_point.hpp>
#include <cmath>
#include <cstring>
#include <map>
#include <protozero/pbf_reader.hpp>

#include "drive_support.hpp"

using namespace gnosphere;
using namespace gnosphere::test;
using Catch::Matchers::WithinAbs;
using protozero::pbf_reader;

namespace {

/// The only field of this number in a message; fails if there is none.
pbf_reader child(pbf_reader message, uint32_t tag) {
  REQUIRE(message.next(tag));
  return message.get_message();
}
double number(pbf_reader message, uint32_t tag) {
  REQUIRE(message.next(tag));
  return message.get_double();
}
uint64_t whole(pbf_reader message, uint32_t tag) {
  REQUIRE(message.next(tag));
  return message.get_uint64();
}
/// Seconds and nanoseconds of a Timestamp as nanoseconds.
int64_t timeOf(const pbf_reader& timestamp) {
  return static_cast<int64_t>(whole(timestamp, 1) * 1'000'000'000 + whole(timestamp, 2));
}

std::vector<std::string> messagesOf(const std::string& trace) {
  std::vector<std::string> messages;
  for (size_t at = 0; at < trace.size();) {
    uint32_t length = 0;
    REQUIRE(at + sizeof(length) <= trace.size());
    std::memcpy(&length, &trace[at], sizeof(length));
    REQUIRE(at + sizeof(length) + length <= trace.size());
    messages.push_back(trace.substr(at + sizeof(length), length));
    at += sizeof(length) + length;
  }
  return messages;
}

/// The small drive with the formats osi and kitti.
Json osiDrive() {
  Json json = smallDrive();
  json["sensors"][0]["effects"] = "auto";
  json["outputs"] = {{{"format", "osi"}}, {{"format", "kitti"}, {"sensors", {"top"}}}};
  json["epoch"] = 1700000000;
  return json;
}

}  // namespace

TEST_CASE("OSI: SensorData with a lidar's header, mounting and detections, in a trace that is named for it") {
  const DriveFolder folder;
  Json json = osiDrive();
  json["weather"] = Json::array();
  REQUIRE(folder.run(json).finished);
  CHECK_FALSE(fs::exists(folder / "out/osi/parts"));
  const std::vector<std::string> side = messagesOf(folder.get("out/osi/20231114T221320Z_sd_370_300_5_side.osi")),
                                 top = messagesOf(folder.get("out/osi/20231114T221320Z_sd_370_300_10_top.osi"));
  REQUIRE(side.size() == 5);
  REQUIRE(top.size() == 10);

  const pbf_reader data(side[2]);  // at 0.05 s + 2 / 5 Hz
  CHECK((whole(child(data, 1), 1) == 3 && whole(child(data, 1), 2) == 7 && whole(child(data, 1), 3) == 0));
  const pbf_reader lidar = child(child(data, 26), 3), header = child(lidar, 1);
  CHECK(timeOf(child(header, 1)) == 1700000000'450000000);
  CHECK(whole(header, 2) == 2);
  CHECK(whole(header, 5) == 2);  // DATA_QUALIFIER_AVAILABLE
  CHECK(timeOf(child(data, 2)) == timeOf(child(data, 9)));
  CHECK((timeOf(child(data, 2)) > timeOf(child(header, 1)) &&
         timeOf(child(data, 2)) <= timeOf(child(header, 1)) + 100'000'000));
  CHECK(whole(child(data, 5), 1) == 4);  // after the floor, the car and the person, the second sensor
  CHECK(whole(child(header, 7), 1) == 4);
  for (const pbf_reader& mounting : {child(data, 6), child(header, 3)}) {
    const pbf_reader position = child(mounting, 1), orientation = child(mounting, 2);
    CHECK((number(position, 1) == 1 && number(position, 2) == 0.5 && number(position, 3) == 1));
    CHECK_THAT(number(orientation, 1), WithinAbs(0, 1e-12));
    CHECK_THAT(number(orientation, 2), WithinAbs(10 * M_PI / 180, 1e-12));
    CHECK_THAT(number(orientation, 3), WithinAbs(M_PI / 2, 1e-12));
  }

  const std::string points = folder.get("out/kitti/sequences/00/velodyne/000004.bin");
  pbf_reader detections = child(child(pbf_reader(top[4]), 26), 3);
  CHECK(whole(child(detections, 1), 6) == points.size() / 16);
  std::map<uint64_t, int> objects;
  size_t count = 0;
  for (; detections.next(2); ++count) {
    REQUIRE(16 * (count + 1) <= points.size());
    float row[4];
    std::memcpy(row, &points[16 * count], sizeof(row));
    const pbf_reader detection = detections.get_message(), at = child(detection, 3);
    const double distance = number(at, 1), azimuth = number(at, 2), elevation = number(at, 3);
    CHECK_THAT(distance * std::cos(elevation) * std::cos(azimuth), WithinAbs(row[0], 1e-6));
    CHECK_THAT(distance * std::cos(elevation) * std::sin(azimuth), WithinAbs(row[1], 1e-6));
    CHECK_THAT(distance * std::sin(elevation), WithinAbs(row[2], 1e-6));
    CHECK_THAT(number(detection, 7), WithinAbs(100 * row[3], 1e-4));
    ++objects[whole(child(detection, 2), 1)];
    CHECK_FALSE(pbf_reader(detection).next(9));
    CHECK((whole(child(detection, 2), 1) == 0) == (row[2] < -1.79));  // the floor is object 0
  }
  CHECK(count == points.size() / 16);
  CHECK((objects.size() == 3 && objects.contains(1) && objects.contains(2)));
}

TEST_CASE("OSI: drops of rain are clutter that belongs to no object") {
  const DriveFolder folder;
  Json json = osiDrive();
  json["weather"] = {{{"time", 0}, {"rain", 80}}};
  folder.run(json);
  int drops = 0, surfaces = 0;
  for (const std::string& message : messagesOf(folder.get("out/osi/20231114T221320Z_sd_370_300_10_top.osi"))) {
    pbf_reader detections = child(child(pbf_reader(message), 26), 3);
    while (detections.next(2)) {
      const pbf_reader detection = detections.get_message();
      const bool isDrop = whole(child(detection, 2), 1) == UINT64_MAX;
      ++(isDrop ? drops : surfaces);
      pbf_reader classification = detection;
      CHECK(classification.next(9) == isDrop);
      if (isDrop) CHECK(classification.get_enum() == 3);  // DETECTION_CLASSIFICATION_CLUTTER
    }
  }
  CHECK(drops > 0);
  CHECK(surfaces > 3000);
}
