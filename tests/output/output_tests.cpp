// SPDX-License-Identifier: Apache-2.0
// Checks written files byte by byte; cloud_read_tests.cpp reads them back.
#include <algorithm>
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <cstdlib>
#include <memory>
#ifndef _WIN32
#include <sys/stat.h>
#endif

#define STB_IMAGE_STATIC
#define STB_IMAGE_IMPLEMENTATION
#define STBI_ONLY_PNG
#include <stb_image.h>

#include "base/file.hpp"
#include "cloud_support.hpp"
#include "output/pattern_picture.hpp"
#include "scan/image_order.hpp"
#include "sensor/beams.hpp"
#include "synthetic_scan.hpp"

using namespace gnosphere;
using namespace gnosphere::test;
using Catch::Matchers::ContainsSubstring;

namespace {

/// The pixels of a PNG.
struct Pixels {
  int width = 0, height = 0;
  std::vector<uint8_t> rgb;

  explicit Pixels(const fs::path& file) {
    int channels = 0;
    const std::unique_ptr<uint8_t, void (*)(void*)> read(stbi_load(file.c_str(), &width, &height, &channels, 3),
                                                         stbi_image_free);
    REQUIRE(read);
    rgb.assign(read.get(), read.get() + 3 * width * height);
  }
  const uint8_t* at(int x, int y) const { return &rgb[3 * (static_cast<size_t>(y) * width + x)]; }
};

}  // namespace

TEST_CASE("field names are parsed in order, and an unknown one is refused with the nearest names") {
  CHECK(parseFields("z, ring,TRIANGLE") == std::vector<Field>{Field::z, Field::ring, Field::triangle});
  CHECK_THROWS_WITH(parseFields("x,colour"), ContainsSubstring("'colour'; the nearest are class, cause, return;"));
  CHECK_THROWS_WITH(parseFields(""), ContainsSubstring("the fields '' have '' where a name is wanted"));
  for (const char* names : {"x,,y", "x,y,", " ,x"})
    CHECK_THROWS_WITH(parseFields(names), ContainsSubstring("the fields '" + std::string(names) + "' have ''"));
  CHECK_THROWS_WITH(parseFields("x,y,x"), ContainsSubstring("twice"));
}

TEST_CASE("a PCD file is organised and binary, and matches its header") {
  const Folder folder;
  const Scan scan = tiny();
  writeCloud(scan, folder / "a.pcd");
  const std::string bytes = bytesOf(folder / "a.pcd");
  const std::string header =
      "# .PCD v0.7 - Point Cloud Data file format\n"
      "# gnosphere columns 3 channels 2 sensor tiny\n"
      "VERSION 0.7\n"
      "FIELDS x y z range ring beam triangle instance\n"
      "SIZE 4 4 4 4 2 4 4 4\n"
      "TYPE F F F F U U U U\n"
      "COUNT 1 1 1 1 1 1 1 1\n"
      "WIDTH 3\n"
      "HEIGHT 2\n"
      "VIEWPOINT 0 0 0 1 0 0 0\n"
      "POINTS 6\n"
      "DATA binary\n";
  REQUIRE(bytes.substr(0, header.size()) == header);
  REQUIRE(bytes.size() == header.size() + 6 * 30);
  for (size_t beam = 0; beam < 6; ++beam) {
    const size_t row = header.size() + 30 * beam;
    CHECK(at<uint16_t>(bytes, row + 16) == beam / 3);
    CHECK(at<uint32_t>(bytes, row + 18) == beam);
    CHECK(at<uint32_t>(bytes, row + 22) == scan.triangles[beam]);
    CHECK(at<uint32_t>(bytes, row + 26) == scan.instances[beam]);
    if (beam == 4) {
      CHECK(std::isnan(at<float>(bytes, row)));
      CHECK(std::isnan(at<float>(bytes, row + 12)));
      CHECK(at<uint32_t>(bytes, row + 22) == 0xffffffffu);
    } else {
      CHECK(at<float>(bytes, row) == scan.points[3 * beam]);
      CHECK(at<float>(bytes, row + 4) == scan.points[3 * beam + 1]);
      CHECK(at<float>(bytes, row + 8) == scan.points[3 * beam + 2]);
      CHECK(at<float>(bytes, row + 12) == scan.ranges[beam]);
    }
  }
}

