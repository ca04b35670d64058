// SPDX-License-Identifier: Apache-2.0
// Sensor files of other simulators: small ones written here, with beams computed by hand.
#include <catch2/catch_test_macros.hpp>
#include <catch2/matchers/catch_matchers_exception.hpp>
#include <catch2/matchers/catch_matchers_floating_point.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <cmath>
#include <tuple>
#include <utility>

#include "gnosphere/ros2.hpp"
#include "gnosphere/sensor.hpp"
#include "sensor/beams.hpp"
#include "sensor/sensor_file_samples.hpp"
#include "sensor/sensor_file_support.hpp"

using namespace gnosphere;
using namespace gnosphere::test;
using Catch::Matchers::ContainsSubstring;
using Catch::Matchers::WithinAbs;

TEST_CASE("Isaac Sim: a rotary profile is a grid at exact firing times") {
  const SensorFile file = readSensorFile(kIsaacRotary, "i.json");
  CHECK(file.family == "Isaac Sim profile");
  const Sensor& sensor = file.sensor;
  CHECK(sensor.isGrid());
  CHECK(sensor.columns == 333);  // 3333 firings a second, 10 turns
  CHECK_THAT(azimuthDeg(sensor, 0), WithinAbs(6.5, 1e-12));
  CHECK_THAT(azimuthDeg(sensor, 10), WithinAbs(6.5 - 36000.0 / 3333, 1e-12));
  CHECK_THAT(sensor.rotationPeriod, WithinAbs(333.0 / 3333, 1e-15));
  CHECK(sensor.scanPeriod == 0.1);
  CHECK_THAT(timeOf(sensor, 333 + 10), WithinAbs(10.0 / 3333 + 2.665e-6, 1e-15));
  checkOrigin(sensor.channels[1].origin, {0, 0.01, 0.066});
  CHECK(rangeWindowOf(sensor, 0).most == 200);
  CHECK(rangeWindowOf(sensor, 333).least == 2);
  CHECK(rangeWindowOf(sensor, 333).most == 50);
  CHECK(rangeWindowOf(readSensorFile(replaced(kIsaacRotary, "0.5", "0"), "i.json").sensor, 0).least == 0);
  CHECK(sensor.maxReturns == 2);
  CHECK(lists(file.ignored, "wavelengthNm"));
  CHECK(lists(file.ignored, "bank of the emitters"));
  CHECK_FALSE(lists(file.ignored, "comment"));

  const std::string turned = replaced(kIsaacRotary, "\"CW\"", "\"CCW\"");
  CHECK_THAT(azimuthDeg(readSensorFile(turned, "i.json").sensor, 10), WithinAbs(6.5 + 36000.0 / 3333, 1e-12));
}

TEST_CASE("Isaac Sim: a rotary profile whose channels are numbered otherwise than its emitters is a list with rings") {
  const Sensor grid = readSensorFile(kIsaacRotary, "i.json").sensor;
  const auto withChannels = [](const std::string& ids) {
    return readSensorFile(replaced(kIsaacRotary, "\"bank\"", "\"channelId\": " + ids + ", \"bank\""), "i.json").sensor;
  };
  CHECK(withChannels("[0, 1]").isGrid());
  const Sensor list = withChannels("[5, 0]");
  REQUIRE((!list.isGrid() && list.beamCount() == grid.beamCount()));
  CHECK((list.width() == 333 && list.height() == 2));
  CHECK(list.scanPeriod == grid.scanPeriod);
  for (const size_t beam : {0, 10, 332, 333, 500}) {
    INFO(beam);
    CHECK(ringOf(list, beam) == (beam < 333 ? 5 : 0));
    CHECK_THAT(std::remainder(azimuthDeg(list, beam) - azimuthDeg(grid, beam), 360), WithinAbs(0, 1e-9));
    CHECK_THAT(elevationDeg(list, beam), WithinAbs(elevationDeg(grid, beam), 1e-9));
    CHECK_THAT(timeOf(list, beam), WithinAbs(timeOf(grid, beam), 1e-12));
    checkOrigin(originOf(list, beam), originOf(grid, beam));
    CHECK(rangeWindowOf(list, beam).least == rangeWindowOf(grid, beam).least);
    CHECK(rangeWindowOf(list, beam).most == rangeWindowOf(grid, beam).most);
  }
}

TEST_CASE("Isaac Sim: the range of the weakest target is that of one of 10 %, because power falls with its square") {
  const auto reach = [](const std::string& stated) {
    return readSensorFile(replaced(kIsaacRotary, "\"wavelengthNm\"", stated + "\"wavelengthNm\""), "i.json");
  };
  const SensorFile file = reach(R"("minReflectance": 0.1, "minReflectanceRange": 90.0, )");
  CHECK(file.sensor.rangeAt10Percent == 90);
  CHECK_FALSE(lists(file.ignored, "minReflectance"));
  CHECK_FALSE(lists(file.assumed, "10 %"));
  CHECK_THAT(reach(R"("minReflectance": 0.05, "minReflectanceRange": 5, )").sensor.rangeAt10Percent,
             WithinAbs(5 * std::sqrt(2.0), 1e-12));
  const SensorFile half = reach(R"("minReflectance": 0.1, )");
  CHECK(half.sensor.rangeAt10Percent == 0);
  CHECK(lists(half.ignored, "minReflectance"));
  CHECK_THAT(problemOf(replaced(kIsaacRotary, "\"wavelengthNm\"",
                                "\"minReflectance\": 10, \"minReflectanceRange\": 90, \"wavelengthNm\""),
                       "i.json"),
             ContainsSubstring("'minReflectance' is 10, expected is a number from 0 to 1"));
  const SensorFile all = reach(R"("minReflectance": 0.0, "minReflectanceRange": 90, )");
  CHECK(all.sensor.rangeAt10Percent == 0);
  CHECK(lists(all.ignored, "minReflectanceRange"));
}

