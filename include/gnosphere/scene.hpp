// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "gnosphere/export.hpp"

namespace gnosphere {

/// A point or vector in metres, or a direction without a unit. Frames are right-handed: x forward, y left, z up (ROS
/// REP-103).
struct Vec3 {
  double x = 0, y = 0, z = 0;
};

/// Unit quaternion, Hamilton convention; the default is the identity. Of another length, it stands for the unit
/// quaternion of its direction; one of length 0 is an error.
struct Quaternion {
  double x = 0, y = 0, z = 0, w = 1;
};

/// Affine map from the mesh frame to the world frame, row-major 3x4: p' = M p + t with M = columns 0..2 and t = column
/// 3 (metres).
struct Transform {
  std::array<double, 12> rows = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
};

/// Composes two maps: (a * b) p = a * (b * p).
GNOSPHERE_API Transform operator*(const Transform& a, const Transform& b);
/// Maps the point `p` by the transform `a`.
GNOSPHERE_API Vec3 operator*(const Transform& a, const Vec3& p);

/// Meaning of the alpha of a material, as in glTF.
enum class AlphaMode { opaque, mask, blend };

/// The index of no image.
inline constexpr uint32_t kNoImage = 0xffffffffu;
/// Mesh index of an instance that was removed.
inline constexpr uint32_t kNoMesh = 0xffffffffu;

/// The alpha channel of a texture; row 0 is at v = 0. `wrapU` and `wrapV` tell what coordinates outside 0..1 read.
struct AlphaImage {
  enum class Wrap : uint8_t { repeat, mirror, clamp };
  uint32_t width = 0, height = 0;
  std::vector<uint8_t> alpha;  ///< width * height values, row by row
  Wrap wrapU = Wrap::repeat, wrapV = Wrap::repeat;
};

/// Surface properties in the terms of the glTF metallic-roughness model. Colours are linear; factors lie in 0..1.
struct Material {
  static constexpr float kMostRetro = 1e6f;  ///< the gain of a cube corner

  std::string name;
  std::array<float, 4> baseColor = {1, 1, 1, 1};
  float metallic = 0;
  float roughness = 1;
  float transmission = 0;
  AlphaMode alphaMode = AlphaMode::opaque;
  float alphaCutoff = 0.5f;
  uint32_t alphaImage = kNoImage;  ///< index into Scene::alphaImages: alpha channel of the base colour texture
  /// Gain of the retro-reflection over a Lambertian surface of reflectance 1, at most kMostRetro. A surface without
  /// retro-reflection has 0. glTF states it in `extras`, other formats do not.
  float retro = 0;
  /// If true, both faces reflect. glTF states this per material; scenes from other formats are double-sided.
  bool doubleSided = true;
  uint16_t classId = 0;   ///< semantic class, numbered by the user; if 0, that of the instance counts
  std::string className;  ///< class that the file states by its name instead; a drive file gives it a number
};

/// A run of triangles of one mesh that share a material.
struct MeshPart {
  uint32_t firstTriangle = 0;
  uint32_t triangleCount = 0;
  uint32_t material = 0;  ///< index into Scene::materials
};

/// Where the joints and morph targets of a deformable mesh are. An empty one leaves the vertices at Mesh::positions.
struct Deformation {
  /// By joint: maps a vertex of the mesh frame to where the joint takes it, in the mesh frame. In the terms of glTF:
  /// inverse(node of the mesh) * node of the joint * inverse bind matrix. The list has Mesh::jointCount entries.
  std::vector<Transform> joints;
  std::vector<float> morphWeights;  ///< by morph target: its share. As many entries as Mesh::morphTargets.

  bool empty() const { return joints.empty() && morphWeights.empty(); }
};

/// A mesh of indexed triangles. Vertex v is at `origin + positions[3v..3v+2]` in the mesh frame. Positions are floats
/// relative to an origin in double precision, so georeferenced files keep their precision.
struct Mesh {
  std::string name;
  Vec3 origin;
  std::vector<float> positions;   ///< 3 per vertex, metres
  std::vector<uint32_t> indices;  ///< 3 per triangle, counter-clockwise seen from the front
  std::vector<float> uvs;         ///< 2 per vertex; empty if no material of the mesh has an alpha image
  std::vector<MeshPart> parts;    ///< in ascending order; together they cover every triangle

