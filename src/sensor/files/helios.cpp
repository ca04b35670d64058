// SPDX-License-Identifier: Apache-2.0
// Reads scanners of HELIOS++, whose y points forward and z up. The scanner that several <channels> turn around z is a
// grid, and so is one whose mirror sweeps a line while its head turns, as on a tripod. One whose mirror sweeps a line
// and whose head does not turn, as in an aircraft, is a list: of one period of the mirror, or of as many as a scan has.
#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "base/limits.hpp"
#include "base/text.hpp"
#include "base/units.hpp"
#include "base/vector.hpp"
#include "sensor/files/xml.hpp"

namespace gnosphere {
namespace {

constexpr double kMostPulses = 1e6, kMostListed = 1e7;
constexpr double kMirrorRange = 1e4;  ///< metres; HELIOS++ has no limit where none is stated

/// Returns the number in an attribute, the first one if commas separate several.
double attributeOf(const SensorSource& source, const pugi::xml_node& node, const char* name, double otherwise) {
  const pugi::xml_attribute found = node.attribute(name);
  return found ? numberOf(source, cellsOf(found.value())[0], std::string("'") + name + "'") : otherwise;
}

/// A vector of HELIOS++ in our axes.
Vec3 fromHelios(const Vec3& v) {
  return {v.y, -v.x, v.z};
}

/// The direction, in our axes, to which the rotations of a beam's origin lead one of HELIOS++. Their axes are the
/// scanner's, or if the rotations are local, those that the rotations before have turned.
Vec3 turned(const SensorSource& source, const pugi::xml_node& origin, Vec3 d) {
  const auto children = origin.children("rot");
  std::vector<pugi::xml_node> turns(children.begin(), children.end());
  if (sameWord(origin.attribute("rotations").value(), "local")) std::reverse(turns.begin(), turns.end());
  for (const pugi::xml_node& rot : turns) {
    const double angle = kDegree * attributeOf(source, rot, "angle_deg", 0), c = std::cos(angle), s = std::sin(angle);
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
  return fromHelios(d);
}

Vec3 positionOf(const SensorSource& source, const pugi::xml_node& origin) {
  const auto along = [&](const char* name) { return attributeOf(source, origin, name, 0); };
  return fromHelios({along("x"), along("y"), along("z")});
}

/// Lists the attributes of a node that are not read.
void ignoreOthers(SensorSource& source, const pugi::xml_node& node, const std::set<std::string>& read,
                  const std::string& where) {
  for (const pugi::xml_attribute& attribute : node.attributes())
    if (!read.contains(attribute.name())) source.ignore(attribute.name() + where);
}

/// A scanner, and how fast it fires.
struct Scanner {
  pugi::xml_node node;
  std::string name;        ///< for messages: the scanner 'id'
  double pulseRate = 0;    ///< pulses a second
  double headSpeed = 0;    ///< largest, in degrees a second; 0 if the head does not turn
  bool hasMirror = false;  ///< whether a mirror moves the beam
  bool hasChannels = false;

  /// The beams: <channels>, or the scanner itself.
  std::vector<pugi::xml_node> beams() const {
    if (!hasChannels) return {node};
    const auto children = node.child("channels").children("channel");
    return {children.begin(), children.end()};
  }
  /// Where a beam leaves the scanner.
  pugi::xml_node originOf(const pugi::xml_node& beam) const {
    return beam.child("beamOrigin") ? beam.child("beamOrigin") : node.child("beamOrigin");
  }
};

/// The part of "ID:PULSES" that is a number, if no scanner has the whole as its id; then it is cut off the mode.
double pulseRateOf(const SensorSource& source, const std::vector<pugi::xml_node>& scanners, std::string& mode) {
  const auto isId = [&](const pugi::xml_node& node) { return mode == node.attribute("id").value(); };
  const size_t colon = mode.rfind(':');
  if (colon == mode.npos || std::any_of(scanners.begin(), scanners.end(), isId)) return 0;
  const double rate = numberOf(source, mode.substr(colon + 1), "the pulse rate of --mode " + mode);
  if (!(rate > 0)) source.refuse("the pulse rate of --mode " + mode + " is not more than 0");
  mode.resize(colon);
  return rate;
}

/// Returns the scanner that the options ask for; without a mode the first one with several channels, or the first of
/// all.
Scanner chooseScanner(SensorSource& source, const pugi::xml_document& document) {
  std::vector<pugi::xml_node> all, several;
  for (const pugi::xpath_node& found : document.select_nodes("//scanner")) {
    all.push_back(found.node());
    if (found.node().child("channels")) several.push_back(found.node());
  }
  if (all.empty()) source.refuse("has no <scanner>, as HELIOS++ has");
  Scanner scanner;
  std::string mode = source.options.mode;
  scanner.pulseRate = pulseRateOf(source, all, mode);
  scanner.node = chooseXml(source, mode.empty() && !several.empty() ? several : all, "id", mode);
  scanner.name = "the scanner '" + std::string(scanner.node.attribute("id").value()) + "'";
  scanner.hasChannels = static_cast<bool>(scanner.node.child("channels"));
  if (scanner.hasChannels && scanner.beams().empty()) source.refuse(scanner.name + " has no <channel>");
  const std::string rates = scanner.node.attribute("pulseFreqs_Hz").value();
  if (scanner.pulseRate == 0) {
    scanner.pulseRate = attributeOf(source, scanner.node, "pulseFreqs_Hz", 0);
    if (rates.find(',') != rates.npos)
      source.assume("the first of the pulse rates " + rates + "; `gnosphere sensors --mode ID:RATE` takes another");
  }
  if (!(scanner.pulseRate > 0)) source.refuse("'pulseFreqs_Hz' is missing, or not more than 0");
  scanner.headSpeed = attributeOf(source, scanner.node, "headRotatePerSecMax_deg", 0);
  // A spinning head of several channels has a mirror that stands still, in HELIOS++'s terms.
  const bool sweeps = scanner.headSpeed == 0 && attributeOf(source, scanner.node, "scanFreqMax_Hz", 0) > 0;
  scanner.hasMirror = !scanner.hasChannels || sweeps;
  return scanner;
}

void checkHeadAxis(const SensorSource& source, const Scanner& scanner) {
  const pugi::xml_node axis = scanner.node.child("headRotateAxis");
  const auto along = [&](const char* name) { return attributeOf(source, axis, name, 0); };
  if (axis && !(along("x") == 0 && along("y") == 0 && along("z") > 0))
    source.refuse(scanner.name + " has a head that does not turn about z");
}

/// A channel of a grid whose beam looks along `d` while the head looks forward.
Channel channelAlong(const Vec3& d, const Vec3& position) {
  Channel channel;
  channel.elevationDeg = std::asin(std::clamp(d.z, -1.0, 1.0)) / kDegree;
  channel.azimuthOffsetDeg = std::atan2(d.y, d.x) / kDegree;
  // An origin's x points along its beam's azimuth.
  const double c = std::cos(kDegree * channel.azimuthOffsetDeg), s = std::sin(kDegree * channel.azimuthOffsetDeg);
  channel.origin = {c * position.x + s * position.y, c * position.y - s * position.x, position.z};
  return channel;
}

/// Makes a grid of a head that turns: `columns` of them at so many a second.
void setHeadTurn(Sensor& sensor, double columns, double columnRate, double turns) {
  sensor.columns = static_cast<uint32_t>(columns);
  sensor.rotationPeriod = columns / columnRate;
  sensor.scanPeriod = std::max(1 / turns, sensor.rotationPeriod);
  sensor.azimuthStartDeg = 0;
  sensor.azimuthSpanDeg = std::min(360 * columns * turns / columnRate, 360.0);
}

/// Returns the turns of the head in a second.
double turnsOf(SensorSource& source, const Scanner& scanner) {
  checkHeadAxis(source, scanner);
  const double turns = source.options.scanRate > 0 ? source.options.scanRate : scanner.headSpeed / 360;
  if (!(turns > 0)) source.refuse("'headRotatePerSecMax_deg' is missing, and --rate is not given");
  if (source.options.scanRate == 0) source.assume("the head's largest speed; `gnosphere sensors --rate` sets another");
  return turns;
}

/// A spinning head of several channels: all of them fire at each pulse.
void readSpinning(SensorSource& source, const Scanner& scanner) {
  if (source.options.columns > 0)
    source.refuse(scanner.name + " has as many columns as pulses in a turn; --columns is for those with a mirror");
  const double turns = turnsOf(source, scanner), columns = std::floor(scanner.pulseRate / turns + 1e-9);
  if (!(columns >= 1 && columns <= kMostPulses))
    source.refuse("'pulseFreqs_Hz' gives " + shownNumber(columns) + " columns in a turn");
  Sensor& sensor = source.file.sensor;
  setHeadTurn(sensor, columns, scanner.pulseRate, turns);
  const std::vector<pugi::xml_node> beams = scanner.beams();
  const bool hasOwn = std::ranges::any_of(
      beams, [](const pugi::xml_node& beam) { return beam.attribute("rangeMin_m") || beam.attribute("rangeMax_m"); });
  bool fromZero = false;  // whether a channel measures from 0 m, which stands for the sensor's least range
  for (const pugi::xml_node& beam : beams) {
    const pugi::xml_node origin = scanner.originOf(beam);
    Channel channel = channelAlong(turned(source, origin, {0, 1, 0}), positionOf(source, origin));
    const double least = attributeOf(source, beam, "rangeMin_m", sensor.rangeMin);
    fromZero |= least == 0;
    if (hasOwn) {
      channel.rangeMin = least;
      channel.rangeMax = attributeOf(source, beam, "rangeMax_m", sensor.rangeMax);
    }
    ignoreOthers(source, beam, {"id", "rangeMin_m", "rangeMax_m"},
                 " of the channel '" + std::string(beam.attribute("id").value()) + "'");
    sensor.channels.push_back(channel);
  }
  if (fromZero) sensor.rangeMin = 0;  // the other channels have their own
}

/// A pulse of a mirror's period: when it fires, and where it goes before the beam's origin turns it.
struct Pulse {
  double time;
  Vec3 direction;
};

/// Returns the pulses of a period that leave the scanner. As in HELIOS++, a polygon sweeps from -`most` to `most`, and
/// pulses beyond the effective angle do not leave it; an oscillating mirror sweeps there and back; a conic one turns.
std::vector<Pulse> pulsesOf(SensorSource& source, const Scanner& scanner, double mirrorRate) {
  const auto degrees = [&](const char* name, double otherwise) {
    return kDegree * attributeOf(source, scanner.node, name, otherwise / kDegree);
  };
  const std::string optics = lower(scanner.node.attribute("optics").value());
  const double most = degrees("scanAngleMax_deg", 0), effective = degrees("scanAngleEffectiveMax_deg", most);
  if (!(most > 0)) source.refuse("'scanAngleMax_deg' is missing, or not more than 0");
  const double inPeriod = scanner.pulseRate / mirrorRate, count = std::floor(inPeriod + 1e-9);
  if (!(count >= 1 && count <= kMostPulses))
    source.refuse(shownNumber(scanner.pulseRate) + " pulses a second and " + shownNumber(mirrorRate) +
                  " periods of the mirror make " + shownNumber(count) + " pulses in a period");
  std::vector<Pulse> pulses;
  for (double k = 0; k < count; ++k) {
    const double part = k / inPeriod;
    double angle = most;
    if (optics == "rotating") angle = most * (2 * part - 1);
    if (optics == "oscillating") angle = most * (1 - std::abs(2 - 4 * part));
    if (optics == "rotating" && std::abs(angle) > effective + 1e-12) continue;
    Vec3 d = {0, std::cos(angle), std::sin(angle)};
    if (optics == "conic")
      d = {d.z * std::sin(2 * std::numbers::pi * part), d.y, d.z * std::cos(2 * std::numbers::pi * part)};
    pulses.push_back({k / scanner.pulseRate, d});
  }
  if (pulses.empty()) source.refuse("no pulse of " + scanner.name + " is within 'scanAngleEffectiveMax_deg'");
  return pulses;
}

/// Returns the periods of the mirror in a second: `asked`, or if that is 0, the most of them.
double mirrorRateOf(SensorSource& source, const Scanner& scanner, double asked) {
  const double least = attributeOf(source, scanner.node, "scanFreqMin_Hz", 0),
               most = attributeOf(source, scanner.node, "scanFreqMax_Hz", 0);
  if (asked == 0 && !(most > 0)) source.refuse("'scanFreqMax_Hz' is missing, and --columns is not given");
  if (asked == 0) {
    source.assume("the mirror's largest frequency, " + shownNumber(most) +
                  " Hz; `gnosphere sensors --columns` sets another");
    return most;
  }
  if ((most > 0 && asked > most * (1 + 1e-9)) || asked < least * (1 - 1e-9))
    source.refuse("--columns " + std::to_string(source.options.columns) + " make " + shownNumber(asked) +
                  " periods of the mirror in a second; those of " + scanner.name + " are " + shownNumber(least) +
                  " to " + shownNumber(most));
  return asked;
}

/// A head that turns while its mirror sweeps lines upwards: a column is a line.
void readTurningMirror(SensorSource& source, const Scanner& scanner) {
  const double turns = turnsOf(source, scanner),
               mirrorRate = mirrorRateOf(source, scanner, source.options.columns * turns);
  const std::vector<Pulse> pulses = pulsesOf(source, scanner, mirrorRate);
  const double columns = source.options.columns > 0 ? source.options.columns : std::floor(mirrorRate / turns + 1e-9);
  if (!(columns >= 1 && columns <= kMostPulses))
    source.refuse("'scanFreqMax_Hz' gives " + shownNumber(columns) + " columns in a turn");
  const std::vector<pugi::xml_node> beams = scanner.beams();
  if (pulses.size() * beams.size() > limits::kChannels.most)
    source.refuse("has " + std::to_string(pulses.size() * beams.size()) + " pulses in a line, which are channels; " +
                  "at most 65535 are read, so take a smaller pulse rate or more --columns");
  Sensor& sensor = source.file.sensor;
  setHeadTurn(sensor, columns, mirrorRate, turns);
  const bool timed = limits::kSeconds.holds(sensor.rotationPeriod);
  if (!timed) {
    source.assume("that all beams fire at once: a turn takes " + shownNumber(sensor.rotationPeriod) +
                  " s, and that of a sensor at most " + std::to_string(limits::kSeconds.most) + " s");
    sensor.rotationPeriod = 0;
  }
  for (const pugi::xml_node& beam : beams) {
    const pugi::xml_node origin = scanner.originOf(beam);
    const Vec3 position = positionOf(source, origin);
    for (const Pulse& pulse : pulses) {
      Channel channel = channelAlong(turned(source, origin, pulse.direction), position);
      channel.azimuthOffsetDeg += 360 * turns * pulse.time;  // by which the head turns on within the line
      channel.timeOffset = timed ? pulse.time : 0;
      sensor.channels.push_back(channel);
    }
  }
}

/// A mirror that sweeps lines across the way of an aircraft or a car: a row is a period of it.
void readLines(SensorSource& source, const Scanner& scanner) {
  const SensorFileOptions& options = source.options;
  const double mirrorRate =
      mirrorRateOf(source, scanner, options.columns > 0 ? scanner.pulseRate / options.columns : 0);
  const std::vector<Pulse> pulses = pulsesOf(source, scanner, mirrorRate);
  const double period = std::floor(scanner.pulseRate / mirrorRate + 1e-9) / scanner.pulseRate;
  const double periods = options.scanRate > 0 ? std::floor(1 / (options.scanRate * period) + 1e-9) : 1;
  if (!(periods >= 1))
    source.refuse("--rate " + shownNumber(options.scanRate) + ": a scan has at least one period of the mirror, " +
                  shownNumber(period) + " s");
  const std::vector<pugi::xml_node> beams = scanner.beams();
  const double count = periods * static_cast<double>(pulses.size() * beams.size());
  if (count > kMostListed)
    source.refuse("makes " + shownNumber(count) +
                  " beams in a scan; at most 10 million are read, so take a larger --rate");
  source.assume("scans of " + shownNumber(periods * period) + " s, " + shownNumber(periods) +
                " of the mirror's periods; " + shownNumber(1 / (periods * period)) +
                " scans a second leave no gap, and `gnosphere sensors --rate` sets another number");
  source.file.sensor.scanPeriod = periods * period;
  BeamList list;
  list.width = static_cast<uint32_t>(pulses.size());
  list.height = static_cast<uint32_t>(periods) * static_cast<uint32_t>(beams.size());
  for (double p = 0; p < periods; ++p)
    for (size_t beam = 0; beam < beams.size(); ++beam) {
      const pugi::xml_node origin = scanner.originOf(beams[beam]);
      const Vec3 position = positionOf(source, origin);
      for (const Pulse& pulse : pulses) {
        list.directions.push_back(turned(source, origin, pulse.direction));
        list.origins.push_back(position);
        list.times.push_back(p * period + pulse.time);
        list.rings.push_back(static_cast<uint16_t>(beam));
      }
    }
  source.file.sensor.patterns.push_back(std::move(list));
}

/// Takes what scanners of all kinds state. HELIOS++ states one divergence, to 1/e^2.
void readCommon(SensorSource& source, const Scanner& scanner) {
  const pugi::xml_node& node = scanner.node;
  Sensor& sensor = source.file.sensor;
  sensor.name = node.attribute("id").value();
  sensor.divergenceHorizontal = sensor.divergenceVertical = attributeOf(source, node, "beamDivergence_rad", 0);
  const double returns = attributeOf(source, node, "maxNOR", 0);
  sensor.maxReturns = static_cast<uint32_t>(
      returns >= 1 && limits::kReturns.holds(returns) ? returns : static_cast<double>(limits::kReturns.most));
  if (returns != sensor.maxReturns)
    source.assume("at most " + std::to_string(limits::kReturns.most) + " returns a beam, not " +
                  (returns >= 1 ? shownNumber(returns) : "any number of them"));
  sensor.rangeMin = attributeOf(source, node, "rangeMin_m", 0);
  if (node.attribute("rangeMax_m"))
    sensor.rangeMax = attributeOf(source, node, "rangeMax_m", 0);
  else
    assumeRange(source, scanner.hasMirror ? kMirrorRange : 200);
}

}  // namespace

void readHelios(SensorSource& source) {
  const pugi::xml_document document = parseXml(source);
  const Scanner scanner = chooseScanner(source, document);
  const std::string optics = lower(scanner.node.attribute("optics").value());
  const bool rotates = optics == "rotating";
  if (!(scanner.hasMirror ? rotates || optics == "oscillating" || optics == "conic" : rotates))
    source.refuse(scanner.name + " has " + optics + " optics; read are " +
                  (scanner.hasMirror ? "rotating, oscillating and conic ones" : "rotating ones for several channels"));
  readCommon(source, scanner);
  std::set<std::string> read = {
      "id",     "name",       "optics",    "headRotatePerSecMax_deg", "pulseFreqs_Hz", "beamDivergence_rad",
      "maxNOR", "rangeMin_m", "rangeMax_m"};
  if (scanner.hasMirror) read.insert({"scanAngleMax_deg", "scanFreqMin_Hz", "scanFreqMax_Hz"});
  if (scanner.hasMirror && rotates) read.insert("scanAngleEffectiveMax_deg");
  if (!scanner.hasMirror)
    readSpinning(source, scanner);
  else if (scanner.headSpeed > 0)
    readTurningMirror(source, scanner);
  else
    readLines(source, scanner);
  if (source.file.sensor.channels.size() > limits::kChannels.most) source.refuse("there are more than 65535 channels");
  ignoreOthers(source, scanner.node, read, "");
}

}  // namespace gnosphere
