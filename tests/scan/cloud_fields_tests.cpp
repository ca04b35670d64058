// SPDX-License-Identifier: Apache-2.0
// Fields that effects add to a cloud, and several returns per beam.
#include <array>
#include <bit>
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <cstdlib>
#include <map>
#include <numbers>
#include <numeric>

#include "cloud_support.hpp"
#include "output/cloud_table.hpp"
#include "problem.hpp"
#include "scan/computed_columns.hpp"
#include "scan/fields.hpp"

using namespace gnosphere;
using namespace gnosphere::test;
using Catch::Matchers::ContainsSubstring;

namespace {

const std::string kEveryField = [] {
  std::string names;
  for (const ColumnInfo& column : allColumns())
    if (column.component == 0) names += (names.empty() ? "" : ",") + std::string(column.fieldName);
  return names;
}();

Sensor smallSensor() {
  Sensor sensor;
  sensor.name = "small";
  sensor.columns = 4;
  sensor.rangeMax = 50;
  sensor.rotationPeriod = 0.1;
  sensor.channels = {{-10, 0}, {30, 5}};
  sensor.channels[1].timeOffset = 0.001;
  return sensor;
}

constexpr Field kFloats[] = {Field::tolerance, Field::intensity,    Field::trueRange, Field::width,      Field::normal,
                             Field::incidence, Field::barycentrics, Field::velocity,  Field::radialSpeed};
const std::vector<Field> kComputed = {Field::classId, Field::time, Field::azimuth, Field::elevation};

/// A scan of four columns and two channels with every column is there. The return of beam 2 comes from the medium.
Scan full(uint32_t returns) {
  Scan scan;
  scan.sensor = "small";
  scan.columns = 4;
  scan.channels = 2;
  scan.returns = returns;
  float next = 0.1f;
  const auto add = [&](bool is, std::vector<float>& to, size_t count = 1) {
    for (size_t i = 0; i < count; ++i) to.push_back(is ? next += 1.7f : std::nanf(""));
  };
  constexpr uint32_t kCounts[] = {2, 0, 1, 5, 0, 1, 2, 1};
  std::map<Field, std::vector<float>> floats;
  std::vector<uint32_t> materials;
  std::vector<uint8_t> ties, labels, causes;
  for (uint32_t beam = 0; beam < 8; ++beam) {
    const uint32_t count = std::min(kCounts[beam], returns);
    for (uint32_t k = 0; k < returns; ++k) {
      const bool is = k < count;
      const bool scattered = is && beam == 2;
      add(is, scan.points, 3);
      add(is, scan.ranges);
      for (const Field field : kFloats) add(is, floats[field], fieldInfo(field).components);
      scan.triangles.push_back(is && !scattered ? 10 * beam + k : kNoTriangle);
      scan.instances.push_back(is && !scattered ? beam / 2 : kNoTriangle);
      materials.push_back(is && !scattered ? 3 : kNoTriangle);
      labels.push_back(static_cast<uint8_t>(!is ? Label::none : scattered ? Label::scatter : Label::solid));
      causes.push_back(static_cast<uint8_t>(count > 0 ? Cause::returned : Cause::weak));
      ties.push_back(is && beam == 5);
    }
  }
  for (const auto& [field, values] : floats) setColumn(scan, field, values);
  setColumn(scan, Field::material, materials);
  setColumn(scan, Field::label, labels);
  setColumn(scan, Field::cause, causes);
  setColumn(scan, Field::tie, ties);
  ClassTable classes;
  classes.setMesh(0, {});
  for (size_t i = 0; i < 3; ++i) classes.setInstance(i, 0, std::array<uint16_t, 3>{500, 1, 65535}[i]);
  ComputedColumns(smallSensor(), kComputed).set(classes, 0, scan);
  return scan;
}

CloudOptions withFields(const std::string& names) {
  CloudOptions options;
  options.fields = parseFields(names);
  return options;
}

}  // namespace

