// SPDX-License-Identifier: Apache-2.0
// Beam tables, NumPy arrays and ray matrices as sensor files, with beams computed by hand.
#include <catch2/catch_test_macros.hpp>
#include <catch2/matchers/catch_matchers_floating_point.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <cmath>

#include "gnosphere/sensor.hpp"
#include "sensor/beams.hpp"
#include "sensor/sensor_file_samples.hpp"
#include "sensor/sensor_file_support.hpp"

using namespace gnosphere;
using namespace gnosphere::test;
using Catch::Matchers::ContainsSubstring;
using Catch::Matchers::WithinAbs;

TEST_CASE("beam tables: azimuth and zenith, times of one scan or a count of beams") {
  const SensorFile file = readSensorFile("Time/s,Azimuth/deg,Zenith/deg\n0,10,90\n0.00001,350,60\n\n", "l.csv");
  CHECK(file.family == "beam table");
  REQUIRE(file.sensor.patterns.size() == 1);
  CHECK_THAT(azimuthDeg(file.sensor, 0), WithinAbs(10, 1e-12));
  CHECK_THAT(azimuthDeg(file.sensor, 1), WithinAbs(-10, 1e-12));
  CHECK_THAT(elevationDeg(file.sensor, 1), WithinAbs(30, 1e-12));
  CHECK_THAT(timeOf(file.sensor, 1), WithinAbs(1e-5, 1e-18));

  const Sensor square = readSensorFile("Azimuth/deg,Elevation/deg\n90,0\n180,0\n30,-90\n", "l.csv").sensor;
  CHECK(square.direction(0).x == 0);
  CHECK(square.direction(1).y == 0);
  CHECK(square.direction(2).x == 0);

  const std::string counted = "Time/s,Azimuth/deg,Zenith/deg\n1,0,90\n2,1,90\n3,2,90\n800000,3,90\n5,4,90\n";
  const SensorFile scans = readSensorFile(counted, "l.csv", {.scanRate = 20, .beamsPerScan = 2});
  REQUIRE(scans.sensor.patterns.size() == 2);
  CHECK_THAT(azimuthDeg(scans.sensor, 1, 1), WithinAbs(3, 1e-12));
  CHECK(timeOf(scans.sensor, 1, 1) == 0.025);
  CHECK(lists(scans.ignored, "800000"));
  CHECK(lists(scans.ignored, "the last 1 beams"));
  CHECK_FALSE(lists(scans.assumed, "scans per second"));
  CHECK(lists(readSensorFile(counted, "l.csv", {.beamsPerScan = 2}).assumed, "10 scans per second"));
  CHECK(readSensorFile(counted, "l.csv").sensor.patterns[0].times.empty());

  CHECK_THAT(problemOf("Time/s,Azimuth/deg,Zenith/deg\n0,1\n", "l.csv"), ContainsSubstring("line 2 has 2 cells"));
  CHECK_THAT(problemOf("Time/s,Azimuth/deg,Zenith/deg\n0,0,1,5,90\n", "l.csv"),
             ContainsSubstring("decimals need a point"));
  CHECK(readSensorFile("Time/s,Azimuth/deg,Zenith/deg\n0,1,90,,\n", "l.csv").sensor.beamCount() == 1);
  CHECK_THAT(problemOf("Time/s,Azimuth/deg,Zenith/deg\n0,1,b\n", "l.csv"), ContainsSubstring("Zenith/deg is 'b'"));
  CHECK_THAT(problemOf("Time/s,Azimuth/deg,Zenith/deg\n0,1,200\n", "l.csv"), ContainsSubstring("no angles of a beam"));
  CHECK_THAT(problemOf("Time/s,Azimuth/deg,Zenith/deg\n", "l.csv"), ContainsSubstring("the pattern has no beam"));
  CHECK_THAT(problemOf("Azimuth/deg,Zenith/deg,ring\n0,1,65536\n", "l.csv"), ContainsSubstring("0..65535"));
}