TEST_CASE("a PCD file states the pose of its scan, which is read back to the bit") {
  const Folder folder;
  Scan scan = tiny();
  scan.pose = {{500000.125, 5999999.1, -2.5}, {0, 0, 0.6, 0.8}};
  writeCloud(scan, folder / "a.pcd");
  CHECK_THAT(bytesOf(folder / "a.pcd"), ContainsSubstring("\nVIEWPOINT 500000.125 5999999.1 -2.5 0.8 0 0 0.6\n"));
  const Pose read = readCloud(folder / "a.pcd").pose;
  CHECK((read.position.x == 500000.125 && read.position.y == 5999999.1 && read.position.z == -2.5));
  CHECK((read.orientation.x == 0 && read.orientation.y == 0 && read.orientation.z == 0.6 && read.orientation.w == 0.8));
  scan.pose.orientation = {0, 0, 3, 4};  // readers take the numbers for those of a unit quaternion
  writeCloud(scan, folder / "long.pcd");
  CHECK_THAT(bytesOf(folder / "long.pcd"), ContainsSubstring("-2.5 0.8 0 0 0.6\n"));
  writeCloud(inWorld(scan), folder / "world.pcd");
  CHECK_THAT(bytesOf(folder / "world.pcd"), ContainsSubstring("\nVIEWPOINT 0 0 0 1 0 0 0\n"));
}

TEST_CASE("a cloud of a file whose pose is not known, or whose columns have frames of their own, is not in the world") {
  const Folder folder;
  Scan scan = tiny();
  scan.pose.position.x = 10;
  for (const char* name : {"a.ply", "a.npy", "a.csv"}) {
    INFO(name);
    writeCloud(scan, folder / name);
    const Scan read = readCloud(folder / name);
    CHECK_FALSE(read.poseKnown);
    CHECK_THROWS_WITH(inWorld(read), ContainsSubstring("does not state the sensor's pose"));
  }
  writeCloud(scan, folder / "a.pcd");
  CHECK(inWorld(readCloud(folder / "a.pcd")).points[0] == scan.points[0] + 10);
  std::ofstream(folder / "b.pcd") << "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 1\nHEIGHT 1\nDATA ascii\n1 2 3\n";
  CHECK_FALSE(readCloud(folder / "b.pcd").poseKnown);

  scan.skewed = true;
  for (const uint32_t returns : {1u, 2u})
    for (const char* name : {"a.pcd", "a.ply"}) {
      INFO(name);
      scan.returns = returns;
      scan.channels = 2 / returns;  // of six entries
      writeCloud(scan, folder / name);
      const Scan read = readCloud(folder / name);
      CHECK(read.skewed);
      CHECK(read.sensor == scan.sensor);
      CHECK_THROWS_WITH(inWorld(read), ContainsSubstring("the sensor moved during the scan"));
    }
}

TEST_CASE("a file that no reader would take is refused before it is written") {
  const Folder folder;
  const Scan scan = tiny();
  for (const char* name : {"a.pcd", "a.ply", "a.npy", "a.csv", "a.bin"}) {
    CloudOptions options;
    options.fields = {Field::range, Field::beam, Field::range};
    CHECK_THROWS_WITH(writeCloud(scan, folder / name, options), ContainsSubstring("field 'range' is asked for twice"));
  }
  CloudOptions options;
  options.fields = {Field::x, Field::range};
  CHECK_THROWS_WITH(writeCloud(scan, folder / "a.bin", options), ContainsSubstring("cannot have 'range'"));
  CHECK_THROWS_WITH(writePicture(scan, folder / "a.jpg"), ContainsSubstring("a.jpg must end in .png"));
  CHECK(folder.fileCount() == 0);
}

