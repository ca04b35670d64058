// SPDX-License-Identifier: Apache-2.0
// Reference lines of OpenDRIVE roads and the edges of their lanes.
#include <algorithm>
#include <catch2/catch_test_macros.hpp>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <tuple>

#include "town/opendrive/drive.hpp"
#include "town/opendrive/road_mesh.hpp"
#include "town/opendrive_support.hpp"

using namespace gnosphere;
using namespace gnosphere::test;
using namespace gnosphere::town::opendrive;
namespace fs = std::filesystem;

namespace {

/// End of a curve with this heading, by Simpson's rule with the platform's sine.
Vec3 integrated(const std::function<double(double)>& heading, double length) {
  constexpr int kSteps = 20'000;
  const double step = length / kSteps;
  double x = 0, y = 0;
  for (int i = 0; i <= kSteps; ++i) {
    const double weight = i == 0 || i == kSteps ? 1 : i % 2 == 1 ? 4 : 2;
    x += weight * std::cos(heading(i * step));
    y += weight * std::sin(heading(i * step));
  }
  return {x * step / 3, y * step / 3, 0};
}

/// All .xodr files under the folder GNOSPHERE_SCENES; none if it is not set.
std::vector<fs::path> sharedNetworks() {
  std::vector<fs::path> files;
  if (const char* folder = std::getenv("GNOSPHERE_SCENES"))
    for (const auto& entry : fs::recursive_directory_iterator(folder))
      if (entry.path().extension() == ".xodr") files.push_back(entry.path());
  return files;
}

/// The largest jump in a road: of its reference line between two geometries, and of driving lanes' edges between two
/// sections.
double largestJump(const Road& road) {
  double largest = 0;
  for (size_t i = 0; i + 1 < road.geometries.size(); ++i) {
    const Geometry& geometry = road.geometries[i];
    largest = std::max(largest, distance(geometry.at(geometry.length).at, road.geometries[i + 1].start));
  }
  for (size_t i = 0; i + 1 < road.sections.size(); ++i) {
    const LaneSection &section = road.sections[i], &next = road.sections[i + 1];
    const std::vector<double> before = laneEdges(road, section, section.end), after = laneEdges(road, next, next.s);
    for (size_t k = 0; k < section.lanes.size(); ++k) {
      const Lane& lane = section.lanes[k];
      const Lane* successor = lane.driving && lane.successor ? next.find(*lane.successor) : nullptr;
      if (!successor || !successor->driving) continue;
      const size_t n = static_cast<size_t>(successor - next.lanes.data());
      largest = std::max({largest, std::abs(before[k] - after[n]), std::abs(before[k + 1] - after[n + 1])});
    }
  }
  return largest;
}

}  // namespace

TEST_CASE("an arc ends at the point of its closed form") {
  const double k = -0.037, length = 61;
  const CurvePoint end = curve(Shape::arc, length, k, k).at(length);
  CHECK(distance(end.at, {std::sin(k * length) / k, (1 - std::cos(k * length)) / k, 0}) < 1e-9);
  CHECK(distance(end.along, {std::cos(k * length), std::sin(k * length), 0}) < 1e-10);
}

TEST_CASE("a clothoid ends at the point of Fresnel's integrals and of an integration of its heading") {
  // With curvature pi s over a length of 1 it ends at C(1), S(1): Abramowitz and Stegun, table 7.7.
  const CurvePoint fresnel = curve(Shape::spiral, 1, 0, M_PI).at(1);
  CHECK(distance(fresnel.at, {0.7798934003768228, 0.4382591473903548, 0}) < 1e-10);

  for (const auto& [from, to, length] : {std::tuple{0.0, 0.02, 30.0}, {0.08, -0.15, 120.0}, {-0.01, -0.3, 45.0}}) {
    const CurvePoint end = curve(Shape::spiral, length, from, to).at(length);
    const auto heading = [from = from, to = to, length = length](double s) {
      return from * s + (to - from) / length * s * s / 2;
    };
    CAPTURE(from, to, length);
    CHECK(distance(end.at, integrated(heading, length)) < 1e-7);
    CHECK(distance(end.along, {std::cos(heading(length)), std::sin(heading(length)), 0}) < 1e-9);
  }
}

