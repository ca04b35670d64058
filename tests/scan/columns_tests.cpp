// SPDX-License-Identifier: Apache-2.0
// A scan's values as columns by field, and as rows in the memory of the caller.
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <cstring>
#include <locale>

#include "classified_fences.hpp"
#include "cloud_support.hpp"
#include "problem.hpp"
#include "scan/api_example.hpp"
#include "scan/coarse_points.hpp"
#include "scan/columns.hpp"
#include "scan/fields.hpp"
#include "support.hpp"

using namespace gnosphere;
using namespace gnosphere::test;
using Catch::Matchers::ContainsSubstring;
using Catch::Matchers::Equals;

namespace {

/// Two columns and two channels, which look down; the upper one beyond the edge of the floor.
Sensor smallSensor() {
  Sensor sensor = gridSensor(2, 2, -40, -5, 50);
  sensor.rotationPeriod = 0.1;
  sensor.channels[1].timeOffset = 0.001;
  return sensor;
}

Scene floorScene() {
  MeshBuilder builder;
  builder.quad({-8, -8, -2}, {16, 0, 0}, {0, 16, 0});
  Scene scene = sceneOf(builder.take());
  scene.instances[0].classId = 9;
  return scene;
}

TestOptions asking(std::vector<Field> fields) {
  TestOptions options;
  options.device = DeviceChoice::Kind::reference;
  options.fields = std::move(fields);
  return options;
}

/// The rows of a layout, and whether a byte behind them was written.
std::vector<std::byte> packed(const Scan& scan, const RecordLayout& layout, size_t rows) {
  std::vector<std::byte> bytes(rows * layout.stride + 1, std::byte{0xee});
  CHECK(pack(scan, layout, bytes) == rows);
  CHECK(bytes.back() == std::byte{0xee});
  bytes.pop_back();
  return bytes;
}

}  // namespace

TEST_CASE("every field has a name, a type and components, and parses back from its name") {
  for (size_t i = 0; i < kFieldCount; ++i) {
    const auto field = static_cast<Field>(i);
    const FieldInfo info = fieldInfo(field);
    CHECK(parseFields(info.name) == std::vector{field});
    CHECK(columnsOf({field}).size() == info.components);
    CHECK(info.type != ValueType::f64);
  }
  CHECK(fieldInfo(Field::z).components == 1);
  CHECK(fieldInfo(Field::normal).components == 3);
  CHECK(fieldInfo(Field::barycentrics).components == 2);
  CHECK(fieldInfo(Field::classId).type == ValueType::u16);
  CHECK_THAT(fieldInfo(Field::trueRange).name, Equals("true_range"));
}

TEST_CASE("a field is named by its column or by its enumerator") {
  CHECK(parseFields("return_number, RETURN_COUNT,class_id") ==
        std::vector<Field>{Field::returnNumber, Field::returnCount, Field::classId});
  CHECK_THROWS_WITH(parseFields("class,class_id"), ContainsSubstring("'class' is asked for twice"));
}

TEST_CASE("a scan without entries has the fields that every scan has, and those that were made") {
  Scan scan;
  for (size_t i = 0; i < kFieldCount; ++i) {
    const auto field = static_cast<Field>(i);
    INFO(fieldInfo(field).name);
    CHECK(scan.has(field) == isOfEveryScan(field));
  }
  ScanColumns(scan).make(Field::normal);
  CHECK(scan.has(Field::normal));
  CHECK(scan.column<float>(Field::normal, 2).empty());
  CHECK(ScanColumns(scan).bytes(Field::normal) == nullptr);
  CHECK_THROWS_WITH(scan.column<float>(Field::intensity), ContainsSubstring("no field 'intensity'"));
  ScanColumns(scan).make(Field::normal, false);
  CHECK_FALSE(scan.has(Field::normal));
}

TEST_CASE("a scan always has points, ranges and owners as columns") {
  const Scan scan = tiny();
  const auto x = scan.column<float>(Field::x), y = scan.column<float>(Field::y), z = scan.column<float>(Field::z);
  const auto ranges = scan.column<float>(Field::range);
  const auto triangles = scan.column<uint32_t>(Field::triangle), instances = scan.column<uint32_t>(Field::instance);
  REQUIRE(x.size() == 6);
  CHECK(x.stride() == 3);
  CHECK(x.data() == scan.points.data());
  for (size_t i = 0; i < 6; ++i) {
    CHECK(&x[i] == &scan.points[3 * i]);
    CHECK(&y[i] == &scan.points[3 * i + 1]);
    CHECK(&z[i] == &scan.points[3 * i + 2]);
    CHECK(&ranges[i] == &scan.ranges[i]);
    CHECK(triangles[i] == scan.triangles[i]);
    CHECK(instances[i] == scan.instances[i]);
  }
  CHECK(std::vector(y.begin(), y.end())[5] == -5);
  CHECK(std::distance(y.begin(), y.end()) == 6);
  CHECK_FALSE(x.empty());
  CHECK(ColumnView<float>().empty());
}

