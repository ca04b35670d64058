// SPDX-License-Identifier: Apache-2.0
// Reads Gazebo's <lidar> and <ray> in SDF: azimuths are counter-clockwise from x, both ends of a range of angles are
// beams, and all beams fire at once. A grid has one column per place on the turn; beams of almost a whole turn, whose
// ends are nearer to each other than other neighbours, are a list.
#include <algorithm>
#include <cmath>
#include <iterator>
#include <locale>
#include <sstream>
#include <vector>

#include "base/text.hpp"
#include "base/units.hpp"
#include "sensor/beams.hpp"
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

/// Reads <horizontal> or <vertical>; `usual` is SDF's number of samples where the element states none. Gazebo drops the
/// fraction of a number of beams.
Angles anglesOf(SensorSource& source, const pugi::xml_node& node, double usual) {
  if (!node) return {};
  if (!node.child("samples")) source.assume("<samples> of " + shownNumber(usual) + ", the default of SDF");
  const double samples = number(source, node, "samples", usual), resolution = number(source, node, "resolution", 1);
  const double count = std::floor(samples * resolution);
  if (!(count >= 1 && count <= 1e6))
    source.refuse("<samples> times <resolution> is " + shownNumber(count) + ", expected is 1 to 1000000");
  const Angles angles{number(source, node, "min_angle", 0) / kDegree, number(source, node, "max_angle", 0) / kDegree,
                      static_cast<size_t>(count)};
  if (!(angles.most >= angles.least)) source.refuse("<max_angle> is less than <min_angle>");
  return angles;
}

/// The angle of a row or column, in degrees.
double angleAt(const Angles& angles, size_t i) {
  const double part = angles.count > 1 ? static_cast<double>(i) / static_cast<double>(angles.count - 1) : 0;
  return (1 - part) * angles.least + part * angles.most;
}

BeamList listOf(const Angles& across, const Angles& up) {
  BeamList list;
  list.width = static_cast<uint32_t>(across.count);
  list.height = static_cast<uint32_t>(up.count);
  for (size_t row = 0; row < up.count; ++row)
    for (size_t column = 0; column < across.count; ++column) {
      list.directions.push_back(unitVectorAt(angleAt(across, column), angleAt(up, row)));
      list.rings.push_back(static_cast<uint16_t>(row));
    }
  return list;
}

/// Whether a <pose> leaves the sensor where its link is.
bool isIdentity(const pugi::xml_node& pose) {
  if (*pose.attribute("relative_to").value() != 0) return false;
  std::istringstream text(pose.text().get());
  text.imbue(std::locale::classic());
  std::vector<double> numbers{std::istream_iterator<double>(text), {}};
  const bool isQuaternion = std::string_view(pose.attribute("rotation_format").value()) == "quat_xyzw";
  if (isQuaternion && numbers.size() == 7 && numbers.back() == 1) numbers.pop_back();
  return text.eof() && std::ranges::all_of(numbers, [](double number) { return number == 0; });
}

/// Returns the parameters of the effect range-noise that is the noise of a <lidar>; empty if it is of another kind.
std::string parametersOf(const SensorSource& source, const pugi::xml_node& noise) {
  std::string type(trimmed(noise.child("type").text().get()));
  if (type.empty()) type = std::string(trimmed(noise.attribute("type").value()));
  if (type != "gaussian") return "";
  const double mean = number(source, noise, "mean", 0), sigma = number(source, noise, "stddev", 0);
  return "sigma " + shownNumber(sigma) + (mean != 0 ? " and bias " + shownNumber(mean) : "");
}

/// Notes the sonars of a file as left out.
void nameSonars(SensorSource& source, const pugi::xml_document& document) {
  for (const pugi::xpath_node& sonar : document.select_nodes("//sensor[not(lidar or ray)][sonar or @type='sonar']"))
    source.ignore("the sonar '" + std::string(sonar.node().attribute("name").value()) +
                  "', whose wide beam would be a list of beams: docs/limits.md");
}

}  // namespace