TEST_CASE("a poly3 is followed by its length, a paramPoly3 by its parameter") {
  Geometry cubic = curve(Shape::poly3, 40);
  cubic.v = {0, 0, 0.003, -0.00003};
  cubic.start = {5, -2, 0};
  cubic.heading = 0.7;
  const auto local = [&](double ds) {
    const Vec3 p = cubic.at(ds).at - cubic.start;
    return Vec3{p.x * std::cos(0.7) + p.y * std::sin(0.7), p.y * std::cos(0.7) - p.x * std::sin(0.7), 0};
  };
  double walked = 0;
  for (int i = 0; i < 4000; ++i) walked += distance(cubic.at(0.01 * i).at, cubic.at(0.01 * (i + 1)).at);
  CHECK(std::abs(walked - 40) < 1e-5);
  const Vec3 end = local(40);
  CHECK(std::abs(end.y - (0.003 * end.x * end.x - 0.00003 * end.x * end.x * end.x)) < 1e-10);

  Geometry parametric = curve(Shape::paramPoly3, 10);
  parametric.u = {1, 2, 3, 4};
  parametric.v = {0.5, -1, 0.25, 2};
  parametric.parameterRange = 1;
  const double p = 0.3;
  CHECK(distance(parametric.at(3).at, {1 + p * (2 + p * (3 + p * 4)), 0.5 + p * (-1 + p * (0.25 + p * 2)), 0}) < 1e-12);
  const double du = 2 + 2 * 3 * p + 3 * 4 * p * p, dv = -1 + 2 * 0.25 * p + 3 * 2 * p * p;
  CHECK(distance(parametric.at(3).along, {du / std::hypot(du, dv), dv / std::hypot(du, dv), 0}) < 1e-12);
}

TEST_CASE("geometries and lane edges of a road join without jumps") {
  for (const Road& road : readNetwork(kJunction).roads) {
    INFO("road " << road.id);
    CHECK(largestJump(road) < 1e-6);
  }
}

TEST_CASE("linked lanes share their edges") {
  const Network network = readNetwork(kJunction);
  // Lane -1 of connecting road 14 links lane 1 of road 2 with lane -1 of road 3.
  const auto edges = [&](const char* id, double s, size_t lane) {
    const Road& road = *network.road(id);
    const std::vector<double> t = laneEdges(road, road.sectionAt(s), s);
    return std::pair(road.frame(s).point(t[lane]), road.frame(s).point(t[lane + 1]));
  };
  const double length = network.road("14")->length;
  CHECK(distance(edges("14", 0, 1).first, edges("2", 0, 1).second) < 1e-6);
  CHECK(distance(edges("14", 0, 1).second, edges("2", 0, 1).first) < 1e-6);
  CHECK(distance(edges("14", length, 1).first, edges("3", 0, 3).first) < 1e-6);
  CHECK(distance(edges("14", length, 1).second, edges("3", 0, 3).second) < 1e-6);
  // Roads 2 and 4 meet end to end, so left and right are swapped.
  const double end2 = network.road("2")->length, end4 = network.road("4")->length;
  CHECK(distance(edges("2", end2, 0).first, edges("4", end4, 4).second) < 1e-6);
}

TEST_CASE("superelevation rotates a road about its reference line, lane offsets shift it sideways") {
  const Network network = readNetwork(kJunction);
  const Road& road = *network.road("3");
  const RoadFrame frame = road.frame(70);  // it runs south, so left is east
  const double ds = 10, offset = 0.0075 * ds * ds - 0.00025 * ds * ds * ds;
  const std::vector<double> edges = laneEdges(road, road.sectionAt(70), 70);
  CHECK(std::abs(edges[2] - offset) < 1e-12);
  CHECK(std::abs(edges[0] - (offset + 5.5)) < 1e-12);
  const Vec3 left = frame.point(3.5) - frame.at;
  CHECK(distance(left, {3.5 * std::cos(0.08), 0, 3.5 * std::sin(0.08)}) < 1e-9);
}

TEST_CASE("at a jump between two sections, the lane offset of the own section is used") {
  Road road;
  road.length = 100;
  road.laneOffset = {{0, 0}, {50, 3.5}};
  Lane centre, inner, outer;
  inner.id = -1;
  outer.id = -2;
  inner.width = outer.width = {{0, 3.5}};
  road.sections = {{0, 50, {centre, inner}}, {50, 100, {centre, inner, outer}}};
  // A lane is added on the left: lane -1 becomes lane -2 and keeps its position.
  CHECK(laneEdges(road, road.sections[0], 50) == std::vector<double>{0, 0, -3.5});
  CHECK(laneEdges(road, road.sections[1], 50) == std::vector<double>{3.5, 3.5, 0, -3.5});
}

TEST_CASE("every road of the networks in GNOSPHERE_SCENES is read and built") {
  const std::vector<fs::path> files = sharedNetworks();
  if (files.empty()) SKIP("GNOSPHERE_SCENES names no folder with .xodr files");
  for (const fs::path& file : files) {
    const Network network = readNetwork(file);
    INFO(file);
    CHECK(network.roads.size() > 0);
    for (const Road& road : network.roads) {
      INFO("road " << road.id);
      CHECK(largestJump(road) < 0.05);
      if (road.junction.empty() && road.length > 0.5) CHECK(roadPieces(road).size() > 0);
    }
    CHECK(planDrive(network, 1, 300).points.size() > 100);
  }
}
