// SPDX-License-Identifier: Apache-2.0
// The command line as people and scripts see it: exit status, one-line errors, no incomplete files.
#include <algorithm>
#include <catch2/generators/catch_generators.hpp>
#include <cstring>
#include <nlohmann/json.hpp>
#include <numeric>

#include "gnosphere/output.hpp"
#include "gnosphere/sensor.hpp"
#include "tools/cli_support.hpp"

using Catch::Matchers::ContainsSubstring;
using Catch::Matchers::EndsWith;
using Catch::Matchers::StartsWith;
using namespace gnosphere::test;

namespace {

size_t longestLine(const std::string& text) {
  size_t longest = 0;
  for (size_t begin = 0; begin < text.size(); begin = text.find('\n', begin) + 1)
    longest = std::max(longest, text.find('\n', begin) - begin);
  return longest;
}

/// 1234 -> 1,234
std::string grouped(size_t number) {
  std::string text = std::to_string(number);
  if (text.size() > 3) text.insert(text.size() - 3, ",");
  return text;
}

}  // namespace

TEST_CASE("a wrong call ends with status 2 and lists the choices") {
  checkRefused("", 2, "scan, plan, accuracy, compare, devices, sensors, effects, options, info, town, drive or view");
  checkRefused("look", 2, "there is no command 'look'; the nearest are ");
  checkRefused("scna floor.obj", 2, "there is no command 'scna'; the nearest are scan, ");
  checkRefused("scan", 2, "SCENE");
  checkRefused("scan floor.obj --frob", 2, "there is no option '--frob'; the nearest are ");
  checkRefused("scan floor.obj --outptu a.pcd", 2, "there is no option '--outptu'; the nearest are --output, ");
  checkRefused("scan floor.obj roof.obj", 2, "there is no place for 'roof.obj'");
  checkRefused("scan floor.obj --pose 0 -1 1.8", 2,
               "there is no place for '-1'; commas join the values of one option, as 1,2,3");
  checkRefused("scan floor.obj -o a.csv --fields x y z", 2, "there is no place for 'y'; commas join the values");
  checkRefused("scan floor.obj --scale cm", 2,
               "gnosphere: --scale must be a number, is 'cm' (see gnosphere scan --help)");
  checkRefused(
      "scan floor.obj --sensor VLP-17", 2,
      "no built-in sensor is called 'VLP-17'; the nearest are VLP-16, VLP-32, VLP-32C; gnosphere sensors lists all; "
      "or give a file");
  checkRefused("scan floor.obj --sensor hdl64e:10Hz", 2,
               "no built-in sensor is called 'hdl64e:10Hz'; the nearest are HDL-64E");
  checkRefused("scan floor.obj -o a.las", 2, ".pcd, .ply, .bin (KITTI), .npy and .csv");
  checkRefused("scan floor.obj -o a.pcd -o a.las", 2, "a.las");
  checkRefused("scan floor.obj -o a.npy --ascii", 2, "--ascii changes .pcd and .ply files");
  checkRefused("scan floor.obj --frame world", 2, "there is no --output");
  checkRefused("scan floor.obj --frame lidar -o a.pcd", 2, "sensor,world");
  checkRefused(
      "scan floor.obj -o a.csv --fields x,y,rnge", 2,
      "no field is called 'rnge'; the nearest are range, ring, tie; docs/api.md and gnosphere scan --help list all");
  checkRefused("scan floor.obj -o a.csv --fields x,Doppler_velocity", 2,
               "no field is called 'doppler_velocity'; the speed along the beam is radial_speed; docs/api.md");
  checkRefused("scan floor.obj -o a.csv --fields x,normal_x", 2,
               "'normal_x' is a column of the field normal; ask for normal");
  checkRefused("scan floor.obj -o a.csv --fields u", 2, "'u' is a column of the field barycentrics");
  checkRefused("scan floor.obj --fields x,tie", 2, "--device reference");
  checkRefused("scan floor.obj --fields '' -o a.npy", 2, "''");
  checkRefused("scan floor.obj --fields x,y", 2, "--fields changes cloud files, and there is no --output");
  checkRefused("scan floor.obj --compact", 2, "--compact changes cloud files, and there is no --output");
  checkRefused("scan floor.obj --no-compact", 2, "--no-compact changes cloud files, and there is no --output");
  checkRefused("scan floor.obj --fields range -o k.bin", 2, "--fields: files of KITTI (.bin) always have x, y, z");
  checkRefused("scan floor.obj --sensor VLP-16:10Hz", 2,
               "the sensor VLP-16 is an ideal head of the paper and has no modes");
  checkRefused("scan floor.obj --image a.jpg", 2, ".png");
  checkRefused("scan floor.obj --pose 1,2", 2, "X,Y,Z");
  checkRefused("scan floor.obj --pose 1,2,nan", 2, "finite");
  checkRefused("scan floor.obj --pose 1,2,3,0,0,0,0", 2, "has a quaternion whose length is 0 and not 1");
  checkRefused("scan floor.obj --pose 1,2,3,0,0,40,9", 2, "has a quaternion whose length is 41 and not 1");
  checkRefused("scan floor.obj --pose 1,2,3,0,0,0.7,0.7", 2, "has a quaternion whose length is 0.99 and not 1; ");
  checkRefused("scan floor.obj --pose 1,2,3,jaw=9", 2, "'jaw=9' is no angle; there are yaw, roll, pitch, in degrees");
  checkRefused("scan floor.obj --pose 1,2,3,yaw=north", 2, "'yaw=north' is no finite number of degrees, as yaw=90 is");
  checkRefused("scan floor.obj --pose 1,2,3,yaw=1,yaw=2", 2, "yaw is given twice; keep one");
  checkRefused("scan floor.obj --pose 1,2,3,0,0,0,1,yaw=2", 2, "has a quaternion and angles; keep one of them");
  checkRefused("scan floor.obj --pose yaw=2", 2, "'yaw=2' is not X,Y,Z, then nothing or ");
  checkRefused("scan floor.obj --pose 1,2,3,", 2, "X,Y,Z");
  checkRefused("scan floor.obj --accuracy rough", 2, "paper");
  checkRefused("scan floor.obj --scale 0", 2, "--scale");
  checkRefused("scan floor.obj --repeat 0", 2, "--repeat");
  checkRefused("scan floor.obj -o a.pcd -o a.pcd", 2, "twice");
  checkRefused("scan floor.obj --stats floor.obj", 2, "is read, too");
  checkRefused("scan robot.urdf", 2, "robot.urdf': the Python package reads such files: python -m gnosphere.robotics");
  checkRefused("sensors VLP-17", 2, "the nearest are VLP-16");
  checkRefused("sensors Puck --rate 20", 2, "--fire-times complete a sensor file, and 'Puck' is built in");
  checkRefused("town -o town.glb --triangles -5", 2, "--triangles");
  checkRefused("town -o town.glb --triangles 1e9", 2,
               "'1e9' is not a whole number up to 2147483647, written in digits alone");
  checkRefused("compare a.pcd", 2, "B");
  checkRefused("compare a.las b.las", 2, "a.las");
  checkRefused("town -o town.obj", 2, ".glb");
  checkRefused("town", 2, "--output");
}

