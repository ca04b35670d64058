// SPDX-License-Identifier: Apache-2.0
#include "kept_scene.hpp"

#include <algorithm>
#include <atomic>
#include <map>
#include <utility>

#include "base/finite.hpp"
#include "base/limits.hpp"
#include "base/room.hpp"
#include "base/threads.hpp"
#include "geometry/transform_rows.hpp"
#include "geometry/transform_sources.hpp"
#include "geometry/vertex_sources.hpp"
#include "gnosphere/error.hpp"
#include "scene/validate.hpp"
#include "shot_checks.hpp"

namespace gnosphere {

KeptScene::KeptScene(const Scene& scene, SensorPlanner& planner) : planner_(planner) {
  validate(scene);
  scene_.materials = scene.materials;
  scene_.alphaImages = scene.alphaImages;
  for (size_t i = 0; i < scene.materials.size(); ++i) materials_.take();
  for (const Mesh& mesh : scene.meshes) keep(keptOf(mesh));
  for (const Instance& instance : scene.instances) {
    reserveInstance();
    keep(instance.mesh, instance.classId, instance.world);
  }
  stale_ = false;
}

namespace {

// Refuses two motions of one instance or mesh. Callers mostly give them in the order of their numbers.
template <typename Motion>
void checkDifferent(const std::vector<Motion>& motions, size_t Motion::*number, const std::string& what) {
  const auto notAfter = [&](const Motion& a, const Motion& b) { return b.*number <= a.*number; };
  if (std::ranges::adjacent_find(motions, notAfter) == motions.end()) return;
  std::vector<size_t> numbers;
  for (const Motion& motion : motions) numbers.push_back(motion.*number);
  std::ranges::sort(numbers);
  const auto twice = std::ranges::adjacent_find(numbers);
  if (twice != numbers.end())
    throw Error(ErrorCode::invalidArgument, what + " " + std::to_string(*twice) + " has two motions");
}

}  // namespace

void KeptScene::checkMotions(const Shot& shot, const std::string& which) const {
  checkDifferent(shot.instanceMotions, &InstanceMotion::instance, which + "instance");
  checkDifferent(shot.meshMotions, &MeshMotion::mesh, which + "mesh");
  for (const InstanceMotion& motion : shot.instanceMotions) {
    instances_.check(motion.instance, which);
    validate(motion.end, motion.instance, which);
    if (inBuffer_[motion.instance]) refuseMotion(motion.instance, which);
  }
  for (const MeshMotion& motion : shot.meshMotions) {
    checkDeformation(motion.mesh, motion.end, which);
    for (size_t i = 0; i < inBuffer_.size(); ++i)
      if (inBuffer_[i] && scene_.instances[i].mesh == motion.mesh) refuseMotion(i, which);
  }
}

size_t KeptScene::addMaterial(Material material, const AlphaImage* image) {
  validate(material, "the new material");
  const size_t index = materials_.next();
  material.alphaImage = kNoImage;
  AlphaImage alpha;
  if (image) {
    validate(*image, "the alpha image of the new material");
    alpha = *image;
    material.alphaImage = unusedImages(1)[0];
  }
  materials_.reserve();
  scene_.materials.resize(std::max(index + 1, materials_.size()));
  const auto exchange = [&, number = material.alphaImage] {
    std::swap(scene_.materials[index], material);
    if (image) std::swap(scene_.alphaImages[number], alpha);
    planner_.forgetTextures();
  };
  changeMaterials(exchange);
  materials_.take();
  return index;
}

void KeptScene::setMaterial(size_t index, Material material, const AlphaImage* image) {
  materials_.check(index);
  const std::string name = "the new value of material " + std::to_string(index);
  validate(material, name);
  const Material& before = scene_.materials[index];
  const auto mustStay = [&](bool changes, const char* what) {
    if (changes && materials_.uses(index) > 0)
      throw Error(ErrorCode::invalidArgument, name + " has another " + what + ", and meshes use it; add a material");
  };
  mustStay(before.doubleSided != material.doubleSided, "side (doubleSided)");
  mustStay(before.classId != material.classId, "class");
  mustStay((before.alphaImage != kNoImage) != (image != nullptr), "kind of alpha: with an image, or without one");
  material.alphaImage = kNoImage;
  AlphaImage alpha;
  if (image) {
    validate(*image, "the alpha image of " + name);
    alpha = *image;
    material.alphaImage = ownsImage(index) ? before.alphaImage : unusedImages(1)[0];
  }
  const bool changesImage = image || ownsImage(index);
  const uint32_t number = image ? material.alphaImage : before.alphaImage;
  changeMaterials([&] {
    std::swap(scene_.materials[index], material);
    if (!changesImage) return;
    std::swap(scene_.alphaImages[number], alpha);
    planner_.forgetTextures();
  });
}

/// Whether a material has an image that no other material has.
bool KeptScene::ownsImage(size_t material) const {
  const uint32_t image = scene_.materials[material].alphaImage;
  const auto shares = [&](const Material& other) { return other.alphaImage == image; };
  return image != kNoImage && std::count_if(scene_.materials.begin(), scene_.materials.end(), shares) == 1;
}

/// The numbers of so many images that no material has.
std::vector<uint32_t> KeptScene::unusedImages(size_t count) {
  std::vector<uint32_t> numbers;
  for (uint32_t i = 0; numbers.size() < count; ++i) {
    if (i == scene_.alphaImages.size()) scene_.alphaImages.emplace_back();  // unused if what follows fails
    if (scene_.alphaImages[i].alpha.empty()) numbers.push_back(i);
  }
  return numbers;
}

void KeptScene::removeMaterial(size_t index) {
  materials_.checkUnused(index, "meshes");
  const uint32_t image = scene_.materials[index].alphaImage;
  const bool alone = ownsImage(index);
  Material none;
  AlphaImage noImage;
  changeMaterials([&] {
    std::swap(scene_.materials[index], none);
    if (alone) std::swap(scene_.alphaImages[image], noImage);
    planner_.forgetTextures();
  });
  materials_.giveBack(index);
}

size_t KeptScene::addMesh(const Mesh& mesh) {
  const size_t index = meshes_.next();
  const std::string name = "the new mesh" + (mesh.name.empty() ? "" : " '" + mesh.name + "'");
  validate(mesh, name, scene_.materials);
  for (const MeshPart& part : mesh.parts) materials_.check(part.material);
  KeptMesh kept = keptOf(mesh);
  backend_->setMesh(index, &mesh);
  keep(std::move(kept));
  return index;
}

void KeptScene::removeMesh(size_t index) {
  meshes_.checkUnused(index, "instances");
  backend_->setMesh(index, nullptr);
  for (const MeshPart& part : scene_.meshes[index].parts) --materials_.uses(part.material);
  scene_.meshes[index] = {};
  meshes_.giveBack(index);
}

void KeptScene::setPositions(size_t mesh, std::span<const float> positions) {
  meshes_.check(mesh);
  if (positions.size() != 3 * vertexCounts_[mesh])
    throw Error(ErrorCode::invalidArgument,
                "mesh " + std::to_string(mesh) + " has " + std::to_string(vertexCounts_[mesh]) +
                    " vertices of three numbers each; " + std::to_string(positions.size()) + " numbers were given");
  if (scene_.meshes[mesh].deformable())
    throw Error(ErrorCode::invalidArgument,
                "mesh " + std::to_string(mesh) + " follows joints or morph targets; its deformation moves it");
  backend_->setPositions(mesh, positions);
}

void KeptScene::setDeformation(size_t mesh, const Deformation& deformation) {
  checkDeformation(mesh, deformation, "");
  backend_->setDeformation(mesh, deformation);
}

void KeptScene::setVertices(size_t mesh, const CallerVertices& buffer) {
  meshes_.check(mesh);
  const std::string name = "mesh " + std::to_string(mesh);
  if (scene_.meshes[mesh].deformable())
    throw Error(ErrorCode::invalidArgument,
                name + " follows joints or morph targets; its vertices cannot come from a buffer");
  validate(buffer, vertexCounts_[mesh], name);
  backend_->setVertices(mesh, buffer);
}

void KeptScene::setTransforms(const CallerTransforms& buffer) {
  validate(buffer);
  for (size_t i = 0; i < buffer.instances; ++i) instances_.check(buffer.firstInstance + i);
  backend_->setTransforms(buffer);
  for (size_t i = 0; i < buffer.instances; ++i) inBuffer_[buffer.firstInstance + i] = 1;
}

size_t KeptScene::addInstance(uint32_t mesh, const Transform& transform, uint16_t classId, uint32_t world) {
  meshes_.check(mesh);
  const size_t index = instances_.next();
  validate(transform, index);
  limits::kTriangles.check(placedTriangles_ + trianglesOf(mesh), "the scene would place");
  reserveInstance();
  backend_->setInstance(index, mesh, transform, world);
  return keep(mesh, classId, world);
}

std::vector<uint32_t> KeptScene::addInstances(std::span<const Instance> instances) {
  std::vector<uint32_t> indices;
  indices.reserve(instances.size());
  for (size_t i = 0; i < instances.size(); ++i) {
    meshes_.check(instances[i].mesh, "entry " + std::to_string(i) + ": ");
    if (!allFinite(instances[i].transform.rows))
      throw Error(ErrorCode::invalidArgument, "entry " + std::to_string(i) + ": the transform is not finite");
  }
  try {
    for (const Instance& instance : instances)
      indices.push_back(
          static_cast<uint32_t>(addInstance(instance.mesh, instance.transform, instance.classId, instance.world)));
  } catch (...) {
    for (size_t i = indices.size(); i > 0; --i) removeInstance(indices[i - 1]);
    throw;
  }
  return indices;
}

AddedScene KeptScene::addScene(const Scene& scene, const Transform& transform) {
  validate(scene);
  AddedScene added;
  added.materials.reserve(scene.materials.size());
  added.meshes.reserve(scene.meshes.size());
  std::vector<Instance> instances = scene.instances;
  std::vector<Material> materials = scene.materials;
  // An image without a material is left out, because it would stay when the materials are removed.
  std::map<uint32_t, uint32_t> numbers;  // of the other images, by those that they have in `scene`
  for (const Material& material : materials)
    if (material.alphaImage != kNoImage) numbers[material.alphaImage] = kNoImage;
  const std::vector<uint32_t> unused = unusedImages(numbers.size());
  std::vector<AlphaImage> images;
  for (auto& [image, number] : numbers) {
    number = unused[images.size()];
    images.push_back(scene.alphaImages[image]);
  }
  for (Material& material : materials)
    if (material.alphaImage != kNoImage) material.alphaImage = numbers[material.alphaImage];
  const auto exchange = [&] {
    for (size_t i = 0; i < materials.size(); ++i) std::swap(scene_.materials[added.materials[i]], materials[i]);
    for (size_t i = 0; i < images.size(); ++i) std::swap(scene_.alphaImages[unused[i]], images[i]);
    planner_.forgetTextures();
  };
  const auto giveBack = [&] {
    std::for_each(added.materials.rbegin(), added.materials.rend(),
                  [&](uint32_t material) { materials_.giveBack(material); });
  };
  try {
    for (size_t i = 0; i < materials.size(); ++i) {
      added.materials.push_back(static_cast<uint32_t>(materials_.next()));
      materials_.take();
    }
    scene_.materials.resize(materials_.size());
    changeMaterials(exchange);
  } catch (...) {
    giveBack();
    throw;
  }
  try {
    for (Mesh mesh : scene.meshes) {
      for (MeshPart& part : mesh.parts) part.material = added.materials[part.material];
      added.meshes.push_back(static_cast<uint32_t>(addMesh(mesh)));
    }
    for (Instance& instance : instances) {
      instance.mesh = added.meshes[instance.mesh];
      instance.transform = transform * instance.transform;
    }
    added.instances = addInstances(instances);
  } catch (...) {
    try {
      std::for_each(added.meshes.rbegin(), added.meshes.rend(), [&](uint32_t mesh) { removeMesh(mesh); });
      changeMaterials(exchange);
      giveBack();
    } catch (...) {
      // Memory has run out again. Meshes and materials that nothing places stay, and change no scan.
    }
    throw;
  }
  return added;
}

void KeptScene::removeInstance(size_t index) {
  instances_.check(index);
  backend_->setInstance(index, kNoMesh, {});
  inBuffer_[index] = 0;
  uint32_t& mesh = scene_.instances[index].mesh;
  placedTriangles_ -= trianglesOf(mesh);
  stale_ |= --meshes_.uses(mesh) == 0;
  mesh = kNoMesh;
  instances_.giveBack(index);
}

void KeptScene::removeInstances(std::span<const uint32_t> instances) {
  std::vector<bool> named(instances_.size());
  for (size_t i = 0; i < instances.size(); ++i) {
    const std::string which = "entry " + std::to_string(i) + ": ";
    instances_.check(instances[i], which);
    if (named[instances[i]])
      throw Error(ErrorCode::invalidArgument, which + "instance " + std::to_string(instances[i]) +
                                                  " stands in an entry before it, too; name it once");
    named[instances[i]] = true;
  }
  // The pool hands out first the index that was given back last, so the next instances get these indices in order.
  std::for_each(instances.rbegin(), instances.rend(), [&](uint32_t instance) { removeInstance(instance); });
}

void KeptScene::setTransform(size_t instance, const Transform& transform) {
  instances_.check(instance);
  validate(transform, instance);
  const auto number = static_cast<uint32_t>(instance);
  move({&number, 1}, {&transform, 1});
}

void KeptScene::setTransforms(std::span<const uint32_t> instances, std::span<const double> values) {
  moveAll(instances, values);
}

void KeptScene::setTransforms(std::span<const uint32_t> instances, std::span<const float> values) {
  moveAll(instances, values);
}

template <typename T>
void KeptScene::moveAll(std::span<const uint32_t> instances, std::span<const T> values) {
  readTransforms(values, instances.size(), transforms_);
  const auto isRight = [&](size_t i) { return instances_.has(instances[i]) && allFinite(transforms_[i].rows); };
  std::atomic<bool> right = true;
  inRuns(instances.size(), kTransformsPerRun, threadCount(), [&](uint64_t first, uint64_t end) {
    for (uint64_t i = first; i < end; ++i)
      if (!isRight(i)) right = false;
  });
  for (size_t i = 0; !right; ++i) {
    if (isRight(i)) continue;
    const std::string which = "entry " + std::to_string(i) + ": ";
    instances_.check(instances[i], which);
    throw Error(ErrorCode::invalidArgument,
                which + "the transform of instance " + std::to_string(instances[i]) + " is not finite" +
                    (values.size() == 7 * instances.size() ? ", or its quaternion is zero" : ""));
  }
  move(instances, transforms_);
}

void KeptScene::checkDeformation(size_t mesh, const Deformation& deformation, const std::string& which) const {
  meshes_.check(mesh);
  const std::string name = which + "mesh " + std::to_string(mesh);
  const Mesh& kept = scene_.meshes[mesh];
  if (!kept.deformable()) throw Error(ErrorCode::invalidArgument, name + " has neither joints nor morph targets");
  validate(deformation, name, kept);
}

uint64_t KeptScene::trianglesOf(size_t mesh) const {
  uint64_t sum = 0;
  for (const MeshPart& part : scene_.meshes[mesh].parts) sum += part.triangleCount;
  return sum;
}

/// Changes the materials, and changes them back if the backend fails; `exchange` undoes itself.
template <typename Exchange>
void KeptScene::changeMaterials(const Exchange& exchange) {
  exchange();
  try {
    backend_->setMaterials(scene_.materials, scene_.alphaImages);
  } catch (...) {
    exchange();
    throw;
  }
  stale_ = true;
}

/// Makes room for the next mesh as well.
KeptScene::KeptMesh KeptScene::keptOf(const Mesh& mesh) {
  KeptMesh kept = {{}, mesh.vertexCount(), ClassTable::runsOf(mesh.parts, scene_.materials)};
  kept.mesh.parts = mesh.parts;
  kept.mesh.jointCount = mesh.jointCount;
  kept.mesh.morphTargets.resize(mesh.morphTargets.size());
  meshes_.reserve();
  const size_t count = std::max(meshes_.next() + 1, meshes_.size());
  makeRoom(scene_.meshes, count);
  makeRoom(vertexCounts_, count);
  classes_.reserveMesh(count);
  return kept;
}

void KeptScene::keep(KeptMesh kept) {
  const size_t index = meshes_.next();
  meshes_.take();
  scene_.meshes.resize(meshes_.size());
  vertexCounts_.resize(meshes_.size());
  scene_.meshes[index] = std::move(kept.mesh);
  vertexCounts_[index] = kept.vertexCount;
  for (const MeshPart& part : scene_.meshes[index].parts) ++materials_.uses(part.material);
  classes_.setMesh(index, std::move(kept.classes));
}

void KeptScene::move(std::span<const uint32_t> instances, std::span<const Transform> transforms) {
  backend_->moveInstances(instances, transforms);
  for (const uint32_t instance : instances) inBuffer_[instance] = 0;
}

/// Makes room for the next instance.
void KeptScene::reserveInstance() {
  instances_.reserve();
  const size_t count = std::max(instances_.next() + 1, instances_.size());
  makeRoom(scene_.instances, count);
  makeRoom(inBuffer_, count);
  classes_.reserveInstance(count);
}

size_t KeptScene::keep(uint32_t mesh, uint16_t classId, uint32_t world) {
  const size_t index = instances_.next();
  instances_.take();
  scene_.instances.resize(instances_.size());
  scene_.instances[index].mesh = mesh;
  scene_.instances[index].world = world;
  placedTriangles_ += trianglesOf(mesh);
  stale_ |= meshes_.uses(mesh)++ == 0;
  classes_.setInstance(index, mesh, classId);
  inBuffer_.resize(instances_.size());
  return index;
}

}  // namespace gnosphere