TEST_CASE("Isaac Sim: emitter states follow each other, in a turn or from scan to scan") {
  std::string text = replaced(kIsaacRotary, "\"emitterStateCount\": 1", "\"emitterStateCount\": 2");
  text =
      replaced(text, "\"emitterStates\": [", R"("emitterStates": [{"azimuthDeg": [1, 2], "elevationDeg": [30, 40]}, )");
  const Sensor turning = readSensorFile(text, "i.json").sensor;
  REQUIRE(turning.patterns.size() == 1);
  CHECK(turning.width() == 333);
  CHECK(turning.scanPeriod == 0.1);
  CHECK_THAT(elevationDeg(turning, 0), WithinAbs(30, 1e-12));
  CHECK_THAT(elevationDeg(turning, 1), WithinAbs(-11.75, 1e-12));
  CHECK_THAT(azimuthDeg(turning, 333 + 2), WithinAbs(2 - 2 * 3600.0 / 3333, 1e-12));
  CHECK(ringOf(turning, 333) == 1);
  const auto window = [&](size_t beam) {
    const RangeWindow found = rangeWindowOf(turning, beam);
    return std::pair(found.least, found.most);
  };
  CHECK(window(0) == std::pair(1.0, 100.0));  // of the whole lidar, as the first state names no ranges
  CHECK(window(1) == std::pair(0.5, 200.0));
  CHECK(window(333 + 1) == std::pair(2.0, 50.0));
  // The second emitter of the second state starts 1 cm to the left of its beam.
  const double azimuth = (-6.5 - 3600.0 / 3333) / kDegrees;
  checkOrigin(originOf(turning, 333 + 1), {-0.01 * std::sin(azimuth), 0.01 * std::cos(azimuth), 0.066});

  const Sensor solid = readSensorFile(replaced(text, "rotary", "solidState"), "i.json").sensor;
  REQUIRE(solid.patterns.size() == 2);
  CHECK_THAT(elevationDeg(solid, 1, 0), WithinAbs(40, 1e-12));
  CHECK_THAT(elevationDeg(solid, 0, 1), WithinAbs(-11.75, 1e-12));
}

TEST_CASE("Isaac Sim: lines of a solid-state lidar are rings, and rows of its cloud if they are equally long") {
  const std::string four = replaced(
      replaced(replaced(kIsaacRotary, "rotary", "solidState"), "\"numberOfEmitters\": 2", "\"numberOfEmitters\": 4"),
      "\"azimuthDeg\": [6.5, -6.5], \"elevationDeg\": [-11.75, 3.5], \"fireTimeNs\": [0, 2665],\n    "
      "\"vertOffsetM\": [0.066, 0.066], \"horOffsetM\": [0, 0.01], \"rangeId\": [0, 1], \"bank\": [1, 0]",
      "\"azimuthDeg\": [1, 2, 3, 4], \"elevationDeg\": [5, 5, 6, 6]");
  const auto lines = [&](const std::string& list) {
    return replaced(four, "\"wavelengthNm\"", "\"numRaysPerLine\": " + list + ", \"wavelengthNm\"");
  };
  const Sensor equal = readSensorFile(lines("[2, 2]"), "i.json").sensor;
  CHECK((equal.width() == 2 && equal.height() == 2));
  CHECK((ringOf(equal, 1) == 0 && ringOf(equal, 2) == 1));
  CHECK_THAT(elevationDeg(equal, 2), WithinAbs(6, 1e-12));
  const Sensor unequal = readSensorFile(lines("[1, 3]"), "i.json").sensor;
  CHECK((unequal.width() == 4 && unequal.height() == 1));
  CHECK((ringOf(unequal, 0) == 0 && ringOf(unequal, 1) == 1 && ringOf(unequal, 3) == 1));
  const Sensor unstated = readSensorFile(four, "i.json").sensor;
  CHECK((unstated.width() == 4 && ringOf(unstated, 3) == 0));
  for (const char* list : {"[2, 1]", "[2, 3]", "[]", "[1e300, 4]"})
    CHECK_THAT(problemOf(lines(list), "i.json"),
               ContainsSubstring("'numRaysPerLine' does not add up to the 4 emitters"));
  for (const auto& [list, shown] : {std::pair{"[-2, 4]", "-2"}, std::pair{"[2.5, 2.5]", "2.5"}})
    CHECK_THAT(problemOf(lines(list), "i.json"),
               ContainsSubstring("'numRaysPerLine' has " + std::string(shown) + ", which is no number of rays"));
}

