// SPDX-License-Identifier: Apache-2.0
// Files of OpenDRIVE: what is read, what is refused, and what is warned of.
#include <catch2/catch_test_macros.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <cctype>
#include <cmath>
#include <random>
#include <tuple>

#include "gnosphere/error.hpp"
#include "problem.hpp"
#include "town/opendrive/drive.hpp"
#include "town/opendrive/road_mesh.hpp"
#include "town/opendrive_support.hpp"

using namespace gnosphere;
using namespace gnosphere::test;
using namespace gnosphere::town::opendrive;
namespace fs = std::filesystem;

namespace {

std::string textOf(const fs::path& file) {
  return bytesOf(file);
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const size_t at = text.find(from);
  REQUIRE(at != std::string::npos);
  return text.replace(at, from.size(), to);
}

}  // namespace

TEST_CASE("a network is centred, and the header's offset transforms back to the world") {
  const Network plain = readNetwork(kJunction);
  const TemporaryFile moved(
      replaced(textOf(kJunction), "version=\"1\"/>",
               "version=\"1\"><offset x=\"500000.25\" y=\"5400000\" z=\"100\" hdg=\"0.5\"/></header>"));
  const Network network = readNetwork(moved.path);
  const Vec3 inFile = plain.toFile * plain.road("2")->frame(33).at;
  const Vec3 there = network.toFile * network.road("2")->frame(33).at;
  const double x = inFile.x + 500000.25, y = inFile.y + 5400000;
  CHECK(distance(there, {x * std::cos(0.5) - y * std::sin(0.5), x * std::sin(0.5) + y * std::cos(0.5),
                         inFile.z + 100}) < 1e-5);
  CHECK(distance(plain.toFile * plain.road("1")->frame(0).at, {0, 0, 0}) < 1e-9);
}

TEST_CASE("traffic goes forward on the right, on the left of left-hand roads, and the other way on reversed lanes") {
  for (const bool leftHand : {false, true})
    for (const bool reversed : {false, true}) {
      const std::string direction = reversed ? " direction=\"reversed\"" : "", rule = leftHand ? "LHT" : "RHT";
      const std::string width = "<width sOffset=\"0\" a=\"3\" b=\"0\" c=\"0\" d=\"0\"/></lane>";
      const TemporaryFile file(
          "<OpenDRIVE><header/><road id=\"1\" length=\"400\" junction=\"-1\" rule=\"" + rule +
          "\"><planView><geometry s=\"0\" x=\"0\" y=\"0\" hdg=\"0\" length=\"400\"><line/></geometry></planView><lanes>"
          "<laneSection s=\"0\"><center><lane id=\"0\"/></center><right><lane id=\"-1\" type=\"driving\"" +
          direction + ">" + width + "</right></laneSection></lanes></road></OpenDRIVE>");
      CAPTURE(leftHand, reversed);
      const std::vector<WayPoint> points = planDrive(readNetwork(file.path), 1, 300).points;
      CHECK((points.back().at.x > points.front().at.x) == (leftHand == reversed));
    }
}

TEST_CASE("a network whose driving lanes are too short for a way is refused") {
  const auto network = [](const std::string& length) {
    const TemporaryFile file("<OpenDRIVE><header/><road id='1' length='" + length +
                             "' junction='-1'><planView><geometry s='0' x='0' y='0' hdg='0' length='" + length +
                             "'><line/></geometry></planView><lanes><laneSection s='0'><center><lane id='0'/></center>"
                             "<right><lane id='-1' type='driving'><width sOffset='0' a='3' b='0' c='0' d='0'/></lane>"
                             "</right></laneSection></lanes></road></OpenDRIVE>");
    return readNetwork(file.path);
  };
  CHECK(planDrive(network("0.06"), 1, 300).points.size() == 2);
  for (const char* length : {"0", "0.04"})
    CHECK_THAT(problemOf([&] { (void)planDrive(network(length), 1, 300); }, ErrorCode::format),
               Catch::Matchers::EndsWith("no road has a driving lane, or none that is 5 cm long"));
}

