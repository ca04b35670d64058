// SPDX-License-Identifier: Apache-2.0
// Tests of trajectories: their files, their times, and where and how things are on them.
#include <sys/stat.h>

#include <catch2/matchers/catch_matchers_floating_point.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <clocale>
#include <cmath>
#include <thread>
#include <vector>

#include "drive/pose_math.hpp"
#include "drive_support.hpp"
#include "problem.hpp"

using namespace gnosphere;
using namespace gnosphere::test;
using Catch::Matchers::ContainsSubstring;
using Catch::Matchers::WithinAbs;

namespace {

void checkPose(const Pose& pose, const Vec3& position, const Quaternion& turn, double within = 1e-9) {
  const auto& [p, q] = pose;
  const double sign = q.x * turn.x + q.y * turn.y + q.z * turn.z + q.w * turn.w < 0 ? -1 : 1;
  const double got[] = {p.x, p.y, p.z, sign * q.x, sign * q.y, sign * q.z, sign * q.w};
  const double wanted[] = {position.x, position.y, position.z, turn.x, turn.y, turn.z, turn.w};
  for (int i = 0; i < 7; ++i) {
    INFO("number " << i << " of the pose");
    CHECK_THAT(got[i], WithinAbs(wanted[i], within));
  }
}

const double kHalf = std::sqrt(0.5);

}  // namespace

TEST_CASE("poses are linear and turn by slerp between the stamps of a trajectory") {
  const drive::Trajectory way({{1, {{0, 0, 0}, {}}}, {3, {{4, -2, 1}, {0, 0, kHalf, kHalf}}}});
  checkPose(way.at(1.5), {1, -0.5, 0.25}, {0, 0, std::sin(M_PI / 16), std::cos(M_PI / 16)}, 1e-12);
  checkPose(way.at(0), {0, 0, 0}, {});
  checkPose(way.at(9), {4, -2, 1}, {0, 0, kHalf, kHalf});
  CHECK(way.covers(3));
  CHECK_FALSE(way.covers(3.01));
  CHECK(way.movesWithin(2.9, 9));
  CHECK_FALSE(way.movesWithin(3, 9));
}

TEST_CASE("the times at which a way changes are its stamps, and where the turns around them begin and end") {
  using Times = std::vector<double>;
  const std::vector<drive::Trajectory::Stamp> stamps = {
      {0, {{0, 0, 0}, {}}}, {2, {{10, 0, 0}, {}}}, {4, {{10, 10, 0}, {}}}, {6, {{20, 10, 0}, {}}}};
  const drive::Trajectory given(stamps), along = drive::Trajectory::alongWay(stamps),
                                         mixed = drive::Trajectory::alongWay(stamps, {false, true});
  CHECK(given.timesWithin(0, 6) == Times{2, 4});
  CHECK(along.timesWithin(0, 6) == Times{1.5, 2, 2.5, 3.5, 4, 4.5});
  CHECK(along.timesWithin(-1, 1.8) == Times{0, 1.5});
  CHECK(along.timesWithin(2.2, 3.6) == Times{2.5, 3.5});
  CHECK(along.timesWithin(2.5, 3.5).empty());
  CHECK(mixed.timesWithin(0, 6) == Times{2, 4, 4.5});  // next to a pose with a turn of its own it turns all the way
}