TEST_CASE("scan, plan and accuracy take every option by --set; drives name the place for it") {
  checkRefused("scan floor.obj --set binning=lists", 2,
               "--set: no option is called 'binning'; there is tuning.binning");
  checkRefused("plan floor.obj --set accuracy=rough", 2, "--set: accuracy must be paper, ");
  checkRefused("accuracy floor.obj --set accuracy=exact", 2, "measures every accuracy");
  checkRefused("drive a.json --set faces=both", 2, "belongs into");
  const Workplace place;
  const std::string scan = "scan floor.obj --stats -" + kQuick;
  REQUIRE(place.run(scan + "--accuracy exact --faces both -o a.npy").status == 0);
  const Result set = place.run(scan + "--set accuracy=exact --set faces=both --set tuning.culling.rows=false -o b.npy");
  CHECK(set.err ==
        "gnosphere: warning: --device reference ignores accuracy, tuning.culling.rows; another --device heeds them\n");
  CHECK(place.run("plan floor.obj --device reference --set accuracy_parts.cull=nearest_point").err ==
        "gnosphere: warning: --device reference ignores accuracy_parts.cull; another --device heeds them\n");
  CHECK_THAT(set.out, ContainsSubstring("\"accuracy\": \"exact\""));
  CHECK(gnosphere::compare(gnosphere::readCloud(place / "a.npy"), gnosphere::readCloud(place / "b.npy")).same());
  // --set wins over the options that set the same, wherever it is.
  for (const char* both : {"--accuracy exact --faces both --set accuracy=draft --set faces=front",
                           "--set accuracy=draft --set faces=front --accuracy exact --faces both"}) {
    INFO(both);
    CHECK(nlohmann::json::parse(place.run(scan + both).out)["plan"]["accuracy"] == "draft");
  }
  const Result none = place.run("scan floor.obj --stats -" + kQuick + "--set ignored_instances=[0]");
  CHECK(nlohmann::json::parse(none.out)["counters"]["hits"] == 0);
  const Result list = place.run("options");
  CHECK(list.status == 0);
  CHECK_THAT(list.out, ContainsSubstring("tuning.binning, default auto") && ContainsSubstring("ignored_instances"));
}

