// SPDX-License-Identifier: Apache-2.0
// Sensor files of Isaac Sim: the rates and sectors of profiles, and OmniLidar prims in USD's text.
#include <catch2/catch_test_macros.hpp>
#include <catch2/matchers/catch_matchers_floating_point.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <cmath>
#include <utility>
#include <vector>

#include "gnosphere/sensor.hpp"
#include "sensor/beams.hpp"
#include "sensor/sensor_file_samples.hpp"
#include "sensor/sensor_file_support.hpp"

using namespace gnosphere;
using namespace gnosphere::test;
using Catch::Matchers::ContainsSubstring;
using Catch::Matchers::WithinAbs;

namespace {

constexpr std::string_view kOmniLidar = R"(#usda 1.0
def OmniLidar "lidar" (
    prepend apiSchemas = ["OmniSensorGenericLidarCoreAPI"]
)
{
    float omni:sensor:tickRate = 10.0
    uint omni:sensor:Core:scanRateBaseHz = 10
    uint omni:sensor:Core:patternFiringRateHz = 3333
    token omni:sensor:Core:scanType = "ROTARY"
    token omni:sensor:Core:rotationDirection = "CW"
    float omni:sensor:Core:nearRangeM = 0.3
    float omni:sensor:Core:farRangeM = 120
    uint omni:sensor:Core:maxReturns = 2
    uint omni:sensor:Core:numberOfEmitters = 2
    float2[] omni:sensor:Core:ranges = [(0, 1)]
    float[] omni:sensor:Core:emitterState:s001:azimuthDeg = [6.5,
        -6.5]
    float[] omni:sensor:Core:emitterState:s001:elevationDeg = [-11.75, 3.5]
    uint[] omni:sensor:Core:emitterState:s001:channelId = [1, 2]
    uint[] omni:sensor:Core:emitterState:s001:fireTimeNs = [0, 2665]
}
)";

/// The file with further lines before that of the least range.
std::string omniLidarWith(const std::string& lines) {
  return replaced(kOmniLidar, "    float omni:sensor:Core:nearRangeM", lines + "    float omni:sensor:Core:nearRangeM");
}

}  // namespace

TEST_CASE("Isaac Sim: scans of a solid-state lidar follow each other at the rate of full firing cycles") {
  const std::string text = replaced(kIsaacRotary, "rotary", "solidState");
  const SensorFile file = readSensorFile(text, "i.json");
  CHECK(file.sensor.scanPeriod == 0.1);
  CHECK_FALSE(lists(file.ignored, "scanRateBaseHz"));
  CHECK(readSensorFile(replaced(text, "\"scanRateBaseHz\": 10.0, ", ""), "i.json").sensor.scanPeriod == 0);
  // The last beam fires after 2.665 us, later than such a rate allows.
  const SensorFile fast = readSensorFile(replaced(text, "10.0", "1e6"), "i.json");
  CHECK_THAT(fast.sensor.scanPeriod, WithinAbs(2.665e-6, 1e-18));
  CHECK(lists(fast.ignored, "scanRateBaseHz 1e+06, because the last beam of a scan fires"));
}

TEST_CASE("Isaac Sim: sectors mask the beams of turning heads, and what they do not do is told") {
  const auto read = [](const std::string& stated, const std::string& scanType = "rotary") {
    const std::string text = replaced(kIsaacRotary, "\"rotary\"", "\"" + scanType + "\"");
    return readSensorFile(replaced(text, "\"wavelengthNm\"", stated + "\"wavelengthNm\""), "i.json");
  };
  for (const std::string prefix : {"s", "validS"}) {
    const std::string key = prefix + "tartAzimuthDeg",
                      endKey = (prefix == "s" ? "e" : "validE") + std::string("ndAzimuthDeg");
    const std::string quarter = "\"" + key + "\": -45, \"" + endKey + "\": 45, ";
    const SensorFile turning = read(quarter);
    CHECK(turning.sensor.maskedBeams.size() == 2 * 249);  // the columns beyond 90 degrees, of two channels
    CHECK_FALSE(lists(turning.ignored, "AzimuthDeg"));
    const std::vector<bool> silent = silentBeams(turning.sensor);
    for (size_t beam = 0; beam < silent.size(); ++beam) {
      const double head = azimuthDeg(turning.sensor, beam) - (beam < 333 ? 6.5 : -6.5);
      if (!silent[beam] && std::abs(std::remainder(head, 360)) > 45 + 1e-9) FAIL(head);
    }
    CHECK_FALSE(lists(read(quarter, "solidState").ignored, "AzimuthDeg"));  // its beams are at 6.5 and -6.5 degrees
    const SensorFile narrow = read("\"" + key + "\": -5, \"" + endKey + "\": 45, ", "solidState");
    CHECK(narrow.sensor.maskedBeams.empty());
    CHECK(lists(narrow.ignored, key + " and " + endKey + ", outside which beams"));
    const SensorFile around = read("\"" + key + "\": 270, \"" + endKey + "\": 90, ");
    CHECK(around.sensor.maskedBeams.empty());
    CHECK(lists(around.ignored, key + " and " + endKey + ", because the end is not beyond the start"));
  }
  const std::string both =
      R"("startAzimuthDeg": 0, "endAzimuthDeg": 360, "validStartAzimuthDeg": 0, "validEndAzimuthDeg": )";
  CHECK_FALSE(lists(read(both + "360, ").ignored, "AzimuthDeg"));
  CHECK(lists(read(both + "270, ").ignored, "validStartAzimuthDeg and validEndAzimuthDeg"));
}

