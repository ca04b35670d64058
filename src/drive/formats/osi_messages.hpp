// SPDX-License-Identifier: Apache-2.0
// Parts of messages of ASAM OSI 3.7.0.
#pragma once

#include <protozero/pbf_builder.hpp>

#include "base/nanoseconds.hpp"
#include "drive/pose_math.hpp"

namespace gnosphere::drive::osi {

using Tag = protozero::pbf_tag_type;
template <typename Message>
using Builder = protozero::pbf_builder<Message>;

// The numbers of the fields that are written, by message.
// osi_version.proto
enum class InterfaceVersion : Tag { versionMajor = 1, versionMinor = 2, versionPatch = 3 };
// osi_common.proto
enum class Timestamp : Tag { seconds = 1, nanos = 2 };
enum class Identifier : Tag { value = 1 };
enum class Vector3d : Tag { x = 1, y = 2, z = 3 };
enum class Orientation3d : Tag { roll = 1, pitch = 2, yaw = 3 };

template <typename Message>
void addVersion(Builder<Message>& parent, Message field) {
  Builder<InterfaceVersion> version(parent, field);
  version.add_uint32(InterfaceVersion::versionMajor, 3);
  version.add_uint32(InterfaceVersion::versionMinor, 7);
  version.add_uint32(InterfaceVersion::versionPatch, 0);
}

template <typename Message>
void addTime(Builder<Message>& parent, Message field, int64_t nanoseconds) {
  const auto [seconds, rest] = splitNanoseconds(nanoseconds);
  Builder<Timestamp> time(parent, field);
  time.add_int64(Timestamp::seconds, seconds);
  time.add_uint32(Timestamp::nanos, rest);
}

template <typename Message>
void addIdentifier(Builder<Message>& parent, Message field, uint64_t value) {
  Builder<Identifier>(parent, field).add_uint64(Identifier::value, value);
}

template <typename Message>
void addVector(Builder<Message>& parent, Message field, const Vec3& value) {
  Builder<Vector3d> vector(parent, field);
  vector.add_double(Vector3d::x, value.x);
  vector.add_double(Vector3d::y, value.y);
  vector.add_double(Vector3d::z, value.z);
}

template <typename Message>
void addOrientation(Builder<Message>& parent, Message field, const Quaternion& value) {
  const auto [yaw, pitch, roll] = yawPitchRollOf(value);
  Builder<Orientation3d> orientation(parent, field);
  orientation.add_double(Orientation3d::roll, roll);
  orientation.add_double(Orientation3d::pitch, pitch);
  orientation.add_double(Orientation3d::yaw, yaw);
}

}  // namespace gnosphere::drive::osi