TEST_CASE("work that fails ends with status 1 and leaves no incomplete file") {
  checkRefused("scan none.glb -o a.pcd --image a.png --stats a.json", 1, "none.glb");
  checkRefused("scan floor.obj -o no/such/folder/a.pcd", 1,
               "No such file or directory; there is no folder 'no/such/folder', so make it first");
  checkRefused("scan none.glb -o no/a.pcd", 1, "no/a.pcd");  // fails before the scene is loaded
  checkRefused("scan floor.obj -o /a.pcd/a.pcd", 1, "/a.pcd/a.pcd");
  checkRefused("scan floor.obj --sensor floor.obj -o a.pcd", 1, "floor.obj: is of no known family");
  checkRefused("compare a.pcd b.pcd", 2, "a.pcd: cannot be read: No such file or directory");
  checkRefused("town -o no/town.glb", 1,
               "no/town.glb: cannot be written: No such file or directory; there is no folder 'no', so make it first");
}

TEST_CASE("a scan writes the requested files and lists them") {
  const Workplace place;
  const Result result = place.run("scan -o a.pcd -o b.npy floor.obj --image a.png --stats a.json" + kQuick);
  CHECK(result.err == "");
  REQUIRE(result.status == 0);
  CHECK_THAT(result.out, ContainsSubstring("2 triangles") && ContainsSubstring("of 28,800 beams") &&
                             ContainsSubstring("at 0, 0, 1.8"));
  CHECK(place.files() == std::vector<std::string>{"a.json", "a.pcd", "a.png", "b.npy", "floor.obj"});
  const gnosphere::Scan scan = gnosphere::readCloud(place / "a.pcd");
  CHECK(scan.columns == 1800);
  CHECK(scan.channels == 16);
  CHECK(scan.sensor == "VLP-16");
}

