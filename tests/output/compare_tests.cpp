// SPDX-License-Identifier: Apache-2.0
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <cmath>
#include <fstream>
#include <iomanip>
#include <limits>

#include "base/npy.hpp"
#include "bits.hpp"
#include "columns.hpp"
#include "folder.hpp"
#include "output/cloud_file.hpp"
#include "synthetic_scan.hpp"

using namespace gnosphere;
using Catch::Matchers::ContainsSubstring;

namespace {

Scan street() {
  return syntheticScan(builtinSensor("VLP-16"));
}

size_t nthHit(const Scan& scan, size_t n) {
  for (size_t beam = 0;; ++beam) {
    if (scan.hit(beam) && n-- == 0) return beam;
  }
}

size_t nthMiss(const Scan& scan, size_t n) {
  for (size_t beam = 0;; ++beam) {
    if (!scan.hit(beam) && n-- == 0) return beam;
  }
}

void makeMiss(Scan& scan, size_t beam) {
  scan.triangles[beam] = scan.instances[beam] = kNoTriangle;
  scan.ranges[beam] = std::nanf("");
}

void makeHit(Scan& scan, size_t beam, float range, uint32_t triangle) {
  scan.triangles[beam] = triangle;
  scan.instances[beam] = 0;
  scan.ranges[beam] = range;
}

}  // namespace

TEST_CASE("a cloud equals itself") {
  const Scan scan = street();
  const Comparison result = compare(scan, scan);
  CHECK(result.same());
  CHECK(result.beams == 28800);
  CHECK(result.hits == scan.counters.hits);
  CHECK(result.rangeErrorMax == 0);
}

TEST_CASE("every kind of difference has its own count") {
  const Scan reference = street();
  Scan other = reference;
  makeMiss(other, nthHit(reference, 0));
  makeMiss(other, nthHit(reference, 1));
  makeHit(other, nthMiss(reference, 0), 5, 1);
  other.triangles[nthHit(reference, 10)] += 1;
  other.instances[nthHit(reference, 11)] += 1;
  other.ranges[nthHit(reference, 20)] += 0.25f;
  const Comparison result = compare(reference, other);
  CHECK(result.missed == 2);
  CHECK(result.falseHits == 1);
  CHECK(result.wrongOwner == 2);
  CHECK(result.wrongRange == 1);
  CHECK(result.ties == 0);
  CHECK_FALSE(result.same());
  CHECK(std::abs(result.rangeErrorMax - 0.25) < 1e-6);
}

TEST_CASE("beams that the reference marks as ties are counted separately") {
  Scan reference = street();
  ScanColumns columns(reference);
  columns.fill(Field::tie, uint8_t{0});
  Scan other = reference;
  const size_t missed = nthHit(reference, 0), invented = nthMiss(reference, 0), owner = nthHit(reference, 10),
               untouched = nthHit(reference, 11);
  makeMiss(other, missed);
  makeHit(other, invented, 5, 1);
  other.triangles[owner] += 1;
  other.ranges[owner] += 3;
  for (size_t beam : {missed, invented, owner, untouched}) columns.data<uint8_t>(Field::tie)[beam] = 1;
  const Comparison result = compare(reference, other);
  CHECK(result.same());
  CHECK(result.ties == 4);
  CHECK(result.tieDifferences == 3);
  CHECK(result.rangeErrorMax == 0);

  // Ties of the other cloud do not count.
  const Comparison swapped = compare(other, reference);
  CHECK(swapped.ties == 0);
  CHECK_FALSE(swapped.same());
}

TEST_CASE("points may be apart by the tolerance of ranges and the rounding of their coordinates") {
  const Scan reference = street();
  Scan other = reference;
  const size_t beam = nthHit(reference, 7);
  other.points[3 * beam + 1] += 0.25f;
  const Comparison moved = compare(reference, other);
  CHECK(moved.wrongPoint == 1);
  CHECK(moved.wrongRange == 0);
  CHECK(std::abs(moved.pointErrorMax - 0.25) < 1e-6);
  CHECK_FALSE(moved.same());
  CHECK(compare(reference, other, 0.3).same());
  // The same cloud in another frame: every range is the same, and no point.
  for (size_t i = 0; i < reference.points.size(); i += 3) other.points[i] = reference.points[i] + 2;
  CHECK(compare(reference, other).wrongPoint == reference.counters.hits);
  for (float& coordinate : other.points) coordinate = std::nanf("");
  CHECK(compare(reference, other).wrongPoint == reference.counters.hits);
  other.points.clear();
  CHECK(compare(reference, other).same());
  CHECK(fieldsNotCompared(reference, other) == std::vector{Field::x, Field::y, Field::z});
}

