// SPDX-License-Identifier: Apache-2.0
#include "geometry/vertex_sources.hpp"

#include <cmath>

#include "gnosphere/error.hpp"

namespace gnosphere {
namespace {

using gpu::Array;

gpu::vec3 vec3Of(const std::array<float, 3>& v) {
  return {v[0], v[1], v[2]};
}

}  // namespace

void validate(const CallerVertices& buffer, size_t vertices, const std::string& name) {
  const auto refuse = [&](const std::string& what) { throw Error(ErrorCode::invalidArgument, name + ": " + what); };
  const bool floats = buffer.format == gpu::kVertexF32;
  const uint32_t size = floats ? 12 : 6, unit = floats ? 4 : 2;
  if (buffer.address == 0 || buffer.address % 4 != 0)
    refuse("the buffer of its vertices needs an address that is a multiple of 4 and not 0");
  if (buffer.stride < size || buffer.stride % unit != 0)
    refuse("its vertices are " + std::to_string(buffer.stride) + " bytes apart; positions of this format need " +
           std::to_string(size) + " or more, in multiples of " + std::to_string(unit));
  if (vertices == 0) return;
  // Kernels read the buffer in whole words.
  const uint64_t needed = ((vertices - 1) * uint64_t{buffer.stride} + size + 3) / 4 * 4;
  if (needed > buffer.bytes)
    refuse("it has " + std::to_string(vertices) + " vertices, " + std::to_string(buffer.stride) +
           " bytes apart; in words of 4 bytes they need " + std::to_string(needed) + " bytes, and the buffer has " +
           std::to_string(buffer.bytes));
  if (needed > UINT32_MAX) refuse("its vertices take more than 4 GiB");
  for (int axis = 0; axis < 3; ++axis) {
    if (!std::isfinite(buffer.scale[axis]) || !std::isfinite(buffer.offset[axis]))
      refuse("the scale or the offset of its vertices is not finite");
    if (floats && (buffer.scale[axis] != 1 || buffer.offset[axis] != 0))
      refuse("floats are positions as they are; only integers have a scale and an offset");
  }
}

void VertexSources::add(size_t mesh, const FlatMesh& flat, uint64_t group, uint64_t vertex) {
  TakenRuns runs;
  Entry entry;
  entry.vertices = flat.vertices.size();
  entry.firstGroup = static_cast<uint32_t>(group);
  entry.groups = flat.groupCount();
  entry.source.vertexFirst = static_cast<uint32_t>(vertex);
  entry.source.numberFirst = static_cast<uint32_t>(runs.take(numbers_, entry.vertices));
  memory_.reserve(Array::vertexNumbers, numbers_.end() * sizeof(uint32_t));
  memory_.write(Array::vertexNumbers, entry.source.numberFirst * sizeof(uint32_t),
                std::as_bytes(std::span(flat.vertices)));
  sources_[mesh] = entry;
  runs.keep();
}

void VertexSources::remove(size_t mesh) {
  const auto found = sources_.find(mesh);
  if (found == sources_.end()) return;
  numbers_.giveBack(found->second.source.numberFirst, found->second.vertices);
  sources_.erase(found);
}

void VertexSources::set(size_t mesh, const CallerVertices& buffer) {
  Entry& entry = sources_.at(mesh);
  entry.address = buffer.address;
  entry.source.stride = buffer.stride;
  entry.source.format = buffer.format;
  entry.source.scale = vec3Of(buffer.scale);
  entry.source.offset = vec3Of(buffer.offset);
  entry.changed = anyChanged_ = true;
}

void VertexSources::takeAgain() {
  for (auto& [mesh, entry] : sources_) entry.changed = anyChanged_ = true;
}

void VertexSources::takeAgain(size_t mesh) noexcept {
  const auto found = sources_.find(mesh);
  if (found != sources_.end()) found->second.changed = anyChanged_ = true;
}

const VertexSources::Work& VertexSources::changed() {
  work_.meshes.clear();
  work_.sources.clear();
  work_.buffers.clear();
  work_.groups.clear();
  if (!anyChanged_) return work_;
  for (auto& [mesh, entry] : sources_) {
    if (!entry.changed) continue;
    for (uint32_t group = entry.firstGroup; group < entry.firstGroup + entry.groups; ++group)
      work_.groups.push_back({static_cast<uint32_t>(work_.sources.size()), group});
    work_.meshes.push_back(mesh);
    work_.sources.push_back(entry.source);
    work_.buffers.push_back({entry.address});
  }
  return work_;
}

void VertexSources::taken() {
  for (const size_t mesh : work_.meshes) sources_.at(mesh).changed = false;
  anyChanged_ = false;
}

void VertexSources::setDropped(size_t mesh, const Dropped& dropped) {
  const auto found = sources_.find(mesh);
  if (found != sources_.end()) found->second.dropped = dropped;
}

VertexSources::Dropped VertexSources::dropped() const {
  Dropped sum;
  for (const auto& [mesh, entry] : sources_) {
    sum.nonFinite += entry.dropped.nonFinite;
    sum.degenerate += entry.dropped.degenerate;
  }
  return sum;
}

}  // namespace gnosphere