TEST_CASE("what follows from the sensor, the beam and the instances is a column where it is asked for") {
  const std::vector<Field> fields = {Field::time, Field::azimuth,      Field::elevation,   Field::classId, Field::ring,
                                     Field::beam, Field::returnNumber, Field::returnCount, Field::normal};
  const Sensor sensor = smallSensor();
  Simulator simulator = makeSimulator(floorScene(), sensor, asking(fields));
  Scan scan = simulator.scan({});
  REQUIRE(scan.counters.hits == 2);
  for (size_t i = 0; i < 4; ++i) {
    INFO("beam " << i);
    const bool hit = i < 2;
    const Vec3 d = sensor.direction(i);
    CHECK(scan.hit(i) == hit);
    CHECK(scan.column<float>(Field::time)[i] == static_cast<float>(0.05 * double(i % 2) + (hit ? 0 : 0.001)));
    CHECK(std::abs(std::remainder(scan.column<float>(Field::azimuth)[i] - std::atan2(d.y, d.x), 2 * M_PI)) < 1e-6);
    CHECK(std::abs(scan.column<float>(Field::elevation)[i] - std::asin(d.z)) < 1e-6);
    CHECK(scan.column<uint16_t>(Field::classId)[i] == (hit ? 9 : 0));
    CHECK(scan.column<uint16_t>(Field::ring)[i] == i / 2);
    CHECK(scan.column<uint32_t>(Field::beam)[i] == i);
    CHECK(scan.column<uint8_t>(Field::returnNumber)[i] == hit);
    CHECK(scan.column<uint8_t>(Field::returnCount)[i] == hit);
    if (hit) CHECK(scan.column<float>(Field::normal, 2)[i] == 1);
  }
  // Into the same scan from another simulator: what that one was not asked for is gone.
  makeSimulator(floorScene(), sensor, asking({Field::beam})).scanInto({}, scan);
  CHECK(scan.has(Field::beam));
  for (const Field field : fields) CHECK(scan.has(field) == (field == Field::beam));
}

TEST_CASE("several returns of a beam share its time, its cause and the number of them") {
  Sensor sensor = smallSensor();
  sensor.maxReturns = 2;
  TestOptions options = asking({Field::time, Field::cause, Field::beam, Field::returnNumber, Field::returnCount});
  options.effects.returns.use = options.effects.intensity.use = EffectUse::on;
  options.effects.returns.count = 2;
  const Scan scan = makeSimulator(floorScene(), sensor, options).scan({});
  REQUIRE(scan.returns == 2);
  const auto beams = scan.column<uint32_t>(Field::beam);
  CHECK(std::vector(beams.begin(), beams.end()) == std::vector<uint32_t>{0, 0, 1, 1, 2, 2, 3, 3});
  for (size_t entry = 0; entry < 8; ++entry) {
    INFO("entry " << entry);
    const bool hit = entry < 4, first = entry % 2 == 0;
    CHECK(scan.column<float>(Field::time)[entry] == scan.column<float>(Field::time)[entry / 2 * 2]);
    CHECK(scan.column<uint8_t>(Field::cause)[entry] == uint8_t(hit ? Cause::returned : Cause::noSurface));
    CHECK(scan.column<uint8_t>(Field::returnNumber)[entry] == (hit && first));
    CHECK(scan.column<uint8_t>(Field::returnCount)[entry] == hit);
  }
}

TEST_CASE("the class of a scan is the one that its instances had when it was made") {
  Simulator simulator = makeSimulator(floorScene(), smallSensor(), asking({Field::classId}));
  const Scan before = simulator.scan({});
  const Transform further = translation(0, 0, -0.5);
  CHECK(simulator.addInstance(0, further, 4) == 1);
  simulator.removeInstance(0);
  CHECK(before.column<uint16_t>(Field::classId)[0] == 9);
  CHECK(simulator.scan({}).column<uint16_t>(Field::classId)[0] == 4);
  CHECK(simulator.addInstance(0, {}) == 0);
  CHECK(simulator.scan({}).column<uint16_t>(Field::classId)[0] == 0);
}

