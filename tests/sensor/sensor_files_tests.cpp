// SPDX-License-Identifier: Apache-2.0
// The choice of the reader of a sensor file, values that a built-in head adds, and damaged files of every family.
#include <algorithm>
#include <catch2/catch_test_macros.hpp>
#include <catch2/matchers/catch_matchers_floating_point.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <cmath>
#include <random>

#include "base/sha256.hpp"
#include "folder.hpp"
#include "gnosphere/error.hpp"
#include "gnosphere/sensor.hpp"
#include "sensor/beams.hpp"
#include "sensor/sensor_file_samples.hpp"
#include "sensor/sensor_file_support.hpp"

using namespace gnosphere;
using namespace gnosphere::test;
using Catch::Matchers::ContainsSubstring;
using Catch::Matchers::WithinAbs;

TEST_CASE("the content decides the family, and a name that belies it is refused") {
  CHECK(readSensorFile(kOusterFlat, "metadata").family == "Ouster metadata");
  CHECK(readSensorFile(kVelodyneYaml, "cal.txt").family == "Velodyne calibration");
  CHECK_THAT(problemOf(kOusterFlat, "os.yaml"),
             ContainsSubstring("looks like a file of the family 'Ouster metadata'") && ContainsSubstring(".yaml"));
  CHECK_THAT(problemOf(kVelodyneYaml, "cal.json"), ContainsSubstring("'Velodyne calibration'"));
  CHECK_THAT(problemOf(kVeloViewXml, "db.csv"), ContainsSubstring("'VeloView calibration'"));
  CHECK_THAT(problemOf("Channel,Elevation,Azimuth\n1,2,3\n", "a.dat"), ContainsSubstring("'Hesai angle correction'"));
  CHECK_THAT(problemOf(npy("<f8", false, {1, 3}, {1, 0, 0}), "a.mat3x4f"), ContainsSubstring("'NumPy array'"));
  CHECK_THAT(problemOf("{\"a\": 1}", "a.json"), ContainsSubstring("JSON, but of no known family"));
  const std::string nan = "{\"name\": \"x\", \"azimuth\": 1, \"elevation_deg\": [NaN], \"columns\": 8}";
  for (const char* name : {"a.json", "a"}) CHECK_THAT(problemOf(nan, name), ContainsSubstring("is not JSON"));
  CHECK_THAT(problemOf("{lasers: [1]}", "a.yaml"), !ContainsSubstring("JSON"));  // YAML may begin so
  CHECK_THAT(problemOf("{\"a\": 1", "a.json"), ContainsSubstring("is not JSON") && ContainsSubstring("line 1"));
  CHECK_THAT(problemOf("nonsense", "file"), ContainsSubstring("known are GnoSphere sensor, Ouster metadata"));
  CHECK_THAT(problemOf("", "file"), ContainsSubstring("is empty"));
  CHECK_THAT(problemOf(std::string("\xff\xfe"
                                   "C\0h\0",
                                   6),
                       "utf16.csv"),
             ContainsSubstring("is text in UTF-16; save it as UTF-8"));
  const std::string raw = problemOf("Channel,Elevation,Azimuth\n1,\x01\xc3\x28,3\n", "a.csv");
  CHECK(raw.find_first_of("\x01\xc3") == raw.npos);
  CHECK_THAT(raw, ContainsSubstring("expected is a number"));
  CHECK_THAT(problemOf(kVelodyneYaml, "cal.yaml", {.columns = 5000000}), ContainsSubstring("more than a million"));
  std::string many = "Channel,Elevation,Azimuth\n";
  for (int row = 1; row <= 128; ++row) many += std::to_string(row) + ",1,1\n";
  CHECK_THAT(problemOf(many, "many.csv", {.columns = 1000000}),
             ContainsSubstring("makes 128000000 beams, of 1000000 columns"));
  CHECK_THAT(problemOf(kIsaacRotary, "i.json", {.mode = "1"}), ContainsSubstring("--mode does not apply"));
}