TEST_CASE("a mistake in a file is reported in one line with the file, the road and the mistake") {
  const std::string sound = textOf(kJunction);
  struct Fault {
    const char *from, *to;
    const char* says;
  };
  const Fault faults[] = {
      {"<line/>", "<bezier/>", "road 1: a geometry of the shape <bezier>"},
      {"<line/>", "", "road 1: a <geometry> without a shape"},
      {"length=\"80\" id", "length=\"x80\" id", "road 1: <road> has length=\"x80\", which is not a number"},
      {"length=\"80\" id", "length=\"1e99\" id", "road 1: <road> has length=\"1e99\", which is out of range"},
      {"length=\"80\" id", "length=\"nan\" id", "which is not a number"},
      {"length=\"80\" id", "length=\"-1\" id", "out of range"},
      {"id=\"1\" junction", "junction", "<road> has no attribute 'id'"},
      {" hdg=\"0\"", "", "road 1: <geometry> has no attribute 'hdg'"},
      {"curvature=\"0.02\"", "curvature=\"1e9\"", "road 2: <arc> has curvature=\"1e9\", which is out of range"},
      {"bU=\"40\"", "bU=\"1e80\"", "road 2: its <paramPoly3> leads out of the map"},
      {"x=\"149.7", "x=\"91149.7", "road 2: with it the roads are more than 20 km apart"},
      {"pRange=\"normalized\"", "pRange=\"metres\"", "road 2: <paramPoly3> has pRange=\"metres\""},
      {"<lane id=\"0\"", "<lane id=\"7\"", "road 1: a <laneSection> has no lane 0"},
      {"<lane id=\"2\"", "<lane id=\"1\"", "road 1: a <laneSection> has lane 1 twice"},
      {"<lane id=\"2\"", "<lane id=\"two\"", "road 1: <lane> has id=\"two\", which is not a number"},
      {"<laneSection s=\"25\">", "<laneSection s=\"75\">", "road 1: <laneSection> elements are not in the order"},
      {"s=\"50\" x", "s=\"5\" x",
       "road 2: its reference line is known up to 50 m, and the next <geometry> begins at 5 m"},
      {"length=\"80\" id", "length=\"90\" id", "road 1: its reference line is known up to 80 m, and it ends at 90 m"},
      {"length=\"120\" id=\"3\"", "length=\"120\" id=\"1\"",
       "road 1: its id is that of another one; give each its own"},
      {"<right><lane id=\"-1\"", "<right><lane id=\"3\"", "road 1: a <laneSection> has lane 3 in its <right>; ids are"},
      {"<left><lane id=\"2\"", "<left><lane id=\"-9\"", "road 1: a <laneSection> has lane -9 in its <left>; ids are"},
      {"<laneSection s=\"60\">", "<laneSection s=\"99\">",
       "road 1: a <laneSection> begins at 99 m, and the road ends at 80 m"},
      {"a=\"3.5\"", "a=\"-3.5\"", "road 1: driving lane 1 has a width of -3.5 m"},
      {"<width sOffset=\"0\" a=\"3.5\" b=\"0\" c=\"0\" d=\"0\"/>", "",
       "road 1: driving lane 1 has neither a <width> nor a <border>"},
      {"elementType=\"road\"", "elementType=\"rail\"", "road 2: it is linked to a \"rail\""},
      {"</OpenDRIVE>", "", "invalid XML"},
      {"<width sOffset=\"0\" a=\"3.5\" b=\"0\" c=\"0\" d=\"0\"/>",
       "<width sOffset=\"0\" a=\"3.5\"/><height sOffset=\"9\" inner=\"0\" outer=\"0\"/>"
       "<height sOffset=\"0\" inner=\"0.1\" outer=\"0.1\"/>",
       "road 1: lane 1: <height> elements are not in the order of their sOffset"},
      {"<width sOffset=\"0\" a=\"3.5\" b=\"0\" c=\"0\" d=\"0\"/>",
       "<width sOffset=\"0\" a=\"3.5\"/><roadMark sOffset=\"9\" type=\"solid\"/><roadMark type=\"broken\"/>",
       "road 1: lane 1: <roadMark> elements are not in the order of their sOffset"},
      {"<laneLink from=\"-1\"", "<laneLink from=\"\"", "junction 100: <laneLink> has from=\"\""},
  };
  for (const Fault& fault : faults) {
    INFO(fault.from << " -> " << fault.to);
    const TemporaryFile file(replaced(sound, fault.from, fault.to));
    const std::string message = problemOf([&] { (void)readNetwork(file.path); }, ErrorCode::format);
    CHECK_THAT(message, Catch::Matchers::StartsWith(file.path.string() + ": "));
    CHECK_THAT(message, Catch::Matchers::ContainsSubstring(fault.says));
    CHECK(message.find('\n') == std::string::npos);
  }
  CHECK_THROWS_AS(readNetwork(TemporaryFile("").path), Error);
  CHECK_THROWS_AS(readNetwork(TemporaryFile("<OpenDRIVE/>").path), Error);
  CHECK_THROWS_AS(readNetwork(TemporaryFile("<osm/>").path), Error);
  CHECK_THROWS_AS(readNetwork("nowhere.xodr"), Error);
}

