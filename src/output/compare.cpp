// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>

#include "base/vector.hpp"
#include "gnosphere/error.hpp"
#include "output/comparison_sum.hpp"
#include "scan/fields.hpp"

namespace gnosphere {
namespace {

void checkFields(const Scan& scan, const char* which) {
  std::string missing;
  for (const Field field : {Field::triangle, Field::instance})
    if (!scan.has(field)) missing += (missing.empty() ? "" : ", ") + std::string(fieldInfo(field).name);
  if (!missing.empty()) {
    throw Error(ErrorCode::invalidArgument, std::string(which) + " lacks what a comparison needs: " + missing +
                                                "; write it with the fields range, beam, triangle, instance");
  }
}

/// Returns the entry of the beam's k-th return, or nothing if the beam has fewer. A hit without a range counts, too.
std::optional<size_t> returnAt(const Scan& scan, size_t beam, size_t k) {
  if (k >= scan.returns || beam >= scan.beamCount()) return {};
  const size_t entry = beam * scan.returns + k;
  return scan.hit(entry) || scan.returned(entry) ? std::optional(entry) : std::nullopt;
}

[[noreturn]] void refuseBeams(const std::string& ofReference, const std::string& ofOther) {
  throw Error(ErrorCode::invalidArgument,
              "the clouds are not of the same beams: the reference has " + ofReference + ", the other " + ofOther);
}
[[noreturn]] void refuseBeams(const Scan& reference, const Scan& other) {
  refuseBeams(std::to_string(reference.beamCount()), std::to_string(other.beamCount()));
}

/// Refuses clouds with two different known grids, in which a beam number means different beams. A scan that a program
/// has put together may have no grid.
void checkGrids(const Scan& reference, const Scan& other) {
  const auto isKnown = [](const Scan& scan) {
    return scan.gridKnown && size_t{scan.columns} * scan.channels == scan.beamCount();
  };
  if (!isKnown(reference) || !isKnown(other)) return;
  if (reference.columns == other.columns && reference.channels == other.channels) return;
  const auto textOf = [](const Scan& scan) {
    return std::to_string(scan.channels) + " channels of " + std::to_string(scan.columns) + " columns";
  };
  refuseBeams(textOf(reference), textOf(other));
}

/// Returns the error of a return that both clouds have: infinity in place of NaN, the error of a hit without a range.
double infiniteIfNaN(double error) {
  return std::isnan(error) ? std::numeric_limits<double>::infinity() : error;
}

/// Whether a cloud has a point for each of its entries.
bool hasPoints(const Scan& scan) {
  return !scan.points.empty() && scan.points.size() == 3 * scan.ranges.size();
}

/// The distance of two points in metres.
double distance(const float* a, const float* b) {
  return lengthOf({double{a[0]} - b[0], double{a[1]} - b[1], double{a[2]} - b[2]});
}

/// Points may be farther apart than the tolerance by the rounding of their coordinates: a share of the range or,
/// because a laser may be away from the origin, a share of the distance from the frame's origin, whichever is more. In
/// files roundingCentre() takes the place of the frame's origin.
constexpr double kPointRounding = 1e-6, kCoordinateRounding = 0x1p-22;

/// Returns the largest number of returns that both clouds may have.
uint64_t mostReturns(const Scan& reference, const Scan& other) {
  return uint64_t{std::max(reference.beamCount(), other.beamCount())} * std::max(reference.returns, other.returns);
}

/// The percentile of the errors that is reported: 99.99 %, in ten thousandths.
constexpr uint64_t kTenThousandths = 9999;

}  // namespace

ComparisonSum::ComparisonSum(uint64_t returns, double tolerance) : tolerance_(tolerance), kept_(returns / 10000 + 1) {
  if (!(tolerance >= 0 && std::isfinite(tolerance)))
    throw Error(ErrorCode::invalidArgument, "the tolerance must be a number of metres from 0 on");
}

void ComparisonSum::add(const Scan& reference, const Scan& other) {
  if (reference.beamCount() != other.beamCount()) refuseBeams(reference, other);
  centre_ = {};
  addBeams(reference, other);
}

void ComparisonSum::add(const CloudFile& reference, const CloudFile& other) {
  const size_t beams = std::max(reference.scan.beamCount(), other.scan.beamCount());
  for (const CloudFile* file : {&reference, &other})
    if (file->statesGrid && file->scan.beamCount() != beams) refuseBeams(reference.scan, other.scan);
  centre_ = roundingCentre(reference, other);
  for (size_t axis = 0; axis < 3; ++axis) centre_[axis] -= reference.origin[axis];
  addBeams(reference.scan, other.scan);
}

void ComparisonSum::addBeams(const Scan& reference, const Scan& other) {
  checkGrids(reference, other);
  checkFields(reference, "the reference cloud");
  checkFields(other, "the other cloud");
  const size_t beams = std::max(reference.beamCount(), other.beamCount());
  sum_.beams += beams;
  ties_ = reference.has(Field::tie) ? reference.column<uint8_t>(Field::tie) : ColumnView<uint8_t>();
  tolerances_ = reference.has(Field::tolerance) ? reference.column<float>(Field::tolerance) : ColumnView<float>();
  points_ = hasPoints(reference) && hasPoints(other);
  const size_t returns = std::max(reference.returns, other.returns);
  for (size_t beam = 0; beam < beams; ++beam)
    for (size_t k = 0; k < returns; ++k) addReturn(reference, other, beam, k);
}

bool ComparisonSum::inTie(size_t beam, size_t returns) const {
  if (ties_.size() < (beam + 1) * returns) return false;
  for (size_t k = 0; k < returns; ++k)
    if (ties_[beam * returns + k] != 0) return true;
  return false;
}

void ComparisonSum::addReturn(const Scan& reference, const Scan& other, size_t beam, size_t k) {
  const std::optional<size_t> expected = returnAt(reference, beam, k), found = returnAt(other, beam, k);
  const bool both = expected && found;
  const bool sameOwner = both && reference.triangles[*expected] == other.triangles[*found] &&
                         reference.instances[*expected] == other.instances[*found];
  const double error =
      both ? infiniteIfNaN(std::abs(double{reference.ranges[*expected]} - double{other.ranges[*found]})) : 0;
  sum_.hits += expected.has_value();
  if (inTie(beam, reference.returns)) {
    sum_.ties += k == 0 || expected || found;
    sum_.tieMissed += expected && !found;
    sum_.tieFalseHits += found && !expected;
    sum_.tieWrongOwner += both && !sameOwner;
    sum_.tieDifferences = sum_.tieMissed + sum_.tieFalseHits + sum_.tieWrongOwner;
    sum_.tieErrorMax = std::max(sum_.tieErrorMax, error);
    return;
  }
  sum_.missed += expected && !found;
  sum_.falseHits += found && !expected;
  if (!both) return;
  double allowed = tolerances_.empty() ? tolerance_ : double{tolerances_[*expected]};
  if (!(allowed >= 0)) allowed = tolerance_;
  sum_.wrongOwner += !sameOwner;
  sum_.wrongRange += error > allowed;
  sum_.hitErrorMax = std::max(sum_.hitErrorMax, error);
  if (points_) addPoints(reference, other, *expected, *found, allowed);
  if (sameOwner) keep(error);
}

void ComparisonSum::addPoints(const Scan& reference, const Scan& other, size_t expected, size_t found, double allowed) {
  const float* const point = &reference.points[3 * expected];
  const double error = infiniteIfNaN(distance(point, &other.points[3 * found]));
  const double rounding =
      std::max(kPointRounding * double{reference.ranges[expected]},
               kCoordinateRounding * lengthOf({point[0] - centre_[0], point[1] - centre_[1], point[2] - centre_[2]}));
  sum_.wrongPoint += !(error <= allowed + rounding);
  sum_.pointErrorMax = std::max(sum_.pointErrorMax, error);
}

void ComparisonSum::keep(double error) {
  ++errors_;
  squares_ += error * error;
  if (largest_.size() == kept_) {
    if (error <= largest_.top()) return;
    largest_.pop();
  }
  largest_.push(error);
}

Comparison ComparisonSum::result() const {
  Comparison result = sum_;
  if (errors_ == 0) return result;
  result.rangeErrorRms = std::sqrt(squares_ / static_cast<double>(errors_));
  // Nearest rank: the smallest error that at least this share of the errors does not exceed.
  const uint64_t rank = (errors_ * kTenThousandths + 9999) / 10000;
  auto largest = largest_;
  while (largest.size() > errors_ - rank + 1) largest.pop();
  result.rangeError9999 = largest.top();
  while (largest.size() > 1) largest.pop();
  result.rangeErrorMax = largest.top();
  return result;
}

Comparison compare(const Scan& reference, const Scan& other, double tolerance) {
  ComparisonSum sum(mostReturns(reference, other), tolerance);
  sum.add(reference, other);
  return sum.result();
}

FileComparison compareFiles(const CloudFile& reference, const CloudFile& other, double tolerance) {
  ComparisonSum sum(mostReturns(reference.scan, other.scan), tolerance);
  sum.add(reference, other);
  return {sum.result(), sum.sameOwner()};
}

Origin roundingCentre(const CloudFile& reference, const CloudFile& other) {
  return reference.floatStep > 0 || other.floatStep > 0 ? Origin{} : reference.origin;
}

std::vector<Field> fieldsNotCompared(const Scan& reference, const Scan& other) {
  constexpr Field kKnown[] = {Field::range,        Field::triangle,    Field::instance, Field::tie, Field::tolerance,
                              Field::returnNumber, Field::returnCount, Field::ring,     Field::beam};
  std::vector<Field> ignored;
  for (const ColumnInfo& column : allColumns()) {
    const Field field = column.field;
    const bool isPoint = field == Field::x || field == Field::y || field == Field::z;
    const bool inBoth = reference.has(field) && other.has(field), inOne = reference.has(field) || other.has(field);
    const bool compared = std::find(std::begin(kKnown), std::end(kKnown), field) != std::end(kKnown);
    if (column.component == 0 && inOne && !compared && !(isPoint && inBoth)) ignored.push_back(field);
  }
  return ignored;
}

}  // namespace gnosphere