TEST_CASE("a built-in head states what a calibration leaves open") {
  std::string yaml = "lasers:\n";
  for (int id = 0; id < 16; ++id)
    yaml += "- {laser_id: " + std::to_string(id) + ", vert_correction: " + std::to_string(0.035 * (15 - id) - 0.26) +
            ", rot_correction: 0}\n";
  const SensorFile file = readSensorFile(yaml, "puck.yaml", {.head = "Puck"});
  const Sensor head = builtinSensor("Puck");
  CHECK(file.sensor.columns == head.columns);
  CHECK(file.sensor.rotationPeriod == head.rotationPeriod);
  CHECK(file.sensor.channels[3].timeOffset == head.channels[3].timeOffset);
  CHECK(file.sensor.channels[3].azimuthOffsetDeg == head.channels[3].azimuthOffsetDeg);
  CHECK(file.sensor.maxReturns == 2);
  REQUIRE(file.assumed.size() == 1);
  CHECK_THAT(file.assumed[0], ContainsSubstring("a target of 10 % is seen up to the largest range"));
  std::vector<double> angles(2 * 20000);
  const Sensor livox = readSensorFile(npy("<f4", false, {20000, 2}, angles), "mid40.npy", {.head = "Mid-40"}).sensor;
  CHECK(livox.patterns.size() == 2);
  CHECK(livox.rangeMax == 260);
  // The head states how long a scan takes, also for a table of one scan.
  angles.resize(2 * 10000);
  const SensorFile single = readSensorFile(npy("<f4", false, {10000, 2}, angles), "mid40.npy", {.head = "Mid-40"});
  CHECK(timeOf(single.sensor, 5000) == 0.05);
  CHECK_FALSE(lists(single.assumed, "scans per second"));
  CHECK_THAT(problemOf(yaml, "puck.yaml", {.head = "HDL-32E"}), ContainsSubstring("has 16 channels"));
  CHECK_THROWS_WITH(readSensorFile(yaml, "puck.yaml", {.head = "Pucks"}), ContainsSubstring("no built-in sensor"));
  // The same number of columns in the same time turns by 360 degrees in a little more.
  const Sensor whole = readSensorFile(yaml, "puck.yaml", {.head = "Puck", .columns = head.columns}).sensor;
  CHECK_THAT(whole.rotationPeriod, WithinAbs(0.1, 1e-12));

  std::string angleTable = "Channel,Elevation,Azimuth\n", times = "Channel,fire time(us)\n";
  for (int id = 1; id <= 128; ++id) {
    angleTable += std::to_string(id) + "," + std::to_string(id - 64) + ",0\n";
    times += std::to_string(id) + "," + std::to_string(id - 1) + "\n";
  }
  const Sensor resting = readSensorFile(angleTable, "qt.csv", {.head = "QT128"}).sensor;
  CHECK(resting.maskedBeams == builtinSensor("QT128").maskedBeams);
  const Sensor fewer = readSensorFile(angleTable, "qt.csv", {.head = "QT128", .columns = 10}).sensor;
  CHECK(fewer.maskedBeams.size() * 4 == fewer.beamCount());
  // A firing time of 0 is stated as well.
  const Folder folder;
  put(folder / "times.csv", times);
  const Sensor timed = readSensorFile(angleTable, "p.csv", {.head = "OT128", .fireTimes = folder / "times.csv"}).sensor;
  CHECK(timed.channels[0].timeOffset == 0);
  CHECK_THAT(timed.channels[5].timeOffset, WithinAbs(5e-6, 1e-18));
  CHECK_THROWS_WITH(readSensorFile(angleTable, "p.csv", {.mode = "2"}), ContainsSubstring("--fire-times"));
}

TEST_CASE("a head states its range at 10 % and its divergence for files of every family that do not") {
  const Sensor head = builtinSensor("OS1-128");
  for (const Sample& sample : samples()) {
    INFO(sample.name);
    const SensorFile plain = readSensorFile(sample.bytes, sample.name);
    const bool assumed = lists(plain.assumed, "a target of 10 % is seen up to the largest range");
    CHECK(assumed == (plain.sensor.rangeAt10Percent == 0 && plain.family != "GnoSphere sensor"));
    if (plain.family == "Velodyne calibration" || plain.family == "VeloView calibration" ||
        plain.family == "Hesai angle correction" || plain.family == "RoboSense angles")
      continue;  // of two channels, which are not those of the head
    const SensorFile file = readSensorFile(sample.bytes, sample.name, {.head = "OS1-128"});
    CHECK(file.sensor.rangeAt10Percent == 90);
    CHECK(file.sensor.divergenceVertical > 0);
    CHECK_FALSE(lists(file.assumed, "a target of 10 %"));
    CHECK_FALSE(lists(file.assumed, "a largest range"));
    if (lists(plain.assumed, "a largest range")) CHECK(file.sensor.rangeMax == head.rangeMax);
    CHECK(file.sensor.beamCount() == plain.sensor.beamCount());
  }
  // A figure of the file counts more than that of the head.
  const std::string dark = replaced(kIsaacRotary, "\"wavelengthNm\"",
                                    "\"minReflectance\": 0.4, \"minReflectanceRange\": 120, \"wavelengthNm\"");
  CHECK(readSensorFile(dark, "i.json", {.head = "OS1-128"}).sensor.rangeAt10Percent == 60);
}

