// SPDX-License-Identifier: Apache-2.0
// Optical properties of materials, and tables of materials.
#include <catch2/catch_approx.hpp>
#include <catch2/catch_test_macros.hpp>
#include <catch2/matchers/catch_matchers_exception.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <cmath>
#include <numbers>

#include "cpu_time.hpp"
#include "effects/material_table.hpp"
#include "folder.hpp"
#include "gnosphere/effects.hpp"
#include "gnosphere/error.hpp"
#include "gnosphere/simulator.hpp"

using namespace gnosphere;
using namespace gnosphere::test;
using Catch::Approx;
using Catch::Matchers::ContainsSubstring;
using Catch::Matchers::MessageMatches;

namespace {

void refused(const Folder& folder, const std::string& name, const std::string& bytes, const std::string& words) {
  INFO(bytes);
  const fs::path file = put(folder / name, bytes);
  CHECK_THROWS_MATCHES(loadMaterialTable(file), Error, MessageMatches(ContainsSubstring(words)));
}

Material material(const std::string& name) {
  Material one;
  one.name = name;
  return one;
}

// Two rows are near 905 nm and normal incidence; the nearest has 0.1 / pi.
const char* const kBrdf = R"({"metadata": {"name": "grey", "typicalSensorTechnology": "lidar"},
  "brdf": {"wavelengths": [9.05e-07, 5.5e-07], "lookupTable": [
    [5.5e-07, 0.0, 0.0, 0.0, 0.3], [9.05e-07, 0.05, 0.05, 3.14159, 0.2], [9.05e-07, 0.05, 0.05, 0.0, 0.0318309886],
    [9.05e-07, 0.1, 0.1, null, 0.4], [9.05e-07, 1.2, 1.2, 0.0, 0.001]]}})";
const char* const kMetal = R"({"metadata": {"name": "metal"}, "opticalProperties":
  [[5.5e-07, 293, 1.0, 6.7], [9.05e-07, 293, 2.0, 8.0], [1.55e-06, 293, 1.5, 15.0]]})";
const char* const kGlass = R"({"metadata": {"name": "glass"}, "opticalProperties": [[9.05e-07, 293, 1.5, 1e-06]]})";

std::string xomp(const std::string& properties) {
  return R"({"metadata": {"name": "paint"}, "materialProperties": {)" + properties + "}}";
}

}  // namespace

TEST_CASE("a glTF material is split into shares of the light") {
  Material plain;
  plain.baseColor = {0.5f, 1, 1, 1};
  CHECK(opticsOf(plain).reflectance == 0.5f);
  CHECK(opticsOf(plain).gloss == 0.04f);
  CHECK(opticsOf(plain).transmission == 0);

  Material metal = plain;
  metal.metallic = 1;
  metal.roughness = 0.25f;
  CHECK(opticsOf(metal).reflectance == 0);
  CHECK(opticsOf(metal).gloss == 0.5f);
  CHECK(opticsOf(metal).roughness == 0.25f);

  Material pane = plain;
  pane.alphaMode = AlphaMode::blend;
  pane.baseColor[3] = 0.25f;
  CHECK(opticsOf(pane).transmission == 0.75f);
  CHECK(opticsOf(pane).reflectance == 0.125f);
  CHECK(opticsOf(pane).gloss == 0.01f);
  pane.alphaMode = AlphaMode::mask;  // a hole is present or absent, it does not share the light
  CHECK(opticsOf(pane).transmission == 0);

  Material glass = plain;
  glass.transmission = 0.5f;
  CHECK(opticsOf(glass).transmission == 0.5f);
  CHECK(opticsOf(glass).reflectance == 0.25f);

  // By KHR_materials_transmission light passes through the dielectric share of a material, and not through the metal.
  glass.metallic = 0.5f;
  CHECK(opticsOf(glass).transmission == 0.25f);
  CHECK(opticsOf(glass).reflectance == 0.125f);
  glass.metallic = 1;
  CHECK(opticsOf(glass).transmission == 0);
  CHECK(opticsOf(glass).reflectance == 0);
  CHECK(opticsOf(glass).gloss == 0.5f);
}

TEST_CASE("a table replaces the properties of the materials that it names") {
  const Folder folder;
  const MaterialTable table = loadMaterialTable(put(folder / "t.json", R"({"materials": [
    {"name": "ASPHALT", "reflectance_905": 0.1, "reflectance_1550": 0.2, "roughness": 0.9},
    {"name": "sign", "retro": 300, "transmission": 0}, {"name": "brick", "reflectance_905": 0.3}]})"));
  Scene scene;
  scene.materials = {material("Asphalt"), material("sign"), material("asphalt"), material("other")};
  std::vector<std::string> unused;
  const auto optics = opticsOf(scene, table, 905, &unused);
  REQUIRE(optics.size() == 4);
  CHECK(optics[0].reflectance == 0.1f);
  CHECK(optics[2].reflectance == 0.1f);
  CHECK(optics[0].roughness == 0.9f);
  CHECK(optics[1].retro == 300);
  CHECK(optics[1].reflectance == 1);  // not stated, so the scene's value is used
  CHECK(optics[3].reflectance == 1);
  CHECK(unused == std::vector<std::string>{"brick"});
  CHECK(opticsOf(scene, table, 1550)[0].reflectance == 0.2f);
}

