// SPDX-License-Identifier: Apache-2.0
// Reads scanners of two simulators. Gazebo's <lidar> and <ray> in SDF: azimuths are counter-clockwise from x, both ends
// of a range of angles are beams, and all beams fire at once. HELIOS++'s scanners of several channels: y points
// forward, z up, and the head turns counter-clockwise, at its largest speed unless a survey says otherwise.
#include <algorithm>
#include <cmath>
#include <pugixml.hpp>
#include <set>
#include <vector>

#include "base/text.hpp"
#include "base/units.hpp"
#include "base/vector.hpp"
#include "sensor/files/source.hpp"

namespace gnosphere {
namespace {

pugi::xml_document parse(const SensorSource& source) {
  pugi::xml_document document;
  const auto result = document.load_buffer(source.bytes.data(), source.bytes.size());
  if (!result)
    source.refuse("line " + std::to_string(lineNumber(source.bytes, result.offset)) +
                  ": is not XML: " + result.description());
  return document;
}

/// The number in an element of that name, or `otherwise` if there is none.
double number(const SensorSource& source, const pugi::xml_node& parent, const char* name, double otherwise) {
  const pugi::xml_node node = parent.child(name);
  return node ? numberOf(source, trimmed(node.text().get()), std::string("<") + name + ">") : otherwise;
}

/// The number in an attribute, the first of several that commas separate.
double attribute(const SensorSource& source, const pugi::xml_node& node, const char* name, double otherwise) {
  const pugi::xml_attribute found = node.attribute(name);
  return found ? numberOf(source, cellsOf(found.value())[0], std::string("'") + name + "'") : otherwise;
}

/// The one of several nodes whose attribute is the mode that the options ask for, or the first.
pugi::xml_node choose(SensorSource& source, const std::vector<pugi::xml_node>& nodes, const char* attribute) {
  std::string names;
  for (const pugi::xml_node& node : nodes) {
    if (!source.options.mode.empty() && source.options.mode == node.attribute(attribute).value()) return node;
    names.append(names.empty() ? "" : ", ").append(node.attribute(attribute).value());
  }
  if (!source.options.mode.empty()) source.refuse("has no lidar '" + source.options.mode + "', but " + names);
  if (nodes.size() > 1) source.assume("the first of the lidars " + names + "; --mode takes another");
  return nodes[0];
}

/// Angles of a scan in SDF, in degrees.
struct Angles {
  double least = 0, most = 0;
  size_t count = 1;
};

Angles anglesOf(const SensorSource& source, const pugi::xml_node& node) {
  if (!node) return {};
  const double samples = number(source, node, "samples", 1), resolution = number(source, node, "resolution", 1);
  const double count = std::round(samples * resolution);
  if (!(count >= 1 && count <= 1e6))
    source.refuse("<samples> times <resolution> is " + shownNumber(count) + ", expected is 1 to 1000000");
  const Angles angles{number(source, node, "min_angle", 0) / kDegree, number(source, node, "max_angle", 0) / kDegree,
                      static_cast<size_t>(count)};
  if (!(angles.most >= angles.least)) source.refuse("<max_angle> is less than <min_angle>");
  return angles;
}

/// The direction to which turns about axes lead the y axis of HELIOS++, in our axes. The axes are the scanner's, or if
/// the rotations are local, those that the turns before have turned.
Vec3 turned(const SensorSource& source, const pugi::xml_node& origin) {
  Vec3 d = {0, 1, 0};
  const auto children = origin.children("rot");
  std::vector<pugi::xml_node> turns(children.begin(), children.end());
  if (sameWord(origin.attribute("rotations").value(), "local")) std::reverse(turns.begin(), turns.end());
  for (const pugi::xml_node& rot : turns) {
    const double angle = kDegree * attribute(source, rot, "angle_deg", 0), c = std::cos(angle), s = std::sin(angle);
    const std::string axis = lower(rot.attribute("axis").value());
    if (axis == "x")
      d = {d.x, c * d.y - s * d.z, s * d.y + c * d.z};
    else if (axis == "y")
      d = {c * d.x + s * d.z, d.y, c * d.z - s * d.x};
    else if (axis == "z")
      d = {c * d.x - s * d.y, s * d.x + c * d.y, d.z};
    else
      source.refuse("the axis of <rot> is '" + axis + "', expected is x, y or z");
  }
  return {d.y, -d.x, d.z};
}

/// Lists the attributes of a node that are not read.
void ignoreOthers(SensorSource& source, const pugi::xml_node& node, const std::set<std::string>& read,
                  const std::string& where) {
  for (const pugi::xml_attribute& attribute : node.attributes())
    if (!read.contains(attribute.name())) source.ignore(attribute.name() + where);
}

}  // namespace

void readSdf(SensorSource& source) {
  const pugi::xml_document document = parse(source);
  std::vector<pugi::xml_node> sensors;
  for (const pugi::xpath_node& found : document.select_nodes("//sensor[lidar or ray]")) sensors.push_back(found.node());
  if (sensors.empty()) source.refuse("has no <sensor> with <lidar> or <ray>, as SDF has");
  const pugi::xml_node node = choose(source, sensors, "name");
  const pugi::xml_node lidar = node.child("lidar") ? node.child("lidar") : node.child("ray");
  const pugi::xml_node scan = lidar.child("scan"), range = lidar.child("range");
  if (!scan.child("horizontal")) source.refuse("<horizontal> of <scan> is missing");
  Angles across = anglesOf(source, scan.child("horizontal"));
  const Angles up = anglesOf(source, scan.child("vertical"));
  if (up.count > 65535) source.refuse("has more than 65535 vertical samples");

  Sensor& sensor = source.file.sensor;
  sensor.name = node.attribute("name").value();
  // Both ends of the span are beams. Of a whole turn the last one looks where the first does.
  double span = across.most - across.least;
  const double step = across.count > 1 ? span / static_cast<double>(across.count - 1) : 360;
  if (across.count > 1 && span + step > 360 + 1e-9) {
    --across.count;
    source.ignore("the last column, which looks where the first does");
  }
  span = step * static_cast<double>(across.count);
  if (!(span > 0 && span <= 360 + 1e-6)) source.refuse("the horizontal angles span " + shownNumber(span) + " degrees");
  sensor.columns = static_cast<uint32_t>(across.count);
  sensor.azimuthStartDeg = across.least;
  sensor.azimuthSpanDeg = std::min(span, 360.0);
  for (size_t row = 0; row < up.count; ++row) {
    const double part = up.count > 1 ? static_cast<double>(row) / static_cast<double>(up.count - 1) : 0;
    sensor.channels.push_back({(1 - part) * up.least + part * up.most});
  }
  sensor.rangeMin = number(source, range, "min", 0);
  sensor.rangeMax = number(source, range, "max", 0);
  if (!range.child("max")) source.refuse("<max> of <range> is missing");
  for (const char* name : {"pose", "update_rate"})
    if (node.child(name)) source.ignore(std::string(name) + " of the sensor");
  if (lidar.child("noise")) source.ignore("noise of the lidar");
  if (range.child("resolution")) source.ignore("resolution of the ranges");
}

namespace {

/// The one of HELIOS++'s scanners that the options ask for, or the first of several channels. Refuses one that is no
/// spinning head.
pugi::xml_node chooseHead(SensorSource& source, const pugi::xml_document& document) {
  std::vector<pugi::xml_node> all, several;
  for (const pugi::xpath_node& found : document.select_nodes("//scanner")) {
    all.push_back(found.node());
    if (found.node().child("channels")) several.push_back(found.node());
  }
  if (all.empty()) source.refuse("has no <scanner>, as HELIOS++ has");
  const pugi::xml_node node = choose(source, source.options.mode.empty() && !several.empty() ? several : all, "id");
  const std::string optics = node.attribute("optics").value();
  const std::string which = "the scanner '" + std::string(node.attribute("id").value()) + "'";
  if (!node.child("channels") || !sameWord(optics, "rotating"))
    source.refuse(which + " has " + optics + " optics" + (node.child("channels") ? "" : " and one line") +
                  "; only spinning heads of several <channels> are read");
  if (attribute(source, node, "headRotatePerSecMax_deg", 0) == 0 && attribute(source, node, "scanFreqMax_Hz", 0) > 0)
    source.refuse(which + " has a mirror that turns and a head that does not; only spinning heads are read");
  const pugi::xml_node axis = node.child("headRotateAxis");
  const auto along = [&](const char* name) { return attribute(source, axis, name, 0); };
  if (axis && !(along("x") == 0 && along("y") == 0 && along("z") > 0))
    source.refuse(which + " has a head that does not turn about z");
  if (!node.child("channels").child("channel")) source.refuse(which + " has no <channel>");
  return node;
}

/// The channel of a spinning head of HELIOS++. Values that it does not state are the scanner's.
Channel channelOf(SensorSource& source, const pugi::xml_node& scanner, const pugi::xml_node& node) {
  const pugi::xml_node origin = node.child("beamOrigin") ? node.child("beamOrigin") : scanner.child("beamOrigin");
  const Vec3 d = turned(source, origin);
  Channel channel;
  channel.elevationDeg = std::asin(std::clamp(d.z, -1.0, 1.0)) / kDegree;
  channel.azimuthOffsetDeg = std::atan2(d.y, d.x) / kDegree;
  // An origin's x points along its beam's azimuth.
  const double c = std::cos(kDegree * channel.azimuthOffsetDeg), s = std::sin(kDegree * channel.azimuthOffsetDeg);
  const double x = attribute(source, origin, "y", 0), y = -attribute(source, origin, "x", 0);
  channel.origin = {c * x + s * y, c * y - s * x, attribute(source, origin, "z", 0)};
  if (node.attribute("rangeMin_m") || node.attribute("rangeMax_m")) {
    channel.rangeMin = attribute(source, node, "rangeMin_m", source.file.sensor.rangeMin);
    channel.rangeMax = attribute(source, node, "rangeMax_m", source.file.sensor.rangeMax);
  }
  ignoreOthers(source, node, {"id", "rangeMin_m", "rangeMax_m"},
               " of the channel '" + std::string(node.attribute("id").value()) + "'");
  return channel;
}

}  // namespace

void readHelios(SensorSource& source) {
  const pugi::xml_document document = parse(source);
  const pugi::xml_node node = chooseHead(source, document);
  const double turns = source.options.scanRate > 0 ? source.options.scanRate
                                                   : attribute(source, node, "headRotatePerSecMax_deg", 0) / 360;
  if (!(turns > 0)) source.refuse("'headRotatePerSecMax_deg' is missing, and --rate is not given");
  if (source.options.scanRate == 0) source.assume("the head's largest speed; --rate sets another");
  const double pulses = attribute(source, node, "pulseFreqs_Hz", 0);
  if (const std::string rates = node.attribute("pulseFreqs_Hz").value(); rates.find(',') != rates.npos)
    source.assume("the first of the pulse rates " + rates);
  const double columns = std::floor(pulses / turns + 1e-9);
  if (!(columns >= 1 && columns <= 1e6))
    source.refuse("'pulseFreqs_Hz' gives " + shownNumber(columns) + " columns in a turn");

  Sensor& sensor = source.file.sensor;
  sensor.name = node.attribute("id").value();
  sensor.columns = static_cast<uint32_t>(columns);
  sensor.rotationPeriod = columns / pulses;
  sensor.azimuthStartDeg = 0;
  sensor.azimuthSpanDeg = std::min(360 * columns * turns / pulses, 360.0);
  // HELIOS++ states one angle, to 1/e^2.
  sensor.divergenceHorizontal = sensor.divergenceVertical = attribute(source, node, "beamDivergence_rad", 0);
  sensor.maxReturns = static_cast<uint32_t>(std::clamp(attribute(source, node, "maxNOR", 1), 1.0, 5.0));
  sensor.rangeMin = attribute(source, node, "rangeMin_m", 0);
  if (node.attribute("rangeMax_m"))
    sensor.rangeMax = attribute(source, node, "rangeMax_m", 0);
  else
    assumeRange(source, 200);
  for (const pugi::xml_node& channel : node.child("channels").children("channel"))
    sensor.channels.push_back(channelOf(source, node, channel));
  if (sensor.channels.size() > 65535) source.refuse("there are more than 65535 channels");
  ignoreOthers(source, node,
               {"id", "name", "optics", "headRotatePerSecMax_deg", "pulseFreqs_Hz", "beamDivergence_rad", "maxNOR",
                "rangeMin_m", "rangeMax_m"},
               "");
}

void refuseXml(SensorSource& source) {
  const pugi::xml_document document = parse(source);
  source.refuse(std::string("is XML of <") + document.document_element().name() +
                ">, not of a lidar: neither VeloView's <boost_serialization>, nor a <sensor> with <lidar> or <ray> "
                "(SDF), nor a <scanner> (HELIOS++)");
}

}  // namespace gnosphere