TEST_CASE("Isaac Sim: mistakes are named with their keys") {
  const auto edited = [](const std::string& from, const std::string& to) {
    return problemOf(replaced(kIsaacRotary, from, to), "i.json");
  };
  CHECK_THAT(edited("[-11.75, 3.5]", "[-11.75]"), ContainsSubstring("'elevationDeg' has 1 entries, 'azimuthDeg' 2"));
  CHECK_THAT(edited("\"numberOfEmitters\": 2", "\"numberOfEmitters\": 3"),
             ContainsSubstring("'numberOfEmitters' is 3"));
  CHECK_THAT(edited("\"numberOfEmitters\": 2", "\"numberOfEmitters\": 2.5"),
             ContainsSubstring("'numberOfEmitters' is 2.5"));
  CHECK_THAT(edited("\"emitterStateCount\": 1", "\"emitterStateCount\": 9"), ContainsSubstring("has 1 entries"));
  CHECK_THAT(edited("\"emitterStateCount\": 1,\n  \"emitterStates\": [",
                    "\"emitterStates\": [{\"azimuthDeg\": [1], \"elevationDeg\": [2]}, "),
             ContainsSubstring("emitterStates[0]: 'azimuthDeg' has 1 entries, 'numberOfEmitters' is 2"));
  CHECK_THAT(edited("\"numberOfEmitters\": 2, \"emitterStateCount\": 1,\n  \"emitterStates\": [",
                    "\"emitterStates\": [{\"azimuthDeg\": [1], \"elevationDeg\": [2]}, "),
             ContainsSubstring("emitterStates[1] has 2 emitters, emitterStates[0] 1"));
  CHECK_THAT(problemOf(R"({"profile": {"scanType": "rotary", "farRangeM": 9, "emitterStates": [7]}})", "i.json"),
             ContainsSubstring("emitterStates[0]: is no object"));
  CHECK_THAT(problemOf(R"({"profile": {"emitterStates": [{"azimuthDeg": [], "elevationDeg": []}]}})", "i.json"),
             ContainsSubstring("emitterStates[0]: there is no emitter"));
  CHECK_THAT(problemOf(R"({"profile": 7})", "i.json"), ContainsSubstring("'profile' is missing, or no object"));
  CHECK_THAT(edited("\"rangeId\": [0, 1]", "\"rangeId\": [0, 2]"), ContainsSubstring("'ranges' has 2 entries"));
  CHECK_THAT(edited("\"bank\"", "\"channelId\": [0, 65536], \"bank\""), ContainsSubstring("no ring from 0 to 65535"));
  for (const char* ranges : {"7", "[7, 8]"})
    CHECK_THAT(edited("[{\"min\": 0.5, \"max\": 200}, {\"min\": 2, \"max\": 50}]", ranges),
               ContainsSubstring("'ranges' is no list of 'min' and 'max'"));
  CHECK_THAT(edited("\"maxReturns\": 2", "\"maxReturns\": 16"),
             ContainsSubstring("'maxReturns' is 16, expected is 1..15"));
  CHECK_THAT(problemOf(R"({"profile": {"scanType": "rotary", "farRangeM": 9, "emitterStates": []}})", "i.json"),
             ContainsSubstring("'emitterStates' has no entry"));
  CHECK_THAT(edited("\"rotary\"", "\"spinning\""), ContainsSubstring("expected is rotary or solidState"));
  CHECK_THAT(edited("3333", "5"), ContainsSubstring("firings and turns per second"));
  CHECK_THAT(edited("-11.75", "-98"), ContainsSubstring("elevation of channel 0"));
  CHECK_THAT(edited("\"profile\"", "\"profil\""), ContainsSubstring("of no known family"));
}

TEST_CASE("SDF: both ends of a range of angles are beams, of a whole turn one of them") {
  const std::string text = R"(<?xml version="1.0"?><sdf version="1.9"><model name="m"><link name="l">
    <sensor name="camera" type="camera"/>
    <sensor name="front" type="gpu_lidar"><update_rate>10</update_rate><lidar><scan>
      <horizontal><samples>5</samples><resolution>1</resolution><min_angle>-0.7853981633974483</min_angle>
        <max_angle>0.7853981633974483</max_angle></horizontal>
      <vertical><samples>3</samples><min_angle>-0.2617993877991494</min_angle><max_angle>0.5235987755982988</max_angle>
      </vertical></scan><range><min>0.08</min><max>10.5</max><resolution>0.01</resolution></range></lidar></sensor>
    <sensor name="round" type="ray"><ray><scan><horizontal><samples>9</samples><min_angle>-3.141592653589793</min_angle>
        <max_angle>3.141592653589793</max_angle></horizontal></scan><range><min>1</min><max> 30 </max></range></ray>
    </sensor></link></model></sdf>)";
  const SensorFile file = readSensorFile(text, "model.sdf");
  CHECK(file.family == "SDF lidar");
  CHECK(file.sensor.name == "front");
  CHECK(file.sensor.columns == 5);
  REQUIRE(file.sensor.channels.size() == 3);
  CHECK_THAT(azimuthDeg(file.sensor, 0), WithinAbs(-45, 1e-9));
  CHECK_THAT(azimuthDeg(file.sensor, 4), WithinAbs(45, 1e-9));
  CHECK_THAT(elevationDeg(file.sensor, 0), WithinAbs(-15, 1e-9));
  CHECK_THAT(elevationDeg(file.sensor, 5), WithinAbs(7.5, 1e-9));
  CHECK(file.sensor.rangeMin == 0.08);
  CHECK(file.sensor.rangeMax == 10.5);
  CHECK(file.sensor.scanPeriod == 0.1);
  CHECK_FALSE(lists(file.ignored, "update_rate"));
  CHECK(readSensorFile(replaced(text, "<update_rate>10", "<update_rate>0"), "model.sdf").sensor.scanPeriod == 0);
  CHECK_THAT(problemOf(replaced(text, "<update_rate>10", "<update_rate>x"), "model.sdf"),
             ContainsSubstring("<update_rate> is 'x'"));
  CHECK(lists(file.assumed, "the first of the lidars front, round"));
  const SensorFile round = readSensorFile(text, "model.sdf", {.mode = "round"});
  CHECK(round.sensor.columns == 8);
  CHECK(round.sensor.channels.size() == 1);
  CHECK_THAT(azimuthDeg(round.sensor, 2), WithinAbs(-90, 1e-9));
  CHECK(round.sensor.rangeMax == 30);
  CHECK(lists(round.ignored, "the last column"));
  CHECK_THAT(problemOf(text, "model.sdf", {.mode = "back"}), ContainsSubstring("no lidar 'back', but front, round"));
  CHECK_THAT(problemOf(replaced(text, "<samples>5", "<samples>x"), "model.sdf"), ContainsSubstring("<samples> is 'x'"));
  CHECK_THAT(problemOf(replaced(text, "<max>10.5</max>", ""), "model.sdf"), ContainsSubstring("<max> of <range>"));
  CHECK_THAT(problemOf("<sdf><sensor name='a' type='camera'/><lidar/></sdf>", "model.sdf"),
             ContainsSubstring("has no <sensor> with <lidar> or <ray>, as SDF has"));
  CHECK_THAT(problemOf("<sdf><sensor name='a'><lidar><scan/></lidar></sensor></sdf>", "model.sdf"),
             ContainsSubstring("<horizontal> of <scan> is missing"));
  CHECK_THAT(problemOf(replaced(text, "<samples>3", "<samples>65536"), "model.sdf"),
             ContainsSubstring("has more than 65535 vertical samples"));
  CHECK_THAT(problemOf(replaced(text, "<resolution>1<", "<resolution>0.1<"), "model.sdf"),
             ContainsSubstring("<samples> times <resolution> is 0, expected is 1 to 1000000"));
  CHECK_THAT(problemOf(replaced(text, "<max_angle>0.78", "<max_angle>-0.79"), "model.sdf"),
             ContainsSubstring("<max_angle> is less than <min_angle>"));
}