TEST_CASE("a stated reflectance is that of a Lambertian surface, unless the row states a roughness") {
  Scene scene;
  scene.materials = {material("metal"), material("paint")};
  for (Material& each : scene.materials) each.metallic = each.roughness = 0.5f;
  MaterialTable table;
  table.rows = {{.name = "metal", .reflectance905 = 0.1f},
                {.name = "paint", .reflectance905 = 0.2f, .roughness = 0.4f}};
  const auto near = opticsOf(scene, table, 905), far = opticsOf(scene, table, 1550);
  CHECK(near[0].reflectance == 0.1f);
  CHECK(near[0].gloss == 0);
  CHECK(near[1].reflectance == 0.2f);
  CHECK(near[1].gloss == opticsOf(scene.materials[1]).gloss);
  table.rows.push_back({.name = "metal", .roughness = 0.3f});  // a second row states it
  CHECK(opticsOf(scene, table, 905)[0].gloss == opticsOf(scene.materials[0]).gloss);
  for (const double wrong : {double(NAN), -1.0, 1064.0})
    CHECK_THROWS_WITH(opticsOf(scene, table, wrong), Catch::Matchers::ContainsSubstring("must be 905 or 1550 nm, is "));
  CHECK(far[0].gloss == opticsOf(scene.materials[0]).gloss);  // nothing is stated at 1550 nm
}

TEST_CASE("an invalid table is refused") {
  const Folder folder;
  refused(folder, "t.json", std::string("\xfe\xff\0[\0]", 6), "is text in UTF-16; save it as UTF-8");
  refused(folder, "t.json", "[]", "is neither {\"materials\"");
  refused(folder, "t.json", R"({"materials": [], "version": 1})", "holds more than 'materials'");
  refused(folder, "t.json", R"({"materials": [3]})", "a material must be an object, is 3");
  refused(folder, "t.json", R"({"materials": [{"reflectance_905": 1}]})", "has no 'name'");
  refused(folder, "t.json", R"({"materials": [{"name": "a", "reflectance": 1}]})",
          "material 'a' has an unknown key 'reflectance'; the nearest are reflectance_905");
  refused(folder, "t.json", R"({"materials": [{"name": "a", "reflectance_905": 10}]})",
          "material 'a': reflectance_905 must be 0..1, is 10");
  refused(folder, "t.json", R"({"materials": [{"name": "a", "retro": "much"}]})", "retro must be 0..1000000");
  refused(folder, "t.json", R"({"materials": [{"name": "a", "name": "b"}]})", "'name' is there twice");
  refused(folder, "t.json", R"({"materials": [{"name": "Wall"}, {"name": "roof"}, {"name": "wall"}]})",
          "t.json: has the materials 'Wall' and 'wall', which are one, because case does not matter; keep one of them");
  // The limit is 64 levels; the object and its list of materials are two of these. A message that quoted a million
  // levels overflowed the stack.
  const auto nested = [](size_t depth) {
    return "{\"materials\": [" + std::string(depth, '[') + std::string(depth, ']') + "]}";
  };
  refused(folder, "t.json", nested(62), "a material must be an object, is [[[");
  for (const size_t depth : {size_t{63}, size_t{1'000'000}})
    refused(folder, "t.json", nested(depth), "is not JSON: it nests deeper than 64 levels");
  refused(folder, "t.json", "\xef\xbb\xbf " + nested(63), "is not JSON: it nests deeper than 64 levels");
  // A file of another kind may have any number of brackets.
  refused(folder, "t.json", "glTF" + std::string(1'000'000, '['), "is not JSON: parse error at line 1, column 1");
  CHECK_THROWS_MATCHES(loadMaterialTable("none.json"), Error, MessageMatches(ContainsSubstring("none.json")));
}