TEST_CASE("Isaac Sim: OmniLidar prims in USD's text are profiles") {
  const std::string text(kOmniLidar);
  const SensorFile file = readSensorFile(text, "lidar.usda");
  CHECK(file.family == "Isaac Sim USD");
  CHECK(file.sensor.isGrid());
  CHECK(file.sensor.columns == 333);
  CHECK_THAT(azimuthDeg(file.sensor, 10), WithinAbs(6.5 - 36000.0 / 3333, 1e-12));
  CHECK_THAT(timeOf(file.sensor, 333 + 10), WithinAbs(10.0 / 3333 + 2.665e-6, 1e-15));
  CHECK(file.sensor.rangeMax == 120);
  CHECK(file.sensor.maxReturns == 2);
  CHECK(lists(file.ignored, "ranges"));
  const std::string fine = replaced(text, "uint omni:sensor:Core:patternFiringRateHz = 3333",
                                    "float omni:sensor:Core:rotPatternFiringResDeg = 0.4");
  CHECK(readSensorFile(fine, "lidar.usda").sensor.columns == 900);
  // The rate of patterns goes before that of older schemas.
  const std::string older = "    uint omni:sensor:Core:reportRateBaseHz = 5000\n";
  CHECK(readSensorFile(omniLidarWith(older), "lidar.usda").sensor.columns == 333);
  const std::string alone = replaced(text, "    uint omni:sensor:Core:patternFiringRateHz = 3333\n", older);
  CHECK(readSensorFile(alone, "lidar.usda").sensor.columns == 500);
  // Channels that are counted from 0 stay; counted from 1 they are the emitters here.
  for (const auto& [ids, ring] : {std::pair("[0, 1]", 0), {"[1, 2]", 0}, {"[1, 0]", 1}, {"[4, 7]", 3}})
    CHECK(ringOf(readSensorFile(replaced(text, "[1, 2]", ids), "lidar.usda").sensor, 0) == static_cast<uint32_t>(ring));
  CHECK_THAT(problemOf(replaced(text, "\"ROTARY\"", "\"SPINNING\""), "lidar.usda"), ContainsSubstring("'SPINNING'"));
  CHECK_THAT(problemOf(replaced(text, "s001:azimuthDeg", "s001:azimuth"), "lidar.usda"),
             ContainsSubstring("is missing"));
  CHECK_THAT(problemOf("#usda 1.0\ndef Xform \"a\" {}\n", "lidar.usda"), ContainsSubstring("without an OmniLidar"));
  CHECK_THAT(problemOf("PXR-USDC" + std::string(80, '\1'), "lidar.usd"), ContainsSubstring("is binary USD"));
}