TEST_CASE("the tolerance 0 leaves points the rounding of their coordinates") {
  Scan reference;
  reference.columns = reference.channels = 1;
  reference.ranges = {100};
  reference.points = {100, 0, 0};
  reference.triangles = reference.instances = {0};
  Scan other = reference;
  other.points[1] = 0.9e-4f;
  CHECK(compare(reference, other, 0).wrongPoint == 0);
  other.points[1] = 1.1e-4f;
  CHECK(compare(reference, other, 0).wrongPoint == 1);
  // Range noise may leave a range of 0, and the laser may be away from the origin.
  reference.ranges = other.ranges = {0};
  reference.points = other.points = {0.05f, 0, 0.1f};
  other.points[2] = std::nextafter(0.1f, 1.0f);
  CHECK(compare(reference, other, 0).wrongPoint == 0);
  other.points[2] = 0.100001f;
  CHECK(compare(reference, other, 0).wrongPoint == 1);
}

TEST_CASE("fields that a comparison ignores are told, but none that follows from the number of an entry") {
  Scan reference = street();
  ScanColumns(reference).fill(Field::intensity, 1.0f);
  ScanColumns(reference).fill(Field::time, 0.0f);
  ScanColumns(reference).fill(Field::normal, 0.0f);
  ScanColumns(reference).fill(Field::tie, uint8_t{0});
  CHECK(fieldsNotCompared(reference, street()) == std::vector{Field::intensity, Field::normal, Field::time});
  CHECK(fieldsNotCompared(street(), street()).empty());
}

TEST_CASE("a compact file that does not state its grid is compared beam by beam with one that does") {
  const test::Folder folder;
  Scan reference = street();
  for (size_t beam = reference.beamCount() - 50; beam < reference.beamCount(); ++beam) makeMiss(reference, beam);
  CloudOptions compact;
  compact.compact = true;
  writeCloud(reference, folder / "a.pcd", compact);
  CHECK(readCloudFile(folder / "a.pcd").statesGrid);
  const CloudFile whole = readCloudFile(folder / "a.pcd");
  for (const char* name : {"b.npy", "b.csv"}) {
    INFO(name);
    writeCloud(reference, folder / name, compact);
    const CloudFile part = readCloudFile(folder / name);
    REQUIRE(part.scan.beamCount() < whole.scan.beamCount());
    CHECK_FALSE(part.statesGrid);
    for (const Comparison& result : {compareFiles(whole, part, 1e-3), compareFiles(part, whole, 1e-3)}) {
      CHECK(result.same());
      CHECK(result.beams == 28800);
      CHECK(result.hits == whole.scan.counters.hits);
    }
  }
  Scan more = reference;
  makeHit(more, more.beamCount() - 1, 5, 1);
  writeCloud(more, folder / "more.pcd", compact);
  const CloudFile part = readCloudFile(folder / "b.npy");
  CHECK(compareFiles(readCloudFile(folder / "more.pcd"), part, 1e-3).missed == 1);
  // A grid that is stated has no beams beyond it.
  writeCloud(syntheticScan(builtinSensor("VLP-32")), folder / "larger.csv", compact);
  CHECK_THROWS_WITH(compareFiles(whole, readCloudFile(folder / "larger.csv"), 1e-3),
                    ContainsSubstring("not of the same beams"));
}

