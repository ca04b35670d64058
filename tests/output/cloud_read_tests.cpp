// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <cstring>
#include <limits>
#include <utility>

#include "base/npy.hpp"
#include "cloud_support.hpp"
#include "output/cloud_table.hpp"
#include "problem.hpp"
#include "synthetic_scan.hpp"

using namespace gnosphere;
using namespace gnosphere::test;
using Catch::Matchers::ContainsSubstring;

namespace {

void checkSame(const Scan& read, const Scan& written) {
  CHECK(read.columns == written.columns);
  CHECK(read.channels == written.channels);
  CHECK(sameFloats(read.points, written.points));
  CHECK(sameFloats(read.ranges, written.ranges));
  CHECK(sameBytes(read.triangles, written.triangles));
  CHECK(sameBytes(read.instances, written.instances));
}

std::string problemOf(const fs::path& file) {
  const std::string problem = test::problemOf([&] { readCloud(file); }, ErrorCode::format);
  CHECK_THAT(problem, ContainsSubstring(file.filename().string()));
  return problem;
}

}  // namespace

TEST_CASE("a PCD file with a field of no values is refused") {
  const Folder folder;
  for (const std::string data : {"binary", "binary_compressed", "ascii"}) {
    const std::string header =
        "FIELDS x y z t\nSIZE 4 4 4 8\nTYPE F F F F\nCOUNT 1 1 1 0\nWIDTH 2\nHEIGHT 1\nPOINTS 2\nDATA " + data + "\n";
    std::ofstream(folder / "a.pcd") << header << std::string(24, '\0');
    CHECK_THAT(problemOf(folder / "a.pcd"), ContainsSubstring("COUNT must be 1 to 65536, is 0"));
  }
}

TEST_CASE("a cloud without owners has none, and says so") {
  const Folder folder;
  std::ofstream(folder / "a.csv") << "x,y,z\n1,2,3\n4,5,6\n";
  const Scan scan = readCloud(folder / "a.csv");
  CHECK(scan.triangles == std::vector<uint32_t>{kNoTriangle, kNoTriangle});
  CHECK(scan.instances == std::vector<uint32_t>{kNoTriangle, kNoTriangle});
  CHECK_FALSE(scan.hit(0));
  CHECK(scan.returned(1));
  CHECK_FALSE(scan.has(Field::triangle));
  CHECK_THROWS_AS(scan.column<uint32_t>(Field::instance), Error);
  CHECK_THROWS_AS(compare(scan, scan, 0.1), Error);
  // The memory of a scan that was read serves the next scan of a simulator.
  Scan reused = scan;
  Scene scene;
  SimulatorOptions options;
  options.device.kind = DeviceChoice::Kind::reference;
  Simulator simulator(scene, SensorRequest{builtinSensor("VLP-16"), Effects::none(), {}}, options);
  simulator.scanInto({}, reused);
  CHECK(reused.has(Field::triangle));
  // So does that of a scan without points, of which there may be none at all.
  for (const char* rows : {"range\n", "range\n1\n"}) {
    std::ofstream(folder / "b.csv") << rows;
    Scan ranges = readCloud(folder / "b.csv");
    CHECK_FALSE(ranges.has(Field::x));
    simulator.scanInto({}, ranges);
    CHECK(ranges.has(Field::x));
  }
  std::ofstream(folder / "none.csv") << "x,y,z\n";
  CHECK(readCloud(folder / "none.csv").has(Field::x));
}

TEST_CASE("every format that identifies beams reads back to the same bits") {
  const Folder folder;
  const std::string ending = GENERATE("pcd", "ply", "npy", "csv");
  CloudOptions options;
  options.ascii = GENERATE(false, true);
  const Scan scan = syntheticScan(builtinSensor("VLP-16"));
  writeCloud(scan, folder / ("a." + ending), options);
  checkSame(readCloud(folder / ("a." + ending)), scan);
}