TEST_CASE("a scan whose ranges do not fill its grid is refused") {
  const Folder folder;
  Scan scan = tiny();
  scan.columns = scan.channels = 1;
  scan.returns = 4;
  CHECK_THROWS_WITH(writeCloud(scan, folder / "a.pcd"),
                    ContainsSubstring("6 ranges for 1 columns x 1 channels x 4 returns"));
  scan.returns = 0;
  CHECK(scan.beamCount() == 0);
  CHECK_THROWS_WITH(writeCloud(scan, folder / "a.pcd"), ContainsSubstring("0 returns per beam"));
  CHECK_THROWS_WITH(writePicture(scan, folder / "a.png"), ContainsSubstring("0 returns per beam"));
}

TEST_CASE("ASCII PCD and CSV are readable text with one line per beam") {
  const Folder folder;
  CloudOptions options;
  options.ascii = true;
  options.fields = parseFields("beam,x,triangle");
  writeCloud(tiny(), folder / "a.pcd", options);
  CHECK_THAT(bytesOf(folder / "a.pcd"), ContainsSubstring("DATA ascii\n0 0.1 100\n1 1.1 101\n2 2.1 102\n3 3.1 103\n"
                                                          "4 nan 4294967295\n5 5.1 105\n"));
  options.compact = true;
  writeCloud(tiny(), folder / "a.csv", options);
  CHECK(bytesOf(folder / "a.csv") == "beam,x,triangle\n0,0.1,100\n1,1.1,101\n2,2.1,102\n3,3.1,103\n5,5.1,105\n");
}

TEST_CASE("a PLY file has packed rows, and the names and types that other readers know") {
  const Folder folder;
  CloudOptions options;
  options.fields = parseFields("x,ring,tie,tolerance,instance,normal");
  Scan scan = tiny();
  setColumn(scan, Field::normal, std::vector<float>(3 * scan.beamCount(), 0.5f));
  writeCloud(scan, folder / "a.ply", options);
  const std::string bytes = bytesOf(folder / "a.ply");
  const std::string header =
      "ply\nformat binary_little_endian 1.0\ncomment gnosphere columns 3 channels 2 sensor tiny\nelement vertex 6\n"
      "property float x\nproperty uint16 ring\nproperty uint8 tie\nproperty float tolerance\n"
      "property uint32 instance\nproperty float nx\nproperty float ny\nproperty float nz\nend_header\n";
  REQUIRE(bytes.substr(0, header.size()) == header);
  REQUIRE(bytes.size() == header.size() + 6 * 27);
  CHECK(at<uint8_t>(bytes, header.size() + 2 * 27 + 6) == 1);
  CHECK(at<uint32_t>(bytes, header.size() + 2 * 27 + 11) == 7);
  CHECK(at<float>(bytes, header.size() + 2 * 27 + 15) == 0.5f);
}

TEST_CASE("a KITTI file holds x, y, z and a zero reflectance of the hits") {
  const Folder folder;
  writeCloud(tiny(), folder / "a.bin");
  const std::string bytes = bytesOf(folder / "a.bin");
  REQUIRE(bytes.size() == 5 * 16);
  CHECK(at<float>(bytes, 4 * 16) == 5.1f);  // the sixth beam, after the miss
  CHECK(at<float>(bytes, 4 * 16 + 4) == -5);
  for (size_t row = 0; row < 5; ++row) CHECK(at<float>(bytes, row * 16 + 12) == 0);
}

