// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <pugixml.hpp>
#include <set>
#include <string>
#include <system_error>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/file.hpp"
#include "base/text.hpp"
#include "gnosphere/error.hpp"
#include "town/opendrive/network.hpp"

namespace gnosphere::town::opendrive {
namespace {

using Node = pugi::xml_node;

// Numbers beyond these limits are mistakes; without limits, sampling every metre or two might not end.
constexpr double kLongestRoad = 2e4, kLongestNetwork = 1e6, kWidestNetwork = 2e4, kFarthest = 1e8, kSharpest = 10,
                 kLargestFactor = 1e8;

/// The file and the road or junction in it that is being read, for messages.
struct Reader {
  std::string file, who;

  [[noreturn]] void fail(const std::string& what) const {
    throw Error(ErrorCode::format, file + ": " + who + (who.empty() ? "" : ": ") + what);
  }

  std::string text(const Node& node, const char* name) const {
    const pugi::xml_attribute attribute = node.attribute(name);
    if (!attribute) fail("<" + std::string(node.name()) + "> has no attribute '" + name + "'");
    return attribute.value();
  }

  double number(const Node& node, const char* name) const { return parsed<double>(node, name, text(node, name)); }
  double number(const Node& node, const char* name, double otherwise) const {
    return node.attribute(name) ? number(node, name) : otherwise;
  }
  int integer(const Node& node, const char* name) const { return parsed<int>(node, name, text(node, name)); }

  double within(const Node& node, const char* name, double low, double high) const {
    const double value = number(node, name);
    if (value < low || value > high)
      fail("<" + std::string(node.name()) + "> has " + name + "=\"" + text(node, name) + "\", which is out of range");
    return value;
  }

