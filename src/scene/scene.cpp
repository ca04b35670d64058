// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstdint>
#include <limits>
#include <locale>
#include <sstream>

#include "base/finite.hpp"
#include "base/limits.hpp"
#include "base/text.hpp"
#include "base/vector.hpp"
#include "scene/used_vertices.hpp"
#include "scene/validate.hpp"

namespace gnosphere {

Transform operator*(const Transform& a, const Transform& b) {
  Transform c;
  for (int row = 0; row < 3; ++row) {
    const double* m = &a.rows[4 * row];
    for (int column = 0; column < 4; ++column) {
      double sum = column == 3 ? m[3] : 0;
      for (int k = 0; k < 3; ++k) sum += m[k] * b.rows[4 * k + column];
      c.rows[4 * row + column] = sum;
    }
  }
  return c;
}

Vec3 operator*(const Transform& a, const Vec3& p) {
  const auto& m = a.rows;
  return {m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3], m[4] * p.x + m[5] * p.y + m[6] * p.z + m[7],
          m[8] * p.x + m[9] * p.y + m[10] * p.z + m[11]};
}

namespace {

[[noreturn]] void fail(const std::string& what) {
  throw Error(ErrorCode::invalidArgument, what);
}

}  // namespace

const Mesh& meshOf(const Scene& scene, size_t instance) {
  const uint32_t mesh = scene.instances[instance].mesh;
  if (mesh >= scene.meshes.size())
    fail("instance " + std::to_string(instance) + ": mesh " + std::to_string(mesh) + " does not exist, the scene has " +
         std::to_string(scene.meshes.size()));
  return scene.meshes[mesh];
}

size_t Scene::uniqueTriangleCount() const {
  size_t count = 0;
  for (const Mesh& mesh : meshes) count += mesh.triangleCount();
  return count;
}

size_t Scene::placedTriangleCount() const {
  size_t count = 0;
  for (size_t i = 0; i < instances.size(); ++i)
    if (instances[i].mesh != kNoMesh) count += meshOf(*this, i).triangleCount();
  return count;
}

std::vector<bool> usedVertices(const Mesh& mesh) {
  std::vector<bool> used(mesh.vertexCount());
  for (const uint32_t index : mesh.indices)
    if (index < used.size()) used[index] = true;
  return used;
}

void validate(const AlphaImage& image, const std::string& name) {
  const uint64_t pixels = uint64_t{image.width} * image.height;
  if (pixels > 0 && image.alpha.size() == pixels) return;
  fail(name + ": " + std::to_string(image.width) + " x " + std::to_string(image.height) +
       (pixels == 0 ? " pixels are none, and an image has at least one"
                    : " pixels need as many values, there are " + std::to_string(image.alpha.size())));
}

namespace {

void checkJoints(const Mesh& mesh, const std::string& name) {
  const size_t expected = mesh.vertexCount() * mesh.influences;
  limits::kJoints.check(mesh.jointCount, name + ": it has");
  if ((mesh.jointCount > 0) != (mesh.influences > 0))
    fail(name + ": " + std::to_string(mesh.jointCount) + " joints and " + std::to_string(mesh.influences) +
         " influences per vertex; both must be 0 or both more");
  limits::kInfluences.check(mesh.influences, name + ": it has");
  if (mesh.joints.size() != expected || mesh.jointWeights.size() != expected)
    fail(name + ": " + std::to_string(mesh.vertexCount()) + " vertices with " + std::to_string(mesh.influences) +
         " influences each need " + std::to_string(expected) + " joints and weights, there are " +
         std::to_string(mesh.joints.size()) + " and " + std::to_string(mesh.jointWeights.size()));
  for (uint16_t joint : mesh.joints)
    if (joint >= mesh.jointCount)
      fail(name + ": a vertex follows joint " + std::to_string(joint) + ", the mesh has " +
           std::to_string(mesh.jointCount));
  for (size_t vertex = 0; vertex < (mesh.influences > 0 ? mesh.vertexCount() : 0); ++vertex) {
    double sum = 0;
    for (size_t k = 0; k < mesh.influences; ++k) {
      const float weight = mesh.jointWeights[vertex * mesh.influences + k];
      if (!(weight >= 0)) fail(name + ": a joint's weight at vertex " + std::to_string(vertex) + " is negative or NaN");
      sum += weight;
    }
    if (!(std::abs(sum - 1) < 1e-3))
      fail(name + ": the joints' weights of vertex " + std::to_string(vertex) + " sum to " + numberText(sum) +
           ", not to 1");
  }
  for (size_t i = 0; i < mesh.morphTargets.size(); ++i)
    if (mesh.morphTargets[i].size() != mesh.positions.size())
      fail(name + ": morph target " + std::to_string(i) + " has " + std::to_string(mesh.morphTargets[i].size()) +
           " numbers, the positions have " + std::to_string(mesh.positions.size()));
  validate(mesh.deformation, name, mesh);
}

}  // namespace