TEST_CASE("a scan tells whether its head is an ideal one of the paper or a real one") {
  const Workplace place;
  const auto told = [&](const std::string& sensor) {
    const Result result = place.run("scan floor.obj --effects clean --sensor " + sensor);
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

TEST_CASE("a pose may begin with a minus, and its quaternion have few digits") {
  const auto pose = Workplace().runJson("scan floor.obj --pose -1,2.5,3e0,0,0,1.001,0 --stats -" + kQuick).at("pose");
  CHECK(pose.at("position") == nlohmann::json({-1.0, 2.5, 3.0}));
  CHECK(pose.at("orientation_xyzw") == nlohmann::json({0.0, 0.0, 1.0, 0.0}));
}

TEST_CASE("the orientation of a pose may be angles, and a scan tells those of a head that does not stand upright") {
  const Workplace place;
  const auto told = [&](const std::string& pose) {
    const Result result = place.run("scan floor.obj --pose " + pose + kQuick);
    CHECK(result.status == 0);
    return result.out;
  };
  CHECK_THAT(told("0,0,1.8,0,0,0,-1"), ContainsSubstring(" at 0, 0, 1.8: 16 channels"));
  // A quaternion whose w is first stands on its head.
  CHECK_THAT(told("0,0,1.8,1,0,0,0"),
             ContainsSubstring(" at 0, 0, 1.8, turned by roll 180, pitch 0, yaw 0 degrees: 16"));
  CHECK_THAT(told("0,0,1.8,pitch=-10,yaw=90"), ContainsSubstring(", turned by roll 0, pitch -10, yaw 90 degrees: 16"));
}

TEST_CASE("with --frame world clouds of all poses lie on the scene's surfaces") {
  const Workplace place;
  place.put("wall.obj", "v 10 -50 -50\nv 10 50 -50\nv 10 50 50\nv 10 -50 50\nf 1 2 3\nf 1 3 4\n");
  place.put("poses.tum", "0 1 2 3 0 0 0 1\n1 4 -5 6 0 0.6 0 0.8\n2 20 0 0 0 0 1 0\n");
  // On this trajectory a Puck moves and turns during each scan; a VLP-16 fires all beams at once.
  for (const char* sensor : {"VLP-16", "Puck"})
    for (const char* frame : {"world", "sensor"}) {
      INFO(sensor << ", " << frame);
      const std::string command =
          "scan wall.obj --up z --faces both --trajectory poses.tum -o a.npy --effects clean "
          "--effect sensor-motion=auto --sensor ";
      REQUIRE(place.run(command + sensor + " --frame " + frame).status == 0);
      float low = 1e9f, high = -1e9f;
      for (const char* file : {"a-000000.npy", "a-000001.npy", "a-000002.npy"}) {
        const gnosphere::Scan scan = gnosphere::readCloud(place / file);
        size_t hits = 0;
        for (size_t i = 0; i < scan.ranges.size(); ++i) {
          if (!scan.hit(i)) continue;
          ++hits;
          low = std::min(low, scan.points[3 * i]);
          high = std::max(high, scan.points[3 * i]);
        }
        CHECK(hits > 1000);
      }
      CHECK((low > 9.999f && high < 10.001f) == (frame == std::string("world")));
    }
}

TEST_CASE("a scene away from the origin is scanned from its middle by default") {
  const Workplace place;
  place.put("far.obj", "v 100 200 50\nv 140 200 50\nv 100 260 50\nf 1 2 3\n");
  const Result result = place.run("scan far.obj" + kQuick);
  REQUIRE(result.status == 0);
  CHECK_THAT(result.out, ContainsSubstring("at 120, 230, 51.8"));
  place.put("points.ply",
            "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
            "property float z\nend_header\n1 2 3\n");
  CHECK_THAT(place.run("scan points.ply" + kQuick).err, ContainsSubstring("warning: points.ply has no triangle"));
  place.put("hill.obj",  // 5 m high in the middle, with a roof above
            "v 100 200 0\nv 140 200 0\nv 140 260 10\nv 100 260 10\nf 1 2 3\nf 1 3 4\n"
            "v 100 200 40\nv 140 200 40\nv 140 260 40\nf 5 6 7\n");
  CHECK_THAT(place.run("scan hill.obj" + kQuick).out, ContainsSubstring("at 120, 230, 6.8"));
  place.put("high.obj", "v -10 -10 1700000\nv 30 -10 1700000\nv -10 30 1700000\nf 1 2 3\n");
  CHECK_THAT(place.run("scan high.obj" + kQuick).out, ContainsSubstring("at 10, 10, 1700001.8"));
  place.put("low.obj", "v -10 -10 -1.7\nv 30 -10 -1.7\nv -10 30 -1.7\nf 1 2 3\n");  // below a car's sensor
  CHECK_THAT(place.run("scan low.obj" + kQuick).out, ContainsSubstring("at 0, 0, 1.8"));
}

TEST_CASE("the extent of a scene far from the origin has centimetres") {
  const Workplace place;
  place.put("far.obj", "v 691000.126 5324000.5 0.0125\nv 691010.1 5324000 -0.5\nv 691000 5344000 30.25\nf 1 2 3\n");
  const Result result = place.run("scan far.obj --pose 691000,5324000.25,5000" + kQuick);
  const std::string extent = "x 691000..691010.1, y 5324000..5344000, z -0.5..30.25 m";
  CHECK_THAT(result.out, ContainsSubstring(extent));
  CHECK_THAT(result.err, ContainsSubstring(extent) && ContainsSubstring("at 691000, 5324000.25, 5000 sees"));
}

TEST_CASE("a file whose positions have steps of single precision is warned of") {
  const Workplace place;
  const auto ply = [&](const std::string& name, const char* type, const std::string& corners) {
    std::string text = "ply\nformat ascii 1.0\nelement vertex 4\n";
    for (const char axis : {'x', 'y', 'z'}) text += std::string("property ") + type + " " + axis + "\n";
    place.put(name,
              text + "element face 1\nproperty list uchar int vertex_indices\nend_header\n" + corners + "3 0 1 2\n");
  };
  const std::string far = "5300000.5 0 0\n5300020 0 0\n5300000 20.5 0\n";
  const std::string warning =
      "gnosphere: warning: float.ply: its positions are in single precision, which has steps of 0.5 m at 5300020 m; "
      "give them in an OBJ file, in a PLY file of doubles, or in glTF near the origin of a node whose translation "
      "places them\n";
  ply("float.ply", "float", far + "0 0 0\n");
  CHECK(place.run("info float.ply").err == warning);
  CHECK(place.run("info float.ply --json").err == warning);
  CHECK(place.run("scan float.ply" + kQuick).err == warning);
  CHECK_THAT(place.run("info float.ply --scale 0.01").err, ContainsSubstring("0.005 m at 53000 m;"));
  CHECK(place.run("info float.ply --scale 0.001").err == "");
  for (const char* type : {"double", "float64"}) {
    ply("double.ply", type, far + "0 0 0\n");
    CHECK(place.run("info double.ply").err == "");
  }
  place.put("far.obj", "v 5300000.5 0 0\nv 5300020 0 0\nv 5300000 20.5 0\nf 1 2 3\n");
  CHECK(place.run("info far.obj").err == "");
  place.put("decimal.obj", "v 5300000.1 0 0\nv 5300020 0 0\nv 5300000 20.5 0\nf 1 2 3\n");
  CHECK(place.run("info decimal.obj").err == "");
  ply("stray.ply", "float", "0 0 0\n20 0 0\n0 20 0\n5300000.5 0 0\n");  // no triangle uses the last vertex
  CHECK(place.run("info stray.ply").err == "");
  // An origin of its own would not help this large terrain.
  ply("wide.ply", "float", "-30000 0 0\n30000 0 0\n0 30000 0\n0 0 0\n");
  CHECK(place.run("info wide.ply").err ==
        "gnosphere: warning: wide.ply: a mesh is so wide that its positions are in single precision, which has steps "
        "of 0.00195 m at 30000 m from its origin; split it into objects of an OBJ file, of which each gets an origin "
        "of its own\n");
}

TEST_CASE("a scene without triangles gives a cloud of misses and a warning") {
  const Workplace place;
  place.put("empty.gltf", R"({"asset": {"version": "2.0"}, "scenes": [{"nodes": []}], "scene": 0})");
  const Result result = place.run("scan empty.gltf -o a.pcd" + kQuick);
  REQUIRE(result.status == 0);
  CHECK_THAT(result.err, StartsWith("gnosphere: warning: empty.gltf has no triangle"));
  CHECK(gnosphere::readCloud(place / "a.pcd").counters.hits == 0);
  CHECK(gnosphere::readCloud(place / "a.pcd").beamCount() == 28800);
}

TEST_CASE("a scan that meets nothing tells where scene and sensor are") {
  const Workplace place;
  const Result far = place.run("scan floor.obj --pose 0,0,5000" + kQuick);
  REQUIRE(far.status == 0);
  CHECK_THAT(far.err, StartsWith("gnosphere: warning: no beam hits anything; floor.obj spans x ") &&
                          ContainsSubstring("the sensor at 0, 0, 5000 sees as far as 100 m; --pose moves it, --scale"));
  CHECK(place.run("scan floor.obj --set ignored_instances=[] --effect fog.visibility=20" + kQuick).err == "");
}

TEST_CASE("a scan whose beams are all lost tells why, and what helps") {
  const Workplace place;
  const auto warning = [&](const std::string& arguments) {
    INFO(arguments);
    const Result result = place.run("scan floor.obj --device reference " + arguments);
    CHECK(result.status == 0);
    CHECK(std::count(result.err.begin(), result.err.end(), '\n') == 1);
    return result.err;
  };
  const std::string lost = "gnosphere: warning: no beam returns anything; ";
  const std::string weak = warning("--sensor VLP-16 --effect detection.range=0.1");
  // More beams look past the floor than onto it.
  const std::string both = "floor.obj spans x -10..10, y -10..10, z 0..0 m, and the sensor at 0, 0, 1.8 sees";
  CHECK_THAT(weak, StartsWith(lost) && ContainsSubstring(" of 28,800 beams too weak, ") &&
                       ContainsSubstring(" met nothing; their surfaces are too dark") && ContainsSubstring(both));
  const std::string dropped = warning("--sensor VLP-16 --effect drop-out.general_rate=1");
  CHECK_THAT(dropped, StartsWith(lost) && ContainsSubstring(" of 28,800 beams dropped out, ") &&
                          ContainsSubstring(" met nothing; they are lost at random") && ContainsSubstring(both));

  // All beams look at the floor, or half of them.
  auto head = nlohmann::json::parse(R"({"name": "down", "columns": 30, "elevation_deg": [-60, -45],
      "range": {"min": 0.5, "max": 100}})");
  const auto with = [&](const char* key, const nlohmann::json& value, const std::string& arguments) {
    auto other = head;
    other[key] = value;
    place.put("head.json", other.dump());
    return warning("--sensor head.json " + arguments);
  };
  CHECK(with("max_returns", 1, "--effect detection.range=0.1") ==
        lost +
            "60 of 60 beams too weak; their surfaces are too dark or too far for the threshold of detection, which "
            "a larger detection.range lowers and detection=off leaves out in clear air\n");
  CHECK(with("max_returns", 1, "--effect drop-out.general_rate=1") ==
        lost +
            "60 of 60 beams dropped out; they are lost at random, with the probabilities drop-out.general_rate and "
            "drop-out.zero_intensity_rate\n");
  CHECK(with("elevation_deg", {45, -45, -60}, "--effect detection.range=0.1")
            .starts_with(lost + "60 of 90 beams too weak, 30 met nothing; their surfaces are too dark"));
  std::vector<uint32_t> beams(60);
  std::iota(beams.begin(), beams.end(), 0);
  CHECK(with("masked_beams", beams, "--effect drop-out.general_rate=0.5") ==
        lost + "60 of 60 beams masked; masked_beams of the sensor names them\n");
  CHECK(with("masked_beams", beams, "--effects clean") ==
        lost + "60 of 60 beams masked; masked_beams of the sensor names them\n");
  place.put("dead.json", nlohmann::json{{"drop-out", {{"dead_beams", beams}}}}.dump());
  CHECK(with("max_returns", 1, "--effects dead.json") ==
        lost + "60 of 60 beams dead; drop-out.dead_beams, or masked_beams of the sensor, names them\n");
  // A few dead beams are not why the others meet nothing.
  CHECK_THAT(with("masked_beams", {0, 1}, "--pose 0,0,-2 --effect drop-out.general_rate=0.5"),
             StartsWith("gnosphere: warning: no beam hits anything; floor.obj spans x -10..10"));
  head["range"]["min"] = 5;
  const std::string nearer =
      "60 of 60 beams met a surface nearer than the least range; surfaces nearer than 5 m give no return";
  CHECK(with("near_hits", "hide", "--effects clean") ==
        lost + nearer +
            " and hide what is behind them, because near_hits of the sensor is hide; --pose moves the sensor\n");
  CHECK(with("near_hits", "see_through", "") == lost + nearer + "; --pose moves the sensor\n");
  // An instance that the sensor ignores is no near surface.
  CHECK_THAT(with("near_hits", "hide", "--effects clean --set ignored_instances=[0]"),
             StartsWith("gnosphere: warning: no beam hits anything; floor.obj spans x -10..10"));
  place.put("t.tum", "0 0 0 1.8 0 0 0 1\n1 2 0 1.8 0 0 0 1\n");
  CHECK_THAT(with("near_hits", "hide", "--trajectory t.tum"),
             StartsWith("gnosphere: warning: no beam of any scan returns anything; of the first scan " + nearer));
}

TEST_CASE("a scan of faces that look away tells of --faces") {
  const Workplace place;
  place.put("one.gltf", R"({"asset": {"version": "2.0"}, "nodes": [{"mesh": 0}], "scenes": [{"nodes": [0]}], "scene": 0,
      "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}], "buffers": [{"byteLength": 36, "uri":
      "data:application/octet-stream;base64,AAAgwQAAAAAAACBBAAAgQQAAAAAAACBBAAAAAAAAAAAAAKDB"}],
      "bufferViews": [{"buffer": 0, "byteLength": 36}], "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3,
      "type": "VEC3", "min": [-10, 0, -20], "max": [10, 0, 10]}]})");
  for (const char* scene : {"one.gltf", "floor.obj --faces front"}) {
    INFO(scene);
    const std::string scan = std::string("scan ") + scene + kQuick;
    CHECK(place.run(scan + "--pose 0,0,1.8").err == "");
    const Result below = place.run(scan + "--pose 0,0,-1.8");
    REQUIRE(below.status == 0);
    CHECK_THAT(below.err, StartsWith("gnosphere: warning: no beam hits anything; the triangles of ") &&
                              ContainsSubstring(" that are in view face away, and only their front reflects; with "
                                                "--faces both ") &&
                              EndsWith(" of 28,800 beams hit\n"));
    CHECK(place.run(scan + "--pose 0,0,-1.8 --set faces=both").err == "");
    // Where nothing is in reach, faces are not to blame.
    CHECK_THAT(place.run(scan + "--pose 0,0,-5000").err,
               ContainsSubstring(" hits anything; ") && ContainsSubstring("--scale"));
  }
  CHECK_THAT(place.run("scan --help").out, ContainsSubstring("only glTF files have others"));
}

