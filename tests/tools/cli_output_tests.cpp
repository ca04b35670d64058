// SPDX-License-Identifier: Apache-2.0
// The output of the command line: places that it is written to, warnings, reports, and the comparison of clouds.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/sha256.hpp"
#include "gnosphere/output.hpp"
#include "tools/cli_support.hpp"

using Catch::Matchers::ContainsSubstring;
using Catch::Matchers::StartsWith;
using namespace gnosphere::test;

TEST_CASE("output that cannot be written to the standard output is a failure, also of help and of lists") {
  const Workplace place;
  for (const std::string& call : {std::string("effects"), std::string("--help"), std::string("scan --help"),
                                  "scan floor.obj --stats -" + kQuick}) {
    INFO(call);
    const Result full = place.run("-c \"'" GNOSPHERE_BINARY "' " + call + " >/dev/full\"", "", "/bin/sh");
    CHECK(full.status == 1);
    CHECK_THAT(full.err, StartsWith("gnosphere: the standard output is not complete"));
    CHECK(std::count(full.err.begin(), full.err.end(), '\n') == 1);
  }
  REQUIRE(place.run("scan floor.obj -o a.pcd" + kQuick).status == 0);
  CHECK(place.run("-c \"'" GNOSPHERE_BINARY "' compare a.pcd a.pcd >/dev/full\"", "", "/bin/sh").status == 2);
}

TEST_CASE("what is printed to a closed output is a failure, and goes to no other file") {
  const Workplace place;
  for (const std::string& call :
       {std::string("effects"), "plan floor.obj --json" + kQuick, "scan floor.obj --stats - -o a.pcd" + kQuick}) {
    INFO(call);
    const Result closed = place.run("-c \"'" GNOSPHERE_BINARY "' " + call + " >&-\"", "", "/bin/sh");
    CHECK(closed.status == 1);
    CHECK_THAT(closed.err, StartsWith("gnosphere: the standard output is not complete"));
  }
}

TEST_CASE("whoever closes a pipe wants no more, so there is no message") {
  const Workplace place;
  for (const char* signal : {"", "trap '' PIPE; "}) {
    INFO(signal);
    const Result closed =
        place.run("-c \"" + std::string(signal) +
                      "{ sleep 0.3; '" GNOSPHERE_BINARY "' effects; echo \\$? >status; } | true; cat status\"",
                  "", "/bin/sh");
    CHECK(closed.err == "");
    CHECK(closed.out == "141\n");
  }
}

TEST_CASE("no output file is one that is read, nor another one under a second name") {
  namespace fs = std::filesystem;
  const Workplace place;
  place.put("head.json", place.run("sensors VLP-16 --json").out);
  place.put("e.json", "{}");
  fs::create_symlink("a.pcd", place / "link.pcd");
  const std::string before = place.get("head.json");
  const std::vector<std::string> calls = {"--sensor head.json -o a.pcd --stats head.json",
                                          "--effects e.json -o a.pcd --stats ./e.json", "-o a.pcd --stats ./a.pcd",
                                          "-o a.pcd -o link.pcd", "-o a.pcd -o sub/../a.pcd"};
  fs::create_directory(place / "sub");
  for (const std::string& call : calls) {
    INFO(call);
    const Result result = place.run("scan floor.obj " + call + " --device reference");
    CHECK(result.status == 2);
    CHECK_FALSE(fs::exists(place / "a.pcd"));
  }
  CHECK(place.get("head.json") == before);
  for (const std::string call :
       {"sensors head.json --beams head.json", "sensors VLP-16 --beams p.png --image ./p.png",
        "town -o t.glb --xodr floor.obj --trajectory floor.obj", "town -o t.glb --xodr floor.obj --drive floor.json"}) {
    INFO(call);
    if (call.ends_with("floor.json")) fs::create_symlink("floor.obj", place / "floor.tum");
    const std::string floor = place.get("floor.obj");
    CHECK(place.run(call).status == 2);
    CHECK(place.get("head.json") == before);
    CHECK(place.get("floor.obj") == floor);
  }
}

TEST_CASE("a working directory that is gone is told before any work") {
  const Workplace place;
  const Result gone = place.run(
      "-c \"mkdir gone; cd gone; rmdir ../gone; '" GNOSPHERE_BINARY "' scan floor.obj -o a.pcd\"", "", "/bin/sh");
  CHECK(gone.status == 1);
  CHECK(gone.err == "gnosphere: a.pcd: the working directory is gone: No such file or directory\n");
  CHECK(place.files() == std::vector<std::string>{"floor.obj"});
}

