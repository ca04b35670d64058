// SPDX-License-Identifier: Apache-2.0
// gnosphere scan as a program: poses, the scenes that it warns of, and the fields of its clouds.
#include <algorithm>
#include <cstring>
#include <nlohmann/json.hpp>
#include <numeric>

#include "gnosphere/output.hpp"
#include "support.hpp"
#include "tools/cli_support.hpp"

using Catch::Matchers::ContainsSubstring;
using Catch::Matchers::EndsWith;
using Catch::Matchers::StartsWith;
using namespace gnosphere::test;

namespace {

/// 1234 -> 1,234
std::string grouped(size_t number) {
  std::string text = std::to_string(number);
  if (text.size() > 3) text.insert(text.size() - 3, ",");
  return text;
}

}  // namespace

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
          "--effect sensor-motion=auto --device reference --sensor ";
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
  needVulkan();  // the reference is always exact
  const Workplace place;
  const std::string scan = "scan floor.obj --sensor Puck -o cloud.pcd --effects clean --effect sensor-motion=auto ";
  const Result exact = place.run(scan + "--effect object-motion=auto --accuracy exact");
  REQUIRE(exact.status == 0);
  CHECK_THAT(exact.out, ContainsSubstring("\nleft out   sensor-motion   motion within a scan needs accuracy standard\n"
                                          "           object-motion   motion within a scan needs accuracy standard\n"));
  CHECK_THAT(place.run(scan + "--device reference").out, !ContainsSubstring("left out"));
}

TEST_CASE("a seed gives the same noise again, and that of the command line counts before that of a file") {
  const Workplace place;
  place.put("e.json", R"({"range-noise": {"sigma": 0.1}, "seed": 5})");
  const auto cloudWith = [&](const std::string& arguments) {
    REQUIRE(place.run("scan floor.obj -o a.csv --fields range " + arguments + kQuick).status == 0);
    return place.get("a.csv");
  };
  const std::string noise = "--effect range-noise.sigma=0.1 ", seven = cloudWith(noise + "--seed 7");
  CHECK((cloudWith(noise + "--seed 7") == seven));
  CHECK((cloudWith("--effects e.json --seed 7") == seven));
  CHECK_FALSE((cloudWith(noise + "--seed 8") == seven));
  CHECK((cloudWith("--effects e.json") == cloudWith(noise + "--seed 5")));
}

TEST_CASE("cut-out materials whose images are missing cause a warning") {
  const Workplace place;
  place.put("leaf.gltf", R"({"asset": {"version": "2.0"}, "materials": [{"alphaMode": "MASK", "pbrMetallicRoughness":
      {"baseColorTexture": {"index": 0}}}], "textures": [{"source": 0}], "images": [{"uri": "leaf.png"}]})");
  const Result result = place.run("scan leaf.gltf" + kQuick);
  CHECK(result.status == 0);
  CHECK_THAT(result.err, ContainsSubstring("left out are 1 images of cut-out materials, which are not there"));
}