TEST_CASE("a scan tells the size of its scene, and that it writes nothing") {
  const Workplace place;
  const Result result = place.run("scan floor.obj" + kQuick);
  CHECK_THAT(result.out, ContainsSubstring(" in 1 instance, x -10..10, y -10..10, z 0..0 m, loaded in ") &&
                             EndsWith("\nwrote      nothing; -o FILE writes the cloud\n"));
  CHECK_THAT(place.run("scan floor.obj -o a.npy" + kQuick).out, !ContainsSubstring("nothing"));
}

TEST_CASE("a scan in fog tells how many beams have no surface") {
  const Workplace place;
  const std::string scan = "scan floor.obj -o a.csv --fields beam,label --compact" + kQuick;
  const Result foggy = place.run(scan + "--effect fog.visibility=30");
  REQUIRE(foggy.status == 0);
  const std::string rows = place.get("a.csv");
  size_t scattered = 0;
  for (size_t at = rows.find(",2\n"); at != rows.npos; at = rows.find(",2\n", at + 1)) ++scattered;
  REQUIRE(scattered > 100);
  CHECK_THAT(foggy.out, ContainsSubstring("%), " + grouped(scattered) + " of them by fog alone\n"));
  CHECK_THAT(place.run(scan).out, !ContainsSubstring("alone"));
}

