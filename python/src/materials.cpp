// SPDX-License-Identifier: Apache-2.0
// Binds the optics of materials of gnosphere/effects.hpp.
#include "state.hpp"

namespace gnosphere::python {

void bindMaterials(nb::module_& m) {
  nb::class_<Optics> optics(m, "Optics", "Optical properties of a material at the wavelength of Effects.Intensity.");
  bindState<&Optics::reflectance, &Optics::gloss, &Optics::roughness, &Optics::retro, &Optics::transmission>(optics);
  optics.def_ro("reflectance", &Optics::reflectance, "Diffuse (Lambertian), 0..1.")
      .def_ro("gloss", &Optics::gloss, "Share of the light that the glossy lobe reflects, 0..1.")
      .def_ro("roughness", &Optics::roughness, "Roughness of the glossy lobe, 0..1.")
      .def_ro("retro", &Optics::retro,
              "Gain of retro-reflection over a Lambertian surface of reflectance 1; 0 for none.")
      .def_ro("transmission", &Optics::transmission, "Share of the light that passes through, 0..1.");

  auto table = nb::class_<MaterialTable>(m, "MaterialTable",
                                         "Optical properties by material name, which override those of the scene's "
                                         "materials. A stated reflectance is that of a Lambertian surface; if the row "
                                         "states a roughness, too, the gloss of the scene's material is added. It is "
                                         "never changed after it is made.");
  nb::class_<MaterialTable::Row>(table, "Row",
                                 "A negative value means not stated. A row is never changed after it is made.")
      .def(
          "__init__",
          [](MaterialTable::Row* self, std::string name, float reflectance905, float reflectance1550, float roughness,
             float retro, float transmission) {
            new (self)
                MaterialTable::Row{std::move(name), reflectance905, reflectance1550, roughness, retro, transmission};
          },
          "name"_a, "reflectance905"_a = -1.f, "reflectance1550"_a = -1.f, "roughness"_a = -1.f, "retro"_a = -1.f,
          "transmission"_a = -1.f)
      .def_ro("name", &MaterialTable::Row::name, "Name of the scene's material; case does not matter.")
      .def_ro("reflectance905", &MaterialTable::Row::reflectance905, "0..1")
      .def_ro("reflectance1550", &MaterialTable::Row::reflectance1550, "0..1")
      .def_ro("roughness", &MaterialTable::Row::roughness, "0..1, of the gloss.")
      .def_ro("retro", &MaterialTable::Row::retro, "Retro-reflection: gain over a Lambertian surface of reflectance 1.")
      .def_ro("transmission", &MaterialTable::Row::transmission, "The share of the light that passes through.");
  table.def(
      "__init__",
      [](MaterialTable* self, std::vector<MaterialTable::Row> rows) { new (self) MaterialTable{std::move(rows)}; },
      "rows"_a = nb::make_tuple());
  readTuple(table, "rows", &MaterialTable::rows, "The rows, in the order of the file.");

  m.def(
      "load_material_table",
      [](const std::filesystem::path& file) {
        const ReleasedGil released;
        return loadMaterialTable(file);
      },
      "file"_a,
      "Reads a material table in the JSON format of GnoSphere or in ASAM OpenMATERIAL 3D (.xoma, .xomm or .xomp). "
      "Raises Error(file) or Error(format).");
  m.def(
      "optics_of", [](const Material& material) { return opticsOf(material); }, "material"_a,
      "Derives optics from the glTF properties base colour (red stands for near infrared), metallic, roughness, "
      "transmission and alpha.");
  m.def(
      "optics_of",
      [](const Scene& scene, const MaterialTable& of, double wavelength,
         std::optional<nb::typed<nb::list, std::string>> unused) {
        std::vector<std::string> names;
        const std::vector<Optics> optics = opticsOf(scene, of, wavelength, &names);
        if (unused)
          for (const std::string& name : names) unused->append(name);
        return tupleOf(optics);
      },
      "scene"_a, "table"_a, "wavelength"_a, "unused"_a = nb::none(),
      "Returns the optics of every material of the scene at `wavelength`, 905 or 1550 nm. Names in the table that no "
      "material has are appended to the list `unused`, if given. Raises Error(invalid_argument) for another "
      "wavelength, if a value of the table is NaN or beyond its limit, and if names in the table differ in case "
      "alone.");
}

}  // namespace gnosphere::python