TEST_CASE("a compact PCD or PLY cloud is read onto its grid") {
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

TEST_CASE("a cloud of several returns without the field beam is read as a list of points") {
  const Folder folder;
  const std::string ending = GENERATE("pcd", "ply", "npy", "csv");
  Scan scan;
  scan.columns = 3;
  scan.channels = 1;
  scan.returns = 2;
  const bool oneEach = GENERATE(false, true);  // three points of three beams are no grid either
  const float none = std::numeric_limits<float>::quiet_NaN();
  scan.ranges = {4, oneEach ? none : 5, 6, none, 7, none};
  scan.points.assign(18, none);
  for (size_t entry = 0; entry < 6; ++entry)
    if (scan.ranges[entry] > 0) std::fill_n(&scan.points[3 * entry], 3, scan.ranges[entry]);
  CloudOptions options;
  options.fields = parseFields("x,y,z,range");
  writeCloud(scan, folder / ("a." + ending), options);
  const Scan back = readCloud(folder / ("a." + ending));
  CHECK(back.returns == 1);
  CHECK(back.channels == 1);
  CHECK(back.ranges == (oneEach ? std::vector<float>{4, 6, 7} : std::vector<float>{4, 5, 6, 7}));
  CHECK(back.points[9 - 1] == (oneEach ? 7 : 6));
}

TEST_CASE("ties and tolerances of the reference are written and read") {
  const Folder folder;
  const std::string ending = GENERATE("pcd", "ply", "npy", "csv");
  CloudOptions options;
  options.fields = parseFields("tolerance,tie,instance,triangle,beam,range");
  writeCloud(tiny(), folder / ("a." + ending), options);
  const Scan back = readCloud(folder / ("a." + ending));
  CHECK(valuesOf<uint8_t>(back, Field::tie) == valuesOf<uint8_t>(tiny(), Field::tie));
  CHECK(sameFloats(valuesOf<float>(back, Field::tolerance), valuesOf<float>(tiny(), Field::tolerance)));
  CHECK(back.points.empty());
}

TEST_CASE("PLY is read with either spelling of types and normals") {
  const Folder folder;
  Scan scan = tiny();
  setColumn(scan, Field::normal, std::vector<float>(3 * scan.beamCount(), 0.5f));
  CloudOptions options;
  options.fields = parseFields("x,y,z,range,ring,beam,triangle,instance,tie,normal");
  writeCloud(scan, folder / "a.ply", options);
  std::string bytes = bytesOf(folder / "a.ply");
  for (const auto& [name, other] : {std::pair("uint16 ", "ushort "), std::pair("uint32 ", "uint "),
                                    std::pair("uint8 ", "uchar "), std::pair(" nx", " normal_x")}) {
    REQUIRE(bytes.find(name) != bytes.npos);
    for (size_t at = bytes.find(name); at != bytes.npos; at = bytes.find(name))
      bytes.replace(at, std::string(name).size(), other);
  }
  const Scan back = readCloudBytes(cloudFormat("a.ply"), bytes, "a.ply").scan;
  CHECK(back.triangles == scan.triangles);
  CHECK(valuesOf<uint8_t>(back, Field::tie) == valuesOf<uint8_t>(scan, Field::tie));
  CHECK(valuesOf<float>(back, Field::normal) == valuesOf<float>(scan, Field::normal));
}

TEST_CASE("a range that a file lacks is computed from the point") {
  const Folder folder;
  put(folder / "a.csv", "x,y,z\n3,4,0\n0,0,-2\n");
  const Scan scan = readCloud(folder / "a.csv");
  CHECK(scan.ranges == std::vector<float>{5, 2});
  CHECK(scan.columns == 2);
}

TEST_CASE("clouds written by other programs are read") {
  const fs::path data = fs::path(GNOSPHERE_TEST_DATA) / "clouds";
  CHECK(readCloud(data / "ascii_xyz.pcd").points == std::vector<float>{1.5f, -2.25f, 3, -4.5f, 5.125f, 6.75f});
  CHECK(readCloud(data / "binary_xyz_pcl.pcd").points == std::vector<float>{1.25f, 2.5f, -3.75f, -10, 20, 30});
  CHECK(readCloud(data / "utm17_tab.pcd").points.at(2) == 170.76f);
  CHECK(readCloud(data / "simple_text.ply").points == std::vector<float>{-1, 0, 0, 0, 1, 0, 1, 0, 0});
  CHECK(readCloud(data / "simple_binary.ply").points == std::vector<float>{-1, 0, 0, 0, 1, 0, 1, 0, 0});
  CHECK_THAT(problemOf(data / "missingheader.pcd"), ContainsSubstring("not a PCD file"));
  CHECK_THAT(problemOf(data / "no_vertex.ply"), ContainsSubstring("no element vertex"));
}

TEST_CASE("PCL's binary_compressed is decompressed") {
  const Folder folder;
  // x = 1.0f three times: four literals, then eight bytes copied from four back; y, z = 0: one literal, then 23 bytes
  // from one back.
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
  put(folder / "c.pcd", header + word(12) + word(35) + stream);
  CHECK_THAT(problemOf(folder / "c.pcd"), ContainsSubstring("compressed data does not have the stated length"));
  for (const auto& [size, packed] : {std::pair(36u, std::string("\x05\x00\x00", 3)),            // six literals
                                     std::pair(36u, std::string("\x00\x00\xe0", 3)),            // no length
                                     std::pair(4'000'000'000u, std::string("\x00\x00", 2))}) {  // far too few
    put(folder / "c.pcd", header + word(static_cast<uint32_t>(packed.size())) + word(size) + packed);
    CHECK_THAT(problemOf(folder / "c.pcd"), ContainsSubstring("compressed data is cut short"));
  }
  put(folder / "d.pcd", header + word(2) + word(36) + std::string("\x20\x09", 2));
  CHECK_THAT(problemOf(folder / "d.pcd"), ContainsSubstring("before its start"));
  // Two numbers a point of a histogram, then the three x, all as literals.
  const std::string one = word(0x3f800000), plain = std::string(16, '\7') + one + one + std::string(16, '\0');
  put(folder / "e.pcd",
      "VERSION 0.7\nFIELDS hist x y z\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 2 1 1 1\nWIDTH 2\nHEIGHT 1\nPOINTS 2\n"
      "DATA binary_compressed\n" +
          word(42) + word(40) + '\x1f' + plain.substr(0, 32) + '\7' + plain.substr(32));
  CHECK(readCloud(folder / "e.pcd").points == std::vector<float>{1, 0, 0, 1, 0, 0});
}

TEST_CASE("a number in a text that its field cannot hold is refused") {
  const Folder folder;
  put(folder / "a.csv", "x,y,z,class\n1,2,3,65535\n");
  CHECK(valuesOf<uint16_t>(readCloud(folder / "a.csv"), Field::classId) == std::vector<uint16_t>{65535});
  put(folder / "b.csv", "x,y,z,class\n1,2,3,65536\n");
  CHECK_THAT(problemOf(folder / "b.csv"), ContainsSubstring("point 0: '65536' does not fit the field 'class'"));
}

TEST_CASE("a number in a text that is too large for its field becomes infinity, and one too small 0") {
  const Folder folder;
  put(folder / "a.csv", "x,y,z,range,intensity\n1e40,-1e400,1e-400,+1e400,-1e-60\n");
  const Scan scan = readCloud(folder / "a.csv");
  const float infinity = std::numeric_limits<float>::infinity();
  CHECK(scan.points == std::vector<float>{infinity, -infinity, 0});
  CHECK(scan.ranges == std::vector<float>{infinity});
  CHECK(valuesOf<float>(scan, Field::intensity) == std::vector<float>{0});
}

TEST_CASE("a number that is not whole is refused in a whole field, in text and in binary") {
  const Folder folder;
  put(folder / "a.csv", "x,y,z,class\n1,2,3,1.5\n");
  CHECK_THAT(problemOf(folder / "a.csv"), ContainsSubstring("point 0: '1.5' does not fit the field 'class'"));
  const float row[] = {1, 2, 3, 1.5f};
  put(folder / "a.npy", npyHeaderOf("[('x', '<f4'), ('y', '<f4'), ('z', '<f4'), ('class', '<f4')]", "(1,)") +
                            std::string(reinterpret_cast<const char*>(row), sizeof(row)));
  CHECK_THAT(problemOf(folder / "a.npy"), ContainsSubstring("point 0: 'class' is not a whole number"));
}

TEST_CASE("a number that is too large for its field is refused in binary, too") {
  const Folder folder;
  const auto cloud = [](uint32_t id) {
    std::string row(16, '\0');
    std::memcpy(&row[12], &id, 4);
    return "VERSION 0.7\nFIELDS x y z class\nSIZE 4 4 4 4\nTYPE F F F U\nCOUNT 1 1 1 1\nWIDTH 1\nHEIGHT 1\nPOINTS 1\n"
           "DATA binary\n" +
           row;
  };
  put(folder / "a.pcd", cloud(65535));
  CHECK(valuesOf<uint16_t>(readCloud(folder / "a.pcd"), Field::classId) == std::vector<uint16_t>{65535});
  put(folder / "a.pcd", cloud(65536));
  CHECK_THAT(problemOf(folder / "a.pcd"), ContainsSubstring("point 0: 'class' is 65536, more than the field holds"));
}

TEST_CASE("a cloud cut short at any byte is refused") {
  const Folder folder;
  const std::string ending = GENERATE("pcd", "ply", "npy");
  writeCloud(tiny(), folder / ("whole." + ending));
  const std::string bytes = bytesOf(folder / ("whole." + ending));
  for (size_t length = 0; length < bytes.size(); ++length) {
    INFO(length << " of " << bytes.size() << " bytes");
    CHECK_THROWS_AS(readCloudBytes(cloudFormat("a." + ending), bytes.substr(0, length), "cut"), Error);
  }
}

TEST_CASE("a cloud with any changed byte is read or refused without a crash") {
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

TEST_CASE("absurd counts and invalid values are refused before memory is allocated") {
  const Folder folder;
  const auto pcd = [&](const std::string& size, const std::string& data) {
    put(folder / "a.pcd",
        "VERSION 0.7\nFIELDS x y z beam\nSIZE 4 4 4 4\nTYPE F F F U\n" + size + "DATA ascii\n" + data);
    return problemOf(folder / "a.pcd");
  };
  CHECK_THAT(pcd("WIDTH 4000000000\nHEIGHT 4000000000\n", ""), ContainsSubstring("cut short"));
  CHECK_THAT(pcd("WIDTH 2\nHEIGHT 1\nPOINTS 3\n", "0 0 0 0\n0 0 0 1\n"), ContainsSubstring("POINTS 3"));
  CHECK_THAT(pcd("WIDTH 1\nHEIGHT 1\n", "0 0 0 4294967290\n"), ContainsSubstring("4294967291 beams"));
  CHECK_THAT(pcd("# gnosphere columns 3 channels 2\nWIDTH 2\nHEIGHT 1\n", "0 0 0 5\n0 0 0 5\n"),
             ContainsSubstring("twice"));
  for (const char* viewpoint : {"0 0 0 1 0 0", "0 0 0 1 0 0 nan", "0 0 0 1 0 0 x"})
    CHECK_THAT(pcd(std::string("WIDTH 1\nHEIGHT 1\nVIEWPOINT ") + viewpoint + "\n", "0 0 0 1\n"),
               ContainsSubstring("VIEWPOINT must be x y z qw qx qy qz, seven finite numbers"));
  std::string many;
  for (int row = 0; row < 17; ++row) many += "0 0 0 5\n";
  CHECK_THAT(pcd("WIDTH 17\nHEIGHT 1\n", many), ContainsSubstring("has a return number 17; there may be 16"));
  CHECK_THAT(pcd("WIDTH 1\nHEIGHT 1\n", "0 0 0 -1\n"), ContainsSubstring("'-1'"));
  CHECK_THAT(pcd("WIDTH 1\nHEIGHT 1\n", "0 0 zero 1\n"), ContainsSubstring("'zero'"));
  CHECK_THAT(pcd("COUNT 1 1\n", ""), ContainsSubstring("COUNT has 2 entries, FIELDS has 4"));
  put(folder / "b.pcd",
      "# gnosphere columns 65535 channels 65535\nFIELDS x y z beam\nWIDTH 1\nHEIGHT 1\nDATA ascii\n0 0 0 1\n");
  CHECK_THAT(problemOf(folder / "b.pcd"), ContainsSubstring("65535 columns"));
  std::string fields, sizes, types, counts;
  for (int i = 0; i < 100000; ++i) fields += " a", sizes += " 4", types += " F", counts += " 65536";
  put(folder / "g.pcd", "FIELDS" + fields + "\nSIZE" + sizes + "\nTYPE" + types + "\nCOUNT" + counts +
                            "\nWIDTH 1\nHEIGHT 1\nDATA ascii\n1\n");
  CHECK_THAT(problemOf(folder / "g.pcd"), ContainsSubstring("1 points of 6553600000 values are stated"));
  put(folder / "c.csv", "a,b\n1,2\n");
  CHECK_THAT(problemOf(folder / "c.csv"), ContainsSubstring("as x,y,z,range, and has 'a,b'"));
  put(folder / "e.csv", "x,y,beam\n1,2,3\n");
  CHECK_THAT(problemOf(folder / "e.csv"), ContainsSubstring("neither x, y, z nor range"));
  const auto npy = [&](const std::string& shape, const std::string& data) {
    const std::string header = "{'descr': [('range', '<f4')], 'fortran_order': False, 'shape': " + shape + ", }\n";
    put(folder / "f.npy", std::string("\x93NUMPY\x01\0", 8) + static_cast<char>(header.size()) + '\0' + header + data);
    return problemOf(folder / "f.npy");
  };
  CHECK_THAT(npy("(4294967295, 4294967295, 4294967295)", ""), ContainsSubstring("more points than a 32-bit index"));
  CHECK_THAT(npy("(65536, 65536, 0)", ""), ContainsSubstring("columns"));
  CHECK_THAT(npy("(1, 1, 17)", std::string(68, '\0')), ContainsSubstring("return number 17; there may be 16"));
  CHECK_THAT(npy("(1, 1, 1, 1)", std::string(4, '\0')), ContainsSubstring("one to three dimensions"));
  put(folder / "d.csv", "");
  CHECK_THAT(problemOf(folder / "d.csv"), ContainsSubstring("empty"));
}

TEST_CASE("a header of PCD, PLY or NPY that cannot be is refused with what is wrong in it") {
  const Folder folder;
  const auto edited = [&](const char* name, const std::string& good, const std::string& from, const std::string& to) {
    put(folder / name, good);
    readCloud(folder / name);
    std::string text = good;
    REQUIRE(text.find(from) != text.npos);
    put(folder / name, text.replace(text.find(from), from.size(), to));
    return problemOf(folder / name);
  };
  const auto pcd = [&](const char* from, const char* to) {
    return edited("a.pcd",
                  "FIELDS x y z range\nSIZE 4 4 4 4\nTYPE F F F F\nWIDTH 1\nHEIGHT 1\nPOINTS 1\nDATA ascii\n1 2 2 3\n",
                  from, to);
  };
  CHECK_THAT(pcd("TYPE F F F F", "TYPE F F F X"), ContainsSubstring("TYPE must be F, U or I, is 'X'"));
  CHECK_THAT(pcd("SIZE 4 4 4 4", "SIZE 4 4 4 2"), ContainsSubstring("'range' cannot be of type F and 2 bytes"));
  CHECK_THAT(pcd("SIZE 4 4 4 4\nTYPE F F F F", "SIZE 4 4 4 3\nTYPE F F F U"),
             ContainsSubstring("'range' cannot be of type U and 3 bytes"));
  CHECK_THAT(pcd("SIZE 4 4 4 4", "SIZE 4 4 4"), ContainsSubstring("SIZE has 3 entries, FIELDS has 4"));
  CHECK_THAT(pcd("FIELDS x y z range\nSIZE 4 4 4 4\nTYPE F F F F\n", ""),
             ContainsSubstring("its header has no FIELDS"));
  CHECK_THAT(pcd("z range", "z x"), ContainsSubstring("has the field 'x' twice"));
  CHECK_THAT(pcd("HEIGHT 1", "HEIGHT 4294967296"), ContainsSubstring("WIDTH or HEIGHT is beyond 32 bits"));
  CHECK_THAT(pcd("HEIGHT 1", "HEIGHT one"), ContainsSubstring("WIDTH or HEIGHT must be a count, is 'one'"));
  CHECK_THAT(pcd("POINTS 1", "POINTS -1"), ContainsSubstring("POINTS must be a count, is '-1'"));
  CHECK_THAT(pcd("POINTS", "SPOTS"), ContainsSubstring("its header has a line 'SPOTS 1'"));
  CHECK_THAT(pcd("DATA ascii", "DATA zip"), ContainsSubstring("ascii, binary or binary_compressed, is 'zip'"));
  CHECK_THAT(pcd("DATA ascii\n", ""), ContainsSubstring("a line '1 2 2 3'"));
  CHECK_THAT(pcd("DATA ascii\n1 2 2 3\n", ""), ContainsSubstring("its header has no DATA"));
  CHECK_THAT(pcd("DATA ascii\n1 2 2 3\n", "DATA binary_compressed\n1"),
             ContainsSubstring("cut short after its header"));

  const auto ply = [&](const char* from, const char* to) {
    return edited("a.ply",
                  "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
                  "element face 0\nproperty list uchar int vertex_indices\nend_header\n1 2 2\n",
                  from, to);
  };
  CHECK_THAT(ply("ply\n", "plx\n"), ContainsSubstring("is not a PLY file"));
  CHECK_THAT(ply("ascii", "binary_big_endian"), ContainsSubstring("little_endian, is 'binary_big_endian'"));
  CHECK_THAT(ply("float z", "text z"), ContainsSubstring("a list or a property of no known type"));
  CHECK_THAT(ply("property float z", "property list uchar float z"), ContainsSubstring("a list or a property of no"));
  CHECK_THAT(ply("vertex 1", "vertex"), ContainsSubstring("an element needs a name and a count"));
  CHECK_THAT(ply("vertex 1", "vertex -1"), ContainsSubstring("element must be a count, is '-1'"));
  CHECK_THAT(ply("element vertex 1", "element camera 1\nproperty float f\nelement vertex 1"),
             ContainsSubstring("'camera' comes before the vertices, which must be first"));
  CHECK_THAT(ply("element vertex 1", "hello"), ContainsSubstring("a line starts with 'hello'"));
  CHECK_THAT(ply("end_header\n1 2 2\n", ""), ContainsSubstring("PLY header is cut short"));
  CHECK_THAT(ply("float z", "float x"), ContainsSubstring("has the field 'x' twice"));

  const std::string xyz = "[('x', '<f4'), ('y', '<f4'), ('z', '<f4')]";
  const auto npy = [&](const std::string& type, const std::string& shape, size_t bytes) {
    put(folder / "a.npy", npyHeaderOf(type, shape) + std::string(bytes, '\0'));
    return problemOf(folder / "a.npy");
  };
  CHECK_THAT(npy("[('x', '<f4'), ('y', '<f4'), ('z', '<f2')]", "(1,)", 10),
             ContainsSubstring("field 'z' has the type '<f2', which is not read"));
  CHECK_THAT(npy("[]", "(1,)", 12), ContainsSubstring("NPY header names no field"));
  CHECK_THAT(npy(xyz, "(4294967296,)", 12), ContainsSubstring("NPY shape is beyond 32 bits"));
  CHECK_THAT(npy(xyz, "()", 12), ContainsSubstring("one to three dimensions"));
  std::string columns = npyHeaderOf(xyz, "(1, 2)");
  put(folder / "a.npy", columns.replace(columns.find("False, "), 7, "True,  ") + std::string(24, '\0'));
  CHECK_THAT(problemOf(folder / "a.npy"), ContainsSubstring("in Fortran order; save it in C order"));
  put(folder / "a.npy", "\x93NUMPX" + std::string(20, '\0'));
  CHECK_THAT(problemOf(folder / "a.npy"), ContainsSubstring("is not an NPY file"));
}

TEST_CASE("a CSV cloud may begin with the mark of UTF-8, and one in UTF-16 is refused") {
  const Folder folder;
  std::ofstream(folder / "a.csv") << "\xef\xbb\xbfx,y,z,range\n1,2,2,9\n";
  CHECK(readCloud(folder / "a.csv").points == std::vector<float>{1, 2, 2});
  std::ofstream(folder / "b.csv") << std::string("\xff\xfex\0,\0", 6);
  CHECK_THAT(problemOf(folder / "b.csv"), ContainsSubstring("b.csv: is text in UTF-16; save it as UTF-8"));
}

TEST_CASE("a CSV cloud may have quoted names, comments above them, and lines that end with a carriage return") {
  const Folder folder;
  for (const char* text :
       {"\"x\",\"y\",\"z\"\n1,2,3\n4,5,6\n", "x,y,z\r1,2,3\r4,5,6\r", "# made by hand\n\nx,y,z\n1,2,3\n4,5,6\n",
        "# x,y,z\n1,2,3\n4,5,6\n", "# made by hand\n#x y z\n1 2 3\n\n4 5 6", "x,y,z,\n1,2,3,\n4,5,6,\n"}) {
    INFO(text);
    put(folder / "a.csv", text);
    CHECK(readCloud(folder / "a.csv").points == std::vector<float>{1, 2, 3, 4, 5, 6});
  }
}

TEST_CASE("a CSV cloud that cannot be read is refused by the line at fault") {
  const Folder folder;
  const auto problem = [&](const std::string& text) {
    put(folder / "a.csv", text);
    return problemOf(folder / "a.csv");
  };
  CHECK_THAT(problem("x;y;z\n1;2;3\n"),
             ContainsSubstring("names of fields with commas between") && ContainsSubstring("and has 'x;y;z'"));
  CHECK_THAT(problem("1,2,3\n4,5,6\n"), ContainsSubstring("and has '1,2,3'"));
  CHECK_THAT(problem("# comment\nx,y,z\n1,2,3\n\n4,5,6,7\n"),
             ContainsSubstring("line 5 has 4 values, the head names 3"));
  CHECK_THAT(problem("x,y,z\n1,2\n3,4,5,6\n"), ContainsSubstring("line 2 has 2 values, the head names 3"));
  CHECK_THAT(problem("x,y,z\n1,2,3\n4, ,6\n"), ContainsSubstring("line 3 has an empty value; write nan"));
  CHECK_THAT(problem("x,y,z\n,2,3\n"), ContainsSubstring("line 2 has an empty value"));
  CHECK_THAT(problem("x,y,z,x\n1,2,3,4\n"), ContainsSubstring("has the field 'x' twice"));
  CHECK_THAT(problem("range,Beam,beam\n1,2,3\n"), ContainsSubstring("has the field 'beam' twice"));
}

TEST_CASE("NPY arrays with gaps, of big-endian numbers, and without names of fields are read") {
  const Folder folder;
  const auto bytesOfAll = [](auto... values) {
    std::string bytes;
    (bytes.append(reinterpret_cast<const char*>(&values), sizeof(values)), ...);
    return bytes;
  };
  const auto swapped = [&](auto... values) {
    std::string bytes;
    const auto append = [&](auto value) {
      const std::string one = bytesOfAll(value);
      bytes.append(one.rbegin(), one.rend());
    };
    (append(values), ...);
    return bytes;
  };
  const auto points = [&](const std::string& type, const std::string& shape, const std::string& data) {
    put(folder / "a.npy", npyHeaderOf(type, shape) + data);
    return readCloud(folder / "a.npy");
  };
  const std::vector<float> expected = {1, 2, 3, 4, 5, 6};
  CHECK(points("[('x', '<f4'), ('', '|V4'), ('y', '<f8'), ('z', '<f4'), ('', '|V1')]", "(2,)",
               bytesOfAll(1.f, 0, 2., 3.f, '\0', 4.f, 0, 5., 6.f, '\0'))
            .points == expected);
  CHECK(points(
            "[('x', '>f8'), ('y', '>f4'), ('z', '<f4'), ('beam', '>u2')]", "(2,)",
            swapped(1., 2.f) + bytesOfAll(3.f) + swapped(uint16_t{0}, 4., 5.f) + bytesOfAll(6.f) + swapped(uint16_t{1}))
            .points == expected);
  CHECK(points("'<f8'", "(2, 3)", bytesOfAll(1., 2., 3., 4., 5., 6.)).points == expected);
  CHECK(points("'>f4'", "(2, 3)", swapped(1.f, 2.f, 3.f, 4.f, 5.f, 6.f)).points == expected);
  const Scan four = points("'<f4'", "(2, 4)", bytesOfAll(1.f, 2.f, 3.f, 7.f, 4.f, 5.f, 6.f, 8.f));
  CHECK(four.points == expected);
  CHECK(valuesOf<float>(four, Field::intensity) == std::vector<float>{7, 8});
  std::string columns = npyHeaderOf("'<f4'", "(2, 3)") + bytesOfAll(1.f, 4.f, 2.f, 5.f, 3.f, 6.f);
  columns.replace(columns.find("False, "), 7, "True,  ");
  put(folder / "b.npy", columns);
  CHECK(readCloud(folder / "b.npy").points == expected);
  for (const auto& [type, shape] : {std::pair("'<i4'", "(2, 3)"), std::pair("'<f4'", "(3, 2)"),
                                    std::pair("'<f4'", "(6,)"), std::pair("'<f4'", "(1, 2, 3)")}) {
    put(folder / "c.npy", npyHeaderOf(type, shape) + std::string(24, '\0'));
    CHECK_THAT(problemOf(folder / "c.npy"), ContainsSubstring("with the shape (N, 3) for x, y, z or (N, 4)"));
  }
}

TEST_CASE("errors of reading name the file") {
  const Folder folder;
  CHECK_THROWS_WITH(readCloud(folder / "none.pcd"), ContainsSubstring("none.pcd: cannot be read: No such file"));
  fs::create_directory(folder / "folder.pcd");
  CHECK_THROWS_WITH(readCloud(folder / "folder.pcd"), ContainsSubstring("Is a directory"));
  CHECK_THROWS_WITH(readCloud(folder / "a.bin"), ContainsSubstring("a.bin: a KITTI cloud does not say which beams"));
  CHECK_THROWS_WITH(readCloud(folder / "a.xyz"), ContainsSubstring("known are .pcd, .ply, .npy and .csv"));
  CloudFormat nameless = cloudFormat("a.csv");
  nameless.read = nullptr;
  CHECK_THROWS_WITH(readCloudBytes(nameless, "", "a.csv"), ContainsSubstring("a.csv: a .csv cloud does not say which"));
}