TEST_CASE("beams whose echoes the mode does not choose are counted, and are no misses") {
  const Result result = Workplace().run("scan floor.obj --pose 0,0,2 --effect returns.mode=second" + kQuick);
  CHECK(result.status == 0);
  CHECK(result.err.empty());
  CHECK_THAT(result.out, ContainsSubstring(" not chosen"));
}

TEST_CASE("causes in a cloud that leaves out beams without a return come with a warning and a way out") {
  const Workplace place;
  const std::string one = "scan floor.obj -o a.csv --fields beam,cause" + kQuick;
  const std::string several = "scan floor.obj -o a.csv --fields beam,return,cause --effect returns.count=2" + kQuick;
  for (const std::string& scan : {one + "--compact", several}) {
    const Result warned = place.run(scan);
    CHECK(warned.status == 0);
    CHECK_THAT(warned.err, StartsWith("gnosphere: warning: --fields: the clouds leave out beams without a return, so "
                                      "`cause` is 0 everywhere; --no-compact writes every beam"));
  }
  CHECK(place.run(one).err.empty());
  const Result whole = place.run(several + "--no-compact --stats s.json");
  CHECK(whole.status == 0);
  CHECK(whole.err.empty());
  const std::string rows = place.get("a.csv"), stats = place.get("s.json");
  CHECK_THAT(rows, ContainsSubstring(",0,1\n") && ContainsSubstring(",1,0\n"));
  CHECK_THAT(stats, ContainsSubstring("\"compact\": false,"));
}

