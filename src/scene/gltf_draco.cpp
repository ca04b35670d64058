// SPDX-License-Identifier: Apache-2.0
#include <draco/compression/decode.h>

#include "scene/gltf_accessor.hpp"

namespace gnosphere {
namespace {

/// Returns an attribute as `components` floats per vertex.
template <int components>
std::vector<float> values(const draco::Mesh& mesh, int id, const char* what, const std::string& user,
                          const Source& source) {
  const draco::PointAttribute* attribute = mesh.GetAttributeByUniqueId(static_cast<uint32_t>(id));
  if (attribute == nullptr || attribute->num_components() != components)
    source.fail(user + ": its Draco data has no " + what + "s under attribute " + std::to_string(id));
  std::vector<float> values(size_t{mesh.num_points()} * components);
  for (uint32_t point = 0; point < mesh.num_points(); ++point) {
    const draco::AttributeValueIndex value = attribute->mapped_index(draco::PointIndex(point));
    if (value.value() >= attribute->size() ||
        !attribute->ConvertValue<float, components>(value, &values[size_t{point} * components]))
      source.fail(user + ": its Draco data has no " + what + " for vertex " + std::to_string(point));
  }
  return values;
}

}  // namespace

DracoMesh decodeDraco(Bytes bytes, const DracoIds& ids, const std::string& user, const Source& source) {
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  draco::Decoder decoder;
  auto result = decoder.DecodeMeshFromBuffer(&buffer);
  if (!result.ok()) source.fail(user + ": its Draco data is invalid (" + result.status().error_msg_string() + ")");
  const std::unique_ptr<draco::Mesh> mesh = std::move(result).value();

  DracoMesh decoded;
  decoded.positions = values<3>(*mesh, ids.positions, "position", user, source);
  if (ids.uvs >= 0) decoded.uvs = values<2>(*mesh, ids.uvs, "texture coordinate", user, source);
  for (int id : ids.joints) decoded.joints.push_back(values<4>(*mesh, id, "joint", user, source));
  for (int id : ids.weights) decoded.weights.push_back(values<4>(*mesh, id, "weight", user, source));
  decoded.indices.reserve(size_t{mesh->num_faces()} * 3);
  for (uint32_t face = 0; face < mesh->num_faces(); ++face)
    for (const draco::PointIndex& point : mesh->face(draco::FaceIndex(face))) decoded.indices.push_back(point.value());
  return decoded;
}

}  // namespace gnosphere