TEST_CASE("files are written to what a link leads to, into pipes, and into devices") {
  namespace fs = std::filesystem;
  const Workplace place;
  place.put("target.pcd", "before");
  fs::create_symlink("target.pcd", place / "link.pcd");
  fs::create_symlink("none.csv", place / "dangling.csv");
  fs::create_symlink("/dev/null", place / "null.npy");
  const Result linked = place.run("scan floor.obj -o link.pcd -o dangling.csv -o null.npy" + kQuick);
  CHECK(linked.err == "");
  REQUIRE(linked.status == 0);
  for (const char* link : {"link.pcd", "dangling.csv", "null.npy"}) CHECK(fs::is_symlink(place / link));
  CHECK(fs::is_character_file("/dev/null"));
  CHECK(gnosphere::readCloud(place / "target.pcd").beamCount() == 28800);
  CHECK(gnosphere::readCloud(place / "none.csv").beamCount() == 28800);
  const Result piped =
      place.run("-c \"mkfifo pipe.csv; cat pipe.csv >read.csv & '" GNOSPHERE_BINARY "' scan floor.obj -o pipe.csv" +
                    kQuick + "; status=$?; wait; exit $status\"",
                "", "/bin/sh");
  CHECK(piped.status == 0);
  CHECK(fs::is_fifo(place / "pipe.csv"));
  CHECK(place.get("read.csv") == place.get("none.csv"));
  CHECK(place.files() == std::vector<std::string>{"dangling.csv", "floor.obj", "link.pcd", "none.csv", "null.npy",
                                                  "pipe.csv", "read.csv", "target.pcd"});
}

TEST_CASE("a cloud in the world frame far from the origin comes with a warning of its precision") {
  const Workplace place;
  place.put("far.obj", "v 5429000 -50 0\nv 5429100 -50 0\nv 5429000 50 0\nf 1 2 3\n");
  const std::string far = "scan far.obj --pose 5429030,0,1.8 -o far.csv" + kQuick;
  const Result world = place.run(far + " --frame world");
  CHECK(world.status == 0);
  CHECK_THAT(world.err, StartsWith("gnosphere: warning: points in the world frame are in single precision, which has "
                                   "steps of 0.5 m at 54290") &&
                            ContainsSubstring(" m; --frame sensor keeps millimetres"));
  CHECK(place.run(far).err == "");
}

TEST_CASE("the reference tells which options it ignores") {
  const Workplace place;
  const Result scan =
      place.run("scan floor.obj --set tuning.binning=lists --validation --accuracy exact --faces both" + kQuick);
  CHECK(scan.status == 0);
  CHECK_THAT(scan.err, StartsWith("gnosphere: warning: --device reference ignores ") && ContainsSubstring("accuracy") &&
                           ContainsSubstring("tuning.binning") && ContainsSubstring("validation") &&
                           !ContainsSubstring("faces"));
  CHECK(place.run("scan floor.obj --set ignored_instances=[0] --pose 0,0,1 --effect fog.visibility=9" + kQuick).err ==
        "");
}

TEST_CASE("a name of a file cannot control the terminal") {
  const Workplace place;
  const Result result = place.run("scan 'no\x1b[31m.glb'" + kQuick);
  CHECK(result.status == 1);
  CHECK_THAT(result.err, ContainsSubstring("no\\x1b[31m.glb") && !ContainsSubstring("\x1b"));
}

TEST_CASE("numbers of one have no plural, and a share that is not the whole is not rounded to it") {
  const Workplace place;
  place.put("one.obj", "v -500 -500 0\nv 500 -500 0\nv 0 500 0\nf 1 2 3\n");
  const Result one = place.run("scan one.obj" + kQuick);
  CHECK_THAT(one.out, ContainsSubstring("1 triangle (1 unique) in 1 instance, x -500..500"));
  // Inside a box every beam hits but those that leave by a hole.
  place.put("box.obj",
            "v -5 -5 -5\nv 5 -5 -5\nv 5 5 -5\nv -5 5 -5\nv -5 -5 5\nv 5 -5 5\nv 5 5 5\nv -5 5 5\n"
            "v 5 -0.02 0.2\nv 5 0.02 0.2\nv 5 0 -0.2\n"
            "f 1 2 3\nf 1 3 4\nf 5 6 7\nf 5 7 8\nf 1 2 6\nf 1 6 5\nf 3 4 8\nf 3 8 7\nf 4 1 5\nf 4 5 8\n"
            "f 2 6 9\nf 6 7 9\nf 9 7 10\nf 7 3 10\nf 10 3 11\nf 3 2 11\nf 11 2 9\n");
  const Result most = place.run("scan box.obj --up z --faces both --pose 0,0,0" + kQuick);
  INFO(most.out);
  CHECK_THAT(most.out, ContainsSubstring(" of 28,800 beams (more than 99.9 %)"));
}