namespace {

/// A model of SDF with one lidar that has this content of <horizontal>.
std::string sdfWith(const std::string& horizontal) {
  return "<sdf version='1.9'><model name='m'><link name='l'><sensor name='s' "
         "type='gpu_lidar'><lidar><scan><horizontal>" +
         horizontal + "</horizontal></scan><range><max>10</max></range></lidar></sensor></link></model></sdf>";
}

std::string anglesOf(int samples, double least, double most) {
  return "<samples>" + std::to_string(samples) + "</samples><min_angle>" + std::to_string(least) +
         "</min_angle><max_angle>" + std::to_string(most) + "</max_angle>";
}

}  // namespace

TEST_CASE("SDF: of almost a whole turn every sample is a beam, as in Gazebo") {
  // A scanner that looks back and forth, a coarse one, TurtleBot 3's and an RPLidar's.
  for (const auto& [samples, least, most] :
       {std::tuple{2, -2.0, 2.0}, std::tuple{10, -3.0, 3.0}, std::tuple{71, -3.0979, 3.0979},
        std::tuple{360, 0.0, 6.28}, std::tuple{1450, -3.14, 3.14}}) {
    INFO(samples << " samples");
    const SensorFile file = readSensorFile(sdfWith(anglesOf(samples, least, most)), "model.sdf");
    REQUIRE(file.sensor.beamCount() == static_cast<size_t>(samples));
    CHECK(file.ignored.empty());
    for (int i = 0; i < samples; ++i) {
      const double wanted = least + i * (most - least) / (samples - 1);
      CHECK_THAT(std::remainder(azimuthOf(file.sensor, i) - wanted, 2 * M_PI), WithinAbs(0, 1e-9));
    }
    CHECK(file.sensor.height() == 1);
    CHECK(ros2::hasLaserScan(file.sensor));
  }
  CHECK(readSensorFile(sdfWith(anglesOf(360, -3.1416, 3.1416)), "model.sdf").sensor.columns == 359);
  CHECK_THAT(problemOf(sdfWith(anglesOf(9, -180, 180)), "model.sdf"), ContainsSubstring("in radians"));
  const std::string tall = "<vertical>" + anglesOf(20000, -1, 1) + "</vertical>";
  CHECK_THAT(problemOf(replaced(sdfWith(anglesOf(501, -3.14, 3.14)), "</scan>", tall + "</scan>"), "model.sdf"),
             ContainsSubstring("has more than 10000000 beams that are not evenly spaced"));
}

TEST_CASE("SDF: a missing number of samples is that of SDF, and masks of visibility are told") {
  const SensorFile file = readSensorFile(sdfWith("<min_angle>-1</min_angle><max_angle>1</max_angle>"), "model.sdf");
  CHECK(file.sensor.columns == 640);
  CHECK(lists(file.assumed, "<samples> of 640"));
  // The number of samples is multiplied by the resolution, as SDF's specification has it.
  CHECK(readSensorFile(sdfWith("<resolution>0.5</resolution>" + anglesOf(10, -1, 1)), "model.sdf").sensor.columns == 5);
  CHECK(readSensorFile(sdfWith("<resolution>0.5</resolution>" + anglesOf(11, -1, 1)), "model.sdf").sensor.columns == 5);
  const std::string masked =
      replaced(sdfWith(anglesOf(9, -1, 1)), "<lidar>", "<lidar><visibility_mask>1</visibility_mask>");
  CHECK(lists(readSensorFile(masked, "model.sdf").ignored, "the visibility mask"));
}

TEST_CASE("SDF: what is left out of a lidar is named with the effect that gives it") {
  using Notes = std::vector<std::string>;
  const auto notes = [](const std::string& ofSensor, const std::string& ofLidar) {
    const std::string text = replaced(sdfWith(anglesOf(9, -1, 1)), "<lidar>", ofSensor + "<lidar>" + ofLidar);
    return readSensorFile(text, "model.sdf").ignored;
  };
  for (const char* pose : {"<pose/>", "<pose>0 0 0 0 0 0</pose>", "<pose> 0.0 0 -0  0 0 0\n</pose>",
                           "<pose rotation_format='quat_xyzw'>0 0 0 0 0 0 1</pose>"}) {
    INFO(pose);
    CHECK(notes(pose, "") == Notes{});
  }
  for (const char* pose : {"<pose>0 0 0.1 0 0 0</pose>", "<pose>0 0 0 0 0 1</pose>", "<pose>0 0 0 0 0 x</pose>",
                           "<pose relative_to='mast'>0 0 0 0 0 0</pose>"}) {
    INFO(pose);
    CHECK(notes(pose, "") == Notes{"pose of the sensor"});
  }
  CHECK(notes("", "<noise><type>gaussian</type><mean>0.0</mean><stddev>0.01</stddev></noise>") ==
        Notes{"noise of the lidar, which the effect `range-noise` with sigma 0.01 gives"});
  CHECK(notes("", "<noise type='gaussian'><mean>-0.5</mean><stddev>0.01</stddev></noise>") ==
        Notes{"noise of the lidar, which the effect `range-noise` with sigma 0.01 and bias -0.5 gives"});
  CHECK(notes("", "<noise><type>custom</type></noise>") == Notes{"noise of the lidar"});
  const std::string fine = replaced(sdfWith(anglesOf(9, -1, 1)), "<max>10", "<resolution>0.01</resolution><max>10");
  CHECK(readSensorFile(fine, "model.sdf").ignored ==
        Notes{"resolution of the ranges of the lidar, which the effect `range-noise` with step 0.01 gives"});
  const std::string exact = replaced(sdfWith(anglesOf(9, -1, 1)), "<max>10", "<resolution>0</resolution><max>10");
  CHECK(readSensorFile(exact, "model.sdf").ignored == Notes{});
}

