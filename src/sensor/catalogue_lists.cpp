// SPDX-License-Identifier: Apache-2.0
#include "sensor/catalogue_lists.hpp"

#include <cmath>
#include <numbers>

#include "base/units.hpp"
#include "base/vector.hpp"
#include "sensor/beams.hpp"
#include "sensor/catalogue_mid360.hpp"

namespace gnosphere {
namespace {

constexpr double kFrame = 0.1;  // seconds

/// A prism that turns about the x axis, along which light reaches the first prism. One of its two faces is inclined.
struct Prism {
  double turnsPerSecond, angleDeg;  ///< the angle is that between the faces
  bool inclinedAtEntry;             ///< whether the inclined face is the one through which light enters
};

/// A head whose beams turning prisms deflect. At the start of the pattern all prisms are thickest on the left (y).
struct PrismHead {
  const char *name, *product, *source, *remarks;
  double rangeMin, rangeMax, rangeAt10Percent;      ///< metres
  double divergenceHorizontal, divergenceVertical;  ///< degrees
  uint32_t returns;
  double beamsPerSecond;
  int frames;         ///< of a tenth of a second, after which the pattern starts anew
  double refraction;  ///< refractive index of the prisms
  std::vector<Prism> prisms;
  std::vector<double> lasers;  ///< z of the unit vectors along which light reaches the first prism; they fire in turn
};

const PrismHead kPrismHeads[] = {
    {"Mid-40",
     "Livox Mid-40",
     "Mid series user manual: 38.4 degrees, 100,000 points per second, 260 m (90 m at 10 %); Livox wiki: divergence of "
     "0.28 degrees vertically, 0.03 horizontally; HELIOS++: two prisms of 18 degrees at 7294 and -4664 turns per "
     "minute",
     "Model of two prisms. Their refractive index, 1.5089, is fitted to scan_mode/mid40.npy of MuJoCo-LiDAR, all of "
     "whose 400,000 directions it meets within 0.00002 degrees. 40 scans, after which the pattern starts anew.",
     1,
     260,
     90,
     0.03,
     0.28,
     1,
     100000,
     40,
     1.5089,
     {{7294.0 / 60, 18, false}, {-4664.0 / 60, 18, true}},
     {0}},
    {"Mid-70",
     "Livox Mid-70",
     "Mid-70 user manual: 70.4 degrees, 100,000 points per second, 0.05 to 260 m (90 m at 10 %), 2 returns; HELIOS++, "
     "scanners_tls.xml: two prisms of 29.7 degrees and of a refractive index of 1.5095 at 7294 and -4664 turns per "
     "minute",
     "Model of two prisms, whose angle HELIOS++ estimates from the field of view. Divergence as Mid-40. 40 scans, "
     "after which the pattern starts anew.",
     0.05,
     260,
     90,
     0.03,
     0.28,
     2,
     100000,
     40,
     1.5095,
     {{7294.0 / 60, 29.7, false}, {-4664.0 / 60, 29.7, true}},
     {0}},
    {"Avia",
     "Livox Avia",
     "Avia specifications: 70.4 x 77.2 degrees, 240,000 points per second, 450 m (190 m at 10 %), 0.28 degrees "
     "vertically, 0.03 horizontally, 3 returns; HELIOS++, scanners_als.xml: three prisms of 30.8856, 29.7735 and "
     "3.1351 "
     "degrees and of a refractive index of 1.51 at -131.5463, 40.8032 and 213.1611 turns per second, directions of six "
     "lasers",
     "Model of three prisms, in the mode that does not repeat. The lasers are taken to fire in turn. 10 scans, after "
     "which the pattern starts anew.",
     1,
     450,
     190,
     0.03,
     0.28,
     3,
     240000,
     10,
     1.51,
     {{-131.5463, 30.8856, true}, {40.8032, 29.7735, true}, {213.1611, 3.1351, true}},
     {-0.0521607, -0.03237635, -0.01079672, 0.01079672, 0.03237635, 0.05300785}},
};

/// The direction of light that comes along `along` and crosses a face, by Snell's law. The face's normal points against
/// the light; `ratio` is the refractive index before the face over the one behind it.
Vec3 refracted(const Vec3& along, const Vec3& normal, double ratio) {
  const double c = -dot(along, normal);
  return ratio * along + (ratio * c - std::sqrt(1 - ratio * ratio * (1 - c * c))) * normal;
}

/// The direction of light behind a prism that is thickest at the angle `turn` about the x axis, from y to z.
Vec3 behind(const Prism& prism, double turn, double refraction, const Vec3& along) {
  const Vec3 across = {-1, 0, 0};
  const double slope = (prism.inclinedAtEntry ? -1 : 1) * std::sin(kDegree * prism.angleDeg);
  const Vec3 inclined = {-std::cos(kDegree * prism.angleDeg), slope * std::cos(turn), slope * std::sin(turn)};
  const Vec3 inside = refracted(along, prism.inclinedAtEntry ? inclined : across, 1 / refraction);
  return refracted(inside, prism.inclinedAtEntry ? across : inclined, refraction);
}

Sensor prismSensor(const PrismHead& head) {
  Sensor sensor;
  sensor.rangeMin = head.rangeMin;
  sensor.rangeMax = head.rangeMax;
  sensor.rangeAt10Percent = head.rangeAt10Percent;
  sensor.divergenceHorizontal = kDegree * head.divergenceHorizontal;
  sensor.divergenceVertical = kDegree * head.divergenceVertical;
  sensor.maxReturns = head.returns;
  sensor.scanPeriod = kFrame;
  const auto beams = static_cast<size_t>(std::lround(kFrame * head.beamsPerSecond));
  for (size_t frame = 0; frame < static_cast<size_t>(head.frames); ++frame) {
    BeamList& list = sensor.patterns.emplace_back();
    for (size_t beam = 0; beam < beams; ++beam) {
      const size_t laser = beam % head.lasers.size();
      const double z = head.lasers[laser];
      // The first beam fires a step after the start, as in the table of the Mid-40.
      const double time = static_cast<double>(frame * beams + beam + 1) / head.beamsPerSecond;
      Vec3 direction = {std::sqrt(1 - z * z), 0, z};
      for (const Prism& prism : head.prisms) {
        const double turns = std::fmod(prism.turnsPerSecond * time, 1.0);
        direction = behind(prism, 2 * std::numbers::pi * turns, head.refraction, direction);
      }
      list.directions.push_back(direction);
      list.times.push_back(static_cast<double>(beam) / head.beamsPerSecond);
      if (head.lasers.size() > 1) list.rings.push_back(static_cast<uint16_t>(laser));
    }
  }
  return sensor;
}

const CatalogueHead kZones = {
    "RS-M1",
    "RoboSense RS-LiDAR-M1",
    {"10Hz"},
    "rs_driver, doc/howto/17_about_point_layout.md: five zones of 126 lines and 125 columns, which fire together, from "
    "top to bottom within a tenth of a second; decoder_RSM1.hpp: 0.2 to 200 m; LeGO-LOAM, issue 284: 120 x 25 degrees "
    "in steps of 0.2",
    "Solid state. Nominal angles: the mirror of a head bends the lines. Zones from the left, each line from the left. "
    "The "
    "ring is the number of the zone. Range at 10 % and divergence: not stated there.",
    0};

/// RoboSense M1: five lasers side by side, each of which a mirror leads through a zone of its own, line by line.
Sensor zonesSensor() {
  constexpr int kLasers = 5, kLines = 126, kColumns = 125;
  constexpr double kStep = 0.2, kWidth = 120;  // degrees
  Sensor sensor;
  sensor.rangeMin = 0.2;
  sensor.rangeMax = 200;
  sensor.maxReturns = 2;
  sensor.scanPeriod = kFrame;
  BeamList& list = sensor.patterns.emplace_back();
  list.width = kLasers * kColumns;
  list.height = kLines;
  for (int line = 0; line < kLines; ++line)
    for (int zone = 0; zone < kLasers; ++zone)
      for (int column = 0; column < kColumns; ++column) {
        const double elevation = kStep * (0.5 * (kLines - 1) - line);
        const double left = kWidth / 2 - zone * (kWidth - kStep * (kColumns - 1)) / (kLasers - 1);
        list.directions.push_back(unitVectorAt(left - kStep * column, elevation));
        list.times.push_back(kFrame * (line * kColumns + column) / (kLines * kColumns));
        list.rings.push_back(static_cast<uint16_t>(zone));
      }
  return sensor;
}

}  // namespace

std::vector<CatalogueHead> listHeads() {
  std::vector<CatalogueHead> heads;
  for (const PrismHead& head : kPrismHeads)
    heads.push_back({head.name, head.product, {"10Hz"}, head.source, head.remarks, head.rangeAt10Percent});
  heads.push_back(mid360Head());
  heads.push_back(kZones);
  return heads;
}

Sensor listHead(const std::string& name) {
  for (const PrismHead& head : kPrismHeads)
    if (head.name == name) return prismSensor(head);
  return name == kZones.name ? zonesSensor() : mid360Sensor();
}

}  // namespace gnosphere