TEST_CASE("gaps, links that lead nowhere and included files are warnings, one of each kind") {
  const std::string sound = textOf(kJunction);
  const auto warningsOf = [](const std::string& text) { return readNetwork(TemporaryFile(text).path).warnings; };
  CHECK(warningsOf(sound).empty());
  using Lines = std::vector<std::string>;
  CHECK(warningsOf(replaced(sound, "x=\"120.0\"", "x=\"120.25\"")) ==
        Lines{"road 2: its reference line jumps by 0.25 m at s = 20 m (and 1 more)"});
  CHECK(warningsOf(replaced(sound, "x=\"120.0\"", "x=\"120.05\"")).empty());
  CHECK(warningsOf(replaced(sound, "elementId=\"4\"", "elementId=\"44\"")) ==
        Lines{"road 2: it is linked to road 44, which the file lacks"});
  CHECK(warningsOf(replaced(sound, "<junction ", "<include file=\"other.xml\"/><junction ")) ==
        Lines{"<include file=\"other.xml\"> is not read; put its content into the file"});
}

TEST_CASE("an offset with the wrong sign, as old versions of netconvert write it, is a warning") {
  const auto warningsOf = [](const std::string& offset, const std::string& projection) {
    const std::string header = "version=\"1\"><geoReference>\n <![CDATA[\n " + projection +
                               "\n]]>\n</geoReference><offset " + offset + " z=\"0\" hdg=\"0\"/></header>";
    return readNetwork(TemporaryFile(replaced(textOf(kJunction), "version=\"1\"/>", header)).path).warnings;
  };
  const std::string north = "+proj=utm +zone=33 +ellps=WGS84 +datum=WGS84 +units=m +no_defs";
  const std::string wrong = "x=\"-391390.73\" y=\"-5817852.23\"", right = "x=\"391390.73\" y=\"5817852.23\"";
  REQUIRE(warningsOf(wrong, north).size() == 1);
  CHECK_THAT(warningsOf(wrong, north)[0], Catch::Matchers::ContainsSubstring("netconvert 1.21 and older ones"));
  CHECK(warningsOf(right, north).empty());
  CHECK(warningsOf(wrong, north + " +south").empty());
  CHECK(warningsOf(wrong, "+proj=tmerc").empty());
}