TEST_CASE("SDF: sonars beside a lidar are named as left out") {
  const char* told = "the sonar 'us', whose wide beam would be a list of beams: docs/limits.md";
  for (const char* sonar : {"<sensor name='us' type='sonar'><sonar><min>0.02</min><max>3</max></sonar></sensor>",
                            "<sensor name='us' type='sonar'/>"}) {
    INFO(sonar);
    const std::string text = replaced(sdfWith(anglesOf(9, -1, 1)), "<sensor", std::string(sonar) + "<sensor");
    CHECK(readSensorFile(text, "model.sdf").ignored == std::vector<std::string>{told});
  }
}

TEST_CASE("SDF: lidars of one name are chosen by the names of their models") {
  std::string fleet = "<sdf version='1.9'><world name='w'>";
  for (const char* robot : {"r0", "r1"})
    fleet += std::string("<model name='") + robot + "'><link name='l'><sensor name='lidar' type='gpu_lidar'><lidar>" +
             "<scan><horizontal>" + anglesOf(robot[1] == '0' ? 5 : 7, -1, 1) +
             "</horizontal></scan><range><max>10</max></range></lidar></sensor></link></model>";
  fleet += "</world></sdf>";
  const SensorFile first = readSensorFile(fleet, "world.sdf");
  CHECK(first.sensor.columns == 5);
  CHECK(lists(first.assumed, "the first of the lidars r0::lidar, r1::lidar"));
  CHECK(readSensorFile(fleet, "world.sdf", {.mode = "r1::lidar"}).sensor.columns == 7);
  CHECK_THAT(problemOf(fleet, "world.sdf", {.mode = "lidar"}), ContainsSubstring("but r0::lidar, r1::lidar"));
}

TEST_CASE("HELIOS++: a spinning head of several channels, whose y axis points forward") {
  // From vlp16 of scanners_tls.xml, with an origin and a second turn.
  const std::string text = R"(<?xml version="1.0"?><document>
    <scanner id="als" optics="oscillating" pulseFreqs_Hz="100"/>
    <scanner id="vlp16" optics="rotating" beamDivergence_rad="0.0007" pulseFreqs_Hz="18750,300" rangeMin_m="0.01"
      rangeMax_m="100" maxNOR="2" headRotatePerSecMax_deg="7200" wavelength_nm="903"><channels>
      <channel id="0"><beamOrigin x="0" y="0" z="0"><rot axis="x" angle_deg="-15"/></beamOrigin></channel>
      <channel id="1"><beamOrigin x="0.1" y="0.2" z="0.3"><rot axis="x" angle_deg="1"/><rot axis="z" angle_deg="30"/>
      </beamOrigin></channel></channels></scanner></document>)";
  const SensorFile file = readSensorFile(text, "scanners.xml");
  CHECK(file.family == "HELIOS++ scanner");
  const Sensor& sensor = file.sensor;
  CHECK(sensor.name == "vlp16");
  CHECK(sensor.columns == 937);  // 18750 pulses per second, 20 turns
  CHECK_THAT(sensor.rotationPeriod, WithinAbs(937 / 18750.0, 1e-15));
  CHECK(sensor.scanPeriod == 0.05);
  CHECK_THAT(azimuthDeg(sensor, 1), WithinAbs(7200 / 18750.0, 1e-9));
  CHECK_THAT(elevationDeg(sensor, 0), WithinAbs(-15, 1e-9));
  CHECK_THAT(elevationDeg(sensor, 937), WithinAbs(1, 1e-9));
  CHECK_THAT(azimuthDeg(sensor, 937), WithinAbs(30, 1e-9));
  checkOrigin(originOf(sensor, 937), {0.2, -0.1, 0.3});
  CHECK(sensor.divergenceVertical == 0.0007);
  CHECK(sensor.maxReturns == 2);
  CHECK(lists(file.assumed, "the first of the pulse rates 18750,300"));
  CHECK(file.ignored == std::vector<std::string>{"wavelength_nm"});
  CHECK(readSensorFile(text, "scanners.xml", {.scanRate = 10}).sensor.columns == 1875);
  std::string swept = text;
  swept.replace(text.find("wavelength_nm"), 13, "scanAngleMax_deg");  // of a mirror, which this head does not have
  CHECK(readSensorFile(swept, "scanners.xml").ignored == std::vector<std::string>{"scanAngleMax_deg"});
  std::string fromZero = text;
  fromZero.replace(text.find("<channel id=\"1\""), 15, "<channel id=\"1\" rangeMin_m=\"0\"");
  const Sensor near = readSensorFile(fromZero, "scanners.xml").sensor;
  CHECK(rangeWindowOf(near, 0).least == 0.01);
  CHECK(rangeWindowOf(near, 937).least == 0);
  CHECK((rangeWindowOf(near, 0).most == 100 && rangeWindowOf(near, 937).most == 100));
  const Sensor faster = readSensorFile(text, "scanners.xml", {.mode = "vlp16:300"}).sensor;
  CHECK(faster.columns == 15);
  CHECK_THAT(problemOf(text, "scanners.xml", {.mode = "vlp16:fast"}),
             ContainsSubstring("the pulse rate of --mode vlp16:fast is 'fast', expected is a number"));
  CHECK_THAT(
      problemOf(text, "scanners.xml", {.columns = 9}),
      ContainsSubstring("'vlp16' has as many columns as pulses in a turn; --columns is for those with a mirror"));
  CHECK_THAT(problemOf(text, "scanners.xml", {.mode = "vlp16:0"}),
             ContainsSubstring("the pulse rate of --mode vlp16:0 is not more than 0"));
  CHECK_THAT(problemOf(text, "scanners.xml", {.mode = "vlp16:19"}),
             ContainsSubstring("'pulseFreqs_Hz' gives 0 columns in a turn"));
  CHECK_THAT(problemOf("<document><assets/></document>", "scene.xml"),
             ContainsSubstring("is XML of <document>, not of a lidar"));

  const auto changed = [&](std::string_view from, const std::string& to) {
    std::string other = text;
    return other.replace(other.find(from), from.size(), to);
  };
  // Local turns are about axes that have been turned: z is then that of the tilted beam, so y goes to -x of HELIOS++.
  const Sensor local =
      readSensorFile(changed(R"(z="0.3"><rot axis="x" angle_deg="1"/><rot axis="z" angle_deg="30"/>)",
                             R"(z="0" rotations="local"><rot axis="x" angle_deg="30"/><rot axis="z" angle_deg="90"/>)"),
                     "s.xml")
          .sensor;
  CHECK_THAT(elevationDeg(local, 937), WithinAbs(0, 1e-9));
  CHECK_THAT(azimuthDeg(local, 937), WithinAbs(90, 1e-9));
  // About y, which points forward, the beam that was tilted up turns to the right.
  const Sensor rolled = readSensorFile(changed(R"(z="0.3"><rot axis="x" angle_deg="1"/><rot axis="z" angle_deg="30"/>)",
                                               R"(z="0"><rot axis="x" angle_deg="30"/><rot axis="y" angle_deg="90"/>)"),
                                       "s.xml")
                            .sensor;
  CHECK_THAT(elevationDeg(rolled, 937), WithinAbs(0, 1e-9));
  CHECK_THAT(azimuthDeg(rolled, 937), WithinAbs(-30, 1e-9));
  CHECK_THAT(problemOf(changed(R"(axis="z")", R"(axis="w")"), "s.xml"),
             ContainsSubstring("the axis of <rot> is 'w', expected is x, y or z"));
  const SensorFile own = readSensorFile(
      changed(R"(<channel id="1">)", R"(<channel id="1" rangeMin_m="7" beamDivergence_rad="0.001">)"), "s.xml");
  CHECK(rangeWindowOf(own.sensor, 0).least == 0.01);
  CHECK(rangeWindowOf(own.sensor, 937).least == 7);
  CHECK(rangeWindowOf(own.sensor, 937).most == 100);
  CHECK(lists(own.ignored, "beamDivergence_rad of the channel '1'"));
  // HELIOS++ does not limit the returns of a pulse if the file states no number.
  const SensorFile all = readSensorFile(changed(R"(maxNOR="2")", ""), "s.xml");
  CHECK(all.sensor.maxReturns == 15);
  CHECK(lists(all.assumed, "at most 15 returns a beam, not any number of them"));
  CHECK_THAT(problemOf(changed("<channels>", R"(<headRotateAxis x="0" y="1" z="0"/><channels>)"), "s.xml"),
             ContainsSubstring("does not turn about z"));
}