TEST_CASE("Isaac Sim: lists of ranges go before the nearest and the farthest range of an OmniLidar") {
  const std::string core = "    float[] omni:sensor:Core:",
                    id = "    uint[] omni:sensor:Core:emitterState:s001:rangeId = ";
  const std::string least = core + "rangesMinM = [0.5, 0]\n", most = core + "rangesMaxM = [30, 80]\n";
  const auto read = [](const std::string& lines) { return readSensorFile(omniLidarWith(lines), "lidar.usda"); };
  const auto window = [](const SensorFile& file, size_t channel) {
    const RangeWindow found = rangeWindowOf(file.sensor, channel * file.sensor.columns);
    return std::pair(found.least, found.most);
  };
  const SensorFile two = read(least + most + id + "[1, 0]\n    uint omni:sensor:Core:rangeCount = 2\n");
  CHECK(window(two, 0) == std::pair(0.0, 80.0));
  CHECK(window(two, 1) == std::pair(0.5, 30.0));
  CHECK(two.sensor.rangeMin == 0);
  CHECK(two.sensor.rangeMax == 80);
  CHECK_FALSE(lists(two.ignored, "rangesM"));
  CHECK(window(read(most + id + "[1, 1]\n"), 0) == std::pair(0.3, 80.0));
  CHECK(read(most + id + "[0, 0]\n").sensor.rangeMax == 30);
  const std::string unstated =
      replaced(omniLidarWith(least + id + "[0, 0]\n"), "    float omni:sensor:Core:farRangeM = 120\n", "");
  const SensorFile assumed = readSensorFile(unstated, "lidar.usda");
  CHECK(window(assumed, 1) == std::pair(0.5, 200.0));
  CHECK(lists(assumed.assumed, "a largest range of 200 m"));
  // Emitters of a state without rangeId keep the ranges of the whole lidar, and so does the lidar then.
  std::string state =
      "    float[] omni:sensor:Core:emitterState:s002:azimuthDeg = [1, 2]\n"
      "    float[] omni:sensor:Core:emitterState:s002:elevationDeg = [3, 4]\n";
  const SensorFile mixed = read(least + most + id + "[1, 0]\n" + state);
  REQUIRE(mixed.sensor.patterns.size() == 1);
  const auto mixedWindow = [&](size_t beam) {
    const RangeWindow found = rangeWindowOf(mixed.sensor, beam);
    return std::pair(found.least, found.most);
  };
  CHECK(mixedWindow(0) == std::pair(0.0, 80.0));
  CHECK(mixedWindow(333) == std::pair(0.5, 30.0));
  CHECK((mixedWindow(1).first == 0.3f && mixedWindow(1).second == 120));
  CHECK((mixed.sensor.rangeMin == 0.3 && mixed.sensor.rangeMax == 120));
  // A single range needs no rangeId, and neither do the ranges of the whole lidar.
  const SensorFile one = read(core + "rangesMinM = [2]\n" + core + "rangesMaxM = [40]\n");
  CHECK(window(one, 1) == std::pair(2.0, 40.0));
  CHECK(one.sensor.channels[1].rangeMax == 0);
  const SensorFile loose = read(least + most + id + "[]\n");
  CHECK(window(loose, 1) == std::pair(0.3, 120.0));
  CHECK(lists(loose.ignored, "rangesMinM and rangesMaxM, because no rangeId says"));
  CHECK(lists(read(id + "[0, 1]\n").ignored, "rangeId of the emitters, because their ranges are not stated"));
  CHECK_FALSE(lists(read(id + "[0, 0]\n" + core + "rangesMinM = []\n").ignored, "rangeId"));

  const auto problem = [](const std::string& lines) { return problemOf(omniLidarWith(lines), "lidar.usda"); };
  CHECK_THAT(problem(least + most + id + "[1, 2]\n"),
             ContainsSubstring("'rangeId' is 2, but rangesMinM and rangesMaxM have 2 entries, counted from 0"));
  CHECK_THAT(problem(least + core + "rangesMaxM = [30]\n"),
             ContainsSubstring("'rangesMinM' has 2 entries, 'rangesMaxM' 1"));
  CHECK_THAT(problem(most + "    uint omni:sensor:Core:rangeCount = 3\n"), ContainsSubstring("'rangeCount' is 3, but"));
}

TEST_CASE("Isaac Sim: attributes of USD's schema have names of their own") {
  const std::string reach =
      "    float omni:sensor:Core:minReflectance = 0.1\n    float omni:sensor:Core:minReflectionRangeM = 90\n";
  const SensorFile file = readSensorFile(
      omniLidarWith(
          reach +
          "    float omni:sensor:Core:divergenceHorDeg = 0.1\n    float omni:sensor:Core:minDistBetweenEchosM = 0.4\n"
          "    float omni:sensor:Core:startAzimuthOffsetDeg = 270\n    bool[] omni:sensor:Core:emitterState:s001:roi = "
          "[true, false]\n"
          "    string[] omni:sensor:Core:notes = [\"a, b\", \"c\"]\n"),
      "lidar.usda");
  CHECK(file.sensor.rangeAt10Percent == 90);
  CHECK_FALSE(lists(file.ignored, "minReflect"));
  CHECK(file.sensor.divergenceHorizontal == 0);  // whether the angle is a full or a half one is not documented
  CHECK_THAT(azimuthDeg(file.sensor, 0), WithinAbs(6.5, 1e-12));
  for (const char* name :
       {"divergenceHorDeg", "minDistBetweenEchosM", "startAzimuthOffsetDeg", "roi of the emitters", "notes"})
    CHECK(lists(file.ignored, name));
  const SensorFile both =
      readSensorFile(omniLidarWith(reach + "    float omni:sensor:Core:minReflectanceRange = 50\n"), "lidar.usda");
  CHECK(both.sensor.rangeAt10Percent == 90);
  CHECK(lists(both.ignored, "minReflectanceRange"));
  const std::string solid = replaced(replaced(kOmniLidar, "ROTARY", "SOLID_STATE"),
                                     "    token omni:sensor:Core:rotationDirection = \"CW\"\n", "");
  const SensorFile flash = readSensorFile(solid, "lidar.usda");
  CHECK(flash.sensor.scanPeriod == 0.1);
  CHECK_FALSE(lists(flash.assumed, "turns clockwise"));
}