TEST_CASE("the field class of a scene without classes comes with a warning") {
  const Workplace place;
  const std::string scan = "scan floor.obj -o a.csv" + kQuick;
  const Result classless = place.run(scan + "--fields x,class");
  CHECK(classless.status == 0);
  CHECK_THAT(classless.err,
             StartsWith("gnosphere: warning: --fields: nothing in floor.obj has the number of a class") &&
                 ContainsSubstring("the extras of a glTF file give one"));
  CHECK(place.run(scan + "--fields x").err == "");
}

TEST_CASE("a KITTI file has intensities, unless effects without any are asked for") {
  const Workplace place;
  for (const auto& [effects, least] : {std::pair("auto", 0.01f), {"clean", 0.0f}}) {
    REQUIRE(place.run("scan floor.obj -o a.bin --effects " + std::string(effects) + kQuick).status == 0);
    const std::string bytes = place.get("a.bin");
    REQUIRE(bytes.size() > 1000);
    float most = 0;
    for (size_t at = 12; at < bytes.size(); at += 16) {
      float intensity;
      std::memcpy(&intensity, &bytes[at], sizeof intensity);
      most = std::max(most, intensity);
    }
    CHECK((least > 0 ? most > least : most == 0));
  }
}

TEST_CASE("fields that can be derived from the sensor need no request before the scan") {
  const Workplace place;
  REQUIRE(place.run("scan floor.obj -o a.csv --fields beam,return,class,time,azimuth,elevation" + kQuick).status == 0);
  const std::string text = place.get("a.csv");
  CHECK_THAT(text, StartsWith("beam,return,class,time,azimuth,elevation\n0,1,0,0,"));
  CHECK(std::count(text.begin(), text.end(), '\n') == 28801);
}

