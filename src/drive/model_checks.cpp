// SPDX-License-Identifier: Apache-2.0
// Models of a drive file that are valid and probably not meant so: of another unit, distorted, or inside out.
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "base/transform.hpp"
#include "base/vector.hpp"
#include "drive/drive_reader.hpp"
#include "drive/world.hpp"

namespace gnosphere::drive {
namespace {

/// How much of a model shows its front to the outside, by the volumes between its triangles and its middle: 1 of a
/// convex body, -1 of one that is inside out, near 0 of a flat one. Double-sided surfaces count as neither.
double outwardShare(const Scene& model) {
  const Bounds bounds = worldBounds(model);
  const Vec3 middle = 0.5 * (bounds.min + bounds.max);
  double outward = 0, all = 0;
  for (const Instance& instance : model.instances) {
    const Mesh& mesh = model.meshes[instance.mesh];
    const std::vector<float> shape = deformedPositions(mesh, mesh.deformation);
    const double front = determinant(instance.transform) < 0 ? -1 : 1;  // glTF turns the triangles of mirrored meshes
    const auto corner = [&](size_t index) {
      const float* p = &shape[3 * size_t{mesh.indices[index]}];
      return instance.transform * Vec3{mesh.origin.x + p[0], mesh.origin.y + p[1], mesh.origin.z + p[2]} - middle;
    };
    for (const MeshPart& part : mesh.parts)
      for (size_t i = 3 * size_t{part.firstTriangle}; i < 3 * size_t{part.firstTriangle + part.triangleCount}; i += 3) {
        const Vec3 a = corner(i), b = corner(i + 1), c = corner(i + 2);
        const double volume = dot(a, cross(b, c));
        if (!std::isfinite(volume)) continue;
        all += std::abs(volume);
        if (!model.materials[part.material].doubleSided) outward += front * volume;
      }
  }
  return all > 0 ? outward / all : 0;
}

}  // namespace

std::string roundedText(double value, double digits) {
  const double perUnit = std::pow(10, digits - 1 - std::floor(std::log10(value)));
  if (!std::isnormal(perUnit)) return gnosphere::numberText(value);
  return gnosphere::numberText(std::round(value * perUnit) / perUnit);
}

/// Warns of models that are larger or smaller than anything in traffic, and that actors show in their own size.
void DriveReader::warnOfModelSizes() {
  constexpr double kLong = 100, kShort = 0.02;  // m
  for (size_t m = 0; m < drive_.modelNames.size(); ++m) {
    const auto showsIt = [&](const Actor& actor) { return actor.model == m && !actor.size; };
    if (std::ranges::none_of(drive_.actors, showsIt)) continue;
    const Bounds bounds = worldBounds(drive_.models[m]);
    const Vec3 extent = bounds.max - bounds.min;
    const double longest = bounds.empty() ? kShort : std::max({extent.x, extent.y, extent.z});
    if (longest > kLong || (longest > 0 && longest < kShort))
      warn(memberPath("models", drive_.modelNames[m]) + ".file",
           "measures " + roundedText(longest, 3) +
               " m; files are in metres, and \"scale\" changes that: 0.01 for centimetres, 0.001 for millimetres");
  }
}

const Vec3& DriveReader::extentOf(const Actor& actor) {
  const auto clip = actor.animation ? std::optional(actor.animation->clip) : std::nullopt;
  const auto [extent, isNew] = extents_.try_emplace({actor.model, clip});
  if (isNew) extent->second = fittedExtent(drive_.models[actor.model], actor.animation);
  return extent->second;
}

/// Finds the factors that scale models to the sizes of actors. A flat model has none.
void DriveReader::findScales() {
  for (size_t a = 0; a < drive_.actors.size(); ++a) {
    Actor& actor = drive_.actors[a];
    if (!actor.size) continue;
    const Vec3& extent = extentOf(actor);
    actor.scale = {actor.size->x / extent.x, actor.size->y / extent.y, actor.size->z / extent.z};
    if (!(extent.x > 0 && extent.y > 0 && extent.z > 0))
      refuse(entryPath("actors", a) + ".size",
             "the model of " + inQuotes(actor.name) + " is flat, so it cannot be scaled to a size; give it none");
  }
}

/// Warns of actors whose size has other proportions than their model. A model that is a box may stand for any other
/// box.
void DriveReader::warnOfScales() {
  constexpr double kMost = 1.5;  // between the greatest and the least factor
  std::map<size_t, bool> boxes;  // by model
  size_t found = 0, count = 0;
  double most = kMost;
  for (size_t a = 0; a < drive_.actors.size(); ++a) {
    const Actor& actor = drive_.actors[a];
    if (!actor.size) continue;
    const auto [box, isNew] = boxes.try_emplace(actor.model);
    if (isNew) box->second = isBox(drive_.models[actor.model]);
    if (box->second) continue;
    const auto [low, high] = std::minmax({actor.scale.x, actor.scale.y, actor.scale.z});
    if (!(high / low > kMost)) continue;
    ++count;
    if (!(high / low > most)) continue;
    found = a;
    most = high / low;
  }
  if (count == 0) return;
  const Actor& actor = drive_.actors[found];
  const Vec3& extent = extentOf(actor);
  const auto text = [](double x, double y, double z) {
    return roundedText(x, 3) + ", " + roundedText(y, 3) + " and " + roundedText(z, 3);
  };
  warn(entryPath("actors", found) + ".size",
       "scales the model of " + inQuotes(actor.name) + " by " + text(actor.scale.x, actor.scale.y, actor.scale.z) +
           " along x, y and z, which distorts it; the model measures " + text(extent.x, extent.y, extent.z) +
           " m: give a size of its proportions, or turn it by its \"pose\"" +
           (count > 1 ? " (of " + std::to_string(count) + " actors that are distorted this is the most)" : ""));
}

/// Warns of models whose surfaces have their fronts inside, so that beams from outside pass through them.
void DriveReader::warnOfInsideOut() {
  constexpr double kMost = -0.25;  // the car and the person of the town have 0.59 and 0.50
  if (memberOf(memberOf(root_, "simulator"), "faces") == "both") return;
  for (size_t m = 0; m < drive_.modelNames.size(); ++m)
    if (outwardShare(drive_.models[m]) < kMost)
      warn(memberPath("models", drive_.modelNames[m]) + ".file",
           "has the fronts of its surfaces inside, and beams pass through backs, so it is invisible from outside; turn "
           "its triangles round, or make its materials double-sided");
}

}  // namespace gnosphere::drive
