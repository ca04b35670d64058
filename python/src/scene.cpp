// SPDX-License-Identifier: Apache-2.0
// Binds the transforms, materials and scenes of gnosphere/scene.hpp.
#include <nanobind/operators.h>
#include <nanobind/stl/array.h>

#include <algorithm>
#include <cmath>

#include "arrays.hpp"
#include "base/transform.hpp"
#include "rows.hpp"
#include "scene/coarse_positions.hpp"
#include "state.hpp"
#include "whole.hpp"

namespace gnosphere::python {
namespace {

void bindTransform(nb::module_& m) {
  nb::class_<Transform>(m, "Transform",
                        "Affine map from the mesh frame to the world frame: p' = M p + t, with M = rows[:, :3] and t = "
                        "rows[:, 3] in metres. It is never changed after it is made.")
      .def(nb::init<>(), "The identity.")
      .def(
          "__init__",
          [](Transform* self, const ArrayLike& rows) { new (self) Transform(transformOf(rows, "Transform: rows")); },
          "rows"_a,
          "rows: shape (3, 4), or (4, 4) with the last row 0, 0, 0, 1; float64. Raises Error(invalid_argument) for "
          "another shape or another last row.")
      .def_prop_ro(
          "rows",
          [](const Transform& self) {
            return nb::ndarray<nb::numpy, const double, nb::shape<3, 4>>(self.rows.data(), {3, 4}, nb::find(self));
          },
          kOwned, "Shape (3, 4), float64, read-only.")
      .def(
          "__mul__", [](const Transform& a, const Transform& b) { return a * b; }, nb::is_operator(),
          "(a * b) p = a * (b * p)")
      .def(
          "__mul__", [](const Transform& a, const Vec3& p) { return a * p; }, nb::is_operator(), "Maps the point p.")
      .def(
          "__matmul__", [](const Transform& a, const Transform& b) { return a * b; }, nb::is_operator(),
          "As a * b: (a @ b) p = a * (b * p)")
      .def(
          "inverse",
          [](const Transform& self) {
            if (const double size = determinant(self); size == 0 || !std::isfinite(size))
              refuse("Transform: the map has no inverse; its determinant is " + std::to_string(size));
            return inverse(self);
          },
          "The map back: self * self.inverse() is the identity, but for rounding. Raises Error(invalid_argument) if "
          "there is none.")
      .def("__repr__",
           [](nb::handle self) { return nb::str("Transform({})").format(self.attr("rows").attr("tolist")()); });
}

void bindMaterial(nb::module_& m) {
  nb::enum_<AlphaMode>(m, "AlphaMode", "What the alpha of a material means, as in glTF.")
      .value("opaque", AlphaMode::opaque)
      .value("mask", AlphaMode::mask)
      .value("blend", AlphaMode::blend);

  nb::class_<AlphaImage> image(
      m, "AlphaImage", "The alpha channel of a texture. wrap_u and wrap_v tell what coordinates outside 0..1 read.");
  nb::enum_<AlphaImage::Wrap>(image, "Wrap", "What coordinates outside 0..1 read.")
      .value("repeat", AlphaImage::Wrap::repeat)
      .value("mirror", AlphaImage::Wrap::mirror)
      .value("clamp", AlphaImage::Wrap::clamp);
  image
      .def(
          "__init__",
          [](AlphaImage* self, const ArrayLike& alpha, const Choice<AlphaImage::Wrap>& u,
             const Choice<AlphaImage::Wrap>& v) {
            const nb::object image = arrayOrRefuse(alpha.object, "AlphaImage: alpha", " of shape (height, width)");
            const auto shape = nb::cast<nb::tuple>(image.attr("shape"));
            if (nb::len(shape) != 2)
              refuse("AlphaImage: alpha has the shape " + nb::cast<std::string>(nb::str(shape)) +
                     "; it must be (height, width)");
            const ArrayLike flat{image.attr("reshape")(-1)};
            new (self) AlphaImage{nb::cast<uint32_t>(shape[1]), nb::cast<uint32_t>(shape[0]),
                                  arrayOf<uint8_t>(flat, "AlphaImage: alpha").copy(), chosen(u, "AlphaImage: wrap_u"),
                                  chosen(v, "AlphaImage: wrap_v")};
          },
          "alpha"_a, "wrap_u"_a = AlphaImage::Wrap::repeat, "wrap_v"_a = AlphaImage::Wrap::repeat,
          "alpha: shape (height, width), uint8; row 0 is at v = 0.")
      .def_ro("width", &AlphaImage::width, "Pixels.")
      .def_ro("height", &AlphaImage::height, "Pixels.")
      .def_prop_ro(
          "alpha",
          [](AlphaImage& self) {
            return nb::ndarray<nb::numpy, uint8_t, nb::ndim<2>>(self.alpha.data(), {self.height, self.width},
                                                                nb::find(self));
          },
          kOwned, "Shape (height, width), uint8: a view of the image's memory, which it keeps alive.");
  readWriteChoice(image, "wrap_u", &AlphaImage::wrapU, "What coordinates below 0 and above 1 read, across.");
  readWriteChoice(image, "wrap_v", &AlphaImage::wrapV, "What coordinates below 0 and above 1 read, downwards.");

  nb::class_<Material> material(m, "Material",
                                "Surface properties in the terms of the glTF metallic-roughness model. Colours are "
                                "linear; factors lie in 0..1.");
  material.def_rw("name", &Material::name, "Scenes from files have the name that the file states.")
      .def_prop_rw(
          "base_color",
          [](const Material& self) {
            const auto& c = self.baseColor;
            return nb::typed<nb::tuple, float, float, float, float>(nb::make_tuple(c[0], c[1], c[2], c[3]));
          },
          [](Material& self, const Color& color) { self.baseColor = color.rgba; },
          "Red, green, blue, alpha: any sequence or array of 4 numbers is taken.")
      .def_rw("metallic", &Material::metallic, "0 for a dielectric, 1 for a metal.")
      .def_rw("roughness", &Material::roughness, "0 for a mirror, 1 for a rough surface.")
      .def_rw("transmission", &Material::transmission, "The share of the light that passes through.");
  readWriteChoice(material, "alpha_mode", &Material::alphaMode, "What alpha means.");
  material.def_rw("alpha_cutoff", &Material::alphaCutoff, "With AlphaMode.mask, what has less alpha is a hole.");
  readWriteWhole(material, "alpha_image", &Material::alphaImage,
                 "Index into Scene.alpha_images: alpha channel of the base colour texture; NO_IMAGE for none.");
  material
      .def_rw("retro", &Material::retro,
              "Retro-reflection: gain over a Lambertian surface of reflectance 1; 0 for none. glTF states it in "
              "`extras`.")
      .def_rw("double_sided", &Material::doubleSided, "Whether both faces reflect.");
  readWriteWhole(material, "class_id", &Material::classId,
                 "Semantic class, numbered by the user; if 0, that of the instance counts. See Field.class_id.");
  material.def_rw("class_name", &Material::className,
                  "Class that the file states by its name instead; a drive file gives it a number.");
  bindKeywords(material, "Takes its properties as keywords, in which a choice may be its name.",
               {"name", "base_color", "metallic", "roughness", "transmission", "alpha_mode", "alpha_cutoff",
                "alpha_image", "retro", "double_sided", "class_id"});
}

/// Reads a scene, and warns of positions that have steps.
Scene loadSceneTold(const std::filesystem::path& file, const LoadOptions& given) {
  const LoadOptions options = given;
  Scene scene;
  std::string steps;
  {
    const ReleasedGil released;
    scene = loadScene(file, options);
    steps = coarsePositions(file, scene);
  }
  if (!steps.empty()) warnUser(file.string() + ": " + steps);
  return scene;
}

}  // namespace

void bindScene(nb::module_& m) {
  m.attr("NO_IMAGE") = kNoImage;
  m.attr("NO_MESH") = kNoMesh;
  bindTransform(m);
  bindMaterial(m);
  bindMesh(m);
  bindAnimation(m);

  nb::class_<Scene> scene(
      m, "Scene", nb::is_weak_referenceable(),
      "Everything that the sensor can see. Its lists keep their length; what is in them can be changed in "
      "place, for example scene.instances[3].class_id = 7, and counts for simulators that are made "
      "afterwards. Its animation is assigned whole. A scene must not be changed while another thread gives it to the "
      "library.");
  scene
      .def(
          "__init__",
          [](Scene* self, std::vector<Material> materials, std::vector<Mesh> meshes, std::vector<Instance> instances,
             std::vector<AlphaImage> alphaImages, SceneAnimation animation) {
            new (self) Scene{std::move(materials), std::move(alphaImages), 0, std::move(meshes),
                             std::move(instances), std::move(animation),   {}};
          },
          "materials"_a = nb::make_tuple(), "meshes"_a = nb::make_tuple(), "instances"_a = nb::make_tuple(),
          "alpha_images"_a = nb::make_tuple(), "animation"_a = SceneAnimation(), "Copies what it is given.")
      .def_prop_ro(
          "materials", [](Scene& self) { return elementsOf(nb::find(self), self.materials); },
          "A tuple; its elements can be changed in place. Each access makes it anew, so take it once before a loop.")
      .def_prop_ro(
          "alpha_images", [](Scene& self) { return elementsOf(nb::find(self), self.alphaImages); },
          "The alpha channels of textures: a tuple.")
      .def_prop_ro(
          "meshes", [](Scene& self) { return elementsOf(nb::find(self), self.meshes); },
          "A tuple, made anew by each access; names and origins can be changed in place.")
      .def_prop_ro(
          "instances", [](Scene& self) { return elementsOf(nb::find(self), self.instances); },
          "A tuple; its elements can be changed in place. Each access makes it anew, so take it once before a loop.")
      .def_rw("unread_images", &Scene::unreadImages,
              "Number of images of AlphaMode.mask materials that are missing or not PNG.")
      .def("unique_triangle_count", &Scene::uniqueTriangleCount, "Summed over meshes.")
      .def("placed_triangle_count", &Scene::placedTriangleCount, "Summed over instances.");
  readWriteCopy(scene, "animation", &Scene::animation,
                "Empty in a scene that has neither clips nor deformable meshes. A copy, assigned whole.");
  readWriteTuple(scene, "left_out", &Scene::leftOut,
                 "What the scene leaves out of its file: a line for each kind of content, such as lines or vertex "
                 "colours, with how often. A tuple, assigned whole.");

  nb::class_<Bounds> bounds(m, "Bounds", "Axis-aligned box in world coordinates, in metres. It is empty if min > max.");
  bindState<&Bounds::min, &Bounds::max>(bounds);
  bounds.def_ro("min", &Bounds::min, "The least x, y and z, in metres.")
      .def_ro("max", &Bounds::max, "The greatest x, y and z, in metres.")
      .def("empty", &Bounds::empty, "Whether there is no vertex in it.");
  m.def(
      "world_bounds",
      [](const Scene& scene) {
        const ReleasedGil released;
        return worldBounds(scene);
      },
      "scene"_a, "Returns the box around all finite vertices that triangles use, of all instances.");
  m.def(
      "validate", [](const Scene& scene) { validate(scene); }, "scene"_a,
      "Raises Error(invalid_argument) that names the material, image, mesh, part, instance, node, skin or clip whose "
      "indices or sizes are inconsistent.");

  m.def(
      "joined",
      [](const Scene& scene, const Scene& other, const MapLike& to) {
        const Transform map = to.map;
        const ReleasedGil released;
        return joined(scene, other, map);
      },
      "scene"_a, "other"_a, "transform"_a = MapLike(),
      "Returns a scene with everything of `scene`, and everything of `other` behind it, moved by `transform`: "
      "materials, "
      "alpha images, meshes, instances, skins and clips get the indices that follow, in their order; nodes do, too, "
      "behind one more, which moves them, if both scenes have nodes. Raises Error(invalid_argument).");

  nb::enum_<UpAxis>(m, "UpAxis", "Which axis of a file points up.")
      .value("format_default", UpAxis::formatDefault, "glTF is y-up by its specification; OBJ, PLY and STL are z-up.")
      .value("y", UpAxis::y)
      .value("z", UpAxis::z);
  nb::class_<LoadOptions> load(m, "LoadOptions", "How a file of a scene is read.");
  readWriteChoice(load, "up", &LoadOptions::up, "Which axis of the file points up.");
  load.def_rw("scale", &LoadOptions::scale, "Metres per unit of the file.");
  bindKeywords(load, "Takes its properties as keywords, in which a choice may be its name.", {"up", "scale"});
  m.def("load_scene", &loadSceneTold, "file"_a, "options"_a = LoadOptions(),
        "Reads .gltf, .glb, .obj, .ply or .stl, without holding the GIL. The only textures read are PNG images of "
        "cut-out (AlphaMode.mask) materials in glTF. y-up files are turned so that (x, y, z) becomes (x, -z, y). "
        "Skins, morph targets and animations of glTF are in Scene.animation; the instances and the deformations of the "
        "meshes are at rest, as the nodes of the file are. Warns (UserWarning) of positions in single precision so far "
        "from their origin that they have steps of 2 mm or more. Raises Error(file) if the file cannot be read, "
        "Error(format) if its content is invalid.");
  m.def(
      "write_glb",
      [](const Scene& scene, const std::filesystem::path& file) {
        const ReleasedGil released;
        writeGlb(scene, file);
      },
      "scene"_a, "file"_a,
      "Writes a binary glTF 2.0 file (y-up) with Scene.animation; instances share their meshes. For "
      "instances that are not animated a deformable mesh is written as it is deformed. load_scene() reads back what "
      "scans of the scene see. Raises Error(file).");
}

}  // namespace gnosphere::python
