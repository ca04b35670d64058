// SPDX-License-Identifier: Apache-2.0
#include <draco/compression/decode.h>

#include "scene/gltf_accessor.hpp"

namespace gnosphere {

DracoMesh decodeDraco(Bytes bytes, int positionId, const std::string& user, const Source& source) {
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  draco::Decoder decoder;
  auto result = decoder.DecodeMeshFromBuffer(&buffer);
  if (!result.ok()) source.fail(user + ": its Draco data is not sound (" + result.status().error_msg_string() + ")");
  const std::unique_ptr<draco::Mesh> mesh = std::move(result).value();
  const draco::PointAttribute* attribute = mesh->GetAttributeByUniqueId(static_cast<uint32_t>(positionId));
  if (attribute == nullptr || attribute->num_components() != 3)
    source.fail(user + ": its Draco data has no positions under attribute " + std::to_string(positionId));

  DracoMesh decoded;
  decoded.positions.resize(size_t{mesh->num_points()} * 3);
  for (uint32_t point = 0; point < mesh->num_points(); ++point) {
    const draco::AttributeValueIndex value = attribute->mapped_index(draco::PointIndex(point));
    if (value.value() >= attribute->size() ||
        !attribute->ConvertValue<float, 3>(value, &decoded.positions[size_t{point} * 3]))
      source.fail(user + ": its Draco data has no position for vertex " + std::to_string(point));
  }
  decoded.indices.reserve(size_t{mesh->num_faces()} * 3);
  for (uint32_t face = 0; face < mesh->num_faces(); ++face)
    for (const draco::PointIndex& point : mesh->face(draco::FaceIndex(face))) decoded.indices.push_back(point.value());
  return decoded;
}

}  // namespace gnosphere