void readSdf(SensorSource& source) {
  const pugi::xml_document document = parseXml(source);
  std::vector<pugi::xml_node> sensors;
  for (const pugi::xpath_node& found : document.select_nodes("//sensor[lidar or ray]")) sensors.push_back(found.node());
  if (sensors.empty()) source.refuse("has no <sensor> with <lidar> or <ray>, as SDF has");
  const pugi::xml_node node = chooseXml(source, sensors, "name", source.options.mode);
  nameSonars(source, document);
  const pugi::xml_node lidar = node.child("lidar") ? node.child("lidar") : node.child("ray");
  const pugi::xml_node scan = lidar.child("scan"), range = lidar.child("range");
  if (!scan.child("horizontal")) source.refuse("<horizontal> of <scan> is missing");
  Angles across = anglesOf(source, scan.child("horizontal"), 640);
  const Angles up = anglesOf(source, scan.child("vertical"), 1);
  if (up.count > 65535) source.refuse("has more than 65535 vertical samples");

  Sensor& sensor = source.file.sensor;
  sensor.name = node.attribute("name").value();
  const double span = across.most - across.least;
  if (across.count > 1 && !(span > 0 && span <= 360 + 1e-3))
    source.refuse("the horizontal angles span " + shownNumber(span) +
                  " degrees; SDF has them in radians, and a turn is 360 degrees");
  double step = across.count > 1 ? span / static_cast<double>(across.count - 1) : 360;
  constexpr double kWhole = 0.02;  // of a step, as decimals of pi allow
  if (across.count > 1 && std::abs(span - 360) <= kWhole * step) {
    --across.count;
    step = 360 / static_cast<double>(across.count);
    source.ignore("the last column, which looks where the first does");
  }
  if (step * static_cast<double>(across.count) > 360 + 1e-9) {
    if (across.count * up.count > 10'000'000) source.refuse("has more than 10000000 beams that are not evenly spaced");
    sensor.patterns.push_back(listOf(across, up));
  } else {
    sensor.columns = static_cast<uint32_t>(across.count);
    sensor.azimuthStartDeg = across.least;
    sensor.azimuthSpanDeg = std::min(step * static_cast<double>(across.count), 360.0);
    for (size_t row = 0; row < up.count; ++row) sensor.channels.push_back({angleAt(up, row)});
  }
  sensor.rangeMin = number(source, range, "min", 0);
  sensor.rangeMax = number(source, range, "max", 0);
  if (!range.child("max")) source.refuse("<max> of <range> is missing");
  // At a rate of 0 SDF scans as often as it can.
  if (const double rate = number(source, node, "update_rate", 0); rate > 0) sensor.scanPeriod = 1 / rate;
  if (node.child("pose") && !isIdentity(node.child("pose"))) source.ignore("pose of the sensor");
  for (const pugi::xml_node& parent : {node, lidar})
    if (parent.child("visibility_mask"))
      source.ignore("the visibility mask of the lidar, which hides a visual with other visibility flags");
  const auto with = [](const std::string& parameters) {
    return ", which the effect `range-noise` with " + parameters + " gives";
  };
  if (const pugi::xml_node noise = lidar.child("noise")) {
    const std::string parameters = parametersOf(source, noise);
    source.ignore("noise of the lidar" + (parameters.empty() ? "" : with(parameters)));
  }
  if (const double raster = number(source, range, "resolution", 0); raster > 0)
    source.ignore("resolution of the ranges of the lidar" + with("step " + shownNumber(raster)));
}

void refuseXml(SensorSource& source) {
  const pugi::xml_document document = parseXml(source);
  source.refuse(std::string("is XML of <") + document.document_element().name() +
                ">, not of a lidar: neither VeloView's <boost_serialization>, nor a <sensor> with <lidar> or <ray> "
                "(SDF), nor a <scanner> (HELIOS++)");
}

}  // namespace gnosphere