void validate(const Deformation& deformation, const std::string& name, const Mesh& mesh) {
  if (deformation.empty()) return;
  if (deformation.joints.size() != mesh.jointCount || deformation.morphWeights.size() != mesh.morphTargets.size())
    fail(name + ": its deformation has " + std::to_string(deformation.joints.size()) + " joints and " +
         std::to_string(deformation.morphWeights.size()) + " morph weights, the mesh has " +
         std::to_string(mesh.jointCount) + " and " + std::to_string(mesh.morphTargets.size()));
  for (size_t i = 0; i < deformation.joints.size(); ++i)
    if (!allFinite(deformation.joints[i].rows))
      fail(name + ": the map of joint " + std::to_string(i) + " is not finite");
  for (size_t i = 0; i < deformation.morphWeights.size(); ++i)
    if (!std::isfinite(deformation.morphWeights[i]))
      fail(name + ": the weight of morph target " + std::to_string(i) + " is not finite");
}

void validate(const Material& material, const std::string& name) {
  const auto check = [&](const char* what, float value, float most) {
    if (value >= 0 && value <= most) return;
    std::ostringstream text;
    text.imbue(std::locale::classic());
    text << name << ": its " << what << " must be 0.." << most << ", is " << value;
    fail(text.str());
  };
  for (const float factor : material.baseColor) check("base colour", factor, 1);
  check("metallic factor", material.metallic, 1);
  check("roughness", material.roughness, 1);
  check("transmission", material.transmission, 1);
  check("alpha cutoff", material.alphaCutoff, std::numeric_limits<float>::max());
  check("retro-reflection", material.retro, Material::kMostRetro);
}

void validate(const Mesh& mesh, const std::string& name, const std::vector<Material>& materials) {
  if (!isFinite(mesh.origin)) fail(name + ": its origin is not finite");
  if (mesh.positions.size() % 3 != 0) fail(name + ": positions must come in threes");
  if (!mesh.uvs.empty() && mesh.uvs.size() != 2 * mesh.vertexCount())
    fail(name + ": " + std::to_string(mesh.vertexCount()) + " vertices need two texture coordinates each or none, " +
         "there are " + std::to_string(mesh.uvs.size()));
  if (mesh.indices.size() % 3 != 0) fail(name + ": indices must come in threes");
  for (uint32_t index : mesh.indices)
    if (index >= mesh.vertexCount())
      fail(name + ": index " + std::to_string(index) + " is out of range, the mesh has " +
           std::to_string(mesh.vertexCount()) + " vertices");
  checkJoints(mesh, name);
  size_t next = 0;
  for (const MeshPart& part : mesh.parts) {
    if (part.firstTriangle != next) fail(name + ": its parts must follow each other without a gap");
    if (part.material >= materials.size())
      fail(name + ": material " + std::to_string(part.material) + " does not exist, the scene has " +
           std::to_string(materials.size()));
    if (mesh.uvs.empty() && mesh.vertexCount() > 0 && materials[part.material].alphaImage != kNoImage)
      fail(name + ": material " + std::to_string(part.material) + " has an alpha image, the mesh has no uvs for it");
    next += part.triangleCount;
  }
  if (next != mesh.triangleCount())
    fail(name + ": its parts cover " + std::to_string(next) + " of " + std::to_string(mesh.triangleCount()) +
         " triangles");
}

void validate(const Scene& scene) {
  for (size_t i = 0; i < scene.alphaImages.size(); ++i)
    validate(scene.alphaImages[i], "alpha image " + std::to_string(i));
  for (size_t i = 0; i < scene.materials.size(); ++i) {
    const std::string& name = scene.materials[i].name;
    validate(scene.materials[i], "material " + std::to_string(i) + (name.empty() ? "" : " ('" + name + "')"));
    const uint32_t image = scene.materials[i].alphaImage;
    if (image != kNoImage && image >= scene.alphaImages.size())
      fail("material " + std::to_string(i) + ": alpha image " + std::to_string(image) +
           " does not exist, the scene has " + std::to_string(scene.alphaImages.size()));
  }
  for (size_t i = 0; i < scene.meshes.size(); ++i) {
    const std::string& name = scene.meshes[i].name;
    validate(scene.meshes[i], "mesh " + std::to_string(i) + (name.empty() ? "" : " ('" + name + "')"), scene.materials);
  }
  uint64_t placed = 0;
  for (size_t i = 0; i < scene.instances.size(); ++i) {
    const Instance& instance = scene.instances[i];
    const Mesh& mesh = meshOf(scene, i);
    if (!allFinite(instance.transform.rows)) fail("instance " + std::to_string(i) + ": its transform is not finite");
    placed += mesh.triangleCount();
  }
  limits::kTriangles.check(placed, "the scene places");
  validateAnimation(scene);
}

}  // namespace gnosphere