TEST_CASE("an OBJ file tells of a library of materials that is not there") {
  const Workplace place;
  place.put("house.obj", "mtllib house.mtl\nusemtl brick\nv -9 -9 0\nv 9 -9 0\nv 0 9 0\nf 1 2 3\n");
  const Result result = place.run("scan house.obj" + kQuick);
  CHECK(result.status == 0);
  CHECK(result.err ==
        "gnosphere: warning: house.obj: left out are the materials of 'house.mtl', which cannot be read\n");
  place.put("house.mtl", "newmtl brick\nKd 0.5 0.1 0.1\n");
  CHECK(place.run("scan house.obj" + kQuick).err == "");
}

TEST_CASE("compare ends with status 0 for equal clouds and 1 for different ones") {
  const Workplace place;
  REQUIRE(place.run("scan floor.obj -o a.pcd -o b.csv --fields beam,range,triangle,instance,tie,tolerance" + kQuick)
              .status == 0);
  const Result same = place.run("compare a.pcd b.csv");
  CHECK(same.status == 0);
  CHECK_THAT(same.out, ContainsSubstring("the same") &&
                           ContainsSubstring("set apart by the reference; 0 of them differ") &&
                           ContainsSubstring("than the reference's tolerance, or 0.001 m"));

  gnosphere::Scan scan = gnosphere::readCloud(place / "a.pcd");
  for (size_t beam = 0; beam < scan.beamCount(); ++beam) {
    if (!scan.hit(beam) || scan.column<uint8_t>(gnosphere::Field::tie)[beam]) continue;
    scan.ranges[beam] += 1;
    break;
  }
  gnosphere::CloudOptions options;
  options.fields = gnosphere::parseFields("beam,range,triangle,instance");
  gnosphere::writeCloud(scan, place / "c.ply", options);
  const Result other = place.run("compare a.pcd c.ply --json");
  CHECK(other.status == 1);
  const auto json = nlohmann::json::parse(other.out);
  CHECK(json.at("wrong_range") == 1);
  CHECK(json.at("same") == false);
  CHECK(json.at("not_compared").empty());

  // The reference has no fields for ties and tolerances, so the report has no numbers of them.
  const Result plain = place.run("compare c.ply a.pcd");
  CHECK_THAT(plain.out,
             ContainsSubstring("\nties                     -  not known, as the reference has no field tie\n") &&
                 ContainsSubstring("further apart than 0.001 m, as the reference has no field tolerance\n"));
  for (uint32_t& triangle : scan.triangles) triangle += triangle != gnosphere::kNoTriangle;
  gnosphere::writeCloud(scan, place / "e.ply", options);
  CHECK_THAT(place.run("compare e.ply a.pcd").out,
             ContainsSubstring("\nrange error   -, as no return has the same triangle in both, ties aside\n"));

  options.fields = gnosphere::parseFields("beam,range");
  gnosphere::writeCloud(scan, place / "d.ply", options);
  const Result poor = place.run("compare a.pcd d.ply");
  CHECK(poor.status == 2);
  CHECK_THAT(poor.err, ContainsSubstring("triangle, instance"));
}

TEST_CASE("compare looks at points, names the fields that it ignores, and counts returns") {
  const Workplace place;
  const std::string scan = "scan floor.obj --pose 1,0,1.8 --fields x,y,z,range,beam,triangle,instance,intensity,time" +
                           kQuick + " --effects clean --effect intensity=auto ";
  REQUIRE(place.run(scan + "-o a.pcd").status == 0);
  REQUIRE(place.run(scan + "-o b.pcd --frame world").status == 0);
  const Result same = place.run("compare a.pcd a.pcd");
  CHECK(same.status == 0);
  CHECK_THAT(same.out, ContainsSubstring("\nnot compared  intensity, time\nthe same\n") &&
                           ContainsSubstring("\nreturns ") && !ContainsSubstring("hits"));
  const Result moved = place.run("compare a.pcd b.pcd --json");
  CHECK(moved.status == 1);
  const auto json = nlohmann::json::parse(moved.out);
  CHECK(json.at("wrong_point") == json.at("hits"));
  CHECK(json.at("wrong_range") == 0);
  CHECK(json.at("point_error_max_m").get<double>() > 2.05);
  CHECK(json.at("not_compared") == nlohmann::json({"intensity", "time"}));
  CHECK_THAT(place.run("compare a.pcd b.pcd").out, ContainsSubstring("point error   max 2.06 m\n"));
}