TEST_CASE("the data of an NPY file starts at a multiple of 64 bytes and has the sensor's shape") {
  const Folder folder;
  CloudOptions options;
  options.fields = parseFields(GENERATE("x", "x,ring,tie", "x,y,z,range,ring,beam,triangle,instance,tie,tolerance"));
  options.compact = GENERATE(false, true);
  writeCloud(tiny(), folder / "a.npy", options);
  const std::string bytes = bytesOf(folder / "a.npy");
  CHECK(bytes.substr(0, 8) == std::string("\x93NUMPY\x01\x00", 8));
  const size_t length = at<uint16_t>(bytes, 8);
  CHECK((10 + length) % 64 == 0);
  CHECK(bytes[10 + length - 1] == '\n');
  const std::string header = bytes.substr(10, length);
  CHECK_THAT(header, ContainsSubstring("{'descr': [('x', '<f4')"));
  CHECK_THAT(header, ContainsSubstring(*options.compact ? "'shape': (5,), }" : "'shape': (2, 3), }"));
  const size_t rowBytes = options.fields.size() == 1 ? 4 : options.fields.size() == 3 ? 7 : 35;
  CHECK(bytes.size() == 10 + length + (*options.compact ? 5 : 6) * rowBytes);
}

TEST_CASE("Python reads an NPY cloud according to the format") {
  if (std::system("python3 -c pass >/dev/null 2>&1") != 0) SKIP("there is no python3");
  const Folder folder;
  writeCloud(tiny(), folder / "a.npy");
  put(folder / "read.py", R"(
import ast, struct, sys
b = open(sys.argv[1], 'rb').read()
assert b[:6] == b'\x93NUMPY' and b[6] == 1
n = struct.unpack('<H', b[8:10])[0]
h = ast.literal_eval(b[10:10 + n].decode('latin1').strip())
assert set(h) == {'descr', 'fortran_order', 'shape'} and h['fortran_order'] is False
row = struct.Struct('<' + ''.join({'<f4': 'f', '<u2': 'H', '<u4': 'I', '|u1': 'B'}[t] for _, t in h['descr']))
rows = list(row.iter_unpack(b[10 + n:]))
names = [name for name, _ in h['descr']]
assert names == 'x y z range ring beam triangle instance'.split(), names
assert h['shape'] == (2, 3) and len(rows) == 6
assert [r[4] for r in rows] == [0, 0, 0, 1, 1, 1] and [r[5] for r in rows] == list(range(6))
assert rows[4][3] != rows[4][3] and rows[4][6] == 0xffffffff and rows[5][3] == 6.0
)");
  CHECK(std::system(("python3 " + (folder / "read.py").string() + " " + (folder / "a.npy").string()).c_str()) == 0);
}

TEST_CASE("an empty cloud and a cloud of misses are valid files") {
  const Folder folder;
  const std::string ending = GENERATE("pcd", "ply", "npy", "csv", "bin");
  CloudOptions options;
  options.compact = GENERATE(false, true);
  Scan none = tiny();
  none.channels = 0;
  none.points.clear(), none.ranges.clear(), none.triangles.clear(), none.instances.clear();
  CHECK_NOTHROW(writeCloud(none, folder / ("none." + ending), options));
  Scan misses = tiny();
  std::fill(misses.ranges.begin(), misses.ranges.end(), std::nanf(""));
  std::fill(misses.points.begin(), misses.points.end(), std::nanf(""));
  std::fill(misses.triangles.begin(), misses.triangles.end(), kNoTriangle);
  std::fill(misses.instances.begin(), misses.instances.end(), kNoTriangle);
  CHECK_NOTHROW(writeCloud(misses, folder / ("misses." + ending), options));
  if (ending == "bin") return;
  CHECK(readCloud(folder / ("none." + ending)).beamCount() == 0);
  CHECK(readCloud(folder / ("misses." + ending)).counters.hits == 0);
}

TEST_CASE("an empty cloud and a cloud of misses have pictures") {
  const Folder folder;
  Scan none = tiny(), misses = tiny();
  none.channels = 0;
  none.points.clear(), none.ranges.clear(), none.triangles.clear(), none.instances.clear();
  std::fill(misses.ranges.begin(), misses.ranges.end(), std::nanf(""));
  std::fill(misses.points.begin(), misses.points.end(), std::nanf(""));
  for (const Scan& scan : {none, misses}) {
    writePicture(scan, folder / "a.png");
    CHECK(Pixels(folder / "a.png").width >= 1400);
  }
}