TEST_CASE("every kind of trajectory file is read as its makers define it") {
  const Folder folder;
  const auto read = [&](const std::string& name, const std::string& bytes, const std::string& format,
                        const drive::TrajectoryFileOptions& options = {}) {
    return drive::readTrajectory(put(folder / name, bytes), format, options);
  };
  const auto tum = read("a.tum", "# t x y z qx qy qz qw\n1.5 1 2 3 0 0 0.70710678 0.70710678 9 9\n", "tum");
  REQUIRE(tum.size() == 1);
  CHECK(tum[0].time == 1.5);
  checkPose(tum[0].pose, {1, 2, 3}, {0, 0, kHalf, kHalf});

  const auto euroc = read("a.csv", "#t,p,q\n1403715273262142976,1,2,3,0.70710678,0.70710678,0,0,7,7\n", "euroc");
  CHECK_THAT(euroc[0].time, WithinAbs(1403715273.262142976, 1e-6));
  checkPose(euroc[0].pose, {1, 2, 3}, {kHalf, 0, 0, kHalf});

  const auto nuscenes = read("ego_pose.json",
                             R"([{"token":"b","timestamp":2500000,"rotation":[0,0,0,1],"translation":[4,5,6]},
                                 {"token":"a","timestamp":1500000,"rotation":[1,0,0,0],"translation":[1,2,3]},
                                 {"token":"c","timestamp":1500000,"rotation":[1,0,0,0],"translation":[7,8,9]}])",
                             "nuscenes");
  REQUIRE(nuscenes.size() == 2);
  CHECK(nuscenes[0].time == 1.5);
  checkPose(nuscenes[0].pose, {1, 2, 3}, {});  // of two poses of one time the first
  checkPose(nuscenes[1].pose, {4, 5, 6}, {0, 0, 1, 0});

  // A camera that moves 2 m ahead, 1 m to the right and 3 m down, and turns left by a quarter: about its -y.
  drive::TrajectoryFileOptions times;
  times.times = put(folder / "times.txt", "0\n0.1\n");
  const auto kitti = read("p.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n0 0 -1 1 0 1 0 3 1 0 0 2\n", "kitti", times);
  REQUIRE(kitti.size() == 2);
  CHECK(kitti[1].time == 0.1);
  checkPose(kitti[0].pose, {0, 0, 0}, {});
  checkPose(kitti[1].pose, {2, -1, -3}, {0, 0, kHalf, kHalf});
  // Turns by 150 degrees about each of our axes, which are the camera's z, -x and -y.
  times.times = put(folder / "three.txt", "0\n0.1\n0.2\n");
  const auto large = read("large.txt",
                          "-0.86602540378443865 -0.5 0 0 0.5 -0.86602540378443865 0 0 0 0 1 0\n"
                          "1 0 0 0 0 -0.86602540378443865 0.5 0 0 -0.5 -0.86602540378443865 0\n"
                          "-0.86602540378443865 0 -0.5 0 0 1 0 0 0.5 0 -0.86602540378443865 0\n",
                          "kitti", times);
  const double sine = std::sin(M_PI * 75 / 180), cosine = std::cos(M_PI * 75 / 180);
  REQUIRE(large.size() == 3);
  checkPose(large[0].pose, {0, 0, 0}, {sine, 0, 0, cosine});
  checkPose(large[1].pose, {0, 0, 0}, {0, sine, 0, cosine});
  checkPose(large[2].pose, {0, 0, 0}, {0, 0, sine, cosine});
  times.times = folder / "times.txt";

  // CARLA's y points to the right: a vehicle that drives to larger y turns right.
  const auto carla = read("ego.csv", "0,0,1,0.05\n0,1,1,0.1\n0,2,1,0.15\n0,2,1,0.2\n0,2,1,0.25\n", "carla");
  const auto along = drive::Trajectory::alongWay(carla);
  for (const auto& stamp : along.stamps()) checkPose({{}, stamp.pose.orientation}, {0, 0, 0}, {0, 0, -kHalf, kHalf});
  checkPose(along.at(0.15), {0, -2, 1}, {0, 0, -kHalf, kHalf});

  drive::TrajectoryFileOptions route;
  route.route = "7";
  route.speed = 2;
  const std::string xml =
      "<routes><route id='3'><waypoints><position x='0' y='0' z='0'/></waypoints></route><route "
      "id='7'><waypoints><position x='0' y='0' z='0'/><position x='0' y='-4' z='0'/></waypoints>"
      "</route></routes>";
  const auto carlaRoute = read("r.xml", xml, "carla-route", route);
  REQUIRE(carlaRoute.size() == 2);
  CHECK(carlaRoute[1].time == 2);
  checkPose(drive::Trajectory::alongWay(carlaRoute).at(2), {0, 4, 0}, {0, 0, kHalf, kHalf});

  const auto stops = read("s.xml",
                          "<routes><route><waypoint x='0' y='0' z='0'/><waypoint x='0' y='-4' z='0'/>"
                          "<waypoint x='0' y='-4' z='0'/><waypoint x='6' y='-4' z='0'/></route></routes>",
                          "carla-route", {.speed = 2});
  REQUIRE(stops.size() == 3);  // a place that is there twice takes no time
  CHECK(stops[1].time == 2);
  CHECK(stops[2].time == 5);

  std::setlocale(LC_NUMERIC, "de_DE.utf8");  // numbers have commas there, if the machine has this locale
  const auto halves = read("h.xml",
                           "<routes><route><waypoint x='0.5' y='-1.25' z='0'/><waypoint x='2.5' y='-1.25' z='0'/>"
                           "</route></routes>",
                           "carla-route", {.speed = 0.5});
  std::setlocale(LC_NUMERIC, "C");
  REQUIRE(halves.size() == 2);
  CHECK((halves[0].pose.position.x == 0.5 && halves[0].pose.position.y == 1.25));
  CHECK(halves[1].time == 4);
  for (const char* other : {"x='1,5' y='0' z='0'", "x='1' y='0'", "x='1 2' y='0' z='0'"})
    CHECK_THROWS_WITH(read("o.xml", "<routes><route><waypoint " + std::string(other) + "/></route></routes>",
                           "carla-route", {.speed = 1}),
                      ContainsSubstring("without finite x, y and z"));

  CHECK_THROWS_WITH(read("r.xml", xml, "carla-route"), ContainsSubstring("give its \"speed\""));
  CHECK_THROWS_WITH(read("a.feather", "", "tum"), ContainsSubstring("Argoverse 2"));
  for (const char* sbet : {"a.SBET", "sbet_mission 1.out"})
    CHECK_THROWS_WITH(read(sbet, std::string(136, '\0'), "tum"), ContainsSubstring("SBET is read by Python"));
  CHECK(read("sbet.tum", "0 1 2 3 0 0 0 1\n", "tum").size() == 1);
  for (const char* sheared : {"2 0 0 0 0 0.5 0 0 0 0 1 0\n", "1 0.9 0 0 0 1 0 0 0 0 1 0\n"})
    CHECK_THROWS_WITH(read("p.txt", sheared, "kitti", times), ContainsSubstring("is no rotation and translation"));
  CHECK_THROWS_WITH(read("p.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n", "kitti", times),
                    ContainsSubstring("has 2 times for the 1"));
  const std::string still = "1 0 0 0 0 1 0 0 0 0 1 0\n";
  CHECK_THROWS_WITH(read("p.txt", still + still + still, "kitti", times), ContainsSubstring("line 3 has no time in "));
  CHECK_THROWS_WITH(read("p.txt", "1 2 3\n", "kitti", times), ContainsSubstring("line 1 is not a matrix of 3 rows"));
  CHECK_THROWS_WITH(read("p.txt", still, "kitti"), ContainsSubstring("needs the file of its times"));
  route.route = "8";
  CHECK_THROWS_WITH(read("r.xml", xml, "carla-route", route), ContainsSubstring("has no route '8'"));
  CHECK_THROWS_WITH(read("p.txt", "1 2 3\n", "euroc"), ContainsSubstring("line 1 is not t,x,y,z,qw"));
  CHECK_THROWS_WITH(read("p.txt", "99999999999999999999,1,2,3,1,0,0,0\n", "euroc"),
                    ContainsSubstring("line 1 has a time that is not nanoseconds"));
  CHECK_THROWS_WITH(read("a.tum", "0 0 0 0 0 0 0 2\n", "tum"), ContainsSubstring("length is not 1"));
}