TEST_CASE("beam tables: stated firing times, units, origins, windows and patterns, and columns of other names") {
  const std::string timed = "Time/us,Azimuth/deg,Zenith/deg\n5,10,90\n6,20,80\n7,10,90\n9,20,80\n";
  const SensorFile cut = readSensorFile(timed, "l.csv", {.scanRate = 20, .beamsPerScan = 2});
  REQUIRE(cut.sensor.patterns.size() == 2);
  CHECK_THAT(timeOf(cut.sensor, 0, 0), WithinAbs(0, 1e-15));
  CHECK_THAT(timeOf(cut.sensor, 1, 0), WithinAbs(1e-6, 1e-15));
  CHECK_THAT(timeOf(cut.sensor, 1, 1), WithinAbs(2e-6, 1e-15));
  CHECK(lists(cut.ignored, "the scan rate"));
  CHECK_FALSE(lists(readSensorFile(timed, "l.csv", {.beamsPerScan = 2}).assumed, "scans per second"));

  // Each scan of a long recording has its own start.
  std::string recording = "Time/s,Azimuth/deg,Zenith/deg\n";
  for (int i = 0; i < 40; ++i) recording += std::to_string(0.5 * i) + ",10,90\n";
  const SensorFile scans = readSensorFile(recording, "l.csv", {.beamsPerScan = 4});
  REQUIRE(scans.sensor.patterns.size() == 10);
  CHECK_THAT(timeOf(scans.sensor, 3, 9), WithinAbs(1.5, 1e-12));
  CHECK(lists(readSensorFile(recording, "l.csv").ignored, "which are not those of one scan"));
  const Sensor spread =
      readSensorFile("azimuth,elevation,pattern\n0,0,0\n1,0,0\n0,0,1\n1,0,1\n", "p.csv", {.scanRate = 20}).sensor;
  CHECK_THAT(timeOf(spread, 1, 1), WithinAbs(0.025, 1e-12));
  CHECK(spread.scanPeriod == 0.05);
  // The scan of a head whose sector is less than a turn takes all the time.
  std::string beams = "azimuth,elevation\n";
  for (int i = 0; i < 811; ++i) beams += std::to_string(i / 3.0) + ",0\n";
  const Sensor tim = readSensorFile(beams, "t.csv", {.head = "TiM781"}).sensor;
  CHECK_THAT(timeOf(tim, 810), WithinAbs(810 / 16200.0, 1e-9));
  CHECK(tim.scanPeriod == 1 / 15.0);
  CHECK(readSensorFile(beams, "t.csv", {.head = "TiM781", .scanRate = 5}).sensor.scanPeriod == 0.2);
  CHECK(readSensorFile("Time/s,Azimuth/deg,Zenith/deg\n0,10,90\n0.5,10,90\n", "l.csv", {.head = "TiM781"})
            .sensor.scanPeriod == 0);  // its last beam fires later
  CHECK_THAT(readSensorFile("azimuth,elevation,origin_x_mm,origin_y_mm,origin_z_mm\n0,0,1,2,3\n", "o.csv")
                 .sensor.patterns[0]
                 .origins[0]
                 .y,
             WithinAbs(0.002, 1e-12));
  const Sensor units =
      readSensorFile("time_ns,azimuth,elevation,range_min_cm,range_max_cm\n0,0,0,50,6000\n250,0,0,50,6000\n", "u.csv")
          .sensor;
  CHECK_THAT(timeOf(units, 1), WithinAbs(250e-9, 1e-18));
  CHECK(rangeWindowOf(units, 1).least == 0.5);
  CHECK(rangeWindowOf(units, 1).most == 60);

  const SensorFile file = readSensorFile(
      "index,azimuth_deg,elevation_deg,origin_x,origin_y,origin_z,range_min,range_max,pattern,foo\n"
      "0,10,5,0.1,0.2,0.3,5,60,0,1\n0,20,5,0,0,0,6,70,1,1\n",
      "b.csv");
  REQUIRE(file.sensor.patterns.size() == 2);
  checkOrigin(originOf(file.sensor, 0, 0), {0.1, 0.2, 0.3});
  CHECK_THAT(azimuthDeg(file.sensor, 0, 1), WithinAbs(20, 1e-12));
  CHECK(rangeWindowOf(file.sensor, 0, 0).least == 5);
  CHECK(rangeWindowOf(file.sensor, 0, 1).most == 70);
  CHECK(file.sensor.rangeMax == 70);
  REQUIRE(file.ignored.size() == 2);
  CHECK(file.ignored[0] == "the column 'foo'");
  CHECK(file.ignored[1] == "the index: the beams make one row of a cloud, in which masked beams have no place");
  CHECK(lists(file.assumed, "1 return a beam"));
  CHECK_THAT(problemOf("azimuth,elevation,origin_x\n0,0,0\n", "b.csv"), ContainsSubstring("origin_y and origin_z"));
  CHECK_THAT(problemOf("azimuth,elevation,range_max\n0,0,0\n", "b.csv"), ContainsSubstring("range_min and range_max"));
  CHECK_THAT(problemOf("azimuth,elevation,range_min,range_max\n0,0,60,50\n", "b.csv"),
             ContainsSubstring("range min of beam 0 must be at most its range max, 50, is 60"));
  CHECK_THAT(problemOf("azimuth,elevation,pattern\n0,0,1\n", "b.csv"), ContainsSubstring("directions are empty"));
  CHECK_THAT(problemOf("azimuth,elevation,pattern\n0,0,0\n1,0,0\n", "b.csv", {.beamsPerScan = 1}),
             ContainsSubstring("has a column of patterns, so it cannot be cut into scans of 1 beams"));
  const SensorFile both = readSensorFile("azimuth,zenith,elevation\n0,60,20\n", "b.csv");
  CHECK_THAT(elevationDeg(both.sensor, 0), WithinAbs(30, 1e-12));
  CHECK(lists(both.ignored, "the elevations, because there are zenith angles"));
  for (const double rate : {-1.0, 1e-5, 2e6})
    CHECK_THROWS_WITH(readSensorFile("azimuth,elevation\n0,0\n", "b.csv", {.scanRate = rate}),
                      ContainsSubstring("the scan rate must be 0.0001 to 1,000,000 Hz"));
}