TEST_CASE("every field and every return reads back to the same bits from every format") {
  const Folder folder;
  const std::string ending = GENERATE("pcd", "ply", "npy", "csv");
  CloudOptions options = withFields(kEveryField);
  options.ascii = GENERATE(false, true);
  const uint32_t returns = GENERATE(1u, 2u, 5u);
  const Scan scan = full(returns);
  writeCloud(scan, folder / ("a." + ending), options);
  const Scan back = readCloud(folder / ("a." + ending));
  CHECK(back.returns == returns);
  CHECK(back.columns == 4);
  CHECK(back.channels == 2);
  CHECK(sameFloats(back.points, scan.points));
  CHECK(sameFloats(back.ranges, scan.ranges));
  for (const Field field : kFloats) CHECK(sameFloats(valuesOf<float>(back, field), valuesOf<float>(scan, field)));
  for (const Field field : {Field::triangle, Field::instance, Field::material})
    CHECK(valuesOf<uint32_t>(back, field) == valuesOf<uint32_t>(scan, field));
  for (const Field field : {Field::tie, Field::label})
    CHECK(valuesOf<uint8_t>(back, field) == valuesOf<uint8_t>(scan, field));
  CHECK(valuesOf<uint16_t>(back, Field::classId) == valuesOf<uint16_t>(scan, Field::classId));
  // A file of several returns has no rows of beams without any.
  CHECK(back.has(Field::cause) == (returns == 1));
  if (returns == 1) CHECK(valuesOf<uint8_t>(back, Field::cause) == valuesOf<uint8_t>(scan, Field::cause));
  for (const Field field : {Field::time, Field::azimuth, Field::elevation})
    for (size_t entry = 0; entry < scan.ranges.size(); ++entry) {
      if (returns == 1 || scan.returned(entry))
        CHECK(back.column<float>(field)[entry] == scan.column<float>(field)[entry]);
    }
  CHECK(back.counters.hits == 6);
  CHECK(compare(scan, back).same());
}

TEST_CASE("a field is one column, a vector has one column per component") {
  const Folder folder;
  writeCloud(full(1), folder / "a.csv", withFields(kEveryField));
  const std::string text = bytesOf(folder / "a.csv");
  CHECK(text.substr(0, text.find('\n')) ==
        "x,y,z,range,ring,beam,triangle,instance,tie,tolerance,intensity,true_range,cause,label,return,returns,width,"
        "normal_x,normal_y,normal_z,incidence,material,u,v,class,velocity_x,velocity_y,velocity_z,radial_speed,time,"
        "azimuth,elevation");
  CHECK_THROWS_WITH(parseFields("normal_x"), "'normal_x' is a column of the field normal; ask for normal");
  CHECK_THROWS_WITH(parseFields("normal,Normal"), ContainsSubstring("twice"));
}

TEST_CASE("times, angles and classes follow from the sensor and the instances") {
  const Folder folder;
  writeCloud(full(1), folder / "a.csv", withFields("beam,class,time,azimuth,elevation"));
  CloudTable table = readCsv(bytesOf(folder / "a.csv"), "a.csv");
  REQUIRE(table.rows == 8);
  const Sensor sensor = smallSensor();
  for (size_t b = 0; b < 8; ++b) {
    INFO("beam " << b);
    const auto value = [&](const char* name) { return table.value(*table.find(name), b); };
    const Vec3 d = sensor.direction(b);
    const double turned = value("azimuth") - std::atan2(d.y, d.x);
    CHECK(std::abs(std::remainder(turned, 2 * std::numbers::pi)) < 1e-6);
    CHECK(std::abs(value("elevation") - std::asin(d.z)) < 1e-6);
    CHECK(value("time") == static_cast<float>(0.1 * static_cast<double>(b % 4) / 4 + (b < 4 ? 0 : 0.001)));
    // Beam b hits instance b / 2 if it hits any; instance 3 has no class.
    CHECK(value("class") == (b == 0 ? 500 : b == 3 ? 1 : b == 5 ? 65535 : 0));
  }
}

