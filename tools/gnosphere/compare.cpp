// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <memory>

#include "base/path.hpp"
#include "commands.hpp"
#include "console.hpp"
#include "json.hpp"
#include "output/cloud_file.hpp"
#include "output/cloud_format.hpp"

namespace gnosphere::cli {
namespace {

struct CompareOptions {
  std::string reference, other;
  double tolerance = 1e-3;
  bool json = false;
};

constexpr const char* kNoPoints = "not compared, as not both files have x, y, z";

/// The names of the fields that a comparison ignores.
std::vector<std::string> ignoredFields(const Scan& reference, const Scan& other) {
  std::vector<std::string> names;
  for (const Field field : fieldsNotCompared(reference, other)) names.emplace_back(fieldInfo(field).name);
  return names;
}

std::string joined(const std::vector<std::string>& names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
  return list;
}

bool comparesPoints(const CloudFile& a, const CloudFile& b) {
  return a.scan.has(Field::x) && b.scan.has(Field::x);
}

void printJson(const Comparison& comparison, const CloudFile& a, const CloudFile& b,
               const std::vector<std::string>& ignored) {
  Json json = toJson(comparison);
  if (!comparesPoints(a, b)) json["wrong_point"] = json["point_error_max_m"] = nullptr;
  json["not_compared"] = ignored;
  std::printf("%s", dump(json).c_str());
}

/// By how much points may be further apart than ranges, as in compareFiles().
std::string roundingText(const CloudFile& a, const CloudFile& b) {
  const Origin centre = roundingCentre(a, b);
  return "1e-6 of the range, or 2.4e-7 of the distance from " +
         (centre == Origin{} ? "the origin" : formatted("(%.0f, %.0f, %.0f)", centre[0], centre[1], centre[2])) +
         " if more";
}

void printComparison(const FileComparison& c, const CloudFile& a, const CloudFile& b,
                     const std::vector<std::string>& ignored, double tolerance) {
  const Scan& reference = a.scan;
  const auto line = [](const char* name, const std::string& count, const std::string& meaning) {
    std::printf("%-13s %12s  %s\n", name, count.c_str(), meaning.c_str());
  };
  const auto row = [&](const char* name, uint64_t count, const std::string& meaning) {
    line(name, grouped(count), meaning);
  };
  row("beams", c.beams, a.statesGrid || b.statesGrid ? "" : "at least, as neither file states its grid");
  row("returns", c.hits, "of the reference");
  row("missed", c.missed, "returns of the reference alone");
  row("false", c.falseHits, "returns of the other alone");
  row("wrong owner", c.wrongOwner, "returns of both, another triangle");
  row("wrong range", c.wrongRange,
      reference.has(Field::tolerance)
          ? formatted("further apart than the reference's tolerance, or %g m where it has none", tolerance)
          : formatted("further apart than %g m, as the reference has no field tolerance", tolerance));
  if (comparesPoints(a, b))
    row("wrong point", c.wrongPoint, "x, y, z further apart than that plus " + roundingText(a, b));
  else
    line("wrong point", "-", kNoPoints);
  if (reference.has(Field::tie))
    row("ties", c.ties, "set apart by the reference; " + grouped(c.tieDifferences) + " of them differ");
  else
    line("ties", "-", "not known, as the reference has no field tie");
  if (c.sameOwner > 0)
    std::printf("range error   max %.3g m, 99.99 %% %.3g m, RMS %.3g m\n", c.rangeErrorMax, c.rangeError9999,
                c.rangeErrorRms);
  else
    std::printf("range error   -, as no return has the same triangle in both, ties aside\n");
  if (comparesPoints(a, b))
    std::printf("point error   max %.3g m\n", c.pointErrorMax);
  else
    std::printf("point error   -, %s\n", kNoPoints);
  if (!ignored.empty()) std::printf("not compared  %s\n", joined(ignored).c_str());
  std::printf("%s\n", c.same() ? "the same" : "NOT the same");
}

int runCompare(const CompareOptions& options) {
  const auto [reference, other] = readCloudFiles(pathOf(options.reference), pathOf(options.other));
  const FileComparison comparison = compareFiles(reference, other, options.tolerance);
  warnOfFloats(options.reference, reference.floatStep, "--tolerance", options.tolerance);
  warnOfFloats(options.other, other.floatStep, "--tolerance", options.tolerance);
  const std::vector<std::string> ignored = ignoredFields(reference.scan, other.scan);
  options.json ? printJson(comparison, reference, other, ignored)
               : printComparison(comparison, reference, other, ignored, options.tolerance);
  return comparison.same() ? 0 : 1;
}

}  // namespace

Action addCompare(CLI::App& app) {
  const auto options = std::make_shared<CompareOptions>();
  app.add_option("A", options->reference, "The cloud to compare with (" + cloudEndings("or", true) + ")")->required();
  app.add_option("B", options->other, "Another cloud of the same beams")->required();
  app.add_option("--tolerance", options->tolerance,
                 "Largest accepted difference of ranges and points in metres, for beams without a tolerance in A")
      ->capture_default_str();
  app.add_flag("--json", options->json, "Print JSON");
  app.footer(
      "Exit status 0 if no beam differs except A's ties, 1 if one does, 2 if the clouds cannot be compared.\n"
      "Example: gnosphere compare reference.pcd cloud.pcd");
  return [options] { return runCompare(*options); };
}

}  // namespace gnosphere::cli