TEST_CASE("writers of one file do not disturb each other, and the last one that ends has written it") {
  const Folder folder;
  const fs::path file = folder / "same.bin";
  put(folder / "same.bin.part", "the user's");
  put(folder / ".same.bin.part", "left by a process that was killed");
  {
    AtomicFile first(file), second(file), given(file);
    first.write("fir");
    second.write("second");
    checkWritable(file);
    first.write("st");
    first.commit();
    CHECK(bytesOf(file) == "first");
    second.commit();
    CHECK(bytesOf(file) == "second");
  }
  CHECK(bytesOf(folder / "same.bin.part") == "the user's");
  CHECK(folder.fileCount() == 2);
  const std::string longest(255, 'n');  // as long as a name can be
  AtomicFile named(folder / longest);
  named.commit();
  CHECK(fs::exists(folder / longest));
}

#ifndef _WIN32
TEST_CASE("a link or a pipe that has the name of an unfinished file is left alone") {
  const Folder folder;
  put(folder / "victim", "precious");
  fs::create_symlink("victim", folder / ".linked.part");
  REQUIRE(mkfifo((folder / ".piped.part").c_str(), 0600) == 0);
  for (const char* name : {"linked", "piped"}) {
    AtomicFile file(folder / name);
    file.write("new");
    file.commit();
    CHECK(fs::is_regular_file(fs::symlink_status(folder / name)));
    CHECK(bytesOf(folder / name) == "new");
  }
  CHECK(bytesOf(folder / "victim") == "precious");
  CHECK(fs::is_symlink(folder / ".linked.part"));
  CHECK_THROWS_WITH(AtomicFile(folder / "other", folder / ".linked.part"), ContainsSubstring("cannot be written"));
  CHECK(bytesOf(folder / "victim") == "precious");
}

TEST_CASE("a file that is replaced hands its permissions on") {
  const Folder folder;
  put(folder / "secret", "old");
  fs::permissions(folder / "secret", fs::perms::owner_read | fs::perms::owner_write);
  AtomicFile file(folder / "secret");
  file.write("new");
  file.commit();
  CHECK(bytesOf(folder / "secret") == "new");
  CHECK(fs::status(folder / "secret").permissions() == (fs::perms::owner_read | fs::perms::owner_write));
}
#endif

TEST_CASE("a cloud that cannot be written leaves no file behind") {
  const Folder folder;
  Scan scan = tiny();
  CHECK_THROWS_WITH(writeCloud(scan, folder / "no" / "a.pcd"),
                    ContainsSubstring("No such file or directory; there is no folder '" + (folder / "no").string()));
  fs::create_directory(folder / "folder.pcd");
  CHECK_THROWS_WITH(writeCloud(scan, folder / "folder.pcd"), ContainsSubstring("Is a directory"));
  CHECK_THROWS_WITH(writeCloud(scan, folder / "a.las"), ContainsSubstring(".pcd, .ply, .bin (KITTI), .npy"));
  ScanColumns(scan).make(Field::tie, false);
  CloudOptions options;
  options.fields = {Field::tie};
  put(folder / "kept.pcd", "before");
  CHECK_THROWS_WITH(writeCloud(scan, folder / "kept.pcd", options),
                    ContainsSubstring("only the device 'reference' gives it"));
  CHECK(bytesOf(folder / "kept.pcd") == "before");
  CHECK(folder.fileCount() == 2);  // folder.pcd and kept.pcd, without an unfinished file
}