TEST_CASE("scan tells the effects that an accuracy leaves out, and why") {
  const Workplace place;
  const Result exact = place.run("scan floor.obj --sensor Puck --accuracy exact -o cloud.pcd");
  REQUIRE(exact.status == 0);
  CHECK_THAT(exact.out, ContainsSubstring("\nleft out   sensor-motion   motion within a scan needs accuracy standard\n"
                                          "           object-motion   motion within a scan needs accuracy standard\n"));
  CHECK_THAT(place.run("scan floor.obj --sensor Puck -o cloud.pcd").out, !ContainsSubstring("left out"));
}

TEST_CASE("cut-out materials whose images are missing cause a warning") {
  const Workplace place;
  place.put("leaf.gltf", R"({"asset": {"version": "2.0"}, "materials": [{"alphaMode": "MASK", "pbrMetallicRoughness":
      {"baseColorTexture": {"index": 0}}}], "textures": [{"source": 0}], "images": [{"uri": "leaf.png"}]})");
  const Result result = place.run("scan leaf.gltf" + kQuick);
  CHECK(result.status == 0);
  CHECK_THAT(result.err, ContainsSubstring("left out are 1 images of cut-out materials, which are not there"));
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

TEST_CASE("if the disk fills up, the old file stays and no partial file is left") {
  const Workplace place;
  place.put("a.pcd", "before");
  // A limit on file sizes simulates the full disk; its signal is ignored, so that writing fails.
  const Result result = place.run("scan floor.obj -o a.pcd" + kQuick, "trap '' XFSZ; ulimit -f 64;");
  CHECK(result.status == 1);
  CHECK_THAT(result.err, ContainsSubstring("a.pcd: cannot be written: File too large"));
  CHECK(place.get("a.pcd") == "before");
  CHECK(place.files() == std::vector<std::string>{"a.pcd", "floor.obj"});
}

TEST_CASE("a town is written and can be scanned") {
  const Workplace place;
  REQUIRE(place.run("town -o town.glb --triangles 20000 --seed 3").status == 0);
  const Result result = place.run("scan town.glb" + kQuick);
  CHECK(result.status == 0);
  CHECK(result.err == "");
}

TEST_CASE("help and version succeed, and every help text ends with an example") {
  const Workplace place;
  CHECK_THAT(place.run("--help").out, ContainsSubstring("scan") && ContainsSubstring("town"));
  CHECK_THAT(place.run("scan --help").out, ContainsSubstring("--pose") && ContainsSubstring("1.8 m"));
  for (const std::string command : {"", "scan", "plan", "accuracy", "compare", "devices", "sensors", "effects",
                                    "options", "info", "town", "drive", "view"}) {
    const std::string help = place.run(command + " --help").out;
    INFO(help);
    CHECK(longestLine(help) <= 80);
    const size_t example = help.find("\nExample: gnosphere ");
    REQUIRE(example != help.npos);
    CHECK(help.find_first_not_of('\n', help.find('\n', example + 1)) == help.npos);  // it is the last line
  }
  CHECK(longestLine(place.run("options").out) <= 80);
  const Result version = place.run("--version");
  CHECK(version.status == 0);
  CHECK_THAT(version.out, StartsWith("gnosphere "));
}