TEST_CASE("times of trajectories are moved, cut and turned along the way as asked for") {
  const DriveFolder folder;
  put(folder / "ego.tum", "100 0 0 0 0 0 0 1\n101 0 1 0 0 0 0 1\n102 0 2 0 0 0 0 1\n103 0 3 0 0 0 0 1\n");
  const auto read = [&](const Json& trajectory) {
    Json json = smallDrive();
    json["ego"]["trajectory"] = trajectory;
    return folder.read(json).ego;
  };
  const auto cut = read({{"file", "ego.tum"}, {"from", 101}, {"to", 102.5}, {"begin", -1}, {"shift", {0, 0, 2}}});
  REQUIRE(cut.stamps().size() == 2);
  CHECK(cut.begin() == -1);
  checkPose(cut.at(0), {0, 2, 2}, {});
  for (const double clock : {4e8, 1.7e9}) {  // adjusted standard GPS time and Unix time
    const auto line = [&](double after) { return std::to_string(clock + after) + " 0 0 0 0 0 0 1\n"; };
    put(folder / "flight.tum", line(0) + line(0.25) + line(0.5) + line(0.75) + line(10));
    const auto flight = read({{"file", "flight.tum"}, {"from", clock + 0.25}, {"to", clock + 0.75}});
    CHECK(flight.begin() == clock + 0.25);
    CHECK(flight.end() == clock + 0.75);
  }
  checkPose(read({{"file", "ego.tum"}, {"heading", true}}).at(101), {0, 1, 0}, {0, 0, kHalf, kHalf});

  put(folder / "twice.tum", "1 0 0 0 0 0 0 1\n2 5 0 0 0 0 0 1\n2 6 0 0 0 0 0 1\n3 7 0 0 0 0 0 1\n");
  Json json = quietDrive();
  json["ego"]["trajectory"] = {{"file", "twice.tum"}};
  json["actors"] = Json::array();
  const drive::Drive twice = folder.read(json);
  CHECK(twice.ego.stamps().size() == 3);
  CHECK(twice.ego.at(2).position.x == 5);
  REQUIRE(twice.warnings.size() == 1);
  CHECK_THAT(twice.warnings[0], ContainsSubstring("ego.trajectory: 1 poses have the time of the pose before"));
}