// The orientation of the pose turns the x axis to y, y to z and z to x.
TEST_CASE("a scan in the world frame has its points, normals and velocities turned, and its points moved") {
  const uint32_t returns = GENERATE(1u, 2u);
  Scan scan = full(returns);
  scan.pose = {{10, 20, 30}, {0.5, 0.5, 0.5, 0.5}};
  const Scan world = inWorld(scan);
  const auto checkTurned = [&](const auto& valueOf, const auto& worldValueOf, const std::array<double, 3>& moved) {
    for (size_t entry = 0; entry < scan.ranges.size(); ++entry)
      for (uint32_t axis = 0; axis < 3; ++axis) {
        const auto wanted = static_cast<float>(valueOf(entry, (axis + 2) % 3) + moved[axis]);
        const float found = worldValueOf(entry, axis);
        CHECK((found == wanted || (std::isnan(found) && std::isnan(wanted))));
      }
  };
  const auto pointsOf = [](const Scan& of) {
    return [&of](size_t entry, uint32_t axis) { return of.points[3 * entry + axis]; };
  };
  checkTurned(pointsOf(scan), pointsOf(world), {10, 20, 30});
  for (const Field field : {Field::normal, Field::velocity}) {
    const auto vectorsOf = [field](const Scan& of) {
      return [&of, field](size_t entry, uint32_t axis) { return of.column<float>(field, axis)[entry]; };
    };
    checkTurned(vectorsOf(scan), vectorsOf(world), {});
  }
  CHECK(world.pose.position.x == 0);
  CHECK(world.pose.orientation.w == 1);
  CHECK(sameFloats(world.ranges, scan.ranges));
  CHECK(sameFloats(inWorld(world).points, world.points));
  for (const Field field : {Field::incidence, Field::azimuth, Field::trueRange})
    for (size_t entry = 0; entry < scan.ranges.size(); ++entry)
      CHECK(std::bit_cast<uint32_t>(world.column<float>(field)[entry]) ==
            std::bit_cast<uint32_t>(scan.column<float>(field)[entry]));
  scan.skewed = true;
  REQUIRE_THROWS_WITH(inWorld(scan), Catch::Matchers::ContainsSubstring("scan with sensor-motion.deskew"));
  scan.skewed = false;
  scan.points.clear();
  REQUIRE_THROWS_AS(inWorld(scan), Error);
}

TEST_CASE("a cloud of several returns has a row per return, without grid and misses") {
  const Folder folder;
  const Scan scan = full(2);
  writeCloud(scan, folder / "a.pcd");
  const std::string header = bytesOf(folder / "a.pcd").substr(0, 400);
  CHECK_THAT(header, ContainsSubstring("gnosphere columns 4 channels 2 returns 2 sensor small\n"));
  CHECK_THAT(header, ContainsSubstring("FIELDS x y z range ring beam triangle instance return returns\n"));
  CHECK_THAT(header, ContainsSubstring("WIDTH 9\nHEIGHT 1\n"));
  writeCloud(scan, folder / "a.csv", withFields("beam,ring,return,returns,label"));
  CHECK(bytesOf(folder / "a.csv") ==
        "beam,ring,return,returns,label\n0,0,1,2,1\n0,0,2,2,1\n2,0,1,1,2\n3,0,1,2,1\n3,0,2,2,1\n5,1,1,1,1\n6,1,1,2,1\n"
        "6,1,2,2,1\n7,1,1,1,1\n");
  CHECK_NOTHROW(writePicture(scan, folder / "a.png"));
}

TEST_CASE("a cloud of several returns that is not compact has a row for every entry, and reads back with its causes") {
  const Folder folder;
  const std::string ending = GENERATE("pcd", "ply", "npy", "csv");
  CloudOptions options = withFields(
      GENERATE("beam,return,x,y,z,range,cause,label", "beam,x,y,z,range,cause,label", "x,y,z,range,cause,label"));
  options.compact = false;
  options.ascii = GENERATE(false, true);
  const uint32_t returns = GENERATE(2u, 6u);  // of 6 no beam has all
  const Scan scan = full(returns);
  const fs::path file = folder / ("a." + ending);
  writeCloud(scan, file, options);
  const bool placed = std::ranges::count(options.fields, Field::beam) > 0;
  if (ending == "csv" && !placed) return;  // CSV does not state a grid
  const Scan back = readCloud(file);
  REQUIRE(back.returns == returns);
  CHECK(back.columns * back.channels == 8);
  CHECK((back.columns == 4 || ending == "csv"));
  CHECK(sameFloats(back.points, scan.points));
  CHECK(sameFloats(back.ranges, scan.ranges));
  for (const Field field : {Field::cause, Field::label})
    CHECK(valuesOf<uint8_t>(back, field) == valuesOf<uint8_t>(scan, field));
}