TEST_CASE("a material table that a program makes is checked when it is applied") {
  Scene scene;
  scene.materials.resize(1);
  const auto refused = [&](MaterialTable::Row row, const std::string& why) {
    CHECK_THROWS_MATCHES(opticsOf(scene, {{row}}, 905), Error, MessageMatches(ContainsSubstring(why)));
  };
  refused({"a", 7}, "material 'a': reflectance_905 must be 0..1, or negative if not stated, is 7");
  refused({"a", 0.5f, std::nanf("")}, "reflectance_1550 must be 0..1");
  refused({"a", -1, -1, -1, 2e6f}, "retro must be 0..1000000");
  CHECK_NOTHROW(opticsOf(scene, {{{"a", 0.5f}}}, 905));
  CHECK_NOTHROW(opticsOf(scene, {{{"a", 0.5f}, {"a", 0.6f}}}, 905));
  CHECK_THROWS_WITH(opticsOf(scene, {{{"a", 0.5f}, {"A", 0.6f}}}, 905),
                    ContainsSubstring("the material table has the materials 'a' and 'A', which are one"));
}

TEST_CASE("a simulator tells once of the rows of a material table that have no effect") {
  Scene scene;
  scene.materials = {material("wall")};
  std::vector<std::string> warnings;
  SimulatorOptions options;
  options.device = DeviceChoice::Kind::reference;
  options.warn = [&](const std::string& warning) { warnings.push_back(warning); };
  options.materials.rows = {{"WALL", 0.5f}, {"roof", 0.5f}, {"wood"}};
  const Sensor sensor = builtinSensor("VLP-16");
  const Simulator simulator(scene, std::vector<SensorRequest>(2, SensorRequest(sensor)), options);
  CHECK(warnings ==
        std::vector<std::string>{"the material table has 'roof', 'wood', but the scene has no material of that name",
                                 "the material table gives no values for 'wood'"});
  warnings.clear();
  options.materials.rows.resize(1);
  const Simulator fitting(scene, SensorRequest(sensor), options);
  const Simulator empty(Scene(), SensorRequest(sensor), options);
  CHECK(warnings.empty());
}

TEST_CASE("a material that reflects and transmits more light than comes is warned of") {
  Scene scene;
  scene.materials = {material("pane"), material("door")};
  const MaterialTable good = {{{"pane", 0.2f, 0.3f, -1, -1, 0.7f}, {"door", 1.0f}}};
  CHECK(warningsOf(good, scene).empty());
  const std::vector<std::string> expected = {
      "the material table lets 'pane' reflect and transmit more light than comes; reflectance and transmission "
      "together "
      "are 1 at most"};
  CHECK(warningsOf({{{"pane", 0.31f, -1, -1, -1, 0.7f}}}, scene) == expected);
  CHECK(warningsOf({{{"pane", 0.2f, 0.4f}, {"door", 1.0f}, {"pane", -1, -1, -1, -1, 0.7f}}}, scene) == expected);
}

TEST_CASE("a simulator tells if colours decide what is detected, although there is a table") {
  Scene scene;
  scene.materials = {material("wall"), material("roof")};
  std::vector<std::string> warnings;
  SimulatorOptions options;
  options.device = DeviceChoice::Kind::reference;
  options.warn = [&](const std::string& warning) { warnings.push_back(warning); };
  options.materials.rows = {{"wall", 0.5f}, {"roof", 0.5f, 0.4f}};
  SensorRequest request(builtinSensor("VLP-16"), Effects::none());
  request.effects.intensity = {.use = EffectUse::on, .wavelength = 1550};
  const auto told = [&] {
    warnings.clear();
    const Simulator simulator(scene, request, options);
    return warnings;
  };
  CHECK(told().empty());
  const std::vector<std::string> expected = {
      "sensor 'VLP-16': the material table has the reflectances of 'wall' at 905 nm alone, so colours decide whether "
      "they are detected at 1550 nm; give them, or another intensity.wavelength"};
  request.effects.detection = {EffectUse::on, 0.1, 50, 0};
  CHECK(told() == expected);
  request.effects.detection = {};
  request.effects.fog = {EffectUse::on, 20000};
  CHECK(told() == expected);
  request.effects.intensity.wavelength = 905;
  CHECK(told().empty());
}

TEST_CASE("an OpenMATERIAL BRDF is read near normal incidence, for light that returns to the sensor") {
  const Folder folder;
  put(folder / "b.xompt", kBrdf);
  const auto rows = loadMaterialTable(put(folder / "m.xomp", xomp(R"("brdfUris": ["b.xompt"])"))).rows;
  REQUIRE(rows.size() == 1);
  CHECK(rows[0].name == "paint");
  CHECK(rows[0].reflectance905 == Approx(0.1f));
  CHECK(rows[0].reflectance1550 < 0);
  CHECK(rows[0].roughness < 0);
}

TEST_CASE("an OpenMATERIAL conductor reflects according to Fresnel") {
  const Folder folder;
  put(folder / "metal.xompt", kMetal);
  const auto row = loadMaterialTable(put(folder / "m.xomp", xomp(R"("opticalPropertiesUri": "metal.xompt")"))).rows[0];
  CHECK(row.reflectance905 == Approx((1 + 64) / (9.0 + 64)));
  CHECK(row.reflectance1550 == Approx((0.25 + 225) / (6.25 + 225)));
}