TEST_CASE("waypoints of a speed have times from their distances, and may pitch and roll") {
  const DriveFolder folder;
  const auto read = [&](const Json& trajectory) {
    Json json = smallDrive();
    json["ego"]["trajectory"] = trajectory;
    return folder.read(json).ego;
  };
  Json flight = {{"speed", 4}, {"waypoints", {{{"position", {0, 0, 2}}}, {{"position", {8, 0, 8}}}}}};
  flight["waypoints"].push_back({{"position", {8, 2, 8}}, {"yaw_pitch_roll_deg", {0, 0, 90}}});
  const drive::Trajectory ego = read(flight);
  REQUIRE(ego.stamps().size() == 3);
  CHECK((ego.stamps()[0].time == 0 && ego.stamps()[1].time == 2.5 && ego.stamps()[2].time == 3));
  checkPose(ego.at(3), {8, 2, 8}, {kHalf, 0, 0, kHalf});
  flight["begin"] = 100;
  CHECK(read(flight).stamps()[2].time == 103);
  flight["waypoints"][1]["time"] = 1;
  CHECK_THROWS_WITH(read(flight), ContainsSubstring("ego.trajectory.waypoints[1].time: follows from the 'speed'"));
  CHECK_THROWS_WITH(read({{"waypoints", {{{"position", {0, 0, 0}}}}}}),
                    ContainsSubstring("ego.trajectory.waypoints[0]: needs a 'time', or the trajectory a 'speed'"));
  CHECK_THROWS_WITH(
      read(
          {{"waypoints", {{{"time", 0}, {"position", {0, 0, 0}}, {"yaw_deg", 1}, {"yaw_pitch_roll_deg", {1, 0, 0}}}}}}),
      ContainsSubstring("waypoints[0].yaw_deg: is an alternative to yaw_pitch_roll_deg; keep one"));
}