  /// A deformable mesh has joints, morph targets or both. A vertex first moves by the morph targets, each with its
  /// weight; then it is the mean of where its joints take it, by their weights. (glTF 2.0, sections 3.7.2.2 and 3.7.3.)
  uint32_t jointCount = 0;
  uint32_t influences = 0;       ///< joints that each vertex follows, at most 16
  std::vector<uint16_t> joints;  ///< `influences` per vertex, each less than jointCount
  /// `influences` per vertex, not negative; those of a vertex sum to 1 within 0.001, and are divided by their sum
  std::vector<float> jointWeights;
  std::vector<std::vector<float>> morphTargets;  ///< per target 3 per vertex: by how much it moves them, metres
  Deformation deformation;                       ///< at first; see Simulator::setDeformation()

  size_t vertexCount() const { return positions.size() / 3; }
  size_t triangleCount() const { return indices.size() / 3; }
  bool deformable() const { return jointCount > 0 || !morphTargets.empty(); }
};

/// The positions of the deformed mesh, 3 per vertex, in metres relative to Mesh::origin; every device rounds alike.
/// The mesh must be valid, see validate(). Throws Error(invalidArgument) for a deformation that is not empty and has
/// other numbers of joints or weights, or one that is not finite.
GNOSPHERE_API std::vector<float> deformedPositions(const Mesh& mesh, const Deformation& deformation);

/// One placement of a mesh in the world. Instances share the mesh; it is never copied.
struct Instance {
  std::string name;
  uint32_t mesh = 0;  ///< index into Scene::meshes
  Transform transform;
  uint16_t classId = 0;   ///< semantic class of all surfaces whose material states none; 0 for none
  std::string className;  ///< class that the file states by its name instead; a drive file gives it a number
  uint32_t world = 0;     ///< the world that has the instance, see Shot::world; 0 for all of them, as in all files
};

/// The index of no node, and of no skin.
inline constexpr uint32_t kNoNode = 0xffffffffu;
inline constexpr uint32_t kNoSkin = 0xffffffffu;

/// A frame that clips move: its map to the frame of its parent is translation * rotation * scale, or `matrix`.
struct Node {
  std::string name;
  uint32_t parent = kNoNode;  ///< index into SceneAnimation::nodes, less than its own; kNoNode: none
  Vec3 translation;
  Quaternion rotation;  ///< of any length but 0; only its direction counts
  Vec3 scale = {1, 1, 1};
  std::optional<Transform> matrix;  ///< if given, no clip moves the node
  std::vector<float> morphWeights;  ///< of the mesh that it places: as many as its morph targets, or none for all 0
};

/// The joints of skinned meshes.
struct Skin {
  std::string name;
  std::vector<uint32_t> joints;         ///< by joint: index into SceneAnimation::nodes
  std::vector<Transform> inverseBinds;  ///< by joint: maps the mesh frame to the frame of the joint, as it was bound
};

/// How a clip moves one property of one node: values at key times.
struct Track {
  enum class Property : uint8_t { translation, rotation, scale, morphWeights };
  enum class Interpolation : uint8_t { step, linear, cubic };
  uint32_t node = 0;  ///< index into SceneAnimation::nodes
  Property property = Property::translation;
  Interpolation interpolation = Interpolation::linear;  ///< linear: rotations turn by slerp
  std::vector<float> times;                             ///< seconds from 0 on, ascending; at least one
  /// Per key 3 values, 4 for a rotation (x, y, z, w), or one per morph target. Cubic: per key the slopes before it, the
  /// values, and the slopes after it (glTF 2.0, appendix C).
  std::vector<float> values;
};

/// A named motion of nodes; "animation" in glTF. At most one track moves a property of a node.
struct Clip {
  std::string name;
  double duration = 0;  ///< seconds
  std::vector<Track> tracks;
};

/// An instance that follows a node or a skin. Its transform is root * node * offset. With a skin it is root * offset,
/// and the joints of its mesh are at inverse(offset) * node of the joint * inverse bind.
struct AnimatedInstance {
  uint32_t instance = 0;    ///< index into Scene::instances
  uint32_t node = 0;        ///< index into SceneAnimation::nodes; its morph weights are those of the mesh
  uint32_t skin = kNoSkin;  ///< index into SceneAnimation::skins
  Transform offset;
};

/// Everything that clips can move; see stateAt() in animation.hpp. A deformable mesh follows one node and one skin, so
/// instances that follow others have a mesh of their own.
struct SceneAnimation {
  Transform root;           ///< maps the frame above all nodes to the world
  std::vector<Node> nodes;  ///< parents come before their children
  std::vector<Skin> skins;
  std::vector<Clip> clips;
  std::vector<AnimatedInstance> instances;
};

/// Everything that the sensor can see. A scene is plain data: build it by hand or with loadScene().
struct Scene {
  std::vector<Material> materials;
  std::vector<AlphaImage> alphaImages;
  /// Number of images of AlphaMode::mask materials that are missing or not PNG. Their materials have no alpha image.
  uint32_t unreadImages = 0;
  std::vector<Mesh> meshes;
  std::vector<Instance> instances;
  SceneAnimation animation;  ///< empty in a scene that has neither clips nor deformable meshes
  /// Lines about what the scene leaves out of its file: one for each kind of content, such as lines or vertex colours,
  /// with how often, and one for each library of materials that cannot be read.
  std::vector<std::string> leftOut;