TEST_CASE("PCD states the entries of several returns as columns, and NPY as a third dimension") {
  const Folder folder;
  CloudOptions options = withFields("range,cause");
  options.compact = false;
  writeCloud(full(2), folder / "a.pcd", options);
  CHECK_THAT(bytesOf(folder / "a.pcd"), ContainsSubstring("WIDTH 8\nHEIGHT 2\n") && ContainsSubstring("POINTS 16\n"));
  writeCloud(full(2), folder / "a.npy", options);
  CHECK_THAT(bytesOf(folder / "a.npy"), ContainsSubstring("'shape': (2, 4, 2), }"));
  options.fields = parseFields("beam,range,cause");
  writeCloud(full(2), folder / "b.pcd", options);
  std::string bytes = bytesOf(folder / "b.pcd");
  const size_t comment = bytes.find("# gnosphere");  // programs that write the file again leave the comment out
  bytes.erase(comment, bytes.find('\n', comment) + 1 - comment);
  put(folder / "b.pcd", bytes);
  const Scan back = readCloud(folder / "b.pcd");
  CHECK((back.columns == 4 && back.channels == 2 && back.returns == 2));
  options.fields = parseFields("beam,cause,tie");  // ties need no rows of their own
  writeCloud(full(2), folder / "a.csv", options);
  CHECK_THAT(bytesOf(folder / "a.csv"), ContainsSubstring("cause,tie\n0,0,0\n0,0,0\n1,2,0\n1,2,0\n2,0,0\n2,0,0\n"));
}

TEST_CASE("the picture of several returns shows the first ones") {
  const Folder folder;
  const Scan two = full(2);
  Scan one = full(2);
  one.returns = 1;
  one.ranges.clear(), one.points.clear();
  for (size_t beam = 0; beam < 8; ++beam) {
    one.ranges.push_back(two.ranges[2 * beam]);
    for (size_t c = 0; c < 3; ++c) one.points.push_back(two.points[6 * beam + c]);
  }
  writePicture(two, folder / "two.png");
  writePicture(one, folder / "one.png");
  CHECK(bytesOf(folder / "two.png") == bytesOf(folder / "one.png"));
}

TEST_CASE("a cloud on a grid keeps its misses, with return number 0 of 0") {
  const Folder folder;
  writeCloud(full(1), folder / "a.csv", withFields("beam,return,returns,cause"));
  CHECK_THAT(bytesOf(folder / "a.csv"), ContainsSubstring("\n0,1,1,0\n1,0,0,2\n"));
  writeCloud(full(1), folder / "a.pcd");
  CHECK_THAT(bytesOf(folder / "a.pcd"), ContainsSubstring("WIDTH 4\nHEIGHT 2\n"));
}

TEST_CASE("a KITTI file's fourth value is the intensity if the scan has it") {
  const Folder folder;
  const Scan scan = full(2);
  writeCloud(scan, folder / "a.bin");
  const std::string bytes = bytesOf(folder / "a.bin");
  REQUIRE(bytes.size() == 9 * 16);
  CHECK(at<float>(bytes, 16) == scan.points[3]);
  CHECK(at<float>(bytes, 16 + 12) == scan.column<float>(Field::intensity)[1]);
  CHECK(at<float>(bytes, 2 * 16 + 12) == scan.column<float>(Field::intensity)[4]);
}

TEST_CASE("Python reads the fields of an NPY cloud according to the format") {
  if (std::system("python3 -c pass >/dev/null 2>&1") != 0) SKIP("there is no python3");
  const Folder folder;
  writeCloud(full(2), folder / "a.npy", withFields("beam,return,intensity,normal,class,label,time"));
  put(folder / "read.py", R"(
import ast, struct, sys
b = open(sys.argv[1], 'rb').read()
n = struct.unpack('<H', b[8:10])[0]
h = ast.literal_eval(b[10:10 + n].decode('latin1').strip())
row = struct.Struct('<' + ''.join({'<f4': 'f', '<u2': 'H', '<u4': 'I', '|u1': 'B'}[t] for _, t in h['descr']))
rows = list(row.iter_unpack(b[10 + n:]))
names = [name for name, _ in h['descr']]
assert names == 'beam return intensity normal_x normal_y normal_z class label time'.split(), names
assert h['shape'] == (9,) and len(rows) == 9
assert [r[0] for r in rows] == [0, 0, 2, 3, 3, 5, 6, 6, 7] and [r[1] for r in rows] == [1, 2, 1, 1, 2, 1, 1, 2, 1]
assert rows[0][6] == 500 and rows[5][6] == 65535 and rows[6][6] == 0 and rows[2][7] == 2
assert abs(rows[6][8] - 0.051) < 1e-7
)");
  CHECK(std::system(("python3 " + (folder / "read.py").string() + " " + (folder / "a.npy").string()).c_str()) == 0);
}