TEST_CASE("a point has the class of its surface's material, and else that of its instance") {
  const Scan scan = makeSimulator(classifiedFences(), fenceSensor(), asking({Field::classId})).scan({});
  const auto classes = scan.column<uint16_t>(Field::classId);
  std::map<int, int> counts;
  for (size_t i = 0; i < scan.ranges.size(); ++i) {
    if (scan.hit(i))
      checkClass(scan.points[3 * i], scan.points[3 * i + 1], scan.points[3 * i + 2], classes[i], counts);
    else
      CHECK(classes[i] == 0);
  }
  checkCounts(counts);
}

TEST_CASE("materials that come and go bring their classes with them") {
  Simulator simulator = makeSimulator(floorScene(), smallSensor(), asking({Field::classId}));
  const auto classOf = [&] { return simulator.scan({}).column<uint16_t>(Field::classId)[0]; };
  Mesh floor = floorScene().meshes[0];
  Material stating;
  stating.classId = 40;
  floor.parts[0].material = static_cast<uint32_t>(simulator.addMaterial(stating));
  const size_t mesh = simulator.addMesh(floor);
  const size_t upper = simulator.addInstance(static_cast<uint32_t>(mesh), translation(0, 0, 0.5), 8);
  CHECK(classOf() == 40);
  simulator.removeInstance(upper);
  simulator.removeMesh(mesh);
  simulator.removeMaterial(floor.parts[0].material);
  CHECK(classOf() == 9);
  CHECK(simulator.addMaterial({}) == floor.parts[0].material);
  CHECK(simulator.addMesh(floor) == mesh);
  simulator.addInstance(static_cast<uint32_t>(mesh), translation(0, 0, 0.5), 8);
  CHECK(classOf() == 8);
}

TEST_CASE("columns are used again: a second scan allocates none") {
  Simulator simulator = makeSimulator(floorScene(), smallSensor(), asking({Field::normal, Field::time, Field::beam}));
  Scan scan = simulator.scan({});
  const auto* normals = scan.column<float>(Field::normal).data();
  const auto* times = scan.column<float>(Field::time).data();
  simulator.scanInto({}, scan);
  CHECK(scan.column<float>(Field::normal).data() == normals);
  CHECK(scan.column<float>(Field::time).data() == times);
}

TEST_CASE("a column that is not there, of another type or of no such component is refused with the way out") {
  const Scan scan = tiny();
  CHECK_THAT(problemOf([&] { scan.column<float>(Field::intensity); }),
             Equals("the scan has no field 'intensity': it was not asked for; add it to the fields of the sensor"));
  CHECK_THAT(problemOf([&] { scan.column<float>(Field::time); }), ContainsSubstring("'time': it was not asked for"));
  CHECK_THAT(problemOf([&] { scan.column<uint32_t>(Field::tie); }),
             Equals("the values of field 'tie' are uint8_t, not uint32_t"));
  CHECK_THAT(problemOf([&] { scan.column<float>(Field::x, 1); }),
             Equals("field 'x' has no component 1; it has 1, counted from 0"));
  CHECK_THAT(problemOf([&] { scan.column<float>(Field::normal, 3); }), ContainsSubstring("it has 3, counted from 0"));
  Scan device = tiny();
  ScanColumns(device).make(Field::tie, false);
  CHECK_FALSE(device.has(Field::tie));
  CHECK_THAT(problemOf([&] { device.column<uint8_t>(Field::tie); }),
             Equals("the scan has no field 'tie': only the device 'reference' gives it"));
  Sensor tall = smallSensor();
  tall.channels.resize(65537);
  CHECK_THAT(problemOf([&] { makeSimulator(floorScene(), tall, asking({Field::ring})); }),
             ContainsSubstring("field 'ring' is 16 bits wide"));
}

TEST_CASE("rows as in a PointCloud2 of x, y, z and intensity: padding is left as it is") {
  Scan scan = tiny();
  setColumn<float>(scan, Field::intensity, {0.5f, 1.5f, 2.5f, 3.5f, std::nanf(""), 5.5f});
  RecordLayout layout;
  layout.values = {{Field::x, 0, 0}, {Field::y, 0, 4}, {Field::z, 0, 8}, {Field::intensity, 0, 16}};
  layout.stride = 32;
  layout.compact = GENERATE(false, true);
  const std::vector<std::byte> bytes = packed(scan, layout, layout.compact ? 5 : 6);
  for (size_t row = 0; row < 5; ++row) {
    INFO("row " << row);
    const size_t beam = layout.compact && row == 4 ? 5 : row, start = row * layout.stride;
    for (size_t c = 0; c < 3; ++c) CHECK(std::memcmp(&bytes[start + 4 * c], &scan.points[3 * beam + c], 4) == 0);
    if (beam != 4) CHECK(at<float>(bytes, start + 16) == static_cast<float>(beam) + 0.5f);
    CHECK(at<uint32_t>(bytes, start + 12) == 0xeeeeeeee);
    for (size_t hole = 20; hole < 32; hole += 4) CHECK(at<uint32_t>(bytes, start + hole) == 0xeeeeeeee);
  }
}