TEST_CASE("an actor looks along its way between waypoints, turns around them, and keeps its direction while standing") {
  const DriveFolder folder;
  const auto yawOf = [&](const Json& waypoints) {
    Json json = smallDrive();
    json["actors"][0]["trajectory"] = {{"waypoints", waypoints}};
    const drive::Trajectory trajectory = folder.read(json).actors[0].trajectory;
    return [trajectory](double time) { return 180 / M_PI * drive::yawPitchRollOf(trajectory.at(time).orientation)[0]; };
  };
  const auto bend = yawOf({waypoint(0, -20, -5, 0), waypoint(2, 0, -5, 0), waypoint(4, 0, -25, 0)});
  for (const double time : {0.0, 1.0, 1.49}) CHECK_THAT(bend(time), WithinAbs(0, 1e-9));
  CHECK_THAT(bend(1.75), WithinAbs(-22.5, 1e-9));
  CHECK_THAT(bend(2), WithinAbs(-45, 1e-9));
  for (const double time : {2.5, 3.0, 4.0}) CHECK_THAT(bend(time), WithinAbs(-90, 1e-9));

  const auto stop = yawOf({waypoint(0, 0, 0, 0), waypoint(1, 10, 0, 0), waypoint(3, 10, 0, 0), waypoint(4, 10, 10, 0)});
  for (const double time : {0.5, 1.0, 2.0, 3.0}) CHECK_THAT(stop(time), WithinAbs(0, 1e-9));
  CHECK_THAT(stop(3.5), WithinAbs(90, 1e-9));

  // A pose with an angle of its own: the actor turns all the way to it.
  Json given = {waypoint(0, 0, 0, 0), waypoint(2, 10, 0, 0), waypoint(4, 20, 0, 0)};
  given[2]["yaw_deg"] = 40;
  CHECK_THAT(yawOf(given)(3), WithinAbs(20, 1e-9));
  // Behind a bend it does so from where it looks in the middle of the bend, -45 degrees.
  given = {waypoint(0, -20, -5, 0), waypoint(2, 0, -5, 0), waypoint(4, 0, -25, 0)};
  given[2]["yaw_deg"] = -135;
  const auto behind = yawOf(given);
  for (const auto& [time, yaw] : {std::pair(1.75, -22.5), {2.0, -45.0}, {2.5, -67.5}, {3.0, -90.0}, {4.0, -135.0}})
    CHECK_THAT(behind(time), WithinAbs(yaw, 1e-9));

  // Waypoints are cut before the vehicle is turned along what is left, and those that are turned count once.
  const auto ego = [&](Json trajectory) {
    trajectory["waypoints"] = {waypoint(0, -20, -5, 0), waypoint(2, 0, -5, 0), waypoint(4, 0, -25, 0)};
    Json json = smallDrive();
    json["ego"]["trajectory"] = trajectory;
    return folder.read(json).ego;
  };
  checkPose(ego({{"from", 1}, {"begin", 0}}).at(0), {0, -5, 0}, {0, 0, -kHalf, kHalf});
  checkPose(ego({{"to", 3}}).at(4), {0, -5, 0}, {});
  CHECK_THAT(drive::yawPitchRollOf(ego({{"heading", true}}).at(1.75).orientation)[0], WithinAbs(-M_PI / 8, 1e-9));
  // Waypoints that are cut tell the direction of a vehicle that stands.
  put(folder / "stop.csv", "0,0,0,0\n0,-5,0,1\n0,-5,0,2\n0,-5,0,3\n5,-5,0,4\n");
  const auto stopped = [&](double from, double to) {
    Json json = smallDrive();
    json["ego"]["trajectory"] = {{"file", "stop.csv"}, {"format", "carla"}, {"from", from}, {"to", to}};
    json["duration"] = 1;
    return folder.read(json).ego;
  };
  checkPose(stopped(2, 3).at(2.5), {0, 5, 0}, {0, 0, kHalf, kHalf});
  checkPose(stopped(3, 3).at(3), {0, 5, 0}, {0, 0, kHalf, kHalf});
  checkPose(stopped(2, 9).at(2.5), {0, 5, 0}, {0, 0, kHalf, kHalf});
  checkPose(stopped(2, 9).at(4), {5, 5, 0}, {});

  // Along a circle with ten waypoints a second the yaw is that of its tangent.
  constexpr double kRadius = 10, kRate = 0.5;  // m, rad/s
  Json circle = Json::array();
  for (int i = 0; i <= 40; ++i)
    circle.push_back(waypoint(0.1 * i, kRadius * std::sin(0.1 * kRate * i), -kRadius * std::cos(0.1 * kRate * i), 0));
  const auto around = yawOf(circle);
  for (double time = 0.2; time < 3.8; time += 0.013)
    CHECK_THAT(around(time), WithinAbs(180 / M_PI * kRate * time, 1e-3));
  Json json = smallDrive();
  json["ego"]["trajectory"] = {{"waypoints", circle}};
  json["duration"] = 1;
  const drive::Trajectory way = folder.read(json).ego;
  for (double time = 0.2; time < 3.8; time += 0.05)
    CHECK_THAT(lengthOf(way.ratesAt(time).acceleration), WithinAbs(kRadius * kRate * kRate, 0.01));
  // Between waypoints that are far apart the rates are those of the poses.
  const drive::Trajectory sparse = ego({{"heading", true}});
  for (const double time : {0.0, 0.7, 1.3, 2.7, 4.0}) {
    const auto rates = sparse.ratesAt(time);
    CHECK_THAT(lengthOf(rates.velocity - (time < 2 ? Vec3{10, 0, 0} : Vec3{0, -10, 0})), WithinAbs(0, 1e-9));
    CHECK_THAT(lengthOf(rates.acceleration), WithinAbs(0, 1e-9));
    CHECK_THAT(lengthOf(rates.turnRate), WithinAbs(0, 1e-9));
  }
  CHECK_THAT(sparse.ratesAt(2).turnRate.z, WithinAbs(-M_PI / 2, 1e-6));
}