TEST_CASE("a message on a terminal erases no line if there is no progress bar") {
  const Workplace place;
  const Result result =
      place.run("-qec \"'" GNOSPHERE_BINARY "' scan none.glb\" /dev/null </dev/null", "TERM=xterm", "script");
  if (result.status == 127) SKIP("no program `script`, which makes a terminal");
  CHECK_THAT(result.out, StartsWith("gnosphere: cannot read") && !ContainsSubstring("\x1b"));
}

TEST_CASE("a scan that a signal ends leaves no unfinished file") {
  const Workplace place;
  // The shell lets its jobs ignore SIGINT, so that is tested in os_tests.
  for (const auto& [signal, status] : {std::pair("TERM", 128 + 15), std::pair("HUP", 128 + 1)}) {
    INFO(signal);
    place.put("end.sh", std::string("'" GNOSPHERE_BINARY
                                    "' scan floor.obj --sensor HDL-64E --device reference --effects clean -o a.csv &\n"
                                    "while kill -0 $! && [ ! -s .a.csv.part ]; do :; done\n"
                                    "kill -") +
                            signal + " $!\nwait $!\n");
    CHECK(place.run("end.sh", "", "/bin/sh").status == status);
    CHECK_FALSE(std::filesystem::exists(place / ".a.csv.part"));
    CHECK_FALSE(std::filesystem::exists(place / "a.csv"));
  }
}

TEST_CASE("compare says of points, grids and coordinates what it does not know") {
  const Workplace place;
  const std::string head = "range,beam,triangle,instance\n";
  place.put("a.csv", head + "1,0,0,0\n2,4,1,0\n");
  place.put("b.csv", "x,y,z," + head + "1,0,0,1,0,0,0\n2,0,0,2,4,1,0\n");
  place.put("c.csv", "x,y,z," + head + "3,0,0,1,0,0,0\n2,0,0,2,4,1,0\n");
  const std::string none = "-, not compared, as not both files have x, y, z\n";
  for (const char* files : {"a.csv b.csv", "b.csv a.csv"}) {
    const Result bare = place.run(std::string("compare ") + files);
    CHECK_THAT(bare.out,
               ContainsSubstring("\npoint error   " + none) &&
                   ContainsSubstring("\nwrong point              -  not compared, as not both files") &&
                   ContainsSubstring("beams                    5  at least, as neither file states its grid\n"));
    const auto json = place.runJson(std::string("compare --json ") + files);
    CHECK(json.at("point_error_max_m").is_null());
    CHECK(json.at("wrong_point").is_null());
  }
  CHECK_THAT(place.run("compare b.csv c.csv").out,
             ContainsSubstring("wrong point              1  x, y, z further apart than that plus 1e-6 of the range, or "
                               "2.4e-7 of the distance from the origin if more\n") &&
                 ContainsSubstring("\npoint error   max 2 m\n"));
  REQUIRE(place.run("scan floor.obj -o a.pcd" + kQuick).status == 0);
  CHECK_THAT(place.run("compare a.pcd a.pcd").out, !ContainsSubstring("at least"));

  place.put("far.csv", "x,y,z," + head + "500000.123,5400000.456,7.891,1,0,0,0\n");
  place.put("moved.csv", "x,y,z," + head + "500000.123,5400000.458,7.891,1,0,0,0\n");
  const Result moved = place.run("compare far.csv moved.csv");
  CHECK(moved.status == 1);
  CHECK(moved.err.empty());
  CHECK_THAT(moved.out, ContainsSubstring("of the distance from (499712, 5399552, 0) if more"));
  const auto json = nlohmann::json::parse(place.run("compare far.csv moved.csv --json").out);
  CHECK(std::abs(json.at("point_error_max_m").get<double>() - 0.002) < 1e-4);
  place.put("floats.csv", "x,y,z," + head + "500000.12,5400000.5,7.891,1,0,0,0\n");
  const Result floats = place.run("compare far.csv floats.csv");
  CHECK(floats.err ==
        "gnosphere: warning: floats.csv: its coordinates are 32-bit floats, whose steps of 0.5 m are more than "
        "--tolerance 0.001; write doubles, or coordinates from an origin nearby\n");
  CHECK_THAT(floats.out, ContainsSubstring("of the distance from the origin if more"));
  CHECK(place.run("compare far.csv floats.csv --tolerance 0.5").err.empty());
  for (const char* tolerance : {"inf", "nan", "-1"}) {
    const Result refused = place.run("compare b.csv b.csv --tolerance " + std::string(tolerance));
    CHECK(refused.status == 2);
    CHECK(refused.err == "gnosphere: the tolerance must be a number of metres from 0 on\n");
  }
}