TEST_CASE("a head starts the beams of a calibration that states no origins, and its lens turns with no correction") {
  const Sensor head = builtinSensor("RS-Helios-1615");
  std::string angles;
  for (int i = 0; i < 32; ++i) angles += std::to_string(15 - i) + "," + (i == 31 ? "30" : "0") + "\n";
  const Sensor sensor = readSensorFile(angles, "rs.csv", {.head = "RS-Helios-1615"}).sensor;
  for (size_t row = 1; row < 32; ++row) checkOrigin(sensor.channels[row].origin, head.channels[row].origin);
  CHECK(std::abs(sensor.channels[31].origin.x - 0.03498) < 1e-12);
  // The lowest laser points 30 degrees to the right of where the lens is.
  for (const size_t column : {0, 450}) checkOrigin(originOf(sensor, column), originOf(head, column));
  CHECK_THAT(azimuthDeg(sensor, 0) - azimuthDeg(head, 0), WithinAbs(-30, 1e-9));

  std::string yaml = "lasers:\n";
  for (int id = 0; id < 16; ++id)
    yaml += "- {laser_id: " + std::to_string(id) + ", vert_correction: " + std::to_string(0.035 * id - 0.26) +
            ", vert_offset_correction: 0.5}\n";
  CHECK(readSensorFile(yaml, "puck.yaml", {.head = "Puck"}).sensor.channels[7].origin.z > 0.4);
}

TEST_CASE("the built-in HDL-64E-S2 starts its beams where the calibration that it comes from starts them") {
  // A vertical offset is at right angles to the beam, as the reader of calibrations has it.
  for (const Channel& channel : builtinSensor("HDL-64E-S2").channels) {
    const double e = channel.elevationDeg / kDegrees;
    CHECK_THAT(channel.origin.x * std::cos(e) + channel.origin.z * std::sin(e), WithinAbs(0, 1e-15));
    CHECK_THAT(std::abs(channel.origin.y), WithinAbs(0.026, 1e-15));
    CHECK(std::hypot(channel.origin.x, channel.origin.z) > 0.1);
  }
}

TEST_CASE("SHA-256 of texts that Python's hashlib has hashed") {
  CHECK(sha256("") == bytesOfHex("e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855"));
  CHECK(sha256Text("abc") == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  CHECK(sha256("abc") == bytesOfHex("ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"));
  CHECK(sha256(std::string(119, 'a')) ==
        bytesOfHex("31eba51c313a5c08226adf18d4a359cfdfd8d2e816b13f4af952f7ea6584dcfb"));
}

TEST_CASE("no change of a byte or two makes a reader crash or return what is not valid") {
  std::mt19937 random(18);
  for (const Sample& sample : samples()) {
    INFO(sample.name);
    CHECK_NOTHROW(readSensorFile(sample.bytes, sample.name));
    for (int round = 0; round < 1000; ++round) {
      std::string bytes = sample.bytes.substr(0, 60000);
      const auto place = [&] { return random() % std::max<size_t>(bytes.size(), 1); };
      for (size_t edits = 1 + random() % 3; edits > 0 && !bytes.empty(); --edits) switch (random() % 5) {
          case 0: bytes[place()] = static_cast<char>(random()); break;
          case 1: bytes.resize(place()); break;
          case 2: bytes.erase(place(), 1 + random() % 8); break;
          case 3: bytes.insert(place(), bytes.substr(place(), 1 + random() % 8)); break;
          default: bytes[place()] = "0123456789-eE.,[]{}\""[random() % 20]; break;
        }
      // A damaged file with a good checksum gets further.
      if (sample.name.ends_with(".dat") && round % 3 > 0 && bytes.size() > 32)
        bytes = bytes.substr(0, bytes.size() - 32) + sha256(std::string_view(bytes).substr(0, bytes.size() - 32));
      try {
        validate(readSensorFile(bytes, round % 2 ? sample.name : "file").sensor);
      } catch (const Error& error) {
        CHECK(error.code() == ErrorCode::format);
      }
    }
  }
}