TEST_CASE("what looks along its way pitches with \"pitch\": true, and is level with a warning without it") {
  const DriveFolder folder;
  const auto read = [&](const Json& trajectory) {
    Json json = quietDrive();
    json["actors"] = Json::array();
    json["ego"]["trajectory"] = trajectory;
    return folder.read(json);
  };
  // Level for 10 m, 3 m up within 4 m, and again level, after a turn to the left.
  const double slope = std::atan2(3, 4);
  Json way = {{"waypoints",
               {waypoint(0, 0, 0, 0), waypoint(2, 10, 0, 0), waypoint(4, 14, 0, 3), waypoint(6, 14, 0, 3),
                waypoint(8, 14, 9, 3)}}};
  const auto anglesAt = [&](double time) { return drive::yawPitchRollOf(read(way).ego.at(time).orientation); };
  const auto slopeWarning = ContainsSubstring(
      "ego.trajectory: has a slope of 75 %, and what faces its direction of travel stays level; \"pitch\": true "
      "inclines");
  CHECK_THAT(anglesAt(3)[1], WithinAbs(0, 1e-12));
  REQUIRE(read(way).warnings.size() == 1);
  CHECK_THAT(read(way).warnings[0], slopeWarning);
  way["pitch"] = false;
  CHECK(read(way).warnings.empty());
  CHECK_THAT(anglesAt(3)[1], WithinAbs(0, 1e-12));
  way["pitch"] = true;
  CHECK(read(way).warnings.empty());
  for (const auto& [time, share] :
       {std::pair(0.0, 0.0), {1.5, 0.0}, {1.75, 0.25}, {2.0, 0.5}, {2.5, 1.0}, {3.0, 1.0}}) {
    CAPTURE(time);
    CHECK_THAT(anglesAt(time)[0], WithinAbs(0, 1e-9));
    CHECK_THAT(anglesAt(time)[1], WithinAbs(-share * slope, 1e-9));  // the front looks up
  }
  CHECK_THAT(anglesAt(5)[1], WithinAbs(-slope, 1e-9));  // it stands
  CHECK_THAT(anglesAt(6.25)[0], WithinAbs(M_PI / 4, 1e-9));
  CHECK_THAT(anglesAt(6.25)[1], WithinAbs(-slope / 2, 1e-9));
  CHECK_THAT(anglesAt(7)[1], WithinAbs(0, 1e-9));
  const Vec3 ahead = read(way).ego.at(3).orientation * Vec3{1, 0, 0};
  CHECK_THAT(lengthOf(ahead - Vec3{0.8, 0, 0.6}), WithinAbs(0, 1e-12));
  way["from"] = 4;  // it stands there as it came
  CHECK_THAT(anglesAt(5)[1], WithinAbs(-slope, 1e-9));
  // Waypoints with an angle of their own are as they say.
  Json given = {{"waypoints", {waypoint(0, 0, 0, 0), waypoint(2, 4, 0, 3)}}, {"pitch", true}};
  for (Json& point : given["waypoints"]) point["yaw_deg"] = 10;
  CHECK_THROWS_WITH(read(given), ContainsSubstring("ego.trajectory.pitch: is for waypoints without an orientation"));
  given["heading"] = true;
  CHECK_THAT(drive::yawPitchRollOf(read(given).ego.at(1).orientation)[1], WithinAbs(-slope, 1e-9));
  given.erase("pitch");
  given["heading"] = false;
  CHECK(read(given).warnings.empty());
  // Noise of 1 cm is no slope, and neither are 2 %.
  Json noisy = {{"waypoints", Json::array()}};
  for (int i = 0; i < 100; ++i)
    noisy["waypoints"].push_back(waypoint(0.1 * i, 0.1 * i, 0, 0.02 * 0.1 * i + 0.01 * (i % 2)));
  for (const std::string& warning : read(noisy).warnings) CHECK_THAT(warning, !ContainsSubstring("slope"));
}

TEST_CASE("waypoints without times of their own are told once each, and nothing is said of the order of times") {
  const DriveFolder folder;
  const auto problem = [&](const Json& trajectory) {
    Json json = smallDrive();
    json["ego"]["trajectory"] = trajectory;
    return test::problemOf([&] { (void)folder.read(json); }, ErrorCode::format);
  };
  const Json twice = {{{"position", {0, 0, 0}}}, {{"position", {0, 0, 0}}}, {{"position", {9, 0, 0}}}};
  const std::string same = problem({{"speed", 5}, {"waypoints", twice}});
  CHECK_THAT(same,
             ContainsSubstring("ego.trajectory.waypoints[1]: is at the place of the one before, so with a 'speed'"));
  CHECK(same.find("does not come after") == std::string::npos);
  const std::string timeless = problem({{"waypoints", twice}});
  CHECK_THAT(timeless, ContainsSubstring("ego.trajectory.waypoints[1]: needs a 'time', or the trajectory a 'speed'"));
  CHECK(timeless.find("does not come after") == std::string::npos);
}

