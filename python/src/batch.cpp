// SPDX-License-Identifier: Apache-2.0
// Binds the declarations of gnosphere/batch.hpp.
#include "batch.hpp"

#include "arrays.hpp"
#include "fields.hpp"

namespace gnosphere::python {
namespace {

/// An array of shape (views, beams[, returns][, components]) whose memory is that of the batch. The array is not
/// read-only, because DLPack knows no such arrays.
template <typename T>
nb::object arrayOf(const SharedBatch& self, const T* data, size_t components) {
  const Batch& batch = *self.value;
  std::vector<size_t> shape = {batch.views, batch.beams};
  if (batch.returns > 1) shape.push_back(batch.returns);
  if (components > 1) shape.push_back(components);
  return nb::cast(nb::ndarray<nb::numpy, T>(const_cast<T*>(data), shape.size(), shape.data(), keeperOf(self)));
}

bool batchHasField(const SharedBatch& self, Field field) {
  return self.value->has(field);
}

/// Throws Error(invalidArgument) with the way to a batch that has the field.
void requireField(const SharedBatch& self, Field field) {
  if (batchHasField(self, field)) return;
  const std::string name = nb::cast<std::string>(nb::cast(field).attr("name"));
  refuse("the batch does not have the field '" + name + "'; scan_batch(..., fields=[Field." + name +
         "]) asks for it, if the sensor reports it");
}

template <typename T>
nb::object columnOf(const SharedBatch& self, Field field, size_t components) {
  return arrayOf(self, self.value->column<T>(field).data(), components);
}

nb::object columnOfBatch(const SharedBatch& self, Field field) {
  requireField(self, field);
  const FieldInfo info = fieldInfo(field);
  if (field == Field::x || field == Field::y || field == Field::z) {
    const size_t axis = static_cast<size_t>(field) - static_cast<size_t>(Field::x);
    return columnOf<float>(self, Field::x, 3).attr("__getitem__")(nb::make_tuple(nb::ellipsis(), axis));
  }
  return arrayOfType(info.type, [&]<typename T>() { return columnOf<T>(self, field, info.components); });
}

}  // namespace

void bindBatch(nb::module_& m) {
  nb::class_<SharedBatch> batch(
      m, "Batch", nb::is_weak_referenceable(),
      "The results of many shots of one sensor. A shot of a batch is a view. Arrays have the shape (views, beams), or "
      "(views, beams, returns) if a beam may have several, and vectors have their components as a last dimension. An "
      "entry has the bytes that it has in the Scan of the shot. A batch always has ranges; it has the other fields if "
      "it was asked for them.\n\nThe arrays are NumPy arrays of the library's memory, which each keeps alive; "
      "torch.from_dlpack() and its like take them without a copy. While one is held, scan_batch_into() takes new "
      "memory, so the values of an array change only if you write to them.");
  batch.def(nb::init<>(), "An empty batch, for Simulator.scan_batch_into(); of the fields it has ranges alone.");
  readMember(batch, "sensor", &Batch::sensor, "The sensor's name.");
  readMember(batch, "columns", &Batch::columns, "Columns of the organised cloud of a view.");
  readMember(batch, "channels", &Batch::channels, "Rows of the organised cloud of a view.");
  readMember(batch, "returns", &Batch::returns, "Entries per beam.");
  readMember(batch, "views", &Batch::views, "The number of shots.");
  readMember(batch, "beams", &Batch::beams, "Beams of each view.");
  readMember(batch, "counters", &Batch::counters, "Sums over the views.");
  readMember(batch, "timings", &Batch::timings, "The times of all views together.");
  const auto array = [&](const char* name, const char* signature, Field field, size_t components, const char* doc) {
    batch.def_prop_ro(
        name,
        [field, components](const SharedBatch& self) {
          requireField(self, field);
          return components == 3 ? columnOf<float>(self, field, 3) : columnOfBatch(self, field);
        },
        nb::for_getter(nb::sig(signature)), doc);
  };
  array("ranges", "def ranges(self, /) -> numpy.typing.NDArray[numpy.float32]", Field::range, 1,
        "float32: metres along the beam; NaN in an entry without a return.");
  array("points", "def points(self, /) -> numpy.typing.NDArray[numpy.float32]", Field::x, 3,
        "float32, three components: x, y, z in metres in the frame of each view's sensor.");
  array("triangles", "def triangles(self, /) -> numpy.typing.NDArray[numpy.uint32]", Field::triangle, 1,
        "uint32: index within the instance's mesh.");
  array("instances", "def instances(self, /) -> numpy.typing.NDArray[numpy.uint32]", Field::instance, 1,
        "uint32: index of the instance.");
  batch
      .def(
          "column", [](const SharedBatch& self, const FieldLike& given) { return columnOfBatch(self, given.field); },
          "field"_a, nb::sig("def column(self, field: Field | str) -> numpy.typing.NDArray[typing.Any]"),
          "Returns the values of a field in the type of field_info(), in an array that can be written. Raises "
          "Error(invalid_argument) if the batch does "
          "not have the field.")
      .def(
          "has", [](const SharedBatch& self, const FieldLike& given) { return batchHasField(self, given.field); },
          "field"_a, "Whether column() has the field.");
  bindNames<&batchHasField, &columnOfBatch>(batch, "the batch", "`fields` of scan_batch() asks for more");
}

}  // namespace gnosphere::python