TEST_CASE("a tie counts once for each return that a cloud has, and once for a beam without any") {
  Scan reference = street();
  reference.columns /= 2;  // half the beams, with two returns each
  reference.returns = 2;
  ScanColumns(reference).fill(Field::tie, uint8_t{0});
  const size_t hit = 2 * (nthHit(reference, 0) / 2), miss = hit + 2;
  makeMiss(reference, hit + 1);
  for (const size_t entry : {miss, miss + 1}) makeMiss(reference, entry);
  for (const size_t entry : {hit, miss}) ScanColumns(reference).data<uint8_t>(Field::tie)[entry] = 1;
  const Comparison result = compare(reference, reference);
  CHECK(result.ties == 2);
  CHECK(result.tieDifferences == 0);
}

TEST_CASE("a tie is one of the beam, so it covers returns that the reference does not have") {
  // Files keep no rows for missing returns, so the reference's mark stands at the first return alone.
  Scan reference = street();
  reference.columns /= 2;  // half the beams, with two returns each
  reference.returns = 2;
  ScanColumns(reference).fill(Field::tie, uint8_t{0});
  const size_t entry = 2 * (nthHit(reference, 0) / 2);
  makeMiss(reference, entry + 1);
  Scan other = reference;
  makeHit(other, entry + 1, 5, 1);
  CHECK(compare(reference, other).falseHits == 1);
  ScanColumns(reference).data<uint8_t>(Field::tie)[entry] = 1;
  const Comparison result = compare(reference, other);
  CHECK(result.same());
  CHECK(result.ties == 2);
  CHECK(result.tieFalseHits == 1);
}

TEST_CASE("a file of several returns keeps the tie of a beam without any") {
  const test::Folder folder;
  Scan reference = street();
  reference.columns /= 2;  // half the beams, with two returns each
  reference.returns = 2;
  ScanColumns(reference).fill(Field::tie, uint8_t{0});
  const size_t entry = 2 * (nthHit(reference, 0) / 2);
  Scan other = reference;
  for (const size_t at : {entry, entry + 1}) makeMiss(reference, at);
  makeHit(other, entry, 5, 1);
  makeMiss(other, entry + 1);
  CloudOptions options;
  options.fields = {Field::range, Field::beam, Field::triangle, Field::instance, Field::returnNumber};
  for (const uint32_t tie : {1u, 0u}) {
    for (const size_t at : {entry, entry + 1}) ScanColumns(reference).data<uint8_t>(Field::tie)[at] = tie == 1;
    CloudOptions withTies = options;
    withTies.fields.push_back(Field::tie);
    for (const char* name : {"a.npy", "a.pcd", "a.ply", "a.csv"}) {
      INFO(name << ", tie " << tie);
      writeCloud(reference, folder / name, withTies);
      writeCloud(other, folder / ("other-" + std::string(name)), options);
      const Comparison result = compare(readCloud(folder / name), readCloud(folder / ("other-" + std::string(name))));
      CHECK(result.same() == (tie == 1));
      CHECK(result.tieFalseHits == tie);
      CHECK(result.falseHits == 1 - tie);
    }
  }
}

TEST_CASE("a cloud of several returns without any is compared with one that has some") {
  const test::Folder folder;
  Scan some = street();
  some.columns /= 2;
  some.returns = 2;
  Scan none = some;
  for (size_t entry = 0; entry < none.ranges.size(); ++entry) makeMiss(none, entry);
  CloudOptions options;
  options.fields = {Field::range, Field::beam, Field::triangle, Field::instance, Field::returnNumber};
  writeCloud(none, folder / "none.pcd", options);
  writeCloud(some, folder / "some.pcd", options);
  const Comparison result = compare(readCloud(folder / "some.pcd"), readCloud(folder / "none.pcd"));
  CHECK(result.hits > 0);
  CHECK(result.missed == result.hits);
}

TEST_CASE("the reference's tolerance of a beam replaces the constant tolerance") {
  Scan reference = street();
  Scan other = reference;
  const size_t beam = nthHit(reference, 5);
  other.ranges[beam] += 0.01f;
  CHECK(compare(reference, other, 0.02).wrongRange == 0);
  CHECK(compare(reference, other, 0.005).wrongRange == 1);
  ScanColumns(reference).fill(Field::tolerance, 0.02f);
  CHECK(compare(reference, other, 0.005).wrongRange == 0);
  ScanColumns(reference).fill(Field::tolerance, 0.005f);
  CHECK(compare(reference, other, 0.02).wrongRange == 1);
  ScanColumns(reference).fill(Field::tolerance, std::nanf(""));  // no tolerance is stated
  CHECK(compare(reference, other, 0.02).wrongRange == 0);
  CHECK(compare(reference, other, 0.005).wrongRange == 1);
}