TEST_CASE("rings beyond their 16 bits are refused where they are asked for, unless the scan states its own") {
  const Folder folder;
  Scan scan;
  scan.columns = 1;
  const auto lastOf = [&](std::vector<Field> fields) {
    CloudOptions options;
    options.fields = std::move(fields);
    writeCloud(scan, folder / "a.pcd", options);
    const std::string bytes = bytesOf(folder / "a.pcd");
    return at<uint16_t>(bytes, bytes.size() - 2);
  };
  scan.channels = 65536;
  scan.ranges.assign(65536, 1);
  CHECK(lastOf({Field::range, Field::ring}) == 65535);
  scan.channels = 65537;
  scan.ranges.push_back(1);
  CHECK(lastOf({Field::range}) == 0x3f80);  // the upper half of 1
  CHECK_THROWS_WITH(lastOf({Field::range, Field::ring}),
                    ContainsSubstring("16 bits wide, the scan has 65537 channels; leave it out"));
  ScanColumns(scan).fill<uint16_t>(Field::ring, 7);
  CHECK(lastOf({Field::range, Field::ring}) == 7);
}

TEST_CASE("a picture is upright, whether channels count from the bottom or from the top") {
  const Folder folder;
  Sensor sensor = builtinSensor("VLP-16");
  writePicture(syntheticScan(sensor), folder / "up.png");
  std::reverse(sensor.channels.begin(), sensor.channels.end());
  writePicture(syntheticScan(sensor), folder / "down.png");
  CHECK(bytesOf(folder / "up.png") == bytesOf(folder / "down.png"));
}

TEST_CASE("a picture is no mirror image, whichever way the head turns") {
  const Folder folder;
  Sensor sensor = builtinSensor("VLP-16");
  writePicture(syntheticScan(sensor), folder / "left.png");
  sensor.azimuthStartDeg = 180 - 360.0 / sensor.columns;
  sensor.azimuthSpanDeg = -360;
  writePicture(syntheticScan(sensor), folder / "right.png");
  CHECK(bytesOf(folder / "left.png") == bytesOf(folder / "right.png"));
}

TEST_CASE("an image of any head lies as its beams do, whatever they hit") {
  const std::vector<CatalogueHead>& heads = sensorCatalogue();
  REQUIRE(heads.size() > 40);
  for (const CatalogueHead& head : heads) {
    const Sensor sensor = builtinSensor(head.name);
    const uint32_t columns = sensor.width(), channels = sensor.height();
    INFO(head.name << ", " << channels << " x " << columns);
    const BeamList beams = beamsOf(sensor);
    const ImageOrder order = imageOrderOf(sensor);
    const auto heightOf = [&](uint32_t row) {
      double sum = 0;
      for (uint32_t column = 0; column < columns; ++column) sum += beams.directions[size_t{row} * columns + column].z;
      return sum / columns;
    };
    if (channels > 1) CHECK(order.firstRowOnTop == (heightOf(0) > heightOf(channels - 1)));
    const Vec3 &first = beams.directions[0], &last = beams.directions[columns - 1];
    const bool turnsRight = sensor.isGrid() ? sensor.azimuthSpanDeg < 0 : first.x * last.y < first.y * last.x;
    if (channels > 1) CHECK(order.firstColumnOnLeft == turnsRight);
  }
}

TEST_CASE("points of the upper or the lower channels alone tell how the image of a file lies") {
  Sensor sensor = builtinSensor("HDL-64E");
  sensor.azimuthSpanDeg = GENERATE(360, -360);
  if (GENERATE(false, true)) std::reverse(sensor.channels.begin(), sensor.channels.end());
  const bool upper = GENERATE(false, true);
  Scan scan = syntheticScan(sensor);
  for (size_t beam = 0; beam < scan.beamCount(); ++beam)
    if ((beam / scan.columns < 32) == upper) std::fill_n(&scan.points[3 * beam], 3, std::nanf(""));
  const ImageOrder order = imageOrderOf(scan);
  CHECK(order.firstRowOnTop == scan.firstRowOnTop);
  CHECK(order.firstColumnOnLeft == scan.firstColumnOnLeft);
}