TEST_CASE("a field that the scan lacks is refused with advice") {
  const Folder folder;
  const Scan scan = tiny();
  const auto problem = [&](const std::string& fields) {
    return problemOf([&] { writeCloud(scan, folder / "a.pcd", withFields(fields)); });
  };
  for (const char* field : {"intensity", "true_range", "cause", "label", "width", "normal", "incidence", "material",
                            "barycentrics", "velocity", "radial_speed", "class", "time", "azimuth", "elevation"})
    CHECK_THAT(problem(field), ContainsSubstring("the scan has no field '" + std::string(field) +
                                                 "': it was not asked for; add it to the fields of the sensor"));
  CHECK(folder.fileCount() == 0);
}

TEST_CASE("invalid return numbers are refused") {
  const Folder folder;
  const auto problem = [&](const std::string& rows) {
    put(folder / "a.csv", "range,beam,return\n" + rows);
    return problemOf([&] { readCloud(folder / "a.csv"); }, ErrorCode::format);
  };
  CHECK_THAT(problem("1,7,2\n1,7,2\n"), ContainsSubstring("return 2 of beam 7 occurs twice"));
  CHECK_THAT(problem("1,7,1\n1,7,1\n"), ContainsSubstring("beam 7 occurs twice"));
  CHECK_THAT(problem("1,7,200\n"), ContainsSubstring("return number 200"));
  CHECK_THAT(problem("1,4294967290,2\n"), ContainsSubstring("4294967291 beams"));
}

TEST_CASE("clouds of several returns are compared without a field for the returns' numbers") {
  const Folder folder;
  const std::string ending = GENERATE("pcd", "ply", "npy", "csv");
  const Scan reference = full(2);
  Scan other = reference;
  other.triangles[1] = 77;  // second return of beam 0
  writeCloud(reference, folder / ("a." + ending), withFields("range,beam,triangle,instance"));
  writeCloud(other, folder / ("b." + ending), withFields("range,beam,triangle,instance"));
  const Scan read = readCloud(folder / ("a." + ending));
  CHECK(read.returns == 2);
  const Comparison same = compare(read, reference);
  CHECK(same.same());
  CHECK(same.hits == 9);
  const Comparison difference = compare(read, readCloud(folder / ("b." + ending)));
  CHECK(difference.wrongOwner == 1);
  CHECK(difference.missed + difference.falseHits + difference.wrongRange == 0);

  // One that states its beams' single returns has a fault.
  put(folder / "c.ply",
      "ply\nformat ascii 1.0\ncomment gnosphere columns 2 channels 2\nelement vertex 2\n"
      "property float range\nproperty uint beam\nend_header\n1 3\n2 3\n");
  CHECK_THROWS_WITH(readCloud(folder / "c.ply"), ContainsSubstring("beam 3 occurs twice"));
}

TEST_CASE("clouds are compared return by return") {
  const Scan reference = full(2);
  CHECK(compare(reference, reference).hits == 9);
  CHECK(compare(reference, reference).same());

  Scan other = reference;
  other.triangles[1] = 77;           // second return of beam 0
  other.ranges[4] += 0.5f;           // first return of beam 2, from the medium
  other.ranges[13] = std::nanf("");  // second return of beam 6
  other.triangles[13] = other.instances[13] = kNoTriangle;
  ScanColumns(other).make(Field::tolerance, false);
  Scan exact = reference;
  ScanColumns(exact).make(Field::tolerance, false);
  const Comparison difference = compare(exact, other);
  CHECK(difference.beams == 8);
  CHECK(difference.wrongOwner == 1);
  CHECK(difference.wrongRange == 1);
  CHECK(difference.missed == 1);
  CHECK(difference.falseHits == 0);

  Scan first = full(2);  // one return per beam, so that the second returns are missed
  first.returns = 1;
  for (auto* array : {&first.triangles, &first.instances})
    for (size_t beam = 0; beam < 8; ++beam) (*array)[beam] = (*array)[2 * beam];
  for (size_t beam = 0; beam < 8; ++beam) first.ranges[beam] = first.ranges[2 * beam];
  first.triangles.resize(8), first.instances.resize(8), first.ranges.resize(8);
  CHECK(compare(reference, first).missed == 3);
  CHECK(compare(reference, first).wrongOwner == 0);
}