TEST_CASE("range errors have a maximum, a 99.99th percentile and a root mean square") {
  Scan reference;
  reference.columns = 20000;
  reference.channels = 1;
  for (size_t i = 0; i < 20000; ++i) {
    reference.ranges.push_back(64);
    reference.triangles.push_back(0);
    reference.instances.push_back(0);
  }
  Scan other = reference;
  other.ranges[7] = 68;   // error 4
  other.ranges[9] = 62;   // error 2
  other.ranges[11] = 65;  // error 1; rank 19998 of 20000 is the 99.99th percentile
  const Comparison result = compare(reference, other);
  CHECK(result.rangeErrorMax == 4);
  CHECK(result.rangeError9999 == 1);
  CHECK(std::abs(result.rangeErrorRms - std::sqrt(21.0 / 20000)) < 1e-15);
  // 10000 of 10001 errors are at least 99.99 %, and 9999 are not.
  for (Scan* scan : {&reference, &other})
    for (size_t i = 10001; i < 20000; ++i) {
      scan->ranges[i] = std::numeric_limits<float>::quiet_NaN();
      scan->triangles[i] = kNoTriangle;
    }
  CHECK(compare(reference, other).rangeError9999 == 2);
}

TEST_CASE("the 99.99th percentile is that of all returns, of which beams may have several") {
  Scan reference;
  reference.columns = 20000;
  reference.channels = 1;
  reference.returns = 3;
  reference.ranges.assign(60000, 64);
  reference.triangles.assign(60000, 0);
  reference.instances.assign(60000, 0);
  Scan other = reference;
  for (size_t i = 0; i < 10; ++i) other.ranges[1000 * i] = 64.0f + float(i);
  // Nine errors from 1 to 9 m; rank 59,994 of 60,000 leaves six larger ones.
  CHECK(compare(reference, other).rangeError9999 == 3);
}

TEST_CASE("a hit without a range counts as wrong") {
  const Scan reference = street();
  Scan other = reference;
  other.ranges[nthHit(reference, 3)] = std::nanf("");
  CHECK_FALSE(compare(reference, other).same());
}