TEST_CASE("beside a lane section of a single side, the lanes of the other side go on") {
  const auto lane = [](int id, double width, double slope, const char* link) {
    return "<lane id=\"" + std::to_string(id) + "\" type=\"driving\">" + link + "<width sOffset=\"0\" a=\"" +
           std::to_string(width) + "\" b=\"" + std::to_string(slope) +
           "\" c=\"0\" d=\"0\"/><roadMark sOffset=\"10\" type=\"solid\" width=\"0.2\"/></lane>";
  };
  const auto section = [](double s, const std::string& left, const std::string& right, const char* more) {
    const auto side = [](const char* name, const std::string& lanes) {
      return lanes.empty() ? "" : "<" + std::string(name) + ">" + lanes + "</" + name + ">";
    };
    return "<laneSection s=\"" + std::to_string(s) + "\" " + more + ">" + side("left", left) +
           "<center><lane id=\"0\"/></center>" + side("right", right) + "</laneSection>";
  };
  const auto roadOf = [](const std::string& sections) {
    const TemporaryFile file(
        "<OpenDRIVE><header/><road id=\"1\" length=\"400\" junction=\"-1\"><planView><geometry s=\"0\" x=\"0\" y=\"0\" "
        "hdg=\"0\" length=\"400\"><line/></geometry></planView><lanes>" +
        sections + "</lanes></road></OpenDRIVE>");
    const Network network = readNetwork(file.path);
    return std::pair(network.roads[0], planDrive(network, 1, 390).points.size());
  };
  const char *single = "singleSide=\"true\"", *successor = "<link><successor id=\"2\"/></link>";
  const auto [road, points] =
      roadOf(section(0, lane(1, 3, 0.01, successor), lane(-1, 3.5, 0, ""), "") +
             section(100, "", lane(-1, 5, 0, ""), single) + section(200, "", lane(-1, 4, 0, ""), single) +
             section(300, lane(1, 1, 0, "") + lane(2, 3, 0, "<link><predecessor id=\"1\"/></link>"), "", single));
  REQUIRE(road.sections.size() == 4);
  for (const auto& [s, left, right] :
       {std::tuple{50.0, 3.5, 3.5}, {150.0, 4.5, 5.0}, {250.0, 5.5, 4.0}, {350.0, 4.0, 4.0}}) {
    const std::vector<double> edges = laneEdges(road, road.sectionAt(s), s);
    CAPTURE(s);
    CHECK(std::abs(edges.front() - left) < 1e-9);
    CHECK(std::abs(edges.back() + right) < 1e-9);
  }
  CHECK(road.sections[2].find(1)->successor == 2);
  CHECK(road.sections[1].find(1)->predecessor == 1);
  CHECK(road.sections[2].find(1)->marks[0].start == -190);
  CHECK(points > 700);  // one each half metre: the drive goes on from section to section
  // Each side may have a section of its own where the road begins.
  const Road both =
      roadOf(section(0, lane(1, 3, 0, ""), "", single) + section(0, "", lane(-1, 2, 0, ""), single)).first;
  REQUIRE(both.sections.size() == 1);
  CHECK(laneEdges(both, both.sections[0], 7) == std::vector<double>{3, 0, 0, -2});
}

TEST_CASE("damaged files give an Error or a town without a crash") {
  const std::string sound = textOf(kJunction);
  size_t read = 0;
  for (uint32_t seed = 0; seed < 60; ++seed) {
    std::mt19937 random(seed);
    std::string text = sound;
    const size_t count = 1 + random() % 3;
    for (size_t i = 0; i < count; ++i) {
      // Digits become other digits, signs or exponents, which the XML parser accepts.
      constexpr char kOthers[] = "0123456789-.e";
      size_t at = random() % text.size();
      while (at < text.size() && !std::isdigit(static_cast<unsigned char>(text[at]))) ++at;
      if (at < text.size()) text[at] = kOthers[random() % (sizeof kOthers - 1)];
    }
    const TemporaryFile file(text);
    INFO("seed " << seed);
    try {
      const Network network = readNetwork(file.path);
      const Drive drive = planDrive(network, 1, 300);
      for (const Road& road : network.roads) (void)roadPieces(road);
      (void)junctionPieces(network, "100");
      CHECK(drive.points.size() > 1);
      ++read;
    } catch (const Error&) {
    }
  }
  CHECK(read > 10);
}