TEST_CASE("beam tables: the index and the ring bring back the organised cloud and its masked beams") {
  const std::string header = "index,ring,azimuth_deg,elevation_deg,time_us,range_min,range_max\n";
  // 3 rows of 4; the first column of the middle row and the last of the lowest rest.
  std::string rows;
  for (const int i : {0, 1, 2, 3, 5, 6, 7, 8, 9, 10})
    rows += std::to_string(i) + "," + std::to_string(i / 4) + "," + std::to_string(10 * (i % 4)) + "," +
            std::to_string(5 - 5 * (i / 4)) + "," + std::to_string(i) + ",1,60\n";
  const SensorFile file = readSensorFile(header + rows, "b.csv");
  const Sensor& sensor = file.sensor;
  CHECK(sensor.width() == 4);
  CHECK(sensor.height() == 3);
  CHECK(sensor.maskedBeams == std::vector<uint32_t>{4, 11});
  CHECK_THAT(azimuthDeg(sensor, 6), WithinAbs(20, 1e-12));
  CHECK_THAT(elevationDeg(sensor, 10), WithinAbs(-5, 1e-12));
  CHECK_THAT(timeOf(sensor, 10), WithinAbs(1e-5, 1e-18));
  CHECK(ringOf(sensor, 8) == 2);
  CHECK(file.ignored.empty());
  CHECK(lists(file.assumed, "1 return a beam"));
  const auto isOneRow = [&](const std::string& text, size_t beams, const SensorFileOptions& options = {}) {
    const SensorFile read = readSensorFile(header + text, "b.csv", options);
    return read.sensor.height() == 1 && read.sensor.beamCount() == beams && read.sensor.maskedBeams.empty() &&
           lists(read.ignored, "the index: the beams make one row");
  };
  CHECK(isOneRow("0,1,0,0,0,1,60\n1,0,1,0,0,1,60\n", 2));                  // rings are no rows
  CHECK(isOneRow("0,0,0,0,0,1,60\n5,1,1,0,0,1,60\n", 2));                  // the width may be 1 to 5
  CHECK(isOneRow("0,0,0,0,0,1,60\n1,1,0,0,0,1,60\n1,1,1,0,0,1,60\n", 3));  // an index twice
  CHECK(isOneRow("1999,0,0,0,0,1,60\n2000,1,1,0,0,1,60\n", 2));            // hardly a beam of the cloud is there
  CHECK(isOneRow(rows, 5, {.beamsPerScan = 5}));
  CHECK_THAT(problemOf(header + "-1,0,0,0,0,1,60\n", "b.csv"), ContainsSubstring("the index -1 is not a whole number"));
}