TEST_CASE("files with coordinates far from the origin are compared to the millimetre") {
  const test::Folder folder;
  const std::string ending = GENERATE("csv", "pcd", "npy");
  // Two points as in UTM; those of the other file are 3 mm, or 30 cm, higher.
  const auto write = [&](const std::string& name, double higher) {
    const double points[2][3] = {{500'012.3456, 5'400'034.5678, 123.4567 + higher},
                                 {500'001.2345, 5'400'002.3456, 99.8765}};
    std::ofstream out(folder / (name + "." + ending), std::ios::binary);
    if (ending == "csv") {
      out << std::setprecision(17) << "x,y,z,range,beam,triangle,instance\n";
    } else if (ending == "pcd") {
      out << "FIELDS x y z range beam triangle instance\nSIZE 8 8 8 4 4 4 4\nTYPE F F F F U U U\nWIDTH 2\nHEIGHT 1\n"
             "DATA binary\n";
    } else {
      out << npyHeaderOf(
          "[('x', '<f8'), ('y', '<f8'), ('z', '<f8'), ('range', '<f4'), ('beam', '<u4'), ('triangle', '<u4'), "
          "('instance', '<u4')]",
          "(2,)");
    }
    for (uint32_t i = 0; i < 2; ++i) {
      const float range = 20;
      const uint32_t numbers[3] = {i, i, 0};
      if (ending == "csv") {
        for (const double x : points[i]) out << x << ',';
        out << range << ',' << i << ',' << i << ",0\n";
      } else {
        out.write(reinterpret_cast<const char*>(points[i]), sizeof(points[i]));
        out.write(reinterpret_cast<const char*>(&range), sizeof(range));
        out.write(reinterpret_cast<const char*>(numbers), sizeof(numbers));
      }
    }
    return folder / (name + "." + ending);
  };
  const std::filesystem::path a = write("a", 0), b = write("b", 0.003), c = write("c", 0.3);
  for (const auto& [other, apart] : {std::pair(a, 0.0), std::pair(b, 0.003), std::pair(c, 0.3)}) {
    const auto [one, two] = readCloudFiles(a, other);
    CHECK(one.origin == Origin{499'712, 5'399'552, 0});
    CHECK(two.origin == one.origin);
    CHECK(one.floatStep == 0);
    CHECK(roundingCentre(one, two) == one.origin);
    const FileComparison result = compareFiles(one, two, 1e-3);
    CHECK(result.wrongPoint == (apart > 0));
    CHECK(std::abs(result.pointErrorMax - apart) < 1e-4);
    CHECK(result.wrongRange == 0);
  }
  CHECK(readCloudFile(a).origin == Origin{});
}

TEST_CASE("points of files that hold floats may be apart by the floats' steps") {
  const test::Folder folder;
  Scan reference = street();
  for (size_t i = 0; i < reference.points.size(); ++i) reference.points[i] += i % 3 == 1 ? 5'400'000 : 0;
  Scan other = reference;
  for (float& x : other.points) x = std::nextafter(x, 1e9f);
  for (const std::string ending : {"pcd", "ply", "npy", "csv"}) {
    INFO(ending);
    writeCloud(reference, folder / ("a." + ending));
    writeCloud(other, folder / ("b." + ending));
    const auto [a, b] = readCloudFiles(folder / ("a." + ending), folder / ("b." + ending));
    CHECK(a.floatStep == 0.5);
    CHECK(b.floatStep == 0.5);
    CHECK(roundingCentre(a, b) == Origin{});
    const FileComparison result = compareFiles(a, b, 1e-3);
    CHECK(result.wrongPoint == 0);
    CHECK(result.pointErrorMax >= 0.5);
  }
}

TEST_CASE("files with coordinates near the origin are taken from the frame's") {
  const test::Folder folder;
  const Scan reference = street();
  writeCloud(reference, folder / "a.pcd");
  writeCloud(reference, folder / "b.csv");
  const auto [a, b] = readCloudFiles(folder / "a.pcd", folder / "b.csv");
  CHECK(a.origin == Origin{});
  CHECK(test::sameFloats(a.scan.points, reference.points));
  CHECK(test::sameFloats(b.scan.points, reference.points));
}

TEST_CASE("clouds of different beams, or without the arrays to compare, are refused") {
  const Scan reference = street();
  CHECK_THROWS_WITH(compare(reference, syntheticScan(builtinSensor("VLP-32"))),
                    ContainsSubstring("28800") && ContainsSubstring("115200"));
  const auto wall = [](uint32_t columns, uint32_t channels) {
    return syntheticScan(Sensor{"grid", columns, std::vector<Channel>(channels), 0, 100});
  };
  const Scan one = wall(360, 1), two = wall(180, 2);
  CHECK_THROWS_WITH(compare(one, two),
                    ContainsSubstring("1 channels of 360 columns") && ContainsSubstring("2 channels of 180 columns"));
  const test::Folder folder;  // a file without the grid has the beams of any
  CloudOptions options;
  options.fields = parseFields("x,y,z,range,triangle,instance");
  writeCloud(two, folder / "two.csv", options);
  const Scan list = readCloud(folder / "two.csv");
  CHECK_FALSE(list.gridKnown);
  CHECK(compare(two, list).same());
  Scan poor = reference;
  poor.triangles.clear();
  CHECK_THROWS_WITH(compare(reference, poor), ContainsSubstring("the other cloud") && ContainsSubstring("triangle"));
  CHECK_THROWS_WITH(compare(poor, reference), ContainsSubstring("the reference cloud"));
  for (const double tolerance : {std::nan(""), double{INFINITY}, -1e-3})
    CHECK_THROWS_WITH(compare(reference, reference, tolerance), ContainsSubstring("number of metres from 0 on"));
}

TEST_CASE("two clouds without beams are equal") {
  CHECK(compare(Scan{}, Scan{}).same());
}
