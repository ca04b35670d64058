// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "gnosphere/export.hpp"

namespace gnosphere {

/// Metres, or a direction without unit. Frames are right-handed: x forward, y left, z up (ROS REP-103).
struct Vec3 {
  double x = 0, y = 0, z = 0;
};

/// Unit quaternion, Hamilton convention; the default is the identity.
struct Quaternion {
  double x = 0, y = 0, z = 0, w = 1;
};

/// Affine map, row-major 3x4: p' = M p + t with M = columns 0..2 and t = column 3. Mesh frame -> world.
struct Transform {
  std::array<double, 12> rows = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
};

/// `a` after `b`: (a * b)(p) = a(b(p)).
GNOSPHERE_API Transform operator*(const Transform& a, const Transform& b);
GNOSPHERE_API Vec3 operator*(const Transform& a, const Vec3& p);

enum class AlphaMode { opaque, mask, blend };

inline constexpr uint32_t kNoImage = 0xffffffffu;
/// The mesh of an instance that was removed.
inline constexpr uint32_t kNoMesh = 0xffffffffu;

/// One channel of a texture; row 0 is at v = 0. Outside 0..1 it repeats, is mirrored or keeps its border.
struct AlphaImage {
  enum class Wrap : uint8_t { repeat, mirror, clamp };
  uint32_t width = 0, height = 0;
  std::vector<uint8_t> alpha;  ///< width * height
  Wrap wrapU = Wrap::repeat, wrapV = Wrap::repeat;
};

/// Surface properties, glTF metallic-roughness vocabulary. Linear colour; factors in 0..1.
struct Material {
  std::string name;
  std::array<float, 4> baseColor = {1, 1, 1, 1};
  float metallic = 0;
  float roughness = 1;
  float transmission = 0;
  AlphaMode alphaMode = AlphaMode::opaque;
  float alphaCutoff = 0.5f;
  uint32_t alphaImage = kNoImage;  ///< index into Scene::alphaImages: alpha of the base colour's texture
  /// Retro-reflection: gain over a Lambertian of reflectance 1; 0: none. No file format of ours states it.
  float retro = 0;
  /// Both faces reflect. glTF states it per material; formats that do not are read as double-sided.
  bool doubleSided = true;
};

/// A run of triangles of one mesh that share a material.
struct MeshPart {
  uint32_t firstTriangle = 0;
  uint32_t triangleCount = 0;
  uint32_t material = 0;  ///< index into Scene::materials
};

/// Indexed triangles. Vertex v is at `origin + positions[3v..3v+2]` in the mesh frame: positions are floats relative to
/// a double origin, so georeferenced files keep their precision.
struct Mesh {
  std::string name;
  Vec3 origin;
  std::vector<float> positions;   ///< 3 per vertex, metres
  std::vector<uint32_t> indices;  ///< 3 per triangle, counter-clockwise seen from the front
  std::vector<float> uvs;         ///< 2 per vertex; empty where no material of the mesh has a texture that matters
  std::vector<MeshPart> parts;    ///< in order, covering every triangle

  size_t vertexCount() const { return positions.size() / 3; }
  size_t triangleCount() const { return indices.size() / 3; }
};

/// One placement of a mesh in the world. The mesh is shared, never copied.
struct Instance {
  std::string name;
  uint32_t mesh = 0;  ///< index into Scene::meshes
  Transform transform;
  uint16_t classId = 0;  ///< semantic class, of the user's own numbering; goes out as a field
};

/// What is there to be seen. Plain data: build it by hand or with loadScene().
struct Scene {
  std::vector<Material> materials;
  std::vector<AlphaImage> alphaImages;
  /// Images of AlphaMode::mask that are not there or not PNG: how many. Their materials have no alpha image.
  uint32_t unreadImages = 0;
  std::vector<Mesh> meshes;
  std::vector<Instance> instances;

  GNOSPHERE_API size_t uniqueTriangleCount() const;  ///< summed over meshes
  GNOSPHERE_API size_t placedTriangleCount() const;  ///< summed over instances
};

/// Axis-aligned box in world coordinates. Empty where min > max.
struct Bounds {
  Vec3 min, max;
  bool empty() const { return !(min.x <= max.x); }
};

/// Box of every finite vertex of every instance.
GNOSPHERE_API Bounds worldBounds(const Scene& scene);

/// Throws Error(invalidArgument) that names the material, image, mesh, part or instance whose indices or sizes do not
/// fit.
GNOSPHERE_API void validate(const Scene& scene);

enum class UpAxis { formatDefault, y, z };

struct LoadOptions {
  UpAxis up = UpAxis::formatDefault;  ///< glTF is y-up by its specification; OBJ, PLY and STL default to z-up
  double scale = 1;                   ///< file units -> metres
};

/// Reads .gltf, .glb, .obj, .ply or .stl; of textures, only glTF's PNG ones of cut-out materials. y-up files are turned
/// so that (x, y, z) becomes (x, -z, y). Throws Error(file) if the file cannot be read, Error(format) if its content is
/// not sound.
GNOSPHERE_API Scene loadScene(const std::filesystem::path& file, const LoadOptions& options = {});

/// Writes a binary glTF 2.0 file (y-up), meshes shared by their instances. Throws Error(file).
GNOSPHERE_API void writeGlb(const Scene& scene, const std::filesystem::path& file);

}  // namespace gnosphere
