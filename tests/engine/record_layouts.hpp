// SPDX-License-Identifier: Apache-2.0
// Layouts of records with many values, and a scene with classes.
#pragma once

#include <vector>

#include "effects/showroom.hpp"
#include "scan/fields.hpp"

namespace gnosphere::test {

/// A layout with values of every kind at odd places, in the manner of PointCloud2.
inline RecordLayout oddLayout(const std::vector<Field>& fields, bool compact) {
  RecordLayout layout;
  layout.compact = compact;
  layout.stride = 3;
  for (const Field field : fields) {
    const FieldInfo info = fieldInfo(field);
    for (uint32_t component = 0; component < info.components; ++component) {
      const bool wide = field == Field::time || field == Field::beam;
      const ValueType type = wide ? ValueType::f64 : info.type == ValueType::u8 ? ValueType::u16 : info.type;
      layout.values.push_back({field, component, layout.stride, type});
      layout.stride += wide ? 8 : type == ValueType::u16 ? 2 : 4;
    }
  }
  layout.stride += 2;
  return layout;
}

/// Fields that the words of the beams tell, so that no stage stores more for them.
inline const std::vector<Field> kPlainFields = {
    Field::x,    Field::y,        Field::z,       Field::range,   Field::ring,      Field::time,        Field::triangle,
    Field::beam, Field::instance, Field::classId, Field::azimuth, Field::elevation, Field::returnNumber};
/// Every field that a device can write.
inline const std::vector<Field> kAllFields = [] {
  std::vector<Field> fields;
  for (const ColumnInfo& column : allColumns())
    if (column.component == 0 && column.field != Field::tie && column.field != Field::tolerance)
      fields.push_back(column.field);
  return fields;
}();

/// The showroom, with a class for each instance, and walls whose triangles alternate between plaster that states
/// classes and plaster that states none.
inline Scene classifiedRoom() {
  Scene scene = showroom();
  scene.meshes[0].parts.clear();
  for (uint32_t triangle = 0; triangle < scene.meshes[0].triangleCount(); triangle += 6) {
    scene.meshes[0].parts.push_back(
        {triangle, 6, triangle % 18 == 0 ? 0 : static_cast<uint32_t>(scene.materials.size())});
    if (triangle % 18 == 0) continue;
    scene.materials.push_back(scene.materials[0]);
    scene.materials.back().classId = static_cast<uint16_t>(1000 + triangle);
  }
  for (size_t i = 0; i < scene.instances.size(); ++i) scene.instances[i].classId = static_cast<uint16_t>(300 + i);
  return scene;
}

}  // namespace gnosphere::test