TEST_CASE("rows as in a numpy structured array: no padding, and wider types") {
  const Scan scan = tiny();
  RecordLayout layout;
  layout.values = {{Field::beam, 0, 0, ValueType::f64},       {Field::ring, 0, 8, ValueType::u32},
                   {Field::tie, 0, 12, ValueType::u16},       {Field::returnNumber, 0, 14, ValueType::f32},
                   {Field::range, 0, 18, ValueType::f64},     {Field::instance, 0, 26, ValueType::u32},
                   {Field::returnCount, 0, 30, ValueType::u8}};
  layout.stride = 31;
  const std::vector<std::byte> bytes = packed(scan, layout, 6);
  for (size_t beam = 0; beam < 6; ++beam) {
    INFO("beam " << beam);
    const size_t start = beam * layout.stride;
    const bool hit = beam != 4;
    CHECK(at<double>(bytes, start) == static_cast<double>(beam));
    CHECK(at<uint32_t>(bytes, start + 8) == beam / 3);
    CHECK(at<uint16_t>(bytes, start + 12) == (beam == 2));
    CHECK(at<float>(bytes, start + 14) == (hit ? 1 : 0));
    CHECK(
        (hit ? at<double>(bytes, start + 18) == double{scan.ranges[beam]} : std::isnan(at<double>(bytes, start + 18))));
    CHECK(at<uint32_t>(bytes, start + 26) == (hit ? 7 : kNoTriangle));
    CHECK(at<uint8_t>(bytes, start + 30) == hit);
  }
}

TEST_CASE("a column beyond half of what 64 bits number makes no layout small") {
  RecordLayout layout;
  layout.values = {{Field::range, 0, ~size_t{0} - 3, ValueType::f32, 4}};  // the sum of place and bytes would be 4
  CHECK_THAT(problemOf([&] { layout.bytesFor(2); }), ContainsSubstring("has no place in 64 bits"));
  layout.values[0].offset = size_t{1} << 40;
  CHECK(layout.bytesFor(2) == (uint64_t{1} << 40) + 8);
}

TEST_CASE("the layout of fields is that of the rows of a binary file") {
  const std::vector<Field> fields = {Field::ring, Field::x, Field::y, Field::z, Field::tie, Field::beam};
  const RecordLayout layout = layoutOf(fields);
  CHECK(layout.stride == 2 + 3 * 4 + 1 + 4);
  CHECK(layout.values[4].offset == 14);
  CHECK(layout.values[4].type == ValueType::u8);
  CHECK(layoutOf({Field::normal, Field::beam}).values[2].component == 2);
  CHECK(layoutOf({Field::normal, Field::beam}).values[3].offset == 12);
  const Folder folder;
  CloudOptions options;
  options.fields = fields;
  writeCloud(tiny(), folder / "a.pcd", options);
  const std::string file = bytesOf(folder / "a.pcd");
  const std::vector<std::byte> bytes = packed(tiny(), layout, 6);
  REQUIRE(file.size() > bytes.size());
  CHECK(std::memcmp(file.data() + file.size() - bytes.size(), bytes.data(), bytes.size()) == 0);
}

