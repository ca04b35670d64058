// SPDX-License-Identifier: Apache-2.0
// Checks a device: compares hard cases and a town with the reference, and prints fingerprints of its results to compare
// with other devices and machines.
#include "cases.hpp"
#include "golden.hpp"
#include "hardness.hpp"
#include "variants.hpp"

namespace gnosphere::bench {
namespace {

using cli::Json;

std::string fingerprintOf(const Scan& scan) {
  std::vector<Field> fields = {Field::intensity, Field::label, Field::radialSpeed};
  std::erase_if(fields, [&](Field field) { return !scan.has(field); });
  return hashOf(scan, fields);
}

struct SuiteRow {
  std::string name, accuracy;
  Comparison comparison;
  std::string fingerprint;

  uint64_t wrong() const { return comparison.missed + comparison.falseHits + comparison.wrongRange; }
};

struct Print {
  std::string name, fingerprint;
};

class Suite {
 public:
  explicit Suite(Session& session) : session_(session), options_(session.simulatorOptions()) {}

  /// Compares `standard` and `exact` with the reference; ties may differ except in `exact`.
  void judge(const std::string& name, const Scene& scene, const Sensor& sensor, const Pose& pose) {
    SimulatorOptions options = options_;
    options.device = DeviceChoice::Kind::reference;
    const Scan truth = Simulator(scene, {sensor, Effects::none()}, options).scan(pose);
    options.device = options_.device;
    for (Accuracy accuracy : {Accuracy::standard, Accuracy::exact}) {
      options.accuracy = accuracy;
      Simulator simulator(scene, {sensor, Effects::none()}, options);
      session_.setDevice(simulator.device());
      const Scan scan = simulator.scan(pose);
      rows.push_back({name, nameOf(accuracy), compare(truth, scan), fingerprintOf(scan)});
    }
  }

  /// Adds the fingerprint of an effect with `exact`. The fingerprint is the same everywhere, because the effects use
  /// only operations that every device rounds equally.
  void print(const Variant& variant, const Scene& scene, const Sensor& sensor, const Pose& pose) {
    SimulatorOptions options = options_;
    options.accuracy = Accuracy::exact;
    try {
      Simulator simulator(scene, {sensor, variant.request, {Field::intensity, Field::label}}, options);
      if (!variant.effect.empty() && !simulator.plan().has(variant.effect)) return;
      prints.push_back({variant.name, fingerprintOf(simulator.scan(pose))});
    } catch (const Error& error) {  // not every device supports every effect
      session_.addNote(variant.name + ": " + error.what());
    }
  }

  std::vector<SuiteRow> rows;
  std::vector<Print> prints;

 private:
  Session& session_;
  SimulatorOptions options_;
};

void scanTown(Session& session, Suite& suite) {
  const Scene town = session.scene();
  const std::vector<Pose> poses = session.poses(town);
  for (const Sensor& sensor : session.sensors({"VLP-16", "HDL-64E"}))
    for (size_t i = 0; i < poses.size(); ++i)
      suite.judge("town, " + sensor.name + ", pose " + std::to_string(i + 1), town, sensor, poses[i]);

  Sensor sensor = session.sensors({"VLP-16"})[0];
  sensor.divergenceHorizontal = 0.003;
  sensor.divergenceVertical = 0.0015;
  sensor.rotationPeriod = 0.1;
  sensor.maxReturns = 3;
  const Vec3 at = poses[0].position;
  for (Variant variant : variantsOf({at.x + 15, at.y, at.z})) {
    // Motion within a scan cannot be combined with `exact`.
    variant.request.sensorMotion.use = variant.request.objectMotion.use = EffectUse::off;
    suite.print(variant, town, sensor, poses[0]);
  }
}

Json rowJson(const SuiteRow& row) {
  const Comparison& c = row.comparison;
  return {{"name", row.name},
          {"accuracy", row.accuracy},
          {"beams", c.beams},
          {"hits", c.hits},
          {"ties", c.ties},
          {"missed", c.missed},
          {"false_hits", c.falseHits},
          {"wrong_owner", c.wrongOwner},
          {"wrong_range", c.wrongRange},
          {"range_error_max_m", rounded(c.rangeErrorMax)},
          {"fingerprint", row.fingerprint}};
}

}  // namespace

Report correctness(Session& session) {
  Suite suite(session);
  for (const Family& family : families())
    for (double hardness : {family.hardness.front(), family.hardness[family.hardness.size() / 2]}) {
      const HardCase test = family.make(hardness);
      suite.judge(cli::formatted("%s %g %s", family.title, hardness, family.unit), test.scene, test.sensor, test.pose);
    }
  scanTown(session, suite);

  Report report;
  uint64_t wrong = 0;
  Table judged = {"Except ties, no beam may be missed, false or beyond its tolerance", {}};
  judged.rows = {{"case", "accuracy", "beams", "missed", "false", "wrong range", "largest error, m", "fingerprint"}};
  report.more["effects"] = Json::array();
  for (const SuiteRow& row : suite.rows) {
    const Comparison& c = row.comparison;
    wrong += row.wrong();
    report.more["rows"].push_back(rowJson(row));
    judged.rows.push_back({row.name, row.accuracy, cli::grouped(c.beams), cli::grouped(c.missed),
                           cli::grouped(c.falseHits), cli::grouped(c.wrongRange),
                           cli::formatted("%.2g", c.rangeErrorMax), row.fingerprint});
  }
  Table printed = {"Fingerprints of points, owners, intensities and labels, which are equal on every device",
                   {{"effects", "fingerprint"}}};
  for (const Print& print : suite.prints) {
    report.more["effects"].push_back({{"name", print.name}, {"fingerprint", print.fingerprint}});
    printed.rows.push_back({print.name, print.fingerprint});
  }
  report.more["wrong"] = wrong;
  report.wrong = wrong > 0;
  report.tables = {judged, printed};
  return report;
}

}  // namespace gnosphere::bench