TEST_CASE("Isaac Sim: comments, strings and metadata of USD state no attributes") {
  const auto read = [](const std::string& text) { return readSensorFile(text, "lidar.usda"); };
  const std::string far = "    float omni:sensor:Core:farRangeM = 120\n";
  const SensorFile silent = read(replaced(kOmniLidar, far, "    # float omni:sensor:Core:farRangeM = 60\n"));
  CHECK(silent.sensor.rangeMax == 200);
  CHECK(lists(silent.assumed, "a largest range of 200 m"));
  const std::string direction = "    token omni:sensor:Core:rotationDirection = \"CW\"\n";
  CHECK(lists(read(replaced(kOmniLidar, direction, "    #" + direction)).assumed, "turns clockwise"));
  CHECK(read(omniLidarWith("    # omni:sensor:Core:emitterState:s002:azimuthDeg = [9, 9]\n")).sensor.isGrid());
  // Comments behind values and between the entries of lists, and apostrophes in them.
  std::string text = replaced(kOmniLidar, "farRangeM = 120", "farRangeM = 120  # the sheet's metres");
  text = replaced(text, "-11.75, 3.5]", "-11.75, # lowest\n 3.5] # ]");
  text = replaced(text, "\"CW\"", "'CCW' # \"CW\"");
  const Sensor sensor = read(text).sensor;
  CHECK(sensor.rangeMax == 120);
  CHECK_THAT(elevationDeg(sensor, 333), WithinAbs(3.5, 1e-12));
  CHECK(sensor.azimuthSpanDeg > 0);
  // Nothing inside strings and asset paths counts, not even a # or the other quotation marks.
  const std::string strings = R"(    string note = "# omni:sensor:Core:farRangeM = 1 \" omni:sensor:Core:farRangeM = 2"
    string more = """ " # ' omni:sensor:Core:farRangeM = 3
        omni:sensor:Core:farRangeM = 4 """
    string last = '''"""#'''
    asset file = @a#b.usda@
    asset other = @@@a@#b'.usda@@@
    token omni:sensor:Core:marketName = "head # 1"
    token omni:sensor:Core:notes = "[("
)";
  const SensorFile quoted = read(omniLidarWith(strings));
  CHECK(quoted.sensor.rangeMax == 120);
  CHECK(lists(quoted.ignored, "marketName"));
  // Metadata of attributes, declarations, connections and values that are blocked.
  const SensorFile described = read(replaced(kOmniLidar, far,
                                             R"(    float omni:sensor:Core:farRangeM = 120 (doc = "a = 3")
    uint omni:sensor:Core:maxSteps (
        doc = "none"
    )
    float omni:sensor:Core:peakPowerW.connect = </Lidar.power>
    float omni:sensor:Core:farRange = None
)"));
  CHECK(described.sensor.rangeMax == 120);
  CHECK(lists(described.ignored, "peakPowerW.connect"));
  CHECK_FALSE(lists(described.ignored, "maxSteps"));
  CHECK_FALSE(lists(described.ignored, "farRange"));
  CHECK_THAT(problemOf("#usda 1.0\n# def OmniLidar \"a\" {}\n", "lidar.usda"),
             ContainsSubstring("without an OmniLidar"));
  CHECK_THAT(problemOf(omniLidarWith(far), "lidar.usda"),
             ContainsSubstring("'farRangeM' is there twice: a file of one OmniLidar is read"));
  CHECK_THAT(problemOf(replaced(kOmniLidar, "farRangeM = 120", "farRangeM.timeSamples = {\n 0: 120\n }"), "lidar.usda"),
             ContainsSubstring("'farRangeM.timeSamples' changes with time"));
}
