// SPDX-License-Identifier: Apache-2.0
#include "town/opendrive/network.hpp"

#include <algorithm>
#include <cmath>

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

double Road::largestCurvature(double from, double to) const {
  double largest = 0;
  for (const Geometry& geometry : geometries)
    if (geometry.s < to && geometry.s + geometry.length > from)
      largest = std::max(largest, geometry.largestCurvature());
  return largest;
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

const Road* Network::road(const std::string& id) const {
  return named(roads, id);
}

const Junction* Network::junction(const std::string& id) const {
  return named(junctions, id);
}

}  // namespace gnosphere::town::opendrive