TEST_CASE("what is to the left of the sensor is in the left half of both pictures") {
  const Folder folder;
  Sensor sensor = builtinSensor("VLP-16");
  if (GENERATE(false, true)) sensor.azimuthSpanDeg = -360;
  Scan scan = syntheticScan(sensor);
  for (size_t beam = 0; beam < scan.beamCount(); ++beam)
    if (!(scan.points[3 * beam + 1] > 1)) {
      scan.ranges[beam] = std::numeric_limits<float>::quiet_NaN();
      std::fill_n(&scan.points[3 * beam], 3, std::numeric_limits<float>::quiet_NaN());
    }
  writePicture(scan, folder / "a.png");
  const Pixels pixels(folder / "a.png");
  // The range image begins at row 56, and the view from above is a square at the end.
  const int width = pixels.width, height = pixels.height, side = width - 48;
  for (const auto& [top, bottom] : {std::pair(56, height - 24 - side - 56), std::pair(height - 24 - side, height)}) {
    int coloured[2] = {};
    for (int y = top; y < bottom; ++y)
      for (int x = 24; x < width - 24; ++x) {
        const uint8_t* p = pixels.at(x, y);
        coloured[x >= width / 2] += std::max({p[0], p[1], p[2]}) - std::min({p[0], p[1], p[2]}) > 60;
      }
    CHECK(coloured[0] > 100);
    CHECK(coloured[1] == 0);
  }
}

TEST_CASE("a picture has a reasonable size, and the range image of any number of columns fills its width") {
  const Folder folder;
  Sensor sensor = builtinSensor("VLP-16");
  sensor.columns = GENERATE(1u, 3u, 360u, 1399u, 1800u, 2048u, 5001u);
  if (sensor.columns == 1 || sensor.columns == 5001) sensor.channels.resize(1);
  writePicture(syntheticScan(sensor), folder / "a.png");
  CHECK(folder.fileCount() == 1);
  const Pixels pixels(folder / "a.png");
  CHECK((pixels.width >= 1400 && pixels.width <= 2100));
  CHECK((pixels.height > pixels.width && pixels.height < 3 * pixels.width));
  if (sensor.channels.size() == 1) return;
  constexpr int kMargin = 24, kTop = 64;  // the range image begins above this row
  int empty = 0;
  for (int x = kMargin; x < pixels.width - kMargin; ++x) {
    const auto isHit = [&](int y) {
      const uint8_t* pixel = pixels.at(x, y);
      return std::max({pixel[0], pixel[1], pixel[2]}) > 60;  // misses and the background are darker
    };
    bool any = false;
    for (int y = kTop; y < kTop + 200 && !any; ++y) any = isHit(y);
    empty += !any;
  }
  CHECK(empty == 0);
}

TEST_CASE("a beam of range 0 does not hide the other beams of its pixel") {
  const Folder folder;
  Sensor sensor = builtinSensor("VLP-16");
  sensor.columns = 5001;  // a pixel has three columns
  Scan scan = syntheticScan(sensor);
  const auto rangeImage = [&](float range) {
    for (size_t beam = 0; beam < scan.beamCount(); beam += 3) scan.ranges[beam] = range;
    writePicture(scan, folder / "a.png");
    const Pixels pixels(folder / "a.png");
    return std::vector(pixels.at(0, 56), pixels.at(0, 300));
  };
  CHECK(rangeImage(0) == rangeImage(std::nanf("")));
}

TEST_CASE("a scan without hits has a picture of its misses alone") {
  const Folder folder;
  Scan scan = syntheticScan(builtinSensor("VLP-16"));
  writePicture(scan, folder / "hits.png");
  for (std::vector<float>* values : {&scan.points, &scan.ranges})
    std::fill(values->begin(), values->end(), std::nanf(""));
  writePicture(scan, folder / "none.png");
  const Pixels hits(folder / "hits.png"), none(folder / "none.png");
  CHECK((none.width == hits.width && none.height == hits.height));
  const auto brightest = [](const Pixels& pixels) {  // in the part of the range image
    return *std::max_element(pixels.at(0, 64), pixels.at(0, 264));
  };
  CHECK(brightest(hits) > 150);
  CHECK(brightest(none) < 60);
}

