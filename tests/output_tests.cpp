// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <bit>
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>

#include "output/cloud_table.hpp"
#include "synthetic_scan.hpp"

using namespace gnosphere;
using Catch::Matchers::ContainsSubstring;
namespace fs = std::filesystem;

namespace {

/// A folder of its own for each test, gone afterwards.
struct Folder {
  fs::path path;
  Folder() {
    std::string name = (fs::temp_directory_path() / "gnosphere-output-XXXXXX").string();
    REQUIRE(mkdtemp(name.data()) != nullptr);
    path = name;
  }
  ~Folder() { fs::remove_all(path); }
  fs::path operator/(const std::string& name) const { return path / name; }
  size_t fileCount() const { return static_cast<size_t>(std::distance(fs::directory_iterator(path), {})); }
};

std::string bytesOf(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

void put(const fs::path& file, const std::string& bytes) {
  std::ofstream(file, std::ios::binary) << bytes;
}

template <class T>
T at(const std::string& bytes, size_t offset) {
  T value;
  REQUIRE(offset + sizeof(T) <= bytes.size());
  std::memcpy(&value, bytes.data() + offset, sizeof(T));
  return value;
}

/// Three columns, two channels, one miss; every array filled.
Scan tiny() {
  Scan scan;
  scan.sensor = "tiny";
  scan.columns = 3;
  scan.channels = 2;
  for (uint32_t beam = 0; beam < 6; ++beam) {
    const auto f = static_cast<float>(beam);
    const bool hit = beam != 4;
    const float nan = std::nanf("");
    for (float value : {f + 0.1f, -f, f * 1e-20f}) scan.points.push_back(hit ? value : nan);
    scan.ranges.push_back(hit ? f + 1 : nan);
    scan.triangles.push_back(hit ? 100 + beam : kNoTriangle);
    scan.instances.push_back(hit ? 7 : kNoTriangle);
    scan.ties.push_back(beam == 2);
    scan.tolerances.push_back(hit ? 1e-5f : nan);
  }
  return scan;
}

template <class T>
bool sameBytes(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

/// Bytes, except that one NaN is as good as another.
bool sameFloats(const std::vector<float>& a, const std::vector<float>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](float x, float y) {
    return std::bit_cast<uint32_t>(x) == std::bit_cast<uint32_t>(y) || (std::isnan(x) && std::isnan(y));
  });
}

void checkSame(const Scan& read, const Scan& written) {
  CHECK(read.columns == written.columns);
  CHECK(read.channels == written.channels);
  CHECK(sameFloats(read.points, written.points));
  CHECK(sameFloats(read.ranges, written.ranges));
  CHECK(sameBytes(read.triangles, written.triangles));
  CHECK(sameBytes(read.instances, written.instances));
}

std::string problemOf(const fs::path& file) {
  try {
    readCloud(file);
  } catch (const Error& error) {
    CHECK(error.code() == ErrorCode::format);
    CHECK_THAT(error.what(), ContainsSubstring(file.filename().string()));
    return error.what();
  }
  return "nothing was wrong";
}

}  // namespace

TEST_CASE("field names are parsed in order, and an unknown one lists those there are") {
  CHECK(parseFields("z, ring,TRIANGLE") == std::vector<Field>{Field::z, Field::ring, Field::triangle});
  CHECK_THROWS_WITH(parseFields("x,intensity"),
                    ContainsSubstring("'intensity'") && ContainsSubstring("x, y, z, range"));
  CHECK_THROWS_WITH(parseFields(""), ContainsSubstring("''"));
  CHECK_THROWS_WITH(parseFields("x,,y"), ContainsSubstring("''"));
  CHECK_THROWS_WITH(parseFields("x,y,x"), ContainsSubstring("twice"));
}