TEST_CASE("a vehicle whose stamps are far apart has the rates of its poses, and none where it stands") {
  // The vehicle goes 100 m in ten seconds, in which it turns by a quarter, and stands for as long.
  const Pose there = {{100, 0, 0}, {0, 0, kHalf, kHalf}};
  const drive::Trajectory way({{0, {}}, {10, there}, {20, there}});
  for (const double time : {0.0, 1.0, 5.0, 9.4, 10.6, 15.0, 20.0}) {
    INFO(time);
    const bool drives = time < 10;
    const drive::Trajectory::Rates rates = way.ratesAt(time);
    CHECK_THAT(lengthOf(rates.velocity - Vec3{drives ? 10.0 : 0.0, 0, 0}), WithinAbs(0, 1e-9));
    CHECK_THAT(lengthOf(rates.acceleration), WithinAbs(0, 1e-9));
    CHECK_THAT(lengthOf(rates.turnRate - Vec3{0, 0, drives ? M_PI / 20 : 0.0}), WithinAbs(0, 1e-9));
  }
  // The vehicle brakes within the second around the stamp: the acceleration rises and falls evenly, by 10 m/s in all.
  CHECK_THAT(way.ratesAt(10).velocity.x, WithinAbs(5, 1e-9));
  CHECK_THAT(way.ratesAt(10).acceleration.x, WithinAbs(-20, 1e-9));
}

TEST_CASE("stamps that nothing lies between give finite rates") {
  const auto placed = [](double x) { return Pose{{x, 0, 0}, {}}; };
  const Pose turned = {{2, 0, 0}, {0, 0, kHalf, kHalf}};
  for (const drive::Trajectory& way :
       {drive::Trajectory({{0, placed(0)}, {1e-308, turned}}),
        drive::Trajectory({{0, placed(0)}, {1e-308, turned}, {1, placed(3)}}),
        drive::Trajectory({{0, placed(0)}, {1, placed(3)}, {std::nextafter(1.0, 2.0), turned}, {2, placed(4)}}),
        drive::Trajectory({{0, placed(0)}, {1e-308, turned}, {2e-308, placed(1)}, {3e-308, turned}, {1, placed(3)}})})
    for (const double time : {0.0, 1e-308, 0.02, 0.5, 1.0, 1.98}) {
      CAPTURE(way.stamps().size(), way.end(), time);
      const drive::Trajectory::Rates rates = way.ratesAt(time);
      for (const Vec3& rate : {rates.velocity, rates.acceleration, rates.turnRate, way.velocityAt(time)})
        CHECK(std::isfinite(dot(rate, rate)));
    }
}