TEST_CASE("rows of more beams than one thread takes are all there") {
  Scan scan;
  scan.columns = 200'000;
  scan.channels = 1;
  for (uint32_t i = 0; i < scan.columns; ++i) scan.ranges.push_back(i % 3 == 1 ? std::nanf("") : 0.5f);
  RecordLayout layout = layoutOf({Field::beam});
  layout.compact = true;
  std::vector<uint32_t> beams(200'000, 7);
  REQUIRE(pack(scan, layout, std::as_writable_bytes(std::span(beams))) == 133'333);
  for (uint32_t row = 0; row < 133'333; ++row) REQUIRE(beams[row] == row / 2 * 3 + row % 2 * 2);
  CHECK(beams[133'333] == 7);
}

TEST_CASE("a layout or a buffer that does not do is refused, and nothing is written") {
  const Scan scan = tiny();
  std::vector<std::byte> bytes(6 * 16, std::byte{0xee});
  const auto problem = [&](std::vector<RecordLayout::Value> values, size_t stride, bool compact = false) {
    return problemOf([&] { pack(scan, {std::move(values), stride, compact}, bytes); });
  };
  CHECK_THAT(problem({{Field::x, 0, 0}}, 17), Equals("the buffer has 96 bytes; 6 rows of 17 bytes need 102"));
  CHECK_THAT(problem({{static_cast<Field>(99), 0, 0}}, 17), Equals("there is no field number 99"));
  CHECK_THAT(problem({{Field::x, 0, 0}}, 20, true), ContainsSubstring("5 rows of 20 bytes need 100"));
  CHECK_THAT(problem({{Field::intensity, 0, 0}}, 16), ContainsSubstring("no field 'intensity': it was not asked for"));
  CHECK_THAT(problem({{Field::x, 0, 0}, {Field::tie, 0, 3, ValueType::u8}}, 16),
             Equals("the record layout: 'tie' at bytes 3 to 3 overlaps 'x' at bytes 0 to 3"));
  CHECK_THAT(problem({{Field::x, 0, 8}, {Field::y, 0, 8}}, 16), ContainsSubstring("'y' at bytes 8 to 11 overlaps 'x'"));
  CHECK_THAT(problem({{Field::x, 0, 13}}, 16),
             Equals("the record layout: 'x' at bytes 13 to 16 reaches beyond the stride of 16 bytes"));
  CHECK_THAT(problem({{Field::x, 0, ~size_t{0} - 1}}, 16), ContainsSubstring("reaches beyond the stride of 16"));
  CHECK_THAT(problem({{Field::x, 0, 0}}, 0), ContainsSubstring("reaches beyond the stride of 0"));
  CHECK_THAT(problem({{Field::x, 1, 0}}, 16), ContainsSubstring("'x' has no component 1"));
  CHECK_THAT(problem({{Field::instance, 0, 0, ValueType::f32}}, 16),
             Equals("the record layout: f32 does not hold every value of 'instance'; u32 does"));
  CHECK_THAT(problem({{Field::x, 0, 0, ValueType::u32}}, 16),
             ContainsSubstring("u32 does not hold every value of 'x'"));
  CHECK_THAT(problem({{Field::ring, 0, 0, ValueType::u8}}, 16), ContainsSubstring("u8 does not hold every value"));
  CHECK_THAT(problem({}, 16), ContainsSubstring("the record layout: has no values"));
  RecordLayout::Value column{Field::x, 0, 0};
  column.stride = 4;
  CHECK_THAT(problem({column}, 16),
             Equals("the record layout: columns are for results that stay on a device; a Scan has Scan::column()"));
  CHECK(bytes == std::vector<std::byte>(96, std::byte{0xee}));
}

TEST_CASE("the examples of docs/api.md do what they say") {
  Scan scan = tiny();
  setColumn<float>(scan, Field::intensity, {1, 2, 3, 4, std::nanf(""), 5});
  CHECK(meanIntensity(scan) == 3);
  const std::vector<std::byte> rows = pointCloud(scan);
  REQUIRE(rows.size() == 5 * 32);
  CHECK(at<float>(rows, 4 * 32) == scan.points[15]);
  CHECK(at<float>(rows, 4 * 32 + 16) == 5);

  SensorRequest foggy(smallSensor());
  foggy.variableWeather = true;
  TestOptions options;
  options.device = DeviceChoice::Kind::reference;
  Simulator simulator(floorScene(), foggy, options);
  size_t scans = 0;
  thickeningFog(simulator, [&](const Scan& fog) { scans += fog.counters.beams == 4; });
  CHECK(scans == 4);
  MeshBuilder car;
  car.quad({-1, -1, -1}, {2, 0, 0}, {0, 2, 0});
  const Scan with = withCar(simulator, sceneOf(car.take()), {}), without = simulator.scan({});
  CHECK(with.counters.triangles == without.counters.triangles + 2);
  CHECK(twoLidars(floorScene()).plan(1).has("intensity") == false);
  Simulator ahead(floorScene(), solidState());
  CHECK(ahead.scan({{0, 0, 1.8}, {}}).column<float>(Field::range).size() == 20'000);
}

TEST_CASE("how coarse points are in the world is told with a decimal point in every locale") {
  struct Commas : std::numpunct<char> {
    char do_decimal_point() const override { return ','; }
  };
  Scan scan;
  scan.points = {5500010, 0, 0};
  const std::locale before = std::locale::global(std::locale(std::locale(), new Commas));
  const std::string told = coarsePoints(scan);
  std::locale::global(before);
  CHECK(told == "points in the world frame are in single precision, which has steps of 0.5 m at 5500010 m");
}