TEST_CASE("a PCD file is organised, binary and exactly as its header says") {
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

TEST_CASE("ascii PCD and CSV are readable text, one line per beam") {
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

TEST_CASE("a PLY file states its types and packs its rows") {
  const Folder folder;
  CloudOptions options;
  options.fields = parseFields("x,ring,tie,tolerance,instance");
  writeCloud(tiny(), folder / "a.ply", options);
  const std::string bytes = bytesOf(folder / "a.ply");
  const std::string header =
      "ply\nformat binary_little_endian 1.0\ncomment gnosphere columns 3 channels 2 sensor tiny\nelement vertex 6\n"
      "property float x\nproperty ushort ring\nproperty uchar tie\nproperty float tolerance\nproperty uint instance\n"
      "end_header\n";
  REQUIRE(bytes.substr(0, header.size()) == header);
  REQUIRE(bytes.size() == header.size() + 6 * 15);
  CHECK(at<uint8_t>(bytes, header.size() + 2 * 15 + 6) == 1);
  CHECK(at<uint32_t>(bytes, header.size() + 2 * 15 + 11) == 7);
}

TEST_CASE("a KITTI file is x, y, z and a zero reflectance of the hits") {
  const Folder folder;
  writeCloud(tiny(), folder / "a.bin");
  const std::string bytes = bytesOf(folder / "a.bin");
  REQUIRE(bytes.size() == 5 * 16);
  CHECK(at<float>(bytes, 4 * 16) == 5.1f);  // the sixth beam, after the miss
  CHECK(at<float>(bytes, 4 * 16 + 4) == -5);
  for (size_t row = 0; row < 5; ++row) CHECK(at<float>(bytes, row * 16 + 12) == 0);
}

TEST_CASE("an NPY file starts its data at a multiple of 64 bytes and has the sensor's shape") {
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
  CHECK_THAT(header, ContainsSubstring(options.compact ? "'shape': (5,), }" : "'shape': (2, 3), }"));
  const size_t rowBytes = options.fields.size() == 1 ? 4 : options.fields.size() == 3 ? 7 : 35;
  CHECK(bytes.size() == 10 + length + (options.compact ? 5 : 6) * rowBytes);
}

TEST_CASE("Python reads an NPY cloud by the rules of the format") {
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

TEST_CASE("every format that says which beam is which reads back to the same bits") {
  const Folder folder;
  const std::string ending = GENERATE("pcd", "ply", "npy", "csv");
  CloudOptions options;
  options.ascii = GENERATE(false, true);
  const Scan scan = syntheticScan(findSensor("VLP-16"));
  writeCloud(scan, folder / ("a." + ending), options);
  checkSame(readCloud(folder / ("a." + ending)), scan);
}

TEST_CASE("a compact PCD or PLY cloud is put back on its grid") {
  const Folder folder;
  const std::string ending = GENERATE("pcd", "ply");
  CloudOptions options;
  options.compact = true;
  options.ascii = GENERATE(false, true);
  writeCloud(tiny(), folder / ("a." + ending), options);
  const Scan back = readCloud(folder / ("a." + ending));
  checkSame(back, tiny());
  CHECK(back.sensor == "tiny");
  CHECK(back.counters.hits == 5);
}

TEST_CASE("ties and tolerances of the reference are written and read") {
  const Folder folder;
  const std::string ending = GENERATE("pcd", "ply", "npy", "csv");
  CloudOptions options;
  options.fields = parseFields("tolerance,tie,instance,triangle,beam,range");
  writeCloud(tiny(), folder / ("a." + ending), options);
  const Scan back = readCloud(folder / ("a." + ending));
  CHECK(back.ties == tiny().ties);
  CHECK(sameFloats(back.tolerances, tiny().tolerances));
  CHECK(back.points.empty());
}

TEST_CASE("a range that a file lacks comes from its points") {
  const Folder folder;
  put(folder / "a.csv", "x,y,z\n3,4,0\n0,0,-2\n");
  const Scan scan = readCloud(folder / "a.csv");
  CHECK(scan.ranges == std::vector<float>{5, 2});
  CHECK(scan.columns == 2);
}

TEST_CASE("clouds that other programs wrote are read") {
  const fs::path data = fs::path(GNOSPHERE_TEST_DATA) / "clouds";
  CHECK(readCloud(data / "ascii_xyz.pcd").points == std::vector<float>{1.5f, -2.25f, 3, -4.5f, 5.125f, 6.75f});
  CHECK(readCloud(data / "binary_xyz_pcl.pcd").points == std::vector<float>{1.25f, 2.5f, -3.75f, -10, 20, 30});
  CHECK(readCloud(data / "utm17_tab.pcd").points.at(2) == 170.76f);
  CHECK(readCloud(data / "simple_text.ply").points == std::vector<float>{-1, 0, 0, 0, 1, 0, 1, 0, 0});
  CHECK(readCloud(data / "simple_binary.ply").points == std::vector<float>{-1, 0, 0, 0, 1, 0, 1, 0, 0});
  CHECK_THAT(problemOf(data / "missingheader.pcd"), ContainsSubstring("not a PCD file"));
  CHECK_THAT(problemOf(data / "no_vertex.ply"), ContainsSubstring("no element vertex"));
}

TEST_CASE("the compression of PCL's binary_compressed is undone") {
  const Folder folder;
  // x = 1.0f three times: four literals, then eight more bytes from four back; y, z = 0: one literal, 23 from one back.
  const std::string stream("\x03\x00\x00\x80\x3f\xc0\x03\x00\x00\xe0\x0e\x00", 12);
  const auto word = [](uint32_t value) { return std::string(reinterpret_cast<const char*>(&value), 4); };
  const std::string header =
      "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 3\nHEIGHT 1\nPOINTS 3\n"
      "DATA binary_compressed\n";
  put(folder / "a.pcd", header + word(12) + word(36) + stream);
  CHECK(readCloud(folder / "a.pcd").points == std::vector<float>{1, 0, 0, 1, 0, 0, 1, 0, 0});
  put(folder / "b.pcd", header + word(12) + word(37) + stream);
  CHECK_THAT(problemOf(folder / "b.pcd"), ContainsSubstring("length"));
  put(folder / "c.pcd", header + word(12) + word(36) + stream.substr(0, 9));
  CHECK_THAT(problemOf(folder / "c.pcd"), ContainsSubstring("cut short"));
  put(folder / "d.pcd", header + word(2) + word(36) + std::string("\x20\x09", 2));
  CHECK_THAT(problemOf(folder / "d.pcd"), ContainsSubstring("before its start"));
}

TEST_CASE("a cloud cut short anywhere is refused, never misread") {
  const Folder folder;
  const std::string ending = GENERATE("pcd", "ply", "npy");
  writeCloud(tiny(), folder / ("whole." + ending));
  const std::string bytes = bytesOf(folder / ("whole." + ending));
  for (size_t length = 0; length < bytes.size(); ++length) {
    INFO(length << " of " << bytes.size() << " bytes");
    CHECK_THROWS_AS(readCloudBytes(cloudFormat("a." + ending), bytes.substr(0, length), "cut"), Error);
  }
}

TEST_CASE("a cloud with a byte changed anywhere is read or refused, never a crash") {
  const Folder folder;
  const std::string ending = GENERATE("pcd", "ply", "npy", "csv");
  CloudOptions options;
  options.compact = GENERATE(false, true);
  options.ascii = GENERATE(false, true);
  writeCloud(tiny(), folder / ("whole." + ending), options);
  const std::string bytes = bytesOf(folder / ("whole." + ending));
  for (size_t i = 0; i < bytes.size(); ++i) {
    for (char change : {'\x01', '\x10', '\x7f'}) {
      std::string changed = bytes;
      changed[i] = static_cast<char>(changed[i] ^ change);
      try {
        readCloudBytes(cloudFormat("a." + ending), changed, "changed");
      } catch (const Error& error) {
        CHECK(error.code() == ErrorCode::format);
      }
    }
  }
}

TEST_CASE("absurd counts and unsound values are refused before memory is asked for") {
  const Folder folder;
  const auto pcd = [&](const std::string& size, const std::string& data) {
    put(folder / "a.pcd",
        "VERSION 0.7\nFIELDS x y z beam\nSIZE 4 4 4 4\nTYPE F F F U\n" + size + "DATA ascii\n" + data);
    return problemOf(folder / "a.pcd");
  };
  CHECK_THAT(pcd("WIDTH 4000000000\nHEIGHT 4000000000\n", ""), ContainsSubstring("cut short"));
  CHECK_THAT(pcd("WIDTH 2\nHEIGHT 1\nPOINTS 3\n", "0 0 0 0\n0 0 0 1\n"), ContainsSubstring("POINTS 3"));
  CHECK_THAT(pcd("WIDTH 1\nHEIGHT 1\n", "0 0 0 4294967290\n"), ContainsSubstring("4294967291 beams"));
  CHECK_THAT(pcd("WIDTH 2\nHEIGHT 1\n", "0 0 0 5\n0 0 0 5\n"), ContainsSubstring("twice"));
  CHECK_THAT(pcd("WIDTH 1\nHEIGHT 1\n", "0 0 0 -1\n"), ContainsSubstring("'-1'"));
  CHECK_THAT(pcd("WIDTH 1\nHEIGHT 1\n", "0 0 zero 1\n"), ContainsSubstring("'zero'"));
  CHECK_THAT(pcd("COUNT 1 1\n", ""), ContainsSubstring("COUNT has 2 entries, FIELDS has 4"));
  put(folder / "b.pcd",
      "# gnosphere columns 65535 channels 65535\nFIELDS x y z beam\nWIDTH 1\nHEIGHT 1\nDATA ascii\n0 0 0 1\n");
  CHECK_THAT(problemOf(folder / "b.pcd"), ContainsSubstring("65535 columns"));
  put(folder / "c.csv", "a,b\n1,2\n");
  CHECK_THAT(problemOf(folder / "c.csv"), ContainsSubstring("neither x, y, z nor range"));
  put(folder / "d.csv", "");
  CHECK_THAT(problemOf(folder / "d.csv"), ContainsSubstring("empty"));
}

TEST_CASE("an empty cloud and a cloud of misses are files like any other") {
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
  CHECK_NOTHROW(writePicture(none, folder / "none.png"));
  CHECK_NOTHROW(writePicture(misses, folder / "misses.png"));
}

TEST_CASE("a cloud that cannot be written leaves nothing behind") {
  const Folder folder;
  Scan scan = tiny();
  CHECK_THROWS_WITH(writeCloud(scan, folder / "no" / "a.pcd"), ContainsSubstring("No such file or directory"));
  fs::create_directory(folder / "folder.pcd");
  CHECK_THROWS_WITH(writeCloud(scan, folder / "folder.pcd"), ContainsSubstring("Is a directory"));
  CHECK_THROWS_WITH(writeCloud(scan, folder / "a.las"), ContainsSubstring(".pcd, .ply, .bin (KITTI), .npy and .csv"));
  scan.ties.clear();
  CloudOptions options;
  options.fields = {Field::tie};
  put(folder / "kept.pcd", "before");
  CHECK_THROWS_WITH(writeCloud(scan, folder / "kept.pcd", options), ContainsSubstring("--device reference gives it"));
  CHECK(bytesOf(folder / "kept.pcd") == "before");
  CHECK(folder.fileCount() == 2);  // folder.pcd and kept.pcd, no .part
}

TEST_CASE("reading says which file it could not read") {
  const Folder folder;
  CHECK_THROWS_WITH(readCloud(folder / "none.pcd"), ContainsSubstring("none.pcd: cannot be read: No such file"));
  fs::create_directory(folder / "folder.pcd");
  CHECK_THROWS_WITH(readCloud(folder / "folder.pcd"), ContainsSubstring("Is a directory"));
  CHECK_THROWS_WITH(readCloud(folder / "a.bin"), ContainsSubstring("does not say which beams"));
}

TEST_CASE("a picture is a PNG of a sensible size, whatever the grid") {
  const Folder folder;
  Sensor sensor = findSensor("VLP-16");
  sensor.columns = GENERATE(1u, 7u, 1800u, 5001u);
  sensor.channels.resize(GENERATE(size_t{1}, size_t{16}));
  writePicture(syntheticScan(sensor), folder / "a.png");
  const std::string bytes = bytesOf(folder / "a.png");
  REQUIRE(bytes.substr(0, 8) == "\x89PNG\r\n\x1a\n");
  const auto bigEndian = [&](size_t offset) { return __builtin_bswap32(at<uint32_t>(bytes, offset)); };
  CHECK(bigEndian(16) >= 1400);
  CHECK(bigEndian(16) <= 2100);
  CHECK(bigEndian(20) > bigEndian(16));
  CHECK(bigEndian(20) < 3 * bigEndian(16));
  CHECK(folder.fileCount() == 1);
}
