// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "gnosphere/error.hpp"
#include "gnosphere/output.hpp"

namespace gnosphere {
namespace {

void checkFields(const Scan& scan, const char* which) {
  std::string missing;
  const auto need = [&](size_t entries, const char* name) {
    if (entries != scan.beamCount()) missing += (missing.empty() ? "" : ", ") + std::string(name);
  };
  need(scan.triangles.size(), "triangle");
  need(scan.instances.size(), "instance");
  if (!missing.empty()) {
    throw Error(ErrorCode::invalidArgument, std::string(which) + " lacks what a comparison needs: " + missing +
                                                "; write it with the fields range, beam, triangle, instance");
  }
}

bool tieAt(const Scan& scan, size_t beam) {
  return beam < scan.ties.size() && scan.ties[beam] != 0;
}

/// Nearest rank: the smallest error that at least this share of the errors does not exceed.
double percentile(std::vector<double>& errors, double share) {
  const double rank = std::ceil(share * static_cast<double>(errors.size()));
  const auto nth = errors.begin() + static_cast<std::ptrdiff_t>(std::max(rank, 1.0)) - 1;
  std::nth_element(errors.begin(), nth, errors.end());
  return *nth;
}

}  // namespace

Comparison compare(const Scan& reference, const Scan& other, double tolerance) {
  if (!(tolerance >= 0)) throw Error(ErrorCode::invalidArgument, "the tolerance must be at least 0 m");
  if (reference.beamCount() != other.beamCount()) {
    throw Error(ErrorCode::invalidArgument, "the clouds are not of the same beams: the reference has " +
                                                std::to_string(reference.beamCount()) + ", the other " +
                                                std::to_string(other.beamCount()));
  }
  checkFields(reference, "the reference cloud");
  checkFields(other, "the other cloud");

  Comparison result;
  result.beams = reference.beamCount();
  std::vector<double> errors;
  for (size_t b = 0; b < reference.beamCount(); ++b) {
    const bool expected = reference.hit(b);
    const bool found = other.hit(b);
    const bool sameOwner = reference.triangles[b] == other.triangles[b] && reference.instances[b] == other.instances[b];
    result.hits += expected;
    if (tieAt(reference, b)) {
      ++result.ties;
      result.tieDifferences += expected != found || (expected && !sameOwner);
      continue;
    }
    result.missed += expected && !found;
    result.falseHits += found && !expected;
    if (!expected || !found) continue;
    double error = std::abs(double{reference.ranges[b]} - double{other.ranges[b]});
    if (std::isnan(error)) error = std::numeric_limits<double>::infinity();  // a hit without a range is no answer
    double allowed = b < reference.tolerances.size() ? double{reference.tolerances[b]} : tolerance;
    if (!(allowed >= 0)) allowed = tolerance;
    result.wrongOwner += !sameOwner;
    result.wrongRange += error > allowed;
    if (sameOwner) errors.push_back(error);
  }
  if (errors.empty()) return result;
  double squares = 0;
  for (double error : errors) squares += error * error;
  result.rangeErrorRms = std::sqrt(squares / static_cast<double>(errors.size()));
  result.rangeErrorMax = *std::max_element(errors.begin(), errors.end());
  result.rangeError9999 = percentile(errors, 0.9999);
  return result;
}

}  // namespace gnosphere
