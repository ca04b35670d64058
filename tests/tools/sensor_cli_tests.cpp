// SPDX-License-Identifier: Apache-2.0
// gnosphere sensors, and what commands tell of the sensor that --sensor names.
#include <nlohmann/json.hpp>

#include "tools/cli_support.hpp"

using Catch::Matchers::ContainsSubstring;
using Catch::Matchers::StartsWith;
using namespace gnosphere::test;

TEST_CASE("a scan tells whether its head is an ideal one of the paper or a real one") {
  const Workplace place;
  const auto told = [&](const std::string& sensor) {
    const Result result = place.run("scan floor.obj --effects clean --device reference --sensor " + sensor);
    CHECK(result.status == 0);
    return result.out;
  };
  CHECK_THAT(told("VLP-16"), ContainsSubstring("\nsensor     VLP-16, an ideal head of the paper, at 0, 0, 1.8: "));
  CHECK_THAT(told("Puck"), ContainsSubstring("\nsensor     Puck:10Hz (Velodyne VLP-16) at 0, 0, 1.8: "));
  CHECK_THAT(told("OS1-32:512x10"), ContainsSubstring(" (Ouster OS1, 32 channels) at "));
  // A sensor of a file is not that head, whatever its name.
  nlohmann::json own = place.runJson("sensors VLP-16 --json");
  place.put("own.json", own.dump());
  CHECK_THAT(told("own.json"), ContainsSubstring("\nsensor     VLP-16 at 0, 0, 1.8: "));
  own["columns"] = 900;
  place.put("own.json", own.dump());
  CHECK_THAT(told("own.json"), ContainsSubstring("\nsensor     VLP-16 at 0, 0, 1.8: "));
  own["name"] = "OS1-32:mine";
  place.put("own.json", own.dump());
  CHECK_THAT(told("own.json"), ContainsSubstring("\nsensor     OS1-32:mine at 0, 0, 1.8: "));
}

TEST_CASE("a printed sensor is a valid file for --sensor") {
  const Workplace place;
  const Result printed = place.run("sensors hdl-64e --json");
  REQUIRE(printed.status == 0);
  place.put("s.json", printed.out);
  CHECK(place.run("sensors s.json --json").out == printed.out);
  CHECK(place.run("scan floor.obj --device reference --sensor s.json").status == 0);
  CHECK_THAT(place.run("sensors").out, ContainsSubstring("Hypothetical-350") && ContainsSubstring("6,300,000"));
  CHECK(place.run("scan floor.obj --device reference --sensor TiM781").status == 0);
}

TEST_CASE("every command that takes a sensor file tells what the file leaves open") {
  const Workplace place;
  place.put("at.csv", "Channel,Elevation,Azimuth\n1,14.5,-1.25\n2,-3.5,1.25\n");
  place.put("lasers.yaml",
            "lasers:\n- {laser_id: 0, vert_correction: 0.1, focal_slope: 2}\n- {laser_id: 1, vert_correction: 0}\n");
  for (const char* command : {"scan floor.obj --device reference", "plan floor.obj --device reference",
                              "accuracy floor.obj --device cuda:99"}) {
    INFO(command);
    const Result result = place.run(std::string(command) + " --sensor at.csv");
    CHECK_THAT(result.err,
               ContainsSubstring("gnosphere: warning: at.csv: assumed: 1800 columns in a turn of 360 degrees; "
                                 "`gnosphere sensors --columns` sets another number\n") &&
                   ContainsSubstring("at.csv: assumed: a largest range of 200 m\n"));
  }
  CHECK_THAT(place.run("scan floor.obj --device reference --sensor lasers.yaml").err,
             ContainsSubstring("warning: lasers.yaml: ignored: focal_slope of the lasers\n"));
  place.put("own.json", place.run("sensors VLP-16 --json").out);
  CHECK(place.run("scan floor.obj --device reference --sensor own.json").err.find("assumed") == std::string::npos);
}

TEST_CASE("sensors tells how a file was understood, writes its beams and draws them") {
  const Workplace place;
  place.put("two.csv", "Channel,Elevation,Azimuth\n1,14.5,-1.25\n2,-3.5,1.25\n");
  const Result told = place.run("sensors two.csv --columns 4 --rate 20 --beams b.csv --image p.png");
  REQUIRE(told.status == 0);
  CHECK_THAT(told.out, ContainsSubstring("Hesai angle correction") && ContainsSubstring("8 in a cloud of 4 x 2") &&
                           ContainsSubstring("assumed    a largest range of 200 m"));
  CHECK_THAT(bytesOf(place / "b.csv"),
             StartsWith("index,ring,azimuth_deg,elevation_deg,origin_x,origin_y,origin_z,time_us,range_min,range_max\n"
                        "0,0,1.250000000,14.500000000,0.000000000,0.000000000,0.000000000,0.000000,0,200\n"
                        "1,0,-88.750000000,14.500000000,0.000000000,0.000000000,0.000000000,12500.000000,0,200\n"));
  CHECK(bytesOf(place / "p.png").starts_with("\x89PNG"));
  CHECK_THAT(place.run("sensors two.csv --json").err, ContainsSubstring("assumed: "));
  CHECK(place.run("sensors b.csv --beams again.csv").status == 0);
  CHECK(bytesOf(place / "again.csv") == bytesOf(place / "b.csv"));
  CHECK_THAT(place.run("sensors b.csv").out, ContainsSubstring("8 in a cloud of 4 x 2\n"));
  place.put("twice.json", R"({"name": "a", "columns": 8, "range": {"max": 5}, "elevation_deg": [1],
                             "masked_beams": [3, 3]})");
  CHECK_THAT(place.run("sensors twice.json").out, ContainsSubstring("7 in a cloud of 8 x 1, 1 masked\n"));
  place.put("turns.csv", "azimuth,elevation,pattern\n0,0,0\n1,0,0\n0,1,1\n1,1,1\n");
  CHECK_THAT(place.run("sensors turns.csv").out, ContainsSubstring("2 in a cloud of 2 x 1, 2 patterns in turn\n"));
  place.put("wide.json", R"({"name": "a", "columns": 8, "range": {"max": 5}, "elevation_deg": [1],
                            "divergence_mrad": [3, 1.5]})");
  CHECK_THAT(place.run("sensors wide.json").out, ContainsSubstring("divergence 3 x 1.5 mrad\n"));
  CHECK_THAT(place.run("sensors os1-64:2048x10").out, ContainsSubstring("131,072") && ContainsSubstring("data sheet"));
  CHECK_THAT(place.run("sensors tim781").out, ContainsSubstring("one every 66.6667 ms\n"));
  CHECK_THAT(place.run("sensors vlp-16").out, ContainsSubstring("Table 2 of the GnoSphere360 paper"));
  checkRefused("sensors OS1-64:7", 2, "has no mode '7', but 1024x10, 512x10");
  checkRefused("sensors --beams b.csv", 2, "name a sensor");
  checkRefused("sensors floor.obj", 1, "is of no known family");
  checkRefused("sensors nowhere.json", 2, "there is no file 'nowhere.json'");
  checkRefused("sensors vlp-16 --image p.gif", 2, "p.gif must end in .png");
}