namespace {

/// A file of HELIOS++ with one scanner.
std::string heliosScanner(const std::string& attributes, const std::string& children = "") {
  return "<document><scanner id='s' pulseFreqs_Hz='1000' rangeMax_m='900' " + attributes + ">" + children +
         "</scanner></document>";
}

}  // namespace

// The formulas are those of HELIOS++'s PolygonMirrorBeamDeflector, OscillatingMirrorBeamDeflector and
// ConicBeamDeflector: the mirror turns the beam about x, after which y points up for positive angles.
TEST_CASE("HELIOS++: a mirror that sweeps lines is a list of its period, or of as many as a scan has") {
  const std::string polygon =
      "optics='rotating' scanAngleMax_deg='45' scanAngleEffectiveMax_deg='30' "
      "scanFreqMin_Hz='10' scanFreqMax_Hz='50' beamDivergence_rad='0.0005'";
  const SensorFile file = readSensorFile(heliosScanner(polygon), "scanners.xml");
  const Sensor& sensor = file.sensor;
  REQUIRE(sensor.patterns.size() == 1);
  // 20 pulses are 4.5 degrees apart, and those from -27 to 27 degrees leave the scanner.
  CHECK((sensor.width() == 13 && sensor.height() == 1));
  for (size_t beam = 0; beam < 13; ++beam) {
    CHECK_THAT(elevationDeg(sensor, beam), WithinAbs(-27 + 4.5 * static_cast<double>(beam), 1e-9));
    CHECK_THAT(azimuthDeg(sensor, beam), WithinAbs(0, 1e-9));
    CHECK_THAT(timeOf(sensor, beam), WithinAbs(0.001 * static_cast<double>(4 + beam), 1e-12));
  }
  CHECK(sensor.divergenceHorizontal == 0.0005);
  CHECK(sensor.maxReturns == 15);
  CHECK(file.ignored.empty());
  CHECK(lists(file.assumed, "the mirror's largest frequency, 50 Hz"));
  CHECK_THAT(sensor.scanPeriod, WithinAbs(0.02, 1e-15));
  CHECK(lists(file.assumed, "scans of 0.02 s, 1 of the mirror's periods; 50 scans a second leave no gap"));

  const Sensor second = readSensorFile(heliosScanner(polygon), "scanners.xml", {.scanRate = 2, .columns = 40}).sensor;
  CHECK((second.width() == 27 && second.height() == 12));  // 25 periods a second, 12 of them in half a second
  CHECK_THAT(timeOf(second, 27), WithinAbs(0.04 + 0.007, 1e-12));
  CHECK_THAT(elevationDeg(second, 27), WithinAbs(-29.25, 1e-9));

  const Sensor there = readSensorFile(heliosScanner("optics='oscillating' scanAngleMax_deg='20' scanFreqMax_Hz='125'"),
                                      "scanners.xml")
                           .sensor;  // 8 pulses there and back
  CHECK(readSensorFile(heliosScanner("optics='oscillating' scanAngleMax_deg='20' scanFreqMax_Hz='125' "
                                     "scanAngleEffectiveMax_deg='5'"),
                       "scanners.xml")
            .ignored == std::vector<std::string>{"scanAngleEffectiveMax_deg"});  // which is for polygons
  const double angles[] = {-20, -10, 0, 10, 20, 10, 0, -10};
  REQUIRE(there.beamCount() == 8);
  for (size_t beam = 0; beam < 8; ++beam) CHECK_THAT(elevationDeg(there, beam), WithinAbs(angles[beam], 1e-9));

  const Sensor cone = readSensorFile(heliosScanner("optics='conic' scanAngleMax_deg='20' scanFreqMax_Hz='250'"),
                                     "scanners.xml")
                          .sensor;  // 4 pulses in a turn about the direction forward
  REQUIRE(cone.beamCount() == 4);
  const double sides[4][2] = {{0, 20}, {-20, 0}, {0, -20}, {20, 0}};  // azimuth, elevation
  for (size_t beam = 0; beam < 4; ++beam) {
    CHECK_THAT(azimuthDeg(cone, beam), WithinAbs(sides[beam][0], 1e-9));
    CHECK_THAT(elevationDeg(cone, beam), WithinAbs(sides[beam][1], 1e-9));
  }

  // The origin of a VUX-1UAV turns the plane of the mirror across the way, and 0 upwards.
  const Sensor across = readSensorFile(heliosScanner("optics='rotating' scanAngleMax_deg='180' scanFreqMax_Hz='250'",
                                                     "<beamOrigin x='0' y='0.085' z='0.06'><rot axis='x' "
                                                     "angle_deg='90'/><rot axis='z' angle_deg='90'/></beamOrigin>"),
                                       "scanners.xml")
                            .sensor;
  REQUIRE(across.beamCount() == 4);  // at -180, -90, 0 and 90 degrees
  CHECK_THAT(elevationDeg(across, 0), WithinAbs(-90, 1e-6));
  CHECK_THAT(azimuthDeg(across, 1), WithinAbs(90, 1e-9));
  CHECK_THAT(elevationDeg(across, 1), WithinAbs(0, 1e-9));
  CHECK_THAT(elevationDeg(across, 2), WithinAbs(90, 1e-6));
  checkOrigin(originOf(across, 2), {0.085, 0, 0.06});

  CHECK_THAT(problemOf(heliosScanner("optics='rotating' headRotatePerSecMax_deg='360'", "<channels/>"), "s.xml"),
             ContainsSubstring("'s' has no <channel>"));
  CHECK_THAT(problemOf(heliosScanner("optics='rotating' scanAngleMax_deg='90' scanFreqMax_Hz='250' "
                                     "scanAngleEffectiveMax_deg='-1'"),
                       "s.xml"),
             ContainsSubstring("no pulse of the scanner 's' is within 'scanAngleEffectiveMax_deg'"));
  CHECK_THAT(problemOf(heliosScanner("optics='risley'"), "s.xml"),
             ContainsSubstring("'s' has risley optics; read are rotating, oscillating and conic ones"));
  CHECK_THAT(problemOf(heliosScanner("optics='conic' scanFreqMax_Hz='250'"), "s.xml"),
             ContainsSubstring("'scanAngleMax_deg' is missing"));
  CHECK_THAT(problemOf(heliosScanner("optics='conic' scanAngleMax_deg='20'"), "s.xml"),
             ContainsSubstring("'scanFreqMax_Hz' is missing"));
  CHECK_THAT(problemOf(heliosScanner(polygon), "s.xml", {.columns = 10}),
             ContainsSubstring("--columns 10 make 100 periods of the mirror in a second; those of the scanner 's' are "
                               "10 to 50"));
  CHECK_THAT(problemOf(heliosScanner(polygon), "s.xml", {.columns = 200}),
             ContainsSubstring("--columns 200 make 5 periods of the mirror in a second"));
  CHECK_THAT(problemOf(heliosScanner(polygon), "s.xml", {.mode = "s:49"}),
             ContainsSubstring("49 pulses a second and 50 periods of the mirror make 0 pulses in a period"));
  CHECK_THAT(problemOf(heliosScanner(polygon), "s.xml", {.scanRate = 60}),
             ContainsSubstring("--rate 60: a scan has at least one period of the mirror, 0.02 s"));
  CHECK_THAT(problemOf(heliosScanner(polygon), "s.xml", {.mode = "s:4e7", .scanRate = 1}),
             ContainsSubstring("beams in a scan; at most 10 million are read"));
}

