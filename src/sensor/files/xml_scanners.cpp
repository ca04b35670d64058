// SPDX-License-Identifier: Apache-2.0
// Reads Gazebo's <lidar> and <ray> in SDF: azimuths are counter-clockwise from x, both ends of a range of angles are
// beams, and all beams fire at once.
#include <algorithm>
#include <cmath>
#include <vector>

#include "base/text.hpp"
#include "base/units.hpp"
#include "sensor/files/xml.hpp"

namespace gnosphere {
namespace {

/// The number in an element of that name, or `otherwise` if there is none.
double number(const SensorSource& source, const pugi::xml_node& parent, const char* name, double otherwise) {
  const pugi::xml_node node = parent.child(name);
  return node ? numberOf(source, trimmed(node.text().get()), std::string("<") + name + ">") : otherwise;
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

}  // namespace

void readSdf(SensorSource& source) {
  const pugi::xml_document document = parseXml(source);
  std::vector<pugi::xml_node> sensors;
  for (const pugi::xpath_node& found : document.select_nodes("//sensor[lidar or ray]")) sensors.push_back(found.node());
  if (sensors.empty()) source.refuse("has no <sensor> with <lidar> or <ray>, as SDF has");
  const pugi::xml_node node = chooseXml(source, sensors, "name", source.options.mode);
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

void refuseXml(SensorSource& source) {
  const pugi::xml_document document = parseXml(source);
  source.refuse(std::string("is XML of <") + document.document_element().name() +
                ">, not of a lidar: neither VeloView's <boost_serialization>, nor a <sensor> with <lidar> or <ray> "
                "(SDF), nor a <scanner> (HELIOS++)");
}

}  // namespace gnosphere
