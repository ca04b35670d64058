// SPDX-License-Identifier: Apache-2.0
// VeloView's db.xml, an archive of boost: degrees, and centimetres.
#include <set>
#include <utility>

#include "base/units.hpp"
#include "sensor/files/xml.hpp"

namespace gnosphere {
namespace {

std::string lineOf(const SensorSource& source, const pugi::xml_node& node) {
  return "line " + std::to_string(lineNumber(source.bytes, node.offset_debug())) + ": ";
}

double numberAt(const SensorSource& source, const pugi::xml_node& parent, const char* key, bool required = false) {
  const pugi::xml_node node = parent.child(key);
  if (!node && !required) return 0;
  if (!node) source.refuse(lineOf(source, parent) + "'" + key + "' is missing");
  return numberOf(source, node.text().get(), lineOf(source, node) + "'" + key + "'");
}

bool hasNonZero(const SensorSource& source, const pugi::xml_node& list) {
  for (const pugi::xml_node& item : list.children("item"))
    if (numberOf(source, item.text().get(), lineOf(source, item) + "item") != 0) return true;
  return false;
}

}  // namespace

void readVelodyneXml(SensorSource& source) {
  const pugi::xml_document document = parseXml(source);
  const pugi::xml_node database = document.child("boost_serialization").child("DB");
  const pugi::xml_node points = database.child("points_");
  if (!points) source.refuse("has no 'boost_serialization/DB/points_', as VeloView's calibrations have");
  std::vector<bool> enabled;
  for (const pugi::xml_node& item : database.child("enabled_").children("item"))
    enabled.push_back(item.text().as_int() != 0);

  constexpr double kMetres = 0.01;
  std::vector<VelodyneLaser> lasers;
  std::set<double> ids;
  size_t disabled = 0;
  std::set<std::string> ignored;
  for (const pugi::xml_node& item : points.children("item")) {
    const pugi::xml_node laser = item.child("px");
    if (!laser) source.refuse(lineOf(source, item) + "'px' is missing");
    const double id = numberAt(source, laser, "id_", true);
    if (!ids.insert(id).second) source.refuse(lineOf(source, laser) + "there are two lasers with this 'id_'");
    if (id >= 0 && id < static_cast<double>(enabled.size()) && !enabled[static_cast<size_t>(id)]) {
      ++disabled;
      continue;
    }
    lasers.push_back({kDegree * numberAt(source, laser, "rotCorrection_"),
                      kDegree * numberAt(source, laser, "vertCorrection_", true),
                      kMetres * numberAt(source, laser, "vertOffsetCorrection_"),
                      kMetres * numberAt(source, laser, "horizOffsetCorrection_")});
    for (const char* key : {"distCorrection_", "distCorrectionX_", "distCorrectionY_", "focalDistance_", "focalSlope_"})
      if (numberAt(source, laser, key) != 0) ignored.insert(key);
  }
  const double count = numberAt(source, points, "count");
  if (points.child("count") && count > static_cast<double>(ids.size()))
    source.refuse(lineOf(source, points) + "'count' is " + points.child("count").text().get() + ", but " +
                  std::to_string(ids.size()) + " lasers follow");
  if (disabled > 0) source.ignore(std::to_string(disabled) + " lasers that are not enabled");
  for (const std::string& key : ignored) source.ignore(key + " of the lasers");
  if (hasNonZero(source, database.child("position_").child("xyz"))) source.ignore("position_ of the head");
  if (hasNonZero(source, database.child("orientation_").child("rpy"))) source.ignore("orientation_ of the head");
  for (const char* key : {"minIntensity_", "maxIntensity_"})
    if (database.child(key)) source.ignore(key);
  fromVelodyneLasers(source, std::move(lasers), kMetres * numberAt(source, database, "distLSB_"));
}

}  // namespace gnosphere
