// SPDX-License-Identifier: Apache-2.0
#include "scan/class_table.hpp"

#include <algorithm>
#include <utility>

namespace gnosphere {

ClassTable::Runs ClassTable::runsOf(const std::vector<MeshPart>& parts, const std::vector<Material>& materials) {
  Runs runs;
  bool stated = false;
  for (const MeshPart& part : parts) {
    const uint32_t classId = materials[part.material].classId;
    if (part.triangleCount == 0 || (!runs.empty() && runs.back().classId == classId)) continue;
    runs.push_back({part.firstTriangle, classId});
    stated |= classId != 0;
  }
  if (!stated) runs.clear();
  return runs;
}

void ClassTable::setMesh(size_t mesh, Runs runs) {
  if (meshes_.size() <= mesh) meshes_.resize(mesh + 1);
  meshes_[mesh] = std::move(runs);
}

void ClassTable::setInstance(size_t instance, uint32_t mesh, uint16_t classId) {
  if (instances_.size() <= instance) instances_.resize(instance + 1);
  instances_[instance] = {mesh, classId};
}

uint16_t ClassTable::classOf(uint32_t instance, uint32_t triangle) const {
  if (instance >= instances_.size()) return 0;
  const Placed& placed = instances_[instance];
  const std::vector<gpu::ClassRun>& runs = meshes_[placed.mesh];
  if (runs.empty()) return placed.classId;
  const auto next = std::ranges::upper_bound(runs.begin() + 1, runs.end(), triangle, {}, &gpu::ClassRun::firstTriangle);
  const uint32_t stated = (next - 1)->classId;
  return stated != 0 ? static_cast<uint16_t>(stated) : placed.classId;
}

ClassTable::Packed ClassTable::packed() const {
  Packed packed;
  std::vector<uint32_t> firstRuns;
  firstRuns.reserve(meshes_.size());
  for (const std::vector<gpu::ClassRun>& runs : meshes_) {
    firstRuns.push_back(static_cast<uint32_t>(packed.runs.size()));
    packed.runs.insert(packed.runs.end(), runs.begin(), runs.end());
  }
  packed.instances.reserve(instances_.size());
  for (const auto& [mesh, classId] : instances_)
    packed.instances.push_back({classId, firstRuns[mesh], static_cast<uint32_t>(meshes_[mesh].size())});
  return packed;
}

}  // namespace gnosphere