TEST_CASE("beams that never fire are called masked wherever beams are counted") {
  const Workplace place;
  place.put("head.json", R"({"name": "down", "columns": 30, "elevation_deg": [-60, -45],
      "range": {"min": 0.5, "max": 100}, "masked_beams": [0, 1, 2, 2]})");
  const std::string scan = "scan floor.obj --pose 0,0,1.8 --device reference --sensor head.json ";
  CHECK_THAT(place.run(scan + "--effects clean").out,
             ContainsSubstring("hits       57 of 60 beams (95.0 %), 3 masked\n") && !ContainsSubstring("lost  "));
  place.put("t.tum", "0 0 0 1.8 0 0 0 1\n1 2 0 1.8 0 0 0 1\n");
  CHECK_THAT(place.run("scan floor.obj --device reference --sensor head.json --effects clean --trajectory t.tum").out,
             ContainsSubstring(" of 120 beams (95.0 %), 6 masked\n"));
  // Beam 2 is masked and dead, beam 5 is dead alone.
  place.put("dead.json", R"({"drop-out": {"dead_beams": [2, 5]}})");
  const std::string both = place.run(scan + "--effects dead.json").out;
  CHECK_THAT(both, ContainsSubstring("hits       56 of 60 beams (93.3 %), 3 masked\n") &&
                       ContainsSubstring("lost       1 dead\n"));
  CHECK_THAT(place.run("plan floor.obj --device reference --sensor head.json").out,
             ContainsSubstring("down: 60 beams, 3 masked, 1 return each\n"));
  CHECK_THAT(place.run("sensors head.json").out, ContainsSubstring("57 in a cloud of 30 x 2, 3 masked\n"));
  CHECK_THAT(place.run("sensors").out,
             ContainsSubstring("  beams   masked  ") && ContainsSubstring(" 115,200   28,800 "));
}

TEST_CASE("compare ends with status 2 if a file is cut short") {
  const Workplace place;
  REQUIRE(place.run("scan floor.obj -o a.pcd -o b.npy" + kQuick).status == 0);
  std::filesystem::resize_file(place / "b.npy", 5000);
  const Result cut = place.run("compare a.pcd b.npy");
  CHECK(cut.status == 2);
  CHECK_THAT(cut.err, ContainsSubstring("b.npy: is cut short"));
}

TEST_CASE("scan --stats - prints only JSON, with the documented names") {
  const Workplace place;
  const auto stats = place.runJson("scan floor.obj --repeat 3 --stats -" + kQuick);
  CHECK(stats.at("device").at("type") == "reference");
  for (const char* key : {"triangles", "unique_triangles", "instances", "meshes", "clusters", "bytes"}) {
    CHECK(stats.at("scene").contains(key));
  }
  CHECK(stats.at("sensor").at("beams") == 28800);
  for (const char* key : {"effects", "stages", "accuracy", "binning", "bytes", "dispatches"})
    CHECK(stats.at("plan").contains(key));
  const auto& madeBy = stats.at("made_by");
  CHECK(madeBy.at("version") == "0.3.0");
  CHECK(madeBy.at("arguments") ==
        nlohmann::json{
            {"scene", "floor.obj"}, {"repeat", "3"}, {"stats", "-"}, {"device", "reference"}, {"sensor", "VLP-16"}});
  CHECK(madeBy.at("effects").at("seed") == 1);
  CHECK(madeBy.at("effects").at("fog").at("visibility") == 0);
  const std::string floor = place.get("floor.obj");
  CHECK(madeBy.at("inputs") ==
        nlohmann::json{{{"path", "floor.obj"}, {"bytes", floor.size()}, {"sha256", gnosphere::sha256Text(floor)}}});
  CHECK(stats.at("frame").at("runs") == 3);
  CHECK(stats.at("frame").at("wall_ms").at("min") <= stats.at("frame").at("wall_ms").at("median"));
  CHECK(stats.at("frame").contains("gpu_ms"));
  CHECK(stats.at("frame").at("stages_ms").is_object());
  const auto& counters = stats.at("counters");
  CHECK(counters.at("hits").get<uint64_t>() + counters.at("misses").get<uint64_t>() == 28800);
  for (const char* key : {"beams", "triangles", "non_finite", "degenerate", "culled_by_cluster", "culled_by_range",
                          "culled_by_face", "culled_between_beams", "projected", "candidates", "retries"}) {
    CHECK(counters.contains(key));
  }
}
