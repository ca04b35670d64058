// SPDX-License-Identifier: Apache-2.0
// The surfaces of OpenDRIVE roads and junctions, against their reference lines and lanes.
#include <algorithm>
#include <catch2/catch_test_macros.hpp>
#include <cmath>
#include <functional>
#include <tuple>
#include <utility>

#include "town/opendrive/road_mesh.hpp"
#include "town/opendrive_support.hpp"

using namespace gnosphere;
using namespace gnosphere::test;
using namespace gnosphere::town::opendrive;
using town::Surface;

namespace {

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

}  // namespace

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