TEST_CASE("a picture from above has a few rings of round distances") {
  const Folder folder;
  for (const auto& [distance, rings] : {std::pair(9.9f, 5), {0.95f, 5}, {99.0f, 5}, {5.5f, 5}, {13.5f, 7}}) {
    INFO(distance << " m");
    Scan scan = syntheticScan(builtinSensor("VLP-16"));
    for (size_t beam = 0; beam < scan.beamCount(); ++beam) {  // all points to the right
      const float angle = 3.14159f * static_cast<float>(beam) / static_cast<float>(scan.beamCount());
      scan.points[3 * beam] = distance * std::cos(angle);
      scan.points[3 * beam + 1] = -distance * std::sin(angle);
    }
    writePicture(scan, folder / "a.png");
    const Pixels pixels(folder / "a.png");
    const int side = pixels.width - 48, y = pixels.height - 24 - side / 2;
    int crossed = 0;
    for (int x = 24; x < 24 + side / 2 - 10; ++x)
      crossed += pixels.at(x, y)[1] > 20 && !(pixels.at(x - 1, y)[1] > 20);  // the background has 13
    CHECK(crossed == rings);
  }
}

TEST_CASE("a picture of beams has a ring for each that fires, and lines at round angles around them") {
  const Folder folder;
  const auto picture = [&](const Sensor& sensor) {
    writePatternPicture(sensor, folder / "a.png");
    return Pixels(folder / "a.png");
  };
  Sensor sensor{.name = "one", .rangeMax = 10};
  const auto add = [&](double azimuth, double elevation) {
    sensor.patterns[0].directions.push_back(unitVectorAt(azimuth, elevation));
  };
  sensor.patterns.resize(1);
  add(7.3, 3.1);
  // The plot is 1480 x 1000 pixels from (90, 60) on, and 2 x 2 degrees around the beam.
  const Pixels one = picture(sensor);
  const auto isLine = [](const uint8_t* pixel) { return pixel[1] > 40; };  // the background has 13
  int lines[2] = {};
  for (int x = 90; x < 1570; ++x) lines[0] += isLine(one.at(x, 65));
  for (int y = 60; y < 1060; ++y) lines[1] += isLine(one.at(95, y));
  CHECK(lines[0] == 4);  // 6.5, 7, 7.5 and 8 degrees
  CHECK(lines[1] == 4);  // 2.5, 3, 3.5 and 4 degrees
  // The ring is 2.5 pixels from its middle to the middle of its line, which fades within a pixel on either side: in all
  // as much as 2 pi 2.5 pixels of the middle colour of Turbo, whose green is 0.99.
  double covered = 0;
  for (int y = 550; y <= 570; ++y)
    for (int x = 820; x <= 840; ++x) covered += (one.at(x, y)[1] - 13) / (0.99 * 255 - 13);
  CHECK(std::abs(covered / (2 * 3.14159 * 2.5) - 1) < 0.06);
  CHECK(one.at(830, 560)[1] == 13);

  add(8.1, 3.3);
  add(-20, 1);
  sensor.maskedBeams = {1, 2};
  CHECK(picture(sensor).rgb == one.rgb);
  sensor.maskedBeams = {0, 1, 2};
  CHECK(picture(sensor).width == one.width);
  // Where many degrees are shown, the lines are more of them apart.
  sensor.maskedBeams = {};
  const Pixels wide = picture(sensor);
  int across = 0;
  for (int x = 90; x < 1570; ++x) across += isLine(wide.at(x, 65));
  CHECK(across == 6);  // -20, -15 ... 5 degrees
}

TEST_CASE("a letter that the font of pictures lacks is a question mark") {
  const Folder folder;
  Sensor sensor = builtinSensor("VLP-16");
  sensor.name = "K\xc3\xbc\x01";
  writePatternPicture(sensor, folder / "a.png");
  sensor.name = "K???";
  writePatternPicture(sensor, folder / "b.png");
  CHECK(bytesOf(folder / "a.png") == bytesOf(folder / "b.png"));
}
