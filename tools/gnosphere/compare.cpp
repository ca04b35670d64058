// SPDX-License-Identifier: Apache-2.0
#include <memory>

#include "commands.hpp"
#include "console.hpp"
#include "gnosphere/output.hpp"
#include "json.hpp"
#include "output/cloud_format.hpp"

namespace gnosphere::cli {
namespace {

struct CompareOptions {
  std::string reference, other;
  double tolerance = 1e-3;
  bool json = false;
};

void printComparison(const Comparison& c, double tolerance) {
  const auto row = [](const char* name, uint64_t count, const std::string& meaning) {
    std::printf("%-13s %12s  %s\n", name, grouped(count).c_str(), meaning.c_str());
  };
  row("beams", c.beams, "");
  row("hits", c.hits, "of the reference");
  row("missed", c.missed, "only the reference hits");
  row("false", c.falseHits, "only the other hits");
  row("wrong owner", c.wrongOwner, "both hit, another triangle");
  row("wrong range", c.wrongRange,
      formatted("both hit, further apart than the reference's tolerance, or %g m where it has none", tolerance));
  row("ties", c.ties, "set apart by the reference; " + grouped(c.tieDifferences) + " of them differ");
  std::printf("range error   max %.3g m, 99.99 %% %.3g m, RMS %.3g m\n", c.rangeErrorMax, c.rangeError9999,
              c.rangeErrorRms);
  std::printf("%s\n", c.same() ? "the same" : "NOT the same");
}

int runCompare(const CompareOptions& options) {
  const Scan reference = readCloud(options.reference);
  const Comparison comparison = compare(reference, readCloud(options.other), options.tolerance);
  options.json ? void(std::printf("%s", dump(toJson(comparison)).c_str()))
               : printComparison(comparison, options.tolerance);
  return comparison.same() ? 0 : 1;
}

}  // namespace

Action addCompare(CLI::App& app) {
  const auto options = std::make_shared<CompareOptions>();
  app.add_option("A", options->reference, "The cloud to compare with (" + cloudEndings("or", true) + ")")->required();
  app.add_option("B", options->other, "Another cloud of the same beams")->required();
  app.add_option("--tolerance", options->tolerance,
                 "Largest accepted range difference in metres, for beams without a tolerance in A")
      ->capture_default_str();
  app.add_flag("--json", options->json, "Print JSON");
  app.footer(
      "Exit status 0 if no beam differs except A's ties, else 1.\n"
      "Example: gnosphere compare reference.pcd cloud.pcd");
  return [options] { return runCompare(*options); };
}

}  // namespace gnosphere::cli