TEST_CASE("HELIOS++: a head on a tripod turns while its mirror sweeps lines") {
  const std::string text = heliosScanner(
      "optics='rotating' scanAngleMax_deg='120' scanAngleEffectiveMax_deg='50' scanFreqMax_Hz='10' "
      "headRotatePerSecMax_deg='60'",
      "<beamOrigin x='0' y='0' z='0.2'/><headRotateAxis x='0' y='0' z='1'/>");
  const SensorFile file = readSensorFile(text, "scanners.xml");
  const Sensor& sensor = file.sensor;
  CHECK(sensor.columns == 60);            // 10 lines a second, 6 seconds a turn
  REQUIRE(sensor.channels.size() == 41);  // 100 pulses are 2.4 degrees apart, from -48 to 48 degrees
  CHECK_THAT(sensor.rotationPeriod, WithinAbs(6, 1e-12));
  for (const size_t row : {0, 20, 40}) {
    const size_t beam = 60 * row + 2;
    const double time = 0.2 + 0.001 * static_cast<double>(30 + row);
    CHECK_THAT(elevationDeg(sensor, beam), WithinAbs(-48 + 2.4 * static_cast<double>(row), 1e-9));
    CHECK_THAT(timeOf(sensor, beam), WithinAbs(time, 1e-9));
    CHECK_THAT(azimuthDeg(sensor, beam), WithinAbs(60 * time, 1e-9));
  }
  checkOrigin(originOf(sensor, 0), {0, 0, 0.2});
  CHECK(lists(file.assumed, "the head's largest speed"));

  // A turn of 40 s is longer than a sensor's.
  const SensorFile slow = readSensorFile(text, "scanners.xml", {.scanRate = 0.025, .columns = 360});
  CHECK(slow.sensor.columns == 360);
  CHECK(slow.sensor.rotationPeriod == 0);
  CHECK(slow.sensor.scanPeriod == 40);
  CHECK(timeOf(slow.sensor, slow.sensor.beamCount() - 1) == 0);
  CHECK_THAT(azimuthDeg(slow.sensor, 1) - azimuthDeg(slow.sensor, 0), WithinAbs(1, 1e-9));
  CHECK(lists(slow.assumed, "that all beams fire at once: a turn takes 40 s, and that of a sensor at most 10 s"));
  CHECK_THAT(problemOf(text, "scanners.xml", {.columns = 1000}),
             ContainsSubstring("those of the scanner 's' are 0 to 10"));
  CHECK_THAT(problemOf(text, "scanners.xml", {.scanRate = 11}),
             ContainsSubstring("'scanFreqMax_Hz' gives 0 columns in a turn"));
  CHECK_THAT(problemOf(text, "scanners.xml", {.mode = "s:2000000"}),
             ContainsSubstring("pulses in a line, which are channels; at most 65535 are read"));
}

