// SPDX-License-Identifier: Apache-2.0
#include "town/vehicle.hpp"

#include <algorithm>
#include <cmath>

namespace gnosphere::town {
namespace {

struct Point {
  double x, z;
};

/// Side view of a vehicle from rear to front, in metres. `belt` is the upper edge of the body, on which the cabin
/// stands.
struct Shape {
  const char* name;
  double halfWidth;
  double rearAxle, frontAxle, wheelRadius;
  std::vector<Point> belt;
  Point cabin[4];  ///< rear foot, rear top, front top, front foot
  int sideWindows;
};

Shape shapeOf(VehicleKind kind) {
  switch (kind) {
    case VehicleKind::hatchback:
      return {"hatchback",
              0.86,
              -1.22,
              1.22,
              0.30,
              {{-1.92, 0.62}, {-1.86, 0.86}, {-1.2, 0.92}, {0.7, 0.90}, {1.45, 0.80}, {1.88, 0.66}, {1.96, 0.52}},
              {{-1.84, 0.87}, {-1.38, 1.46}, {0.12, 1.48}, {0.98, 0.86}},
              2};
    case VehicleKind::saloon:
      return {"saloon",
              0.90,
              -1.38,
              1.38,
              0.32,
              {{-2.30, 0.66}, {-2.24, 0.92}, {-1.5, 0.95}, {0.8, 0.92}, {1.75, 0.80}, {2.20, 0.66}, {2.30, 0.52}},
              {{-1.62, 0.94}, {-0.92, 1.42}, {0.28, 1.44}, {1.12, 0.88}},
              2};
    case VehicleKind::estate:
      return {"estate",
              0.92,
              -1.42,
              1.40,
              0.34,
              {{-2.28, 0.70}, {-2.24, 1.00}, {-1.5, 1.02}, {0.8, 1.00}, {1.75, 0.90}, {2.18, 0.76}, {2.28, 0.58}},
              {{-2.22, 1.00}, {-1.92, 1.62}, {0.30, 1.66}, {1.10, 0.96}},
              3};
    case VehicleKind::van:
      return {"van",
              0.98,
              -1.65,
              1.62,
              0.34,
              {{-2.65, 0.70}, {-2.62, 1.15}, {-1.5, 1.15}, {1.2, 1.15}, {1.95, 1.08}, {2.45, 0.95}, {2.62, 0.60}},
              {{-2.61, 1.14}, {-2.55, 2.25}, {1.05, 2.25}, {1.90, 1.08}},
              2};
    case VehicleKind::bus:
      return {"bus",
              1.25,
              -3.4,
              3.2,
              0.48,
              {{-5.98, 0.80}, {-5.95, 1.25}, {-3.4, 1.25}, {0, 1.25}, {3.2, 1.25}, {5.85, 1.25}, {5.98, 0.80}},
              {{-5.92, 1.24}, {-5.85, 3.05}, {5.70, 3.05}, {5.84, 1.24}},
              7};
  }
  return {};
}

double beltAt(const std::vector<Point>& belt, double x) {
  for (size_t i = 0; i + 1 < belt.size(); ++i)
    if (x <= belt[i + 1].x) {
      const double share = (x - belt[i].x) / (belt[i + 1].x - belt[i].x);
      return belt[i].z + share * (belt[i + 1].z - belt[i].z);
    }
  return belt.back().z;
}

/// Positions along the body where its cross-section changes: the corners of its belt and its wheel arches.
std::vector<double> stationsOf(const Shape& shape, bool fine) {
  constexpr double kArch[] = {-1, -0.75, 0, 0.75, 1};
  const double reach = shape.wheelRadius + 0.07;
  std::vector<double> stations;
  const auto inArch = [&](double x) {
    return std::abs(x - shape.rearAxle) < reach + 0.05 || std::abs(x - shape.frontAxle) < reach + 0.05;
  };
  for (const Point& p : shape.belt)
    if (!fine || !inArch(p.x)) stations.push_back(p.x);
  for (double axle : {shape.rearAxle, shape.frontAxle})
    for (double at : kArch)
      if (fine) stations.push_back(axle + at * reach);
  std::sort(stations.begin(), stations.end());
  return stations;
}

double undersideAt(const Shape& shape, double x, bool fine) {
  const double reach = shape.wheelRadius + 0.07;
  double z = 0.72 * shape.wheelRadius;
  for (double axle : {shape.rearAxle, shape.frontAxle}) {
    const double square = reach * reach - (x - axle) * (x - axle);
    if (fine && square > 1e-9) z = std::max(z, shape.wheelRadius + std::sqrt(square));
  }
  return z;
}

void addBody(MeshBuilder& builder, const Shape& shape, Surface paint, bool fine) {
  const std::vector<double> stations = stationsOf(shape, fine);
  const double rear = stations.front(), front = stations.back();
  std::vector<Loop> rings;
  for (double x : stations) {
    const double fromEnd = std::min(x - rear, front - x);
    const double taper = fromEnd < 0.5 ? 0.90 + 0.2 * fromEnd : 1;
    const double half = shape.halfWidth * taper, low = undersideAt(shape, x, fine);
    const double high = std::max(beltAt(shape.belt, x), low + 0.08), waist = low + 0.55 * (high - low);
    // Counter-clockwise seen from the front: left is +y.
    rings.push_back({{x, -0.92 * half, low},
                     {x, 0.92 * half, low},
                     {x, half, waist},
                     {x, 0.93 * half, high},
                     {x, -0.93 * half, high},
                     {x, -half, waist}});
  }
  builder.loft(paint, paint, rings);
}

/// Adds roof, pillars and glass as a closed solid that stands in the body.
void addCabin(MeshBuilder& builder, const Shape& shape, Surface paint, bool blind) {
  const double foot = 0.90 * shape.halfWidth, roof = 0.78 * shape.halfWidth + (shape.halfWidth > 0.95 ? 0.1 : 0);
  const auto at = [&](double along, double up, double side) {  // along 0..1 rear to front, up 0..1 foot to roof
    const Point& r0 = shape.cabin[0];
    const Point& r1 = shape.cabin[1];
    const Point& f1 = shape.cabin[2];
    const Point& f0 = shape.cabin[3];
    const double xr = r0.x + up * (r1.x - r0.x), xf = f0.x + up * (f1.x - f0.x);
    const double zr = r0.z + up * (r1.z - r0.z) - 0.06 * (1 - up), zf = f0.z + up * (f1.z - f0.z) - 0.06 * (1 - up);
    return Vec3{xr + along * (xf - xr), side * (foot + up * (roof - foot)), zr + along * (zf - zr)};
  };
  std::vector<double> cuts = {0};
  const int windows = shape.sideWindows;
  for (int i = 0; i < windows; ++i) {
    cuts.push_back((i + 0.07 + (i == 0 ? 0.04 : 0)) / windows);
    cuts.push_back((i + 0.95 - (i + 1 == windows ? 0.04 : 0)) / windows);
  }
  cuts.push_back(1);
  const double rows[] = {0, 0.1, 0.88, 1};
  for (size_t c = 0; c + 1 < cuts.size(); ++c)
    for (int r = 0; r < 3; ++r) {
      const bool open = c % 2 == 1 && r == 1 && (!blind || c + 3 >= cuts.size());
      const Surface surface = open ? Surface::carGlass : paint;
      const auto corner = [&](double along, double up, double side) { return at(along, up, side); };
      builder.quad(surface, corner(cuts[c], rows[r], -1), corner(cuts[c + 1], rows[r], -1),
                   corner(cuts[c + 1], rows[r + 1], -1), corner(cuts[c], rows[r + 1], -1));
      builder.quad(surface, corner(cuts[c + 1], rows[r], 1), corner(cuts[c], rows[r], 1),
                   corner(cuts[c], rows[r + 1], 1), corner(cuts[c + 1], rows[r + 1], 1));
    }
  for (int r = 0; r < 3; ++r) {
    const Surface surface = r == 1 ? Surface::carGlass : paint;
    builder.quad(surface, at(1, rows[r], -1), at(1, rows[r], 1), at(1, rows[r + 1], 1), at(1, rows[r + 1], -1));
    builder.quad(blind ? paint : surface, at(0, rows[r], 1), at(0, rows[r], -1), at(0, rows[r + 1], -1),
                 at(0, rows[r + 1], 1));
  }
  for (size_t c = 0; c + 1 < cuts.size(); ++c) {
    builder.quad(paint, at(cuts[c], 1, -1), at(cuts[c + 1], 1, -1), at(cuts[c + 1], 1, 1), at(cuts[c], 1, 1));
    builder.quad(paint, at(cuts[c], 0, 1), at(cuts[c + 1], 0, 1), at(cuts[c + 1], 0, -1), at(cuts[c], 0, -1));
  }
}

void addWheels(MeshBuilder& builder, const Shape& shape, bool fine) {
  const double radius = shape.wheelRadius, width = 0.21 + 0.1 * (radius - 0.3);
  for (double x : {shape.rearAxle, shape.frontAxle})
    for (double side : {-1.0, 1.0}) {
      const double outside = side * (shape.halfWidth - 0.02), inside = outside - side * width;
      // The tread, and a side wall that narrows towards the rim.
      std::vector<Loop> rings(3);
      for (const Vec3& p : circle({}, 1, fine ? 12 : 8)) {
        rings[0].push_back({x + side * radius * p.x, inside, radius + radius * p.y});
        rings[1].push_back({x + side * radius * p.x, outside, radius + radius * p.y});
        rings[2].push_back({x + side * 0.66 * radius * p.x, outside - side * 0.03, radius + 0.66 * radius * p.y});
      }
      for (Loop& ring : rings) std::reverse(ring.begin(), ring.end());
      builder.loft(Surface::rubber, Surface::rim, rings);
    }
}

void addFittings(MeshBuilder& builder, const Shape& shape) {
  const double rear = shape.belt.front().x, front = shape.belt.back().x, half = 0.86 * shape.halfWidth;
  const double lamp = shape.belt.back().z + 0.04, tail = shape.belt.front().z + 0.06;
  for (double side : {-1.0, 1.0}) {
    const double y0 = side < 0 ? -half : half - 0.34, y1 = y0 + 0.34;
    builder.box(Surface::lampGlass, {front - 0.16, y0, lamp - 0.1}, {front - 0.01, y1, lamp + 0.02});
    builder.box(Surface::paintRed, {rear - 0.01, y0 + 0.04, tail}, {rear + 0.12, y1 - 0.04, tail + 0.13});
    const double mirror = side * (shape.halfWidth + 0.09), z = shape.cabin[3].z + 0.08, x = shape.cabin[3].x - 0.28;
    builder.box(Surface::plastic, {x - 0.05, mirror - 0.1, z}, {x + 0.06, mirror + 0.08, z + 0.14});
  }
  const double low = 0.72 * shape.wheelRadius;
  for (double x : {rear, front})  // bumpers
    builder.box(Surface::plastic, {x - 0.07, -half, low - 0.02}, {x + 0.07, half, low + 0.2});
}

}  // namespace

Mesh vehicleMesh(const Vehicle& vehicle) {
  MeshBuilder builder;
  const Shape shape = shapeOf(vehicle.kind);
  addBody(builder, shape, vehicle.paint, vehicle.fine);
  addCabin(builder, shape, vehicle.paint, vehicle.kind == VehicleKind::van);
  addWheels(builder, shape, vehicle.fine);
  if (vehicle.fine) addFittings(builder, shape);
  return builder.finish(shape.name);
}

}  // namespace gnosphere::town
