// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <catch2/catch_test_macros.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <random>
#include <sstream>
#include <tuple>

#include "gnosphere/error.hpp"
#include "problem.hpp"
#include "town/opendrive/drive.hpp"
#include "town/opendrive/plan.hpp"
#include "town/opendrive/road_mesh.hpp"

using namespace gnosphere;
using town::Surface;
using namespace gnosphere::town::opendrive;
namespace fs = std::filesystem;

namespace {

const fs::path kJunction = fs::path(GNOSPHERE_TEST_DATA) / "junction.xodr";

double distance(const Vec3& a, const Vec3& b) {
  return std::hypot(a.x - b.x, a.y - b.y, a.z - b.z);
}

std::string textOf(const fs::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

/// A temporary file that the destructor removes.
class TemporaryFile {
 public:
  explicit TemporaryFile(const std::string& text) : path(fs::temp_directory_path() / name()) {
    std::ofstream(path) << text;
  }
  ~TemporaryFile() { fs::remove(path); }
  fs::path path;

 private:
  static std::string name() { return "gnosphere-" + std::to_string(std::random_device{}()) + ".xodr"; }
};

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const size_t at = text.find(from);
  REQUIRE(at != std::string::npos);
  return text.replace(at, from.size(), to);
}

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

Geometry curve(Shape shape, double length, double from = 0, double to = 0) {
  Geometry geometry;
  geometry.shape = shape;
  geometry.length = length;
  geometry.curvature = from;
  geometry.curvatureAtEnd = to;
  return geometry;
}

/// A straight road along x with two lanes of 3.5 m, whose reference line starts at (x, 0).
Road straightRoad(const std::string& id, double x, double length) {
  Road road;
  road.id = id;
  road.length = length;
  road.geometries = {curve(Shape::line, length)};
  road.geometries[0].start = {x, 0, 0};
  Lane left, centre, right;
  left.id = 1;
  right.id = -1;
  left.use = right.use = LaneUse::carriageway;
  left.width = right.width = {{0, 3.5}};
  road.sections = {{0, length, {left, centre, right}}};
  return road;
}

struct Triangle {
  Surface surface;
  Vec3 corners[3];
  /// Twice the area that it covers in plan; negative if it is seen from below.
  double plan() const {
    const auto& [a, b, c] = corners;
    return (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y);
  }
};

std::vector<Triangle> trianglesOf(const std::vector<GroundPiece>& pieces) {
  std::vector<Triangle> triangles;
  for (const GroundPiece& piece : pieces)
    for (const MeshPart& part : piece.mesh.parts)
      for (size_t t = part.firstTriangle; t < part.firstTriangle + part.triangleCount; ++t) {
        Triangle triangle = {static_cast<Surface>(part.material), {}};
        for (size_t k = 0; k < 3; ++k) {
          const float* p = &piece.mesh.positions[3 * piece.mesh.indices[3 * t + k]];
          triangle.corners[k] = piece.at + Vec3{p[0], p[1], p[2]};
        }
        triangles.push_back(triangle);
      }
  return triangles;
}

/// Height of the highest triangle at a point in plan; NaN where there is none.
double heightAt(const std::vector<Triangle>& triangles, double x, double y) {
  double highest = std::nan("");
  for (const Triangle& triangle : triangles) {
    const auto& [a, b, c] = triangle.corners;
    const double area = triangle.plan();
    if (area < 1e-9) continue;
    const double u = ((x - a.x) * (c.y - a.y) - (c.x - a.x) * (y - a.y)) / area;
    const double v = ((b.x - a.x) * (y - a.y) - (x - a.x) * (b.y - a.y)) / area;
    if (u < -1e-6 || v < -1e-6 || u + v > 1 + 1e-6) continue;
    const double z = a.z + u * (b.z - a.z) + v * (c.z - a.z);
    if (!(highest >= z)) highest = z;
  }
  return highest;
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

TEST_CASE("road marks have the area of their kind: solid, broken, double") {
  // The road is straight and 90 m long, with a shoulder that has room for both halves of the edge line. Dashes are 3 m
  // in every 9.
  Road road;
  road.length = 90;
  road.geometries = {curve(Shape::line, 90)};
  Lane centre, inner, outer;
  inner.id = -1;
  outer.id = -2;
  inner.width = outer.width = {{0, 3.5}};
  inner.use = outer.use = LaneUse::carriageway;
  struct Case {
    MarkKind kind, second;
    double metres;
  };
  for (const Case& expected : {Case{MarkKind::solid, MarkKind::none, 90},
                               {MarkKind::broken, MarkKind::none, 30},
                               {MarkKind::solid, MarkKind::solid, 180},
                               {MarkKind::solid, MarkKind::broken, 120}}) {
    inner.marks = {{0, expected.kind, expected.second, 0.15}};
    road.sections = {{0, 90, {centre, inner, outer}}};
    double painted = 0, asphalt = 0;
    for (const GroundPiece& piece : roadPieces(road))
      for (const MeshPart& part : piece.mesh.parts)
        for (size_t t = part.firstTriangle; t < part.firstTriangle + part.triangleCount; ++t) {
          const float* p[3];
          for (size_t k = 0; k < 3; ++k) p[k] = &piece.mesh.positions[3 * piece.mesh.indices[3 * t + k]];
          const double area =
              ((p[1][0] - p[0][0]) * (p[2][1] - p[0][1]) - (p[2][0] - p[0][0]) * (p[1][1] - p[0][1])) / 2;
          CHECK(area > -1e-6);  // it faces upwards or is vertical
          (static_cast<Surface>(part.material) == Surface::roadPaint ? painted : asphalt) += area;
        }
    CHECK(std::abs(painted - 0.15 * expected.metres) < 1e-3);
    CHECK(std::abs(painted + asphalt - 630) < 1e-2);
  }
}

TEST_CASE(
    "a road has a cross-section where an entry of its profiles or marks starts, and more where its slope changes") {
  Road road = straightRoad("1", 0, 90);
  // The road is level up to 31.5 m and rises by 15 % up to 50 m; a curve up to 53 m makes it level again.
  road.elevation = {{0, 0}, {31.5, 0, 0.15}, {50, 2.775, 0.15, -0.025}, {53, 3, 0}};
  road.superelevation = {{0, 0}, {70.7, 0, 0.002}};
  road.laneOffset = {{0, 0}, {20.2, 0, 0.1}, {25.2, 0.5}};
  Lane& right = road.sections[0].lanes[2];
  right.width = {{0, 3.5}, {64.4, 3.5, 0.2}, {67.4, 4.1}};
  right.inner = right.outer = {{0, 0}, {40.4, 0, 0.1}, {41.4, 0.1}};
  right.hasHeight = true;
  right.marks = {{0, MarkKind::solid, MarkKind::none, 0.15}, {31.2}};
  const std::vector<Triangle> triangles = trianglesOf(roadPieces(road));
  double worst = 0;
  for (double s = 0.05; s < 90; s += 0.1) {
    const RoadFrame frame = road.frame(s);
    const std::vector<double> edges = laneEdges(road, road.sections[0], s);
    for (double share : {0.05, 0.5, 0.95}) {
      const Vec3 left = frame.point(edges[0] + share * (edges[1] - edges[0]));
      const Vec3 below = frame.point(edges[2] + share * (edges[3] - edges[2]));
      const double height = valueAt(right.inner, s);
      worst = std::max(worst, std::abs(heightAt(triangles, left.x, left.y) - left.z));
      worst = std::max(worst, std::abs(heightAt(triangles, below.x, below.y) - below.z - height));
    }
    // Just inside the outer edge of the right lane there is a surface, and just outside of it there is none.
    const Vec3 inside = frame.point(edges[3] + 0.01), outside = frame.point(edges[3] - 0.01);
    CHECK(std::isfinite(heightAt(triangles, inside.x, inside.y)));
    CHECK(std::isnan(heightAt(triangles, outside.x, outside.y)));
  }
  CHECK(worst < 0.02);
  double painted = 0;
  for (const Triangle& triangle : triangles)
    if (triangle.surface == Surface::roadPaint) painted += triangle.plan() / 2;
  CHECK(std::abs(painted - 0.15 / 2 * 31.2) < 0.01);
  const std::vector<double> all = stations(road, 0, 90);
  for (double s : {20.2, 25.2, 31.2, 31.5, 40.4, 41.4, 64.4, 67.4, 70.7})
    CHECK(std::find(all.begin(), all.end(), s) != all.end());
  for (const auto& [from, to] : {std::pair(0.0, 90.0), {31.5, 31.5004}, {10.0, 12.0}}) {
    const std::vector<double> list = stations(road, from, to);
    CHECK(list.front() == from);
    CHECK(list.back() == to);
    CHECK(std::adjacent_find(list.begin(), list.end(), std::greater_equal<>()) == list.end());
  }
}

/// The distance by which the surface ends short of or beyond a point, along a direction away from the road (metres).
double edgeError(const std::vector<Triangle>& triangles, const Vec3& edge, const Vec3& outwards) {
  constexpr double kFar = 0.6, kStep = 0.0025;
  double reached = -kFar;
  for (double out = -kFar; out < kFar; out += kStep) {
    const Vec3 p = edge + out * outwards;
    if (std::isfinite(heightAt(triangles, p.x, p.y))) reached = out;
  }
  return std::abs(reached);
}

/// A road with one lane to its right along straight geometries from corner to corner.
Road roadOfLines(const std::vector<Vec3>& corners, double width) {
  Road road = straightRoad("1", 0, 0);
  road.geometries.clear();
  road.length = 0;
  for (size_t i = 1; i < corners.size(); ++i) {
    const Vec3 way = corners[i] - corners[i - 1];
    Geometry line = curve(Shape::line, std::sqrt(dot(way, way)));
    line.s = road.length;
    line.start = corners[i - 1];
    line.heading = std::atan2(way.y, way.x);
    road.geometries.push_back(line);
    road.length += line.length;
  }
  LaneSection& section = road.sections[0];
  section.end = road.length;
  section.lanes.erase(section.lanes.begin());
  section.lanes[1].width = {{0, width}};
  return road;
}

TEST_CASE("where geometries of a reference line meet at an angle, the edges of lanes meet in a corner") {
  for (const double degrees : {30.0, -30.0, 70.0}) {
    const double angle = degrees * M_PI / 180, joint = 10.5, width = 3.5;
    const Vec3 after = {std::cos(angle), std::sin(angle), 0};
    const Road road = roadOfLines({{0, 0, 0}, {joint, 0, 0}, Vec3{joint, 0, 0} + 30 * after}, width);
    const std::vector<Triangle> triangles = trianglesOf(roadPieces(road));
    // The right edges of the two straight parts cross at the corner, on the line that halves the angle.
    const Vec3 corner = Vec3{joint, 0, 0} + width * Vec3{std::tan(angle / 2), -1, 0};
    CAPTURE(degrees);
    double worst = 0;
    for (double x = 0.5; x < corner.x; x += 0.37)
      worst = std::max(worst, edgeError(triangles, {x, -width, 0}, {0, -1, 0}));
    for (double way = 0.05; way < 20; way += 0.37)
      worst = std::max(worst, edgeError(triangles, corner + way * after, {after.y, -after.x, 0}));
    CHECK(worst < 0.02);
    double area = 0;
    for (const Triangle& triangle : triangles) {
      CHECK(triangle.plan() > -1e-6);  // none is seen from below
      area += triangle.plan() / 2;
    }
    CHECK(std::abs(area - width * (joint + 30 + width * std::tan(angle / 2))) < 0.01);
  }
}

TEST_CASE(
    "a bend that is written as short lines has the edge of the circle, and no cross-sections that it does not need") {
  constexpr double kRadius = 8, kWidth = 3;
  for (const int count : {12, 24, 900}) {
    std::vector<Vec3> corners;
    for (int i = 0; i <= count; ++i) {
      const double angle = i * M_PI / 2 / count;
      corners.push_back({kRadius * std::sin(angle), kRadius * (1 - std::cos(angle)), 0});
    }
    const Road road = roadOfLines(corners, kWidth);
    const std::vector<Triangle> triangles = trianglesOf(roadPieces(road));
    // A line of this bend is up to this far inside of the circle.
    const double sagitta = (kRadius + kWidth) * (1 - std::cos(M_PI / 4 / count));
    double worst = 0;
    for (double angle = 0.1; angle < 1.5; angle += 0.02) {
      const Vec3 out = {std::sin(angle), -std::cos(angle), 0};
      worst = std::max(worst, edgeError(triangles, Vec3{0, kRadius, 0} + (kRadius + kWidth) * out, out));
    }
    CAPTURE(count);
    CHECK(worst < 0.02 + sagitta);
    CHECK(stations(road, 0, road.length).size() < 50);
  }
  // Joints without an angle need no cross-section.
  std::vector<Vec3> straight;
  for (int i = 0; i <= 1000; ++i) straight.push_back({0.09 * i, 0, 0});
  CHECK(stations(roadOfLines(straight, 3), 0, 90).size() == stations(straightRoad("1", 0, 90), 0, 90).size());
}

TEST_CASE("the edges of tapers, of lane offsets and of wide lanes in bends are within 2 cm of their curves") {
  constexpr double kStart = 31, kWidth = 3.5;
  for (const double length : {4.0, 6.0, 10.0}) {
    const double c = 3 * kWidth / (length * length), d = -2 * kWidth / (length * length * length);
    const Profile taper = {{0, kWidth}, {kStart, kWidth, 0, c, d}, {kStart + length, 2 * kWidth}};
    for (const int kind : {0, 1, 2}) {
      Road road = straightRoad("1", 0, 60);
      Lane& right = road.sections[0].lanes[2];
      if (kind == 0) right.width = taper;
      if (kind == 1) {
        right.width.clear();
        right.border = taper;
      }
      if (kind == 2) {
        road.laneOffset = taper;
        for (Cubic& cubic : road.laneOffset) {
          cubic.a = -cubic.a + kWidth;
          cubic.c = -cubic.c;
          cubic.d = -cubic.d;
        }
      }
      const std::vector<Triangle> triangles = trianglesOf(roadPieces(road));
      double worst = 0;
      for (double s = kStart - 1; s < kStart + length + 1; s += 0.1) {
        const double in = std::clamp(s - kStart, 0.0, length), slope = in * (2 * c + 3 * d * in);
        const Vec3 out = {-slope / std::hypot(1, slope), -1 / std::hypot(1, slope), 0};
        worst = std::max(worst, edgeError(triangles, {s, -(kWidth + in * in * (c + d * in)), 0}, out));
      }
      CAPTURE(length, kind);
      CHECK(worst < 0.025);  // 2 cm, and a step of the search
    }
  }
  // Twelve metres outside of a bend of 12 m, the edge is a circle of 24 m.
  Road road = straightRoad("1", 0, 18);
  road.geometries = {curve(Shape::arc, 18, 1 / 12.0, 1 / 12.0)};
  road.sections[0].lanes[2].width = {{0, 12}};
  const std::vector<Triangle> triangles = trianglesOf(roadPieces(road));
  double worst = 0;
  for (double angle = 0.1; angle < 1.4; angle += 0.01) {
    const Vec3 out = {std::sin(angle), -std::cos(angle), 0};
    worst = std::max(worst, edgeError(triangles, Vec3{0, 12, 0} + 24 * out, out));
  }
  CHECK(worst < 0.025);
  // A superelevation that changes its rate bends the edges of a wide road.
  Road banked = straightRoad("1", 0, 30);
  banked.superelevation = {{0, 0}, {10, 0, 0, 0.008, -0.0004}, {20, 0.4, 0.04}};
  for (Lane& lane : banked.sections[0].lanes)
    if (lane.id != 0) lane.width = {{0, 14}};
  const std::vector<Triangle> surface = trianglesOf(roadPieces(banked));
  worst = 0;
  for (double s = 10.05; s < 20; s += 0.05) {
    const double roll = 0.008 * (s - 10) * (s - 10) - 0.0004 * std::pow(s - 10, 3), t = 13.99;
    worst = std::max(worst, std::abs(heightAt(surface, s, t * std::cos(roll)) - t * std::sin(roll)));
  }
  CHECK(worst < 0.025);
}

TEST_CASE("a junction has the heights of the connecting road, and no step where other roads meet it") {
  constexpr double kStart = 50, kEnd = 81.3;  // metres: where the connecting road C lies between the roads A and B
  for (const auto& [slope, bend, roll, width] :
       {std::tuple{0.1, 0.0, 0.0, 3.5}, {0.0, 0.0, 0.06, 14.0}, {0.05, 0.0, -0.04, 7.0}, {0.0, 0.08, 0.02, 3.5}}) {
    CAPTURE(slope, bend, roll, width);
    // The slope changes by `bend` at 63.2 m, inside C.
    const auto elevation = [&, slope = slope, bend = bend](double x) {
      return slope * x + bend * std::max(0.0, x - 63.2);
    };
    Network network;
    for (const auto& [id, from, to] : {std::tuple{"A", 0.0, kStart}, {"C", kStart, kEnd}, {"B", kEnd, 120.0}}) {
      Road road = straightRoad(id, from, to - from);
      road.elevation = {{0, elevation(from), slope + (from > 63.2 ? bend : 0)}};
      if (from == kStart) road.elevation.push_back({63.2 - from, elevation(63.2), slope + bend});
      road.superelevation = {{0, roll}};
      for (Lane& lane : road.sections[0].lanes)
        if (lane.id != 0) lane.width = {{0, width}};
      network.roads.push_back(road);
    }
    network.roads[0].successor = network.roads[2].predecessor = {RoadLink::junction, "J"};
    network.roads[1].junction = "J";
    const std::vector<Triangle> junction = trianglesOf(junctionPieces(network, "J"));
    const std::vector<Triangle> before = trianglesOf(roadPieces(network.roads[0]));
    double inside = 0, seam = 0, step = 0;
    size_t missing = 0;
    for (double t = -width + 0.1; t < width - 0.1; t += 0.31) {  // corners are rounded
      const double y = t * std::cos(roll);
      const auto error = [&](double x) {
        const double off = std::abs(heightAt(junction, x, y) - elevation(x) - t * std::sin(roll));
        missing += std::isfinite(off) ? 0 : 1;
        return off;
      };
      for (double x = kStart + 0.05; x < kEnd; x += 0.37) inside = std::max(inside, error(x));
      for (double x : {kStart + 0.002, kEnd - 0.002}) seam = std::max(seam, error(x));
      step = std::max(step, std::abs(heightAt(before, kStart - 0.002, y) - heightAt(junction, kStart + 0.002, y)));
    }
    CHECK(missing == 0);
    CHECK(step < 0.002);
    CHECK(inside < (bend == 0 ? 0.001 : 0.02));
    CHECK(seam < 0.001);
  }
}

TEST_CASE(
    "where connecting roads at different heights overlap, the junction leads from one to the other without steps") {
  Network network;
  network.roads = {straightRoad("C", 0, 40), straightRoad("D", 20, 40)};
  network.roads[1].geometries[0].start = {20, -20, 0};
  network.roads[1].geometries[0].heading = M_PI / 2;
  network.roads[1].elevation = {{0, 0.3}};
  for (Road& road : network.roads) road.junction = "J";
  const std::vector<Triangle> junction = trianglesOf(junctionPieces(network, "J"));
  CHECK(std::abs(heightAt(junction, 20, 0) - 0.15) < 0.01);
  for (double y : {-2.0, 0.3, 1.7}) {
    double before = 0;
    for (double x = 0.05; x < 40; x += 0.05) {
      const double z = heightAt(junction, x, y);
      CAPTURE(x, y, z, before);
      CHECK(std::abs(z - before) < 0.02);
      if (std::abs(x - 20) > 4) CHECK(std::abs(z) < 0.01);
      before = z;
    }
  }
}

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
      {"<laneLink from=\"-1\"", "<laneLink from=\"\"", "junction 100: <laneLink> has from=\"\""},
  };
  for (const Fault& fault : faults) {
    INFO(fault.from << " -> " << fault.to);
    const TemporaryFile file(replaced(sound, fault.from, fault.to));
    const std::string message = test::problemOf([&] { (void)readNetwork(file.path); }, ErrorCode::format);
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