TEST_CASE("CARLA: lasers from the top, clockwise, defaults where an attribute is missing") {
  const SensorFile file = readSensorFile(kCarla, "objects.json");
  CHECK(file.family == "CARLA attributes");
  const Sensor& sensor = file.sensor;
  CHECK(sensor.name == "top");
  CHECK(sensor.columns == 50);
  CHECK(sensor.rotationPeriod == 0.05);
  REQUIRE(sensor.channels.size() == 4);
  CHECK(elevationDeg(sensor, 0) == 2);
  CHECK(elevationDeg(sensor, 150) == -28);
  CHECK_THAT(elevationDeg(sensor, 50), WithinAbs(-8, 1e-12));
  CHECK_THAT(azimuthDeg(sensor, 0), WithinAbs(60, 1e-12));
  CHECK_THAT(azimuthDeg(sensor, 25), WithinAbs(0, 1e-12));
  CHECK_THAT(azimuthDeg(sensor, 49), WithinAbs(60 - 120 * 0.98, 1e-12));
  CHECK(sensor.rangeMax == 50);
  // CARLA rounds the points of a laser in a turn to the nearest whole number: 51.25 and 53.75.
  CHECK(readSensorFile(replaced(kCarla, "4000", "4100"), "objects.json").sensor.columns == 51);
  CHECK(readSensorFile(replaced(kCarla, "4000", "4300"), "objects.json").sensor.columns == 54);
  CHECK(lists(file.ignored, "spawn_point"));
  CHECK(lists(file.ignored, "dropoff_general_rate, which `--effects FILE` reads"));
  CHECK_FALSE(lists(file.ignored, "noise_stddev"));
  CHECK(lists(file.assumed, "top, second"));
  const SensorFile second = readSensorFile(kCarla, "objects.json", {.mode = "second"});
  CHECK(second.sensor.channels.size() == 32);
  CHECK(lists(second.assumed, "'channels' 32, CARLA's default"));
  CHECK_THAT(problemOf(kCarla, "objects.json", {.mode = "third"}), ContainsSubstring("but top, second"));
  CHECK_THAT(problemOf(R"({"type": "sensor.camera.rgb"})", "o.json"), ContainsSubstring("no 'sensor.lidar.ray_cast'"));
  CHECK_THAT(problemOf(R"({"type": "sensor.lidar.ray_cast", "channels": 1.5})", "o.json"),
             ContainsSubstring("'channels' is 1.5"));
  CHECK_THAT(problemOf(R"([{"type": "sensor.lidar.ray_cast", "rotation_frequency": "x"}])", "o.json"),
             ContainsSubstring("'rotation_frequency' is 'x'"));
  for (const auto& [attribute, told] :
       {std::pair(R"("rotation_frequency": 0)", "'rotation_frequency' is 0, expected is above 0"),
        {R"("points_per_second": 100)", "'points_per_second' gives 0 columns in a turn"},
        {R"("horizontal_fov": 361)", "'horizontal_fov' is 361, expected is above 0, up to 360"},
        {R"("horizontal_fov": 0)", "'horizontal_fov' is 0"}})
    CHECK_THAT(problemOf(std::string(R"({"type": "sensor.lidar.ray_cast", )") + attribute + "}", "o.json"),
               ContainsSubstring(told));
}

TEST_CASE("CARLA: what is an effect is told, zeros that are not CARLA's defaults among it") {
  const auto notes = [](const std::string& type, const std::string& attributes) {
    return readSensorFile(
               R"({"type": "sensor.lidar.)" + type + R"(", "points_per_second": 320000, )" + attributes + "}", "o.json")
        .ignored;
  };
  CHECK(notes("ray_cast",
              R"("atmosphere_attenuation_rate": 0, "dropoff_general_rate": 0.0, "dropoff_intensity_limit": 0,
                 "dropoff_zero_intensity": 0, "noise_seed": 0, "noise_stddev": 0, "x": 0, "y": 1)") ==
        std::vector<std::string>{"y",
                                 "atmosphere_attenuation_rate, dropoff_general_rate, dropoff_intensity_limit, "
                                 "dropoff_zero_intensity, which `--effects FILE` reads"});
  CHECK(notes("ray_cast", R"("noise_seed": "3", "noise_stddev": 0.01)") ==
        std::vector<std::string>{"noise_seed, noise_stddev, which `--effects FILE` reads"});
  CHECK(notes("ray_cast_semantic", R"("noise_stddev": 0.01)") == std::vector<std::string>{"noise_stddev"});
  CHECK(notes("ray_cast", R"("x": 0)").empty());
}

TEST_CASE("CARLA: attributes without a type are refused with the type that is missing") {
  for (const char* text : {R"({"channels": "32", "points_per_second": "56000", "rotation_frequency": "10"})",
                           R"({"rotation_frequency": 10, "range": 50})"}) {
    CHECK_THAT(problemOf(text, "c.json"),
               ContainsSubstring("c.json: has attributes of a CARLA lidar, but no \"type\": add \"type\": "
                                 "\"sensor.lidar.ray_cast\""));
    CHECK_THROWS_WITH(sensorFromJson(text, "here"), ContainsSubstring("here: has attributes of a CARLA lidar"));
  }
  CHECK_THROWS_WITH(sensorFromJson(R"({"columns": 4, "elevation_deg": [0], "rotation_frequency": 10})", "here"),
                    ContainsSubstring("unknown key 'rotation_frequency'"));
}