TEST_CASE("beam tables: a single ring without gaps is an organised cloud of one row") {
  const std::string header = "index,ring,azimuth_deg,elevation_deg\n";
  const SensorFile row = readSensorFile(header + "0,0,10,0\n1,0,11,0\n2,0,12,0\n", "b.csv");
  CHECK(row.ignored.empty());
  CHECK(row.sensor.width() == 3);
  CHECK(row.sensor.height() == 1);
  CHECK(row.sensor.maskedBeams.empty());
  CHECK(readSensorFile(header + "0,0,10,0\n2,0,12,0\n", "b.csv").ignored.size() == 1);
}

TEST_CASE("beam tables: a first column of another name than channel or laser makes no Hesai head") {
  const char* rows = "0,10,5\n1,20,-5\n";
  for (const char* header : {"ring,azimuth_deg,elevation_deg", "channel,azimuth_deg,elevation_deg",
                             "ring,azimuth,elevation", "beam,azimuth,elevation"}) {
    INFO(header);
    const SensorFile file = readSensorFile(std::string(header) + "\n" + rows, "t.csv");
    CHECK(file.family == "beam table");
    REQUIRE(file.sensor.beamCount() == 2);
    CHECK_THAT(azimuthDeg(file.sensor, 1), WithinAbs(20, 1e-12));
    CHECK_THAT(elevationDeg(file.sensor, 1), WithinAbs(-5, 1e-12));
    CHECK(ringOf(file.sensor, 1) == (header[0] == 'r' ? 1 : 0));
  }
  for (const char* header : {"Channel,Elevation,Azimuth", "Laser id,Elevation,Azimuth", "laser,azimuth,elevation"}) {
    INFO(header);
    CHECK(readSensorFile(std::string(header) + "\n1,10,5\n2,20,-5\n", "t.csv").family == "Hesai angle correction");
  }
}

TEST_CASE("NumPy arrays: angles, directions and poses, in either order of bytes and of indices") {
  const std::vector<double> directions = {2, 0, 0, 0, 0, 3};
  for (const char* type : {"<f4", ">f4", "<f8", ">f8"}) {
    const Sensor sensor = readSensorFile(npy(type, false, {2, 3}, directions), "d.npy").sensor;
    CHECK(sensor.direction(0).x == 1);
    CHECK(sensor.direction(1).z == 1);
  }
  const Sensor halves = readSensorFile(npy("<f2", false, {2, 3}, {-1, 0, 0, 0, 0, 1}), "h.npy").sensor;
  CHECK(halves.direction(0).x == -1);
  CHECK(halves.direction(1).z == 1);
  // 1.5, -2 and the smallest half above 0, as NumPy's float16 has them.
  std::string bits = npy("<f2", false, {1, 3}, {0, 0, 0});
  bits.resize(bits.size() - 6);
  const Vec3 d = readSensorFile(bits + std::string("\x00\x3e\x00\xc0\x01\x00", 6), "h.npy").sensor.direction(0);
  CHECK_THAT(d.x, WithinAbs(0.6, 1e-7));
  CHECK_THAT(d.y, WithinAbs(-0.8, 1e-7));
  CHECK_THAT(d.z, WithinAbs(std::ldexp(1, -24) / 2.5, 1e-15));
  for (const char* type : {"<i4", ">i4", "|i1"}) {
    const Vec3 whole = readSensorFile(npy(type, false, {1, 3}, {-3, 0, 4}), "i.npy").sensor.direction(0);
    CHECK(whole.x == -0.6);
    CHECK(whole.z == 0.8);
  }
  const Sensor fortran = readSensorFile(npy("<f8", true, {2, 3}, {2, 0, 0, 0, 0, 3}), "d.npy").sensor;
  CHECK(fortran.direction(1).z == 1);
  CHECK(fortran.direction(0).x == 1);

  const Sensor angles = readSensorFile(npy("<f4", false, {1, 2}, {0.5, -0.25}), "l.npy").sensor;
  CHECK_THAT(azimuthDeg(angles, 0), WithinAbs(0.5 * kDegrees, 1e-12));
  CHECK_THAT(elevationDeg(angles, 0), WithinAbs(-0.25 * kDegrees, 1e-12));

  const std::vector<double> pose = {0, 0, -1, 1, 0, 1, 0, 2, 1, 0, 0, 3};  // z points to -x
  for (const std::vector<uint64_t>& shape : {std::vector<uint64_t>{1, 12}, {1, 3, 4}}) {
    const Sensor sensor = readSensorFile(npy("<f8", false, shape, pose), "p.npy").sensor;
    CHECK(sensor.direction(0).x == -1);
    checkOrigin(sensor.patterns[0].origins[0], {1, 2, 3});
  }
  const std::vector<double> columnwise = {0, 0, 1, 0, 1, 0, -1, 0, 0, 1, 2, 3};
  const Sensor turned =
      readSensorFile(replaced(npy("<f8", false, {1, 3, 4}, columnwise), "False", "True "), "p.npy").sensor;
  CHECK(turned.direction(0).x == -1);
  checkOrigin(turned.patterns[0].origins[0], {1, 2, 3});
  std::vector<double> square = pose;
  square.insert(square.end(), {0, 0, 0, 1});
  CHECK(readSensorFile(npy("<f8", false, {1, 4, 4}, square), "p.npy").sensor.direction(0).x == -1);
  const Sensor image = readSensorFile(npy("<f8", false, {2, 1, 3}, directions), "i.npy").sensor;
  CHECK(image.height() == 2);
  CHECK(image.width() == 1);
}