TEST_CASE("an OpenMATERIAL mapping and an asset give the same rows") {
  const Folder folder;
  put(folder / "b.xompt", kBrdf);
  put(folder / "metal.xompt", kMetal);
  put(folder / "paint.xomp", xomp(R"("brdfUris": ["b.xompt"])"));
  put(folder / "metal.xomp", xomp(R"("opticalPropertiesUri": "metal.xompt")"));
  const auto mapping = put(folder / "m.xomm", R"({"metadata": {}, "materialMapping": [["Body", "paint.xomp", "grey"],
                                                ["Rim", "metal.xomp"]]})");
  const auto asset = put(folder / "a.xoma", R"({"metadata": {}, "materialMappingUri": "m.xomm"})");
  for (const fs::path& file : {mapping, asset}) {
    const auto rows = loadMaterialTable(file).rows;
    REQUIRE(rows.size() == 2);
    CHECK(rows[0].name == "Body");
    CHECK(rows[0].reflectance905 == Approx(0.1f));
    CHECK(rows[1].name == "Rim");
    CHECK(rows[1].reflectance905 == Approx(0.890410959));
  }
  put(folder / "tyre.xomp", xomp(""));
  put(folder / "m.xomm", R"({"materialMapping": [["Tyre", "tyre.xomp"], ["Body", "paint.xomp"]]})");
  const auto rows = loadMaterialTable(mapping).rows;
  REQUIRE(rows.size() == 2);
  CHECK(rows[0].reflectance905 < 0);
  refused(folder, "m.xomm", R"({"materialMapping": [["Tyre", "tyre.xomp"]]})", "states no reflectance for a laser");
}

TEST_CASE("an OpenMATERIAL table that many materials name is read once") {
  const Folder folder;
  std::string rows = "[9.05e-07, 0.0, 0.0, 0.0, 0.1]", mapping;
  for (int i = 0; i < 5000; ++i) rows += ", [5e-07, 0.0, 0.0, 0.0, 0.1]";
  put(folder / "b.xompt", R"({"brdf": {"lookupTable": [)" + rows + "]}}");
  for (int i = 0; i < 1000; ++i) {
    const std::string name = std::to_string(i % 10) + ".xomp";
    if (i < 10) put(folder / name, xomp(R"("brdfUris": ["./b.xompt", "b.xompt"])"));
    mapping += (i ? ", [\"" : "[\"") + std::to_string(i) + "\", \"" + name + "\"]";
  }
  put(folder / "m.xomm", R"({"materialMapping": [)" + mapping + "]}");
  std::vector<MaterialTable::Row> read;
  CHECK(cpuSeconds([&] { read = loadMaterialTable(folder / "m.xomm").rows; }) < 1);
  REQUIRE(read.size() == 1000);
  CHECK(read[999].name == "999");
  CHECK(read[999].reflectance905 == Approx(0.314159265));
  CHECK(read[999].reflectance1550 < 0);
}

TEST_CASE("an OpenMATERIAL file without a reflectance for lasers is refused") {
  const Folder folder;
  put(folder / "glass.xompt", kGlass);
  const std::string none = "m.xomp: states no reflectance for a laser";
  refused(folder, "m.xomp", xomp(""), none);
  refused(folder, "m.xomp", xomp(R"("opticalPropertiesUri": "glass.xompt")"), none);
  put(folder / "far.xompt", R"({"brdf": {"lookupTable": [[9.05e-07, 1.5, 1.5, 0.0, 0.001]]}})");
  refused(folder, "m.xomp", xomp(R"("brdfUris": ["far.xompt"])"), none);
  put(folder / "far.xompt", R"({"brdf": {"lookupTable": [[9.05e-07, 0.0, 1.5, 0.0, 0.001]]}})");  // a grazing exit
  refused(folder, "m.xomp", xomp(R"("brdfUris": ["far.xompt"])"), none);
  refused(folder, "m.xomp", xomp(R"("brdfUris": ["gone.xompt"])"), "gone.xompt: cannot be read");
  refused(folder, "m.xomp", xomp(R"("brdfUris": [3])"), "the name of a file is not a text but 3");
  refused(folder, "m.xomp", xomp(R"("brdfUris": ["glass.xompt"])"), "glass.xompt: 'brdf' is missing");
  refused(folder, "m.xomm", R"({"materialMapping": [["a"]]})", "is not [name, file, ...] but [\"a\"]");
  refused(folder, "a.xoma", R"({"metadata": {}})", "without 'materialMappingUri', which names the mapping");
  refused(folder, "a.xoma", R"({"materialMappingUri": "a.xoma"})", "is not a mapping");
}