TEST_CASE("an inertial unit measures vibrations that the stamps show") {
  constexpr double kStamps = 400, kTilt = 0.01;  // Hz, rad
  // Returns the greatest turn rate and acceleration that a unit of this rate measures, as shares of the true ones.
  const auto measured = [&](double frequency, double unit, double digits = 0) {
    const double way = 50 / std::pow(2 * M_PI * frequency, 2);  // m, for 50 m/s^2
    const auto rounded = [&](double value) {
      return digits > 0 ? std::round(value * std::pow(10, digits)) / std::pow(10, digits) : value;
    };
    std::vector<drive::Trajectory::Stamp> stamps;
    for (int i = 0; i <= 800; ++i) {
      // Stamps are late or early by up to a tenth of the time between them.
      const double time = i / kStamps + 0.1 / kStamps * std::sin(12.3 * i),
                   swing = std::sin(2 * M_PI * frequency * time);
      const double roll = kTilt * swing;
      stamps.push_back(
          {time, {{rounded(5 * time), 0, rounded(300 + way * swing)}, {std::sin(roll / 2), 0, 0, std::cos(roll / 2)}}});
    }
    const drive::Trajectory trajectory(std::move(stamps));
    std::pair<double, double> most;  // rad/s, m/s^2
    for (double time = 0.5; time < 1.5; time += 1 / 997.0) {
      const drive::Trajectory::Rates rates = trajectory.ratesAt(time, {}, 1 / unit);
      most.first = std::max(most.first, std::abs(rates.turnRate.x));
      most.second = std::max(most.second, std::abs(rates.acceleration.z));
    }
    return std::pair(most.first / (kTilt * 2 * M_PI * frequency), most.second / 50);
  };
  for (const double frequency : {5, 10, 20, 50}) {
    INFO(frequency << " Hz");
    const auto [turn, way] = measured(frequency, 400);
    CHECK_THAT(turn, WithinAbs(1, 0.14));
    CHECK_THAT(way, WithinAbs(1, 0.14));
  }
  CHECK_THAT(measured(100, 400).first, WithinAbs(2 / M_PI, 0.1));
  // A unit that measures 50 times a second does not see what is faster than its rate.
  CHECK(measured(50, 50).first < 0.25);
  CHECK(measured(50, 50).second < 0.25);
  // Positions that are rounded to a millimetre do not jump by one from stamp to stamp, which were 160 m/s^2; turns
  // stay.
  const auto [turn, way] = measured(5, 400, 3);
  CHECK_THAT(turn, WithinAbs(1, 0.14));
  CHECK_THAT(way, WithinAbs(0.85, 0.15));
  // Positions that are round by themselves are not rounded.
  std::vector<drive::Trajectory::Stamp> round;
  for (int i = 0; i <= 800; ++i) round.push_back({i / kStamps, {{5 * i / kStamps, 0, i % 2 == 0 ? 0.0 : 0.001}, {}}});
  CHECK_THAT(drive::Trajectory(round).ratesAt(1).acceleration.z, WithinAbs(0.002 * kStamps * kStamps, 1e-3));
}

TEST_CASE("lines of trajectories end as those of any system, and may have comments and blanks") {
  const Folder folder;
  const std::string pose = " 1 2 3 0 0 0 1", next = "2" + pose;
  for (const std::string end : {"\n", "\r\n", "\r"}) {
    const std::string text =
        "\xef\xbb\xbf# t x y z qx qy qz qw" + end + "1" + pose + " # here" + end + end + next + end;
    const auto stamps = drive::readTrajectory(put(folder / "a.tum", text), "tum", {});
    REQUIRE(stamps.size() == 2);
    CHECK(stamps[1].time == 2);
    CHECK_THROWS_WITH(drive::readTrajectory(put(folder / "a.tum", text + "3 x" + end), "tum", {}),
                      ContainsSubstring("a.tum: line 5 is not t x y z"));
  }
  const auto euroc = drive::readTrajectory(put(folder / "a.csv", " 1000000000 , 1, 2, 3, 1, 0, 0, 0\n"), "euroc", {});
  CHECK(euroc.at(0).time == 1);
}

TEST_CASE("a trajectory may come from a pipe, but not from a device, which may have no end") {
  const auto problem = [](const char* file) {
    return problemOf([&] { drive::readTrajectory(file, "tum", {}); }, ErrorCode::file);
  };
  CHECK(problem("/dev/zero") == "/dev/zero: is a device and no file; give a file or a pipe");
  const Folder folder;
  const fs::path pipe = folder / "poses.tum";
  REQUIRE(::mkfifo(pipe.c_str(), 0600) == 0);
  std::thread writer([&] { put(pipe, "0 0 0 0 0 0 0 1\n1 1 0 0 0 0 0 1\n"); });
  const auto stamps = drive::readTrajectory(pipe, "tum", {});
  writer.join();
  CHECK(stamps.size() == 2);
}

TEST_CASE("yaws that are half a turn or more apart are warned of, because a vehicle turns the shorter way") {
  const DriveFolder folder;
  Json json = quietDrive();
  const auto warnings = [&](const std::vector<double>& yaws) {
    Json waypoints = Json::array();
    for (size_t i = 0; i < yaws.size(); ++i) {
      waypoints.push_back(waypoint(static_cast<double>(i), 0, 0, 0));
      waypoints.back()["yaw_deg"] = yaws[i];
    }
    json["ego"]["trajectory"]["waypoints"] = waypoints;
    return folder.read(json).warnings;
  };
  CHECK(warnings({0, 179, 350}).empty());
  const std::vector<std::string> longer = warnings({0, 90, 360, 0});
  REQUIRE(longer.size() == 1);
  CHECK_THAT(longer[0], ContainsSubstring("ego.trajectory.waypoints[2].yaw_deg: is 270 degrees from the one before") &&
                            ContainsSubstring("by -90 degrees") && ContainsSubstring("2 waypoints"));
}
