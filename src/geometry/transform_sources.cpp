// SPDX-License-Identifier: Apache-2.0
#include "geometry/transform_sources.hpp"

#include <algorithm>
#include <string>

#include "base/room.hpp"
#include "base/vector.hpp"
#include "gnosphere/error.hpp"

namespace gnosphere {

void validate(const CallerTransforms& buffer) {
  const auto refuse = [](const std::string& what) {
    throw Error(ErrorCode::invalidArgument, "the buffer of transforms " + what);
  };
  const uint32_t size = buffer.byColumns ? 64 : 48;
  if (buffer.address == 0 || buffer.address % 4 != 0) refuse("needs an address that is a multiple of 4 and not 0");
  if (buffer.stride < size || buffer.stride % 4 != 0)
    refuse("has one every " + std::to_string(buffer.stride) + " bytes; they take " + std::to_string(size) +
           " or more, in multiples of 4");
  if (buffer.instances == 0) refuse("is for no instances; say how many");
  const uint64_t needed = (buffer.instances - 1) * uint64_t{buffer.stride} + size;
  if (needed > buffer.bytes)
    refuse("has " + std::to_string(buffer.bytes) + " bytes; " + std::to_string(buffer.instances) + " transforms, " +
           std::to_string(buffer.stride) + " bytes apart, need " + std::to_string(needed));
  if (needed > UINT32_MAX) refuse("takes more than 4 GiB");
  if (!isFinite(buffer.origin)) refuse("has an origin that is not finite");
}

void TransformSources::set(const CallerTransforms& buffer) {
  const size_t end = buffer.firstInstance + buffer.instances;
  makeRoom(entries_, end);
  makeRoom(users_, users_.size() + 1);
  makeRoom(buffers_, buffers_.size() + 1);
  for (size_t i = buffer.firstInstance; i < end; ++i) remove(i);
  if (entries_.size() < end) entries_.resize(end);
  const auto unused = static_cast<size_t>(std::find(users_.begin(), users_.end(), 0) - users_.begin());
  if (unused == users_.size()) {
    users_.emplace_back();
    buffers_.emplace_back();
  }
  buffers_[unused] = buffer;
  users_[unused] = buffer.instances;
  count_ += buffer.instances;
  for (size_t i = 0; i < buffer.instances; ++i)
    entries_[buffer.firstInstance + i] = {static_cast<uint32_t>(unused), static_cast<uint32_t>(i)};
}

void TransformSources::remove(size_t instance) {
  if (!has(instance)) return;
  --users_[entries_[instance].source];
  --count_;
  entries_[instance] = {};
}

}  // namespace gnosphere
