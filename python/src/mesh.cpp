// SPDX-License-Identifier: Apache-2.0
// Binds the meshes, deformations and instances of gnosphere/scene.hpp.
#include "arrays.hpp"
#include "scene/validate.hpp"
#include "whole.hpp"

namespace gnosphere::python {
namespace {

// An empty array, as Mesh.joints of a mesh without joints is, counts as none.
bool isGiven(const std::optional<ArrayLike>& array, const std::string& name) {
  return array && nb::cast<size_t>(arrayOrRefuse(array->object, name, "").attr("size")) > 0;
}

void setJoints(Mesh& mesh, uint32_t count, const std::optional<ArrayLike>& joints,
               const std::optional<ArrayLike>& weights) {
  const bool given = isGiven(joints, "Mesh: joints");
  if (given != isGiven(weights, "Mesh: joint_weights") || given != (count > 0))
    refuse("Mesh: joint_count, joints and joint_weights are given together or not at all");
  if (!given) return;
  const auto numbers = arrayOf<uint16_t>(*joints, "Mesh: joints", kAnyWidth);
  const auto shares = arrayOf<float>(*weights, "Mesh: joint_weights", kAnyWidth);
  const std::string vertices = std::to_string(mesh.vertexCount());
  if (numbers.rows() != mesh.vertexCount() || shares.rows() != mesh.vertexCount())
    refuse("Mesh: joints and joint_weights have " + std::to_string(numbers.rows()) + " and " +
           std::to_string(shares.rows()) + " rows; there are " + vertices + " vertices");
  if (numbers.width() != shares.width())
    refuse("Mesh: joints and joint_weights have " + std::to_string(numbers.width()) + " and " +
           std::to_string(shares.width()) + " columns; both must have one per influence");
  for (const uint16_t joint : numbers.values())
    if (joint >= count)
      refuse("Mesh: joints holds " + std::to_string(joint) + "; it must be less than joint_count, " +
             std::to_string(count));
  mesh.jointCount = count;
  mesh.influences = static_cast<uint32_t>(numbers.width());
  mesh.joints = numbers.copy();
  mesh.jointWeights = shares.copy();
}

using Targets = nb::typed<nb::iterable, ArrayLike>;

void setMorphTargets(Mesh& mesh, const Targets& targets) {
  for (const nb::handle target : targets) {
    const std::string name = "Mesh: morph_targets[" + std::to_string(mesh.morphTargets.size()) + "]";
    const auto array = arrayOf<float>({nb::borrow(target)}, name, 3);
    if (array.rows() != mesh.vertexCount())
      refuse(name + " has " + std::to_string(array.rows()) + " rows; there are " + std::to_string(mesh.vertexCount()) +
             " vertices");
    mesh.morphTargets.push_back(array.copy());
  }
}

void setDeformation(Mesh& mesh, const Deformation& deformation) {
  validate(deformation, "Mesh", mesh);
  mesh.deformation = deformation;
}

void bindDeformation(nb::module_& m) {
  nb::class_<Deformation>(m, "Deformation",
                          "Where the joints and morph targets of a deformable mesh are. Empty: the vertices are at "
                          "Mesh.positions. It is never changed after it is made.")
      .def(
          "__init__",
          [](Deformation* self, const TransformsLike& joints, const ArrayLike& weights) {
            new (self) Deformation{transformsOf(joints, "Deformation: joints"),
                                   arrayOf<float>(weights, "Deformation: morph_weights").copy()};
          },
          "joints"_a = nb::make_tuple(), "morph_weights"_a = nb::make_tuple(),
          "joints: shape (joints, 3, 4), float64, or a sequence of Transform. By joint: maps a vertex of the mesh "
          "frame to where the joint takes it, in the mesh frame. In the terms of glTF: inverse(node of the mesh) * "
          "node of the joint * inverse bind matrix. Mesh.joint_count entries.\nmorph_weights: shape (targets,), "
          "float32: the share of each morph target. As many as Mesh.morph_targets.\nRaises Error(invalid_argument) for "
          "arrays of another shape or type.")
      .def_prop_ro(
          "joints", [](const Deformation& self) { return transformsView(self.joints, nb::find(self)); }, kOwned,
          "Shape (joints, 3, 4), float64: a read-only view, which keeps the deformation alive.")
      .def_prop_ro(
          "morph_weights",
          [](const Deformation& self) {
            return columnView<const float>(self.morphWeights.data(), self.morphWeights.size(), nb::find(self));
          },
          kOwned, "Shape (targets,), float32: a read-only view, which keeps the deformation alive.")
      .def("empty", &Deformation::empty, "Whether the vertices are where the mesh has them.");
}

void bindDeformable(nb::class_<Mesh>& mesh) {
  mesh.def_ro("joint_count", &Mesh::jointCount, "How many joints move the vertices.")
      .def_ro("influences", &Mesh::influences, "How many joints each vertex follows.")
      .def_prop_ro(
          "joints",
          [](const Mesh& self) {
            return tableView(self.joints.data(), self.vertexCount(), self.influences, nb::find(self));
          },
          kOwned, "Shape (vertices, influences), uint16: a read-only view, which keeps the mesh alive.")
      .def_prop_ro(
          "joint_weights",
          [](const Mesh& self) {
            return tableView(self.jointWeights.data(), self.vertexCount(), self.influences, nb::find(self));
          },
          kOwned, "Shape (vertices, influences), float32: a read-only view, which keeps the mesh alive.")
      .def_prop_ro(
          "morph_targets",
          [](const Mesh& self) {
            return makeTuple<Rows<const float, 3>>(self.morphTargets.size(), [&](size_t i) {
              return nb::cast(rowsView<3>(self.morphTargets[i].data(), self.vertexCount(), nb::find(self)), kOwned);
            });
          },
          "By how much each target moves the vertices, in metres: a tuple of read-only views of shape (vertices, 3), "
          "float32, which keep the mesh alive.")
      .def_prop_rw(
          "deformation", [](const Mesh& self) { return self.deformation; }, &setDeformation,
          "At first; see Simulator.set_deformation(). Raises Error(invalid_argument) for one that does not fit.")
      .def("deformable", &Mesh::deformable, "Whether the mesh has joints or morph targets.");
}

void bindMeshItself(nb::module_& m) {
  nb::class_<MeshPart>(m, "MeshPart",
                       "A run of triangles of one mesh that share a material. It is never changed after it is made.")
      .def(
          "__init__",
          [](MeshPart* self, const Whole& first, const Whole& count, const Whole& material) {
            new (self)
                MeshPart{first.of<uint32_t>("MeshPart: first_triangle"), count.of<uint32_t>("MeshPart: triangle_count"),
                         material.of<uint32_t>("MeshPart: material")};
          },
          "first_triangle"_a = 0, "triangle_count"_a = 0, "material"_a = 0)
      .def_ro("first_triangle", &MeshPart::firstTriangle, "Index of the first triangle of the run.")
      .def_ro("triangle_count", &MeshPart::triangleCount, "Number of triangles in the run.")
      .def_ro("material", &MeshPart::material, "Index into Scene.materials.");

  auto mesh =
      nb::class_<Mesh>(m, "Mesh",
                       "Indexed triangles. Vertex v is at origin + positions[v] in the mesh frame, in metres. "
                       "The arrays keep their size; "
                       "the values of positions, indices and uvs can be changed in place, before the mesh is given to "
                       "a Simulator.\n\nA deformable mesh has joints, morph targets or both. A vertex first "
                       "moves by the morph targets, each with its weight; then it is the mean of where its "
                       "joints take it, by their weights. (glTF 2.0, sections 3.7.2.2 and 3.7.3.)");
  mesh.def(
          "__init__",
          [](Mesh* self, const ArrayLike& positions, const ArrayLike& indices, std::vector<MeshPart> parts,
             const std::optional<ArrayLike>& uvs, Vec3 origin, std::string name, uint32_t jointCount,
             const std::optional<ArrayLike>& joints, const std::optional<ArrayLike>& jointWeights,
             const std::optional<Targets>& morphTargets, const Deformation& deformation) {
            Mesh made;
            made.name = std::move(name);
            made.origin = origin;
            made.positions = arrayOf<float>(positions, "Mesh: positions", 3).copy();
            made.indices = arrayOf<uint32_t>(indices, "Mesh: indices", 3).copy();
            if (uvs) made.uvs = arrayOf<float>(*uvs, "Mesh: uvs", 2).copy();
            made.parts = std::move(parts);
            setJoints(made, jointCount, joints, jointWeights);
            if (morphTargets) setMorphTargets(made, *morphTargets);
            setDeformation(made, deformation);
            new (self) Mesh(std::move(made));
          },
          "positions"_a, "indices"_a, "parts"_a, "uvs"_a = nb::none(), "origin"_a = Vec3(), "name"_a = "",
          "joint_count"_a = 0, "joints"_a = nb::none(), "joint_weights"_a = nb::none(), "morph_targets"_a = nb::none(),
          "deformation"_a = Deformation(),
          "positions: shape (vertices, 3), float32, metres relative to `origin`.\n"
          "indices: shape (triangles, 3), uint32, counter-clockwise seen from the front.\n"
          "parts: in ascending order; together they cover every triangle.\n"
          "uvs: shape (vertices, 2), float32; needed only for materials with an alpha image.\n"
          "joint_count: how many joints move the vertices.\n"
          "joints: shape (vertices, influences), uint16: the joints that each vertex follows, at most 16, less than "
          "joint_count.\n"
          "joint_weights: shape (vertices, influences), float32, not negative; those of a vertex sum to 1.\n"
          "morph_targets: shape (targets, vertices, 3), float32, metres: by how much each target moves the vertices.\n"
          "deformation: at first; see Simulator.set_deformation().\n"
          "The arrays are copied once. Raises Error(invalid_argument) for arrays of another shape or type.")
      .def_rw("name", &Mesh::name, "Scenes from files have the name that the file states.")
      .def_rw("origin", &Mesh::origin, "Metres, in the mesh frame.")
      .def_prop_ro(
          "positions",
          [](Mesh& self) { return rowsView<3>(self.positions.data(), self.vertexCount(), nb::find(self)); }, kOwned,
          "Shape (vertices, 3), float32, metres: a view of the mesh's memory, which it keeps alive.")
      .def_prop_ro(
          "indices", [](Mesh& self) { return rowsView<3>(self.indices.data(), self.triangleCount(), nb::find(self)); },
          kOwned, "Shape (triangles, 3), uint32: a view of the mesh's memory, which it keeps alive.")
      .def_prop_ro(
          "uvs", [](Mesh& self) { return rowsView<2>(self.uvs.data(), self.uvs.size() / 2, nb::find(self)); }, kOwned,
          "Shape (vertices, 2), float32, or (0, 2): a view of the mesh's memory, which it keeps alive.")
      .def("vertex_count", &Mesh::vertexCount, "Number of vertices.")
      .def("triangle_count", &Mesh::triangleCount, "Number of triangles.");
  bindDeformable(mesh);
  readTuple(mesh, "parts", &Mesh::parts, "In ascending order; together they cover every triangle.");
}

void bindInstance(nb::module_& m) {
  nb::class_<Instance> instance(m, "Instance", "One placement of a mesh in the world. Instances share the mesh.");
  instance
      .def(
          "__init__",
          [](Instance* self, const Whole& of, const MapLike& transform, const Whole& classId, std::string name,
             const Whole& world) {
            new (self) Instance{std::move(name),
                                of.of<uint32_t>("Instance: mesh"),
                                transform.map,
                                classId.of<uint16_t>("Instance: class_id"),
                                "",
                                world.of<uint32_t>("Instance: world")};
          },
          "mesh"_a, "transform"_a = MapLike(), "class_id"_a = 0, "name"_a = "", "world"_a = 0,
          "transform: a Transform, or an array of shape (3, 4) or (4, 4).")
      .def_rw("name", &Instance::name, "Scenes from files have the name that the file states.");
  readWriteWhole(instance, "mesh", &Instance::mesh, "Index into Scene.meshes.");
  instance.def_prop_rw(
      "transform", [](const Instance& self) { return self.transform; },
      [](Instance& self, const MapLike& transform) { self.transform = transform.map; },
      "Mesh frame to world frame. An array of shape (3, 4) or (4, 4) can be assigned, too.");
  readWriteWhole(instance, "class_id", &Instance::classId,
                 "Semantic class of all surfaces whose material states none; 0 for none. See Field.class_id.");
  instance.def_rw("class_name", &Instance::className,
                  "Class that the file states by its name instead; a drive file gives it a number.");
  readWriteWhole(instance, "world", &Instance::world,
                 "The world that has the instance, see Shot.world; 0 for all of them.");
}

}  // namespace

void bindMesh(nb::module_& m) {
  bindDeformation(m);
  bindMeshItself(m);
  bindInstance(m);
  m.def(
      "deformed_positions",
      [](const Mesh& mesh, const Deformation& deformation) {
        validate(deformation, "deformed_positions", mesh);
        return ownedRows<3>(deformedPositions(mesh, deformation));
      },
      "mesh"_a, "deformation"_a,
      "The positions of the deformed mesh: shape (vertices, 3), float32, metres relative to Mesh.origin. They are "
      "computed in single precision, in the same steps on every device, so all devices see the same triangles. Raises "
      "Error(invalid_argument) for a deformation that does not fit the mesh.");
}

}  // namespace gnosphere::python