 private:
  template <typename Number>
  Number parsed(const Node& node, const char* name, const std::string& value) const {
    const char *begin = value.c_str(), *end = begin + value.size();
    while (begin < end && std::strchr(" \t\r\n+", *begin)) ++begin;
    while (end > begin && std::strchr(" \t\r\n", end[-1])) --end;
    Number number{};
    const auto result = std::from_chars(begin, end, number);
    bool sound = result.ec == std::errc() && result.ptr == end;
    if constexpr (std::is_floating_point_v<Number>) sound = sound && std::isfinite(number);
    if (!sound) fail("<" + std::string(node.name()) + "> has " + name + "=\"" + value + "\", which is not a number");
    return number;
  }
};

/// Reads the cubics of one profile; the attribute `start` holds their distances.
Profile readProfile(const Reader& reader, const Node& parent, const char* name, const char* start) {
  Profile profile;
  for (const Node& node : parent.children(name)) {
    Cubic cubic;
    cubic.start = reader.number(node, start);
    if (!profile.empty() && cubic.start < profile.back().start)
      reader.fail("<" + std::string(name) + "> elements are not in the order of their " + start);
    const auto factor = [&](const char* which) {
      return node.attribute(which) ? reader.within(node, which, -kLargestFactor, kLargestFactor) : 0;
    };
    cubic.a = factor("a");
    cubic.b = factor("b");
    cubic.c = factor("c");
    cubic.d = factor("d");
    profile.push_back(cubic);
  }
  return profile;
}

void readShape(const Reader& reader, const Node& node, Geometry& geometry) {
  const std::string shape = node.name();
  if (shape == "line") {
    geometry.shape = Shape::line;
  } else if (shape == "arc") {
    geometry.shape = Shape::arc;
    geometry.curvature = geometry.curvatureAtEnd = reader.within(node, "curvature", -kSharpest, kSharpest);
  } else if (shape == "spiral") {
    geometry.shape = Shape::spiral;
    geometry.curvature = reader.within(node, "curvStart", -kSharpest, kSharpest);
    geometry.curvatureAtEnd = reader.within(node, "curvEnd", -kSharpest, kSharpest);
  } else if (shape == "poly3") {
    geometry.shape = Shape::poly3;
    geometry.v = {reader.number(node, "a"), reader.number(node, "b"), reader.number(node, "c"),
                  reader.number(node, "d")};
  } else if (shape == "paramPoly3") {
    geometry.shape = Shape::paramPoly3;
    geometry.u = {reader.number(node, "aU"), reader.number(node, "bU"), reader.number(node, "cU"),
                  reader.number(node, "dU")};
    geometry.v = {reader.number(node, "aV"), reader.number(node, "bV"), reader.number(node, "cV"),
                  reader.number(node, "dV")};
    const std::string range = node.attribute("pRange").as_string("normalized");
    if (range != "arcLength" && range != "normalized")
      reader.fail("<paramPoly3> has pRange=\"" + range + "\"; arcLength and normalized are known");
    geometry.parameterRange = range == "arcLength" ? geometry.length : 1;
  } else {
    reader.fail("a geometry of the shape <" + shape + ">; line, arc, spiral, poly3 and paramPoly3 are known");
  }
}

std::string metres(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g m", value);
  return text;
}

/// Checks that each geometry begins where the one before it ends, and that the last ends with the road.
void checkOrder(const Reader& reader, const std::vector<Geometry>& geometries, double length) {
  constexpr double kTolerance = 1;  // metres
  double end = 0;
  const auto check = [&](double next, const std::string& what) {
    if (std::abs(next - end) > kTolerance)
      reader.fail("its reference line is known up to " + metres(end) + ", and " + what + " " + metres(next));
  };
  for (const Geometry& geometry : geometries) {
    check(geometry.s, "the next <geometry> begins at");
    end = geometry.s + geometry.length;
  }
  check(length, "it ends at");
}

std::vector<Geometry> readPlanView(const Reader& reader, const Node& road, double roadLength) {
  std::vector<Geometry> geometries;
  for (const Node& node : road.child("planView").children("geometry")) {
    Geometry geometry;
    geometry.s = reader.within(node, "s", 0, kLongestRoad);
    geometry.length = reader.within(node, "length", 0, kLongestRoad);
    geometry.start = {reader.within(node, "x", -kFarthest, kFarthest), reader.within(node, "y", -kFarthest, kFarthest),
                      0};
    geometry.heading = reader.within(node, "hdg", -1e6, 1e6);
    const Node shape = node.find_child([](const Node& child) {
      return child.type() == pugi::node_element && std::strcmp(child.name(), "userData") != 0;
    });
    if (!shape) reader.fail("a <geometry> without a shape");
    readShape(reader, shape, geometry);
    geometry.length = std::max(geometry.length, 1e-9);  // some exporters link roads by geometries of length 0
    for (double ds : {geometry.length / 2, geometry.length}) {
      const Vec3 end = geometry.at(ds).at - geometry.start;
      if (!(dot(end, end) <= kLongestRoad * kLongestRoad))
        reader.fail("its <" + std::string(shape.name()) + "> leads out of the map");
    }
    geometries.push_back(geometry);
  }
  if (geometries.empty()) reader.fail("its <planView> has no geometry");
  checkOrder(reader, geometries, roadLength);
  return geometries;
}

LaneUse useOf(const std::string& type) {
  if (type == "sidewalk" || type == "walking" || type == "curb") return LaneUse::sidewalk;
  if (type == "border" || type == "median") return LaneUse::verge;
  if (type == "none" || type == "restricted") return LaneUse::none;
  return LaneUse::carriageway;
}

RoadMark readMark(const Reader& reader, const Node& node) {
  RoadMark mark;
  mark.start = reader.number(node, "sOffset", 0);
  mark.width = std::clamp(reader.number(node, "width", 0.12), 0.05, 0.5);
  const std::string type = node.attribute("type").as_string("none");
  const auto kind = [](const std::string& word) {
    return word == "solid" ? MarkKind::solid : word == "broken" ? MarkKind::broken : MarkKind::none;
  };
  const size_t space = type.find(' ');
  mark.kind = kind(type.substr(0, space));
  if (space != std::string::npos) mark.second = kind(type.substr(space + 1));
  return mark;
}

/// Refuses a driving lane that has no room for traffic. Rounded tapers may end a little below zero.
void checkWidth(const Reader& reader, const Lane& lane) {
  constexpr double kRounding = 0.01;  // metres
  const std::string who = "driving lane " + std::to_string(lane.id);
  if (lane.width.empty() && lane.border.empty()) reader.fail(who + " has neither a <width> nor a <border>");
  for (const Cubic& width : lane.width)
    if (width.a < -kRounding) reader.fail(who + " has a width of " + metres(width.a));
}

Lane readLane(const Reader& reader, const Node& node) {
  Lane lane;
  lane.id = reader.integer(node, "id");
  const std::string type = node.attribute("type").as_string("none");
  lane.use = useOf(type);
  lane.driving = type == "driving" || type == "bidirectional" || type == "entry" || type == "exit" ||
                 type == "onRamp" || type == "offRamp" || type == "connectingRamp";
  lane.parking = type == "parking";
  lane.reversed = std::strcmp(node.attribute("direction").as_string("standard"), "reversed") == 0;
  lane.width = readProfile(reader, node, "width", "sOffset");
  if (lane.width.empty()) lane.border = readProfile(reader, node, "border", "sOffset");
  if (lane.driving && lane.id != 0) checkWidth(reader, lane);
  const auto mustBeSorted = [&](bool isSorted, const std::string& name) {
    if (!isSorted)
      reader.fail("lane " + std::to_string(lane.id) + ": <" + name +
                  "> elements are not in the order of their sOffset");
  };
  for (const Node& height : node.children("height")) {
    const double start = reader.number(height, "sOffset");
    mustBeSorted(!lane.hasHeight || start >= lane.inner.back().start, "height");
    lane.inner.push_back({start, reader.number(height, "inner")});
    lane.outer.push_back({start, reader.number(height, "outer")});
    lane.hasHeight = true;
  }
  for (const Node& mark : node.children("roadMark")) lane.marks.push_back(readMark(reader, mark));
  mustBeSorted(std::ranges::is_sorted(lane.marks, {}, &RoadMark::start), "roadMark");
  const Node link = node.child("link");
  if (const Node before = link.child("predecessor")) lane.predecessor = reader.integer(before, "id");
  if (const Node after = link.child("successor")) lane.successor = reader.integer(after, "id");
  return lane;
}

LaneSection readSection(const Reader& reader, const Node& node) {
  LaneSection section;
  section.s = reader.within(node, "s", 0, kLongestRoad);
  for (const char* side : {"left", "center", "right"})
    for (const Node& lane : node.child(side).children("lane")) section.lanes.push_back(readLane(reader, lane));
  std::sort(section.lanes.begin(), section.lanes.end(), [](const Lane& a, const Lane& b) { return a.id > b.id; });
  if (!section.find(0)) reader.fail("a <laneSection> has no lane 0");
  for (size_t i = 0; i + 1 < section.lanes.size(); ++i)
    if (section.lanes[i].id == section.lanes[i + 1].id)
      reader.fail("a <laneSection> has lane " + std::to_string(section.lanes[i].id) + " twice");
  const auto checkSide = [&](const char* side, auto&& isSound) {
    for (const Node& lane : node.child(side).children("lane"))
      if (const int id = reader.integer(lane, "id"); !isSound(id))
        reader.fail("a <laneSection> has lane " + std::to_string(id) + " in its <" + side +
                    ">; ids are positive on the left, 0 in the centre and negative on the right");
  };
  checkSide("left", [](int id) { return id > 0; });
  checkSide("center", [](int id) { return id == 0; });
  checkSide("right", [](int id) { return id < 0; });
  return section;
}

/// Returns the lane as it goes on `distance` metres further, in a section of its own.
Lane continued(const Lane& lane, double distance) {
  Lane further = lane;
  for (Profile* profile : {&further.width, &further.border, &further.inner, &further.outer})
    for (Cubic& cubic : *profile) cubic.start -= distance;
  for (RoadMark& mark : further.marks) mark.start -= distance;
  return further;
}

/// Appends a section to the sections of its road. One with singleSide="true" is valid for the side that has lanes in
/// it, and the other side goes on as it was (ASAM OpenDRIVE 1.8, section 11.3).
void addSection(std::vector<LaneSection>& sections, LaneSection section, bool singleSide) {
  if (singleSide && !sections.empty()) {
    LaneSection& before = sections.back();
    const bool hasLeft = section.lanes.front().id > 0, hasRight = section.lanes.back().id < 0;
    const double since = section.s - before.s;
    for (Lane& lane : before.lanes) {
      if (lane.id == 0 || (lane.id > 0 ? hasLeft : hasRight)) continue;
      section.lanes.push_back(continued(lane, since));
      if (since == 0) continue;  // the section before has no length, and this one takes its place
      section.lanes.back().predecessor = lane.id;
      lane.successor = lane.id;
    }
    std::sort(section.lanes.begin(), section.lanes.end(), [](const Lane& a, const Lane& b) { return a.id > b.id; });
    if (since == 0) sections.pop_back();
  }
  sections.push_back(std::move(section));
}

RoadLink readLink(const Reader& reader, const Node& node) {
  if (!node) return {};
  const std::string type = reader.text(node, "elementType");
  if (type == "junction") return {RoadLink::junction, reader.text(node, "elementId"), true};
  if (type != "road") reader.fail("it is linked to a \"" + type + "\"; road and junction are known");
  return {RoadLink::road, reader.text(node, "elementId"),
          std::strcmp(node.attribute("contactPoint").as_string("start"), "end") != 0};
}

Road readRoad(Reader& reader, const Node& node) {
  constexpr double kRounding = 0.01;  // metres
  Road road;
  reader.who = "a road";
  road.id = reader.text(node, "id");
  reader.who = "road " + road.id;
  road.length = reader.within(node, "length", 0, kLongestRoad);
  const std::string junction = node.attribute("junction").as_string("-1");
  if (junction != "-1") road.junction = junction;
  road.leftHand = std::strcmp(node.attribute("rule").as_string("RHT"), "LHT") == 0;
  road.geometries = readPlanView(reader, node, road.length);
  road.elevation = readProfile(reader, node.child("elevationProfile"), "elevation", "s");
  road.superelevation = readProfile(reader, node.child("lateralProfile"), "superelevation", "s");
  road.laneOffset = readProfile(reader, node.child("lanes"), "laneOffset", "s");
  for (const Node& section : node.child("lanes").children("laneSection")) {
    LaneSection next = readSection(reader, section);
    if (!road.sections.empty() && next.s < road.sections.back().s)
      reader.fail("<laneSection> elements are not in the order of their s");
    if (next.s > road.length + kRounding)
      reader.fail("a <laneSection> begins at " + metres(next.s) + ", and the road ends at " + metres(road.length));
    addSection(road.sections, std::move(next), section.attribute("singleSide").as_bool());
  }
  if (road.sections.empty()) reader.fail("it has no <laneSection>");
  for (size_t i = 0; i < road.sections.size(); ++i)
    road.sections[i].end = i + 1 < road.sections.size() ? road.sections[i + 1].s : road.length;
  road.predecessor = readLink(reader, node.child("link").child("predecessor"));
  road.successor = readLink(reader, node.child("link").child("successor"));
  return road;
}

Junction readJunction(Reader& reader, const Node& node) {
  Junction junction;
  reader.who = "a junction";
  junction.id = reader.text(node, "id");
  reader.who = "junction " + junction.id;
  for (const Node& item : node.children("connection")) {
    Connection connection;
    if (!item.attribute("incomingRoad") || !item.attribute("connectingRoad")) continue;  // virtual or direct
    connection.incoming = reader.text(item, "incomingRoad");
    connection.connecting = reader.text(item, "connectingRoad");
    connection.atStart = std::strcmp(item.attribute("contactPoint").as_string("start"), "end") != 0;
    for (const Node& link : item.children("laneLink"))
      connection.lanes.push_back({reader.integer(link, "from"), reader.integer(link, "to")});
    junction.connections.push_back(std::move(connection));
  }
  return junction;
}

/// Returns the centre of the box around the roads' geometries, in whole metres.
Vec3 middleOf(Reader& reader, const std::vector<Road>& roads) {
  Vec3 low = roads[0].frame(0).at, high = low;
  for (const Road& road : roads) {
    reader.who = "road " + road.id;
    for (const Geometry& geometry : road.geometries) {
      const Vec3 p = road.frame(geometry.s).at;
      low = lowest(low, p);
      high = highest(high, p);
    }
    if (std::max({high.x - low.x, high.y - low.y, high.z - low.z}) > kWidestNetwork)
      reader.fail("with it the roads are more than 20 km apart; cut the map into parts");
  }
  return {std::round((low.x + high.x) / 2), std::round((low.y + high.y) / 2), std::round((low.z + high.z) / 2)};
}

/// Returns the words for the offset of a header.
std::string offsetText(const Vec3& moved, double turned) {
  char text[160];
  std::snprintf(text, sizeof text, "x %.10g, y %.10g, z %.10g m", moved.x + 0.0, moved.y + 0.0,
                moved.z + 0.0);  // no -0
  std::string words = text;
  if (turned != 0) {
    std::snprintf(text, sizeof text, ", then hdg %.10g", turned);
    words += text;
  }
  return words;
}

/// Whether a projection is UTM north of the equator, where all coordinates are positive.
bool isNorthernUtm(const std::string& projection) {
  return projection.find("+proj=utm") != std::string::npos && projection.find("+south") == std::string::npos;
}

/// Moves the middle of the network to the origin.
void centre(Reader& reader, Network& network) {
  const Vec3 middle = middleOf(reader, network.roads);
  for (Road& road : network.roads) {
    for (Geometry& geometry : road.geometries) geometry.start = geometry.start - middle;
    if (road.elevation.empty() && middle.z != 0) road.elevation.push_back({0});
    for (Cubic& cubic : road.elevation) cubic.a -= middle.z;
  }
  network.toFile = network.toFile * place(middle);
}

}  // namespace

Network readNetwork(const std::filesystem::path& file) {
  const std::string text = readWholeFile(file, uint64_t{1} << 30);
  Reader reader{file.string(), {}};
  pugi::xml_document document;
  const pugi::xml_parse_result result = document.load_buffer(text.data(), text.size());
  if (!result)
    reader.fail("line " + std::to_string(lineNumber(text, result.offset)) + ": invalid XML: " + result.description());
  const Node root = document.child("OpenDRIVE");
  if (!root) reader.fail("it is not OpenDRIVE: there is no element <OpenDRIVE>");

  Network network;
  network.file = file.string();
  double length = 0;
  std::set<std::string> roads, junctions;
  const auto checkNew = [&](std::set<std::string>& ids, const std::string& id) {
    if (!ids.insert(id).second) reader.fail("its id is that of another one; give each its own");
  };
  for (const Node& node : root.children("road")) {
    network.roads.push_back(readRoad(reader, node));
    checkNew(roads, network.roads.back().id);
    length += network.roads.back().length;
    if (length > kLongestNetwork) reader.fail("with it the roads are more than 1,000 km long; cut the map into parts");
  }
  for (const Node& node : root.children("junction")) {
    network.junctions.push_back(readJunction(reader, node));
    checkNew(junctions, network.junctions.back().id);
  }
  reader.who.clear();
  if (network.roads.empty()) reader.fail("it has no roads");
  if (const Node offset = root.child("header").child("offset")) {
    reader.who = "header";
    const Vec3 moved = {reader.number(offset, "x", 0), reader.number(offset, "y", 0), reader.number(offset, "z", 0)};
    const double turned = reader.number(offset, "hdg", 0);
    // The data set is translated by x, y, z, then rotated by hdg about the new origin.
    network.toFile = place({}, turned / 6.283185307179586) * place(moved);
    if (dot(moved, moved) > 0 || turned != 0) network.offset = offsetText(moved, turned);
  }
  network.warnings = doubtsOf(network);
  const double northing = (network.toFile * network.roads[0].frame(0).at).y;
  if (!network.offset.empty() && northing < 0 && isNorthernUtm(root.child("header").child("geoReference").text().get()))
    network.warnings.push_back("the header's offset leads to y = " + std::to_string(std::lround(northing)) +
                               " m, and its geoReference, UTM in the north, has no negative ones; netconvert 1.21 and "
                               "older ones state the offset with the wrong sign");
  for (const pugi::xpath_node& found : document.select_nodes("//include"))
    network.warnings.push_back("<include file=\"" + std::string(found.node().attribute("file").value()) +
                               "\"> is not read; put its content into the file");
  centre(reader, network);
  return network;
}

}  // namespace gnosphere::town::opendrive
