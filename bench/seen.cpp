// SPDX-License-Identifier: Apache-2.0
#include "seen.hpp"

#include <algorithm>
#include <map>
#include <set>

#include "base/quaternion.hpp"
#include "console.hpp"
#include "contest.hpp"
#include "gnosphere/error.hpp"

namespace gnosphere::bench {
namespace {

bool same(const Pose& a, const Pose& b) {
  const Vec3 &p = a.position, &q = b.position;
  return p.x == q.x && p.y == q.y && p.z == q.z && isSame(a.orientation, b.orientation);
}

/// A mesh of some triangles of another, in ascending order, with their vertices alone.
Mesh reduced(const Mesh& mesh, const std::set<uint32_t>& triangles) {
  Mesh result;
  result.origin = mesh.origin;
  std::map<uint32_t, uint32_t> vertices;
  size_t part = 0;
  for (uint32_t triangle : triangles) {
    for (size_t corner = 0; corner < 3; ++corner) {
      const uint32_t old = mesh.indices[3 * size_t{triangle} + corner];
      const auto [vertex, added] = vertices.try_emplace(old, static_cast<uint32_t>(vertices.size()));
      if (added)
        result.positions.insert(result.positions.end(), &mesh.positions[3 * size_t{old}],
                                &mesh.positions[3 * size_t{old}] + 3);
      result.indices.push_back(vertex->second);
    }
    while (triangle >= mesh.parts[part].firstTriangle + mesh.parts[part].triangleCount) ++part;
    if (result.parts.empty() || result.parts.back().material != mesh.parts[part].material)
      result.parts.push_back({static_cast<uint32_t>(result.triangleCount() - 1), 0, mesh.parts[part].material});
    ++result.parts.back().triangleCount;
  }
  return result;
}

class Seen : public Contender {
 public:
  Seen(const Scene& scene, const SensorRequest& request, const SimulatorOptions& options,
       const std::vector<Pose>& poses)
      : poses_(poses) {
    const double start = cli::nowMs();
    Simulator whole(scene, request, options);
    for (const Pose& pose : poses) {
      const Scan scan = whole.scan(pose);
      contenders_.push_back(makeOurs(seenIn(scene, scan), request, options));
      contenders_.back()->run({{pose}, {}});
      if (const Agreement agreement = agreementOf(scan, contenders_.back()->answer()); agreement.differ() > 0)
        throw Error(ErrorCode::device, "of what is seen alone, " + cli::grouped(agreement.differ()) +
                                           " beams have another range than of the whole scene");
    }
    buildMs_ = cli::nowMs() - start;
  }

  std::string name() const override { return kSeen; }
  double build() override { return buildMs_; }
  Sample run(const Task& task) override {
    const auto pose =
        std::find_if(poses_.begin(), poses_.end(), [&](const Pose& other) { return same(task.shot.pose, other); });
    if (pose == poses_.end() || !task.moved.empty())
      throw Error(ErrorCode::invalidArgument, "what is seen is known only from given poses, where nothing moves");
    last_ = static_cast<size_t>(pose - poses_.begin());
    return contenders_[last_]->run(task);
  }
  const Scan& answer() const override { return contenders_[last_]->answer(); }
  uint64_t memoryBytes() const override { return contenders_[last_]->memoryBytes(); }

 private:
  std::vector<Pose> poses_;
  std::vector<std::unique_ptr<Contender>> contenders_;  ///< one per pose
  size_t last_ = 0;
  double buildMs_ = 0;
};

}  // namespace

Scene seenIn(const Scene& scene, const Scan& scan) {
  std::map<uint32_t, std::set<uint32_t>> seen;
  for (size_t entry = 0; entry < scan.ranges.size(); ++entry)
    if (scan.hit(entry)) seen[scan.instances[entry]].insert(scan.triangles[entry]);
  Scene result;
  result.materials = scene.materials;
  for (Material& material : result.materials) material.alphaImage = kNoImage;
  for (const auto& [instance, triangles] : seen) {
    result.instances.push_back(scene.instances[instance]);
    result.instances.back().mesh = static_cast<uint32_t>(result.meshes.size());
    result.meshes.push_back(reduced(scene.meshes[scene.instances[instance].mesh], triangles));
  }
  return result;
}

std::unique_ptr<Contender> makeSeen(const Scene& scene, const SensorRequest& request, const SimulatorOptions& options,
                                    const std::vector<Pose>& poses) {
  return std::make_unique<Seen>(scene, request, options, poses);
}

}  // namespace gnosphere::bench