  GNOSPHERE_API size_t uniqueTriangleCount() const;  ///< summed over meshes
  GNOSPHERE_API size_t placedTriangleCount() const;  ///< summed over instances
};

/// Axis-aligned box in world coordinates, in metres. The box is empty if min > max.
struct Bounds {
  Vec3 min, max;
  bool empty() const { return !(min.x <= max.x); }
};

/// Returns the box around all finite vertices that triangles use, of all instances.
GNOSPHERE_API Bounds worldBounds(const Scene& scene);

/// Throws Error(invalidArgument) that names the material, image, mesh, part, instance, node, skin or clip whose indices
/// or sizes are inconsistent.
GNOSPHERE_API void validate(const Scene& scene);

/// Returns the scene with everything of `other` behind what it has, moved by `transform`: materials, alpha images,
/// meshes, instances, skins and clips get the indices that follow, in their order; nodes do, too, behind one more,
/// which moves them, if both scenes have nodes. Throws Error(invalidArgument) that names the scene if one of the two is
/// wrong, see validate(), and if the transform is not finite.
GNOSPHERE_API Scene joined(Scene scene, const Scene& other, const Transform& transform = {});

/// Which axis of a file points up.
enum class UpAxis { formatDefault, y, z };

/// How a file of a scene is read.
struct LoadOptions {
  UpAxis up = UpAxis::formatDefault;  ///< glTF is y-up by its specification; OBJ, PLY and STL default to z-up
  double scale = 1;                   ///< metres per unit of the file
};

/// Reads .gltf, .glb, .obj, .ply or .stl. The only textures read are PNG images of cut-out (AlphaMode::mask) materials
/// in glTF. y-up files are turned so that (x, y, z) becomes (x, -z, y). Skins, morph targets and animations of glTF are
/// in Scene::animation; the instances and the deformations of the meshes are at rest, as the nodes of the file are.
/// Throws Error(file) if the file cannot be read, Error(format) if its content is invalid, and Error(invalidArgument)
/// for another ending, or a scale that is not positive.
GNOSPHERE_API Scene loadScene(const std::filesystem::path& file, const LoadOptions& options = {});

/// Writes a binary glTF 2.0 file (y-up) with Scene::animation; instances share their meshes. loadScene() reads back
/// what scans of the scene see, with the same numbers of instances and materials. For instances that are not animated a
/// deformable mesh is written as it is deformed. In names U+FFFD takes the place of what is not UTF-8. Throws
/// Error(file) if the file cannot be written, and Error(invalidArgument) for a scene that is wrong, see validate(), or
/// larger than GLB allows, and for another ending than .glb.
GNOSPHERE_API void writeGlb(const Scene& scene, const std::filesystem::path& file);

}  // namespace gnosphere