TEST_CASE("NumPy arrays: mistakes") {
  CHECK_THAT(problemOf(npy("<f8", false, {2, 5}, std::vector<double>(10)), "a.npy"), ContainsSubstring("shape 2 x 5"));
  CHECK_THAT(problemOf(npy("<f8", false, {0, 3}, {}), "a.npy"), ContainsSubstring("no beam"));
  CHECK_THAT(problemOf(npy("<f8", false, {1, 3}, {0, 0, 0}), "a.npy"), ContainsSubstring("beam 0 has no length"));
  CHECK_THAT(problemOf(npy("<f8", false, {1, 3}, {0, NAN, 0}), "a.npy"), ContainsSubstring("is not finite"));
  CHECK_THAT(problemOf(npy("<f8", false, {1, 12}, {0, 0, 1, 0, 0, 0, 0, INFINITY, 0, 0, 1, 0}), "a.npy"),
             ContainsSubstring("the origin of beam 0 is not finite"));
  CHECK_THAT(problemOf(npy("<f8", false, {1, 2}, {0, INFINITY}), "a.npy"), ContainsSubstring("not finite"));
  CHECK_THAT(problemOf(npy("<f8", false, {2, 3}, {1, 0, 0}), "a.npy"), ContainsSubstring("its shape needs 48"));
  CHECK_THAT(problemOf(npy("<c8", false, {1, 3}, {1, 0, 0}), "a.npy"), ContainsSubstring("expected are floats"));
  CHECK_THAT(problemOf("\x93NUMPY\x01", "a.npy"), ContainsSubstring("too short"));
  CHECK_THAT(problemOf("glTF" + std::string(60, '\2'), "a.npy"), ContainsSubstring("as NPY files do"));
  CHECK_THAT(problemOf(npy("<f4", false, {1000, 2}, {0, 0}), "a.npy"),
             ContainsSubstring("has 8 bytes of data, its shape needs more"));
}

TEST_CASE("ray matrices: a ray starts at the translation and points along z") {
  const float pose[12] = {0, 0, 0, 0.5f, 0, 0, 2, 0.25f, 0, 0, 0, -1};
  std::string bytes(reinterpret_cast<const char*>(pose), sizeof(pose));
  const SensorFile file = readSensorFile(bytes, "r.mat3x4f");
  CHECK(file.family == "ray matrices");
  CHECK(file.sensor.direction(0).y == 1);
  checkOrigin(file.sensor.patterns[0].origins[0], {0.5, 0.25, -1});
  CHECK(readSensorFile(bytes, "without ending").family == "ray matrices");
  bytes.pop_back();
  CHECK_THAT(problemOf(bytes, "r.mat3x4f"), ContainsSubstring("has 47 bytes, expected is a multiple of 48"));
  CHECK_THAT(problemOf(std::string(48, '\0'), "r.mat3x4f"), ContainsSubstring("has no length"));
  CHECK_THAT(problemOf("", "r.mat3x4f"), ContainsSubstring("is empty"));
}
