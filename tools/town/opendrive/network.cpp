// SPDX-License-Identifier: Apache-2.0
#include "town/opendrive/network.hpp"

#include <algorithm>
#include <cmath>

#include "town/vehicle.hpp"

namespace gnosphere::town::opendrive {
namespace {

constexpr double kWidest = 100;  ///< metres: a cubic that grows beyond this was meant for a shorter road

/// Returns the width of a lane; `inner` is the absolute distance of its inner edge from the reference line.
double widthOf(const Lane& lane, double ds, double inner) {
  const double width = lane.border.empty() ? valueAt(lane.width, ds) : std::abs(valueAt(lane.border, ds)) - inner;
  return std::clamp(width, 0.0, kWidest);
}

template <typename Item>
const Item* named(const std::vector<Item>& items, const std::string& id) {
  for (const Item& item : items)
    if (item.id == id) return &item;
  return nullptr;
}

}  // namespace

const Lane* LaneSection::find(int id) const {
  for (const Lane& lane : lanes)
    if (lane.id == id) return &lane;
  return nullptr;
}

RoadFrame Road::frame(double s) const {
  const auto next = std::upper_bound(geometries.begin(), geometries.end(), s,
                                     [](double value, const Geometry& geometry) { return value < geometry.s; });
  const Geometry& geometry = next == geometries.begin() ? *next : next[-1];
  const CurvePoint point = geometry.at(s - geometry.s);
  const double roll = valueAt(superelevation, s) / 6.283185307179586;
  const Vec3 level = {-point.along.y, point.along.x, 0};
  return {{point.at.x, point.at.y, valueAt(elevation, s)},
          point.along,
          superelevation.empty() ? level : cosine(roll) * level + Vec3{0, 0, sine(roll)}};
}

const LaneSection& Road::sectionAt(double s) const {
  const auto next = std::upper_bound(sections.begin(), sections.end(), s,
                                     [](double value, const LaneSection& section) { return value < section.s; });
  return next == sections.begin() ? *next : next[-1];
}

std::vector<double> laneEdges(const Road& road, const LaneSection& section, double s) {
  // Lane offsets jump where sections change, so at a section's end the offset just inside it is used.
  const double inset = std::min(1e-6, (section.end - section.s) / 2);
  const double inside = std::max(section.s + inset, std::min(s, section.end - inset));
  const double offset = valueAt(road.laneOffset, inside), ds = s - section.s;
  const size_t count = section.lanes.size();
  size_t centre = 0;
  while (section.lanes[centre].id != 0) ++centre;
  std::vector<double> edges(count + 1);
  edges[centre] = edges[centre + 1] = offset;
  double out = 0;
  for (size_t i = centre; i-- > 0;) edges[i] = offset + (out += widthOf(section.lanes[i], ds, out));
  out = 0;
  for (size_t i = centre + 1; i < count; ++i) edges[i + 1] = offset - (out += widthOf(section.lanes[i], ds, out));
  return edges;
}

LaneMiddle laneMiddle(const Road& road, const LaneSection& section, size_t index, double s) {
  const Lane& lane = section.lanes[index];
  const std::vector<double> edges = laneEdges(road, section, s);
  const double middle = (edges[index] + edges[index + 1]) / 2, width = edges[index] - edges[index + 1];
  double height = 0, rise = 0;                    // of the lane's left edge over its right edge
  if (lane.hasHeight && road.junction.empty()) {  // the surface of a junction has no heights of lanes
    const double inner = valueAt(lane.inner, s - section.s), outer = valueAt(lane.outer, s - section.s);
    height = (inner + outer) / 2;
    rise = lane.id > 0 ? outer - inner : inner - outer;
  }
  const RoadFrame frame = road.frame(s);
  const Vec3 left = width > 0 ? frame.left + Vec3{0, 0, rise / width} : frame.left;
  const Vec3 way = road.frame(std::min(s + kHalfWheelbase, road.length)).point(middle) -
                   road.frame(std::max(s - kHalfWheelbase, 0.0)).point(middle);
  const double run = lengthOf(way.x, way.y);
  const Vec3 along = normalized({frame.along.x, frame.along.y, run > 0 ? way.z / run : 0});
  return {frame.point(middle, height), along, normalized(cross(along, left))};
}

const Road* Network::road(const std::string& id) const {
  return named(roads, id);
}

const Junction* Network::junction(const std::string& id) const {
  return named(junctions, id);
}

}  // namespace gnosphere::town::opendrive
