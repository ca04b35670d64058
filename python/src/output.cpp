// SPDX-License-Identifier: Apache-2.0
// Binds the declarations of gnosphere/output.hpp and gnosphere/layout.hpp.
#include <string_view>

#include "field_list.hpp"
#include "output/cloud_format.hpp"
#include "scan.hpp"
#include "scan/fields.hpp"
#include "state.hpp"

namespace gnosphere::python {
namespace {

/// Whether the format of a buffer, in the syntax of PEP 3118, has references to Python objects. Names of fields stand
/// between colons.
bool hasObjects(std::string_view format) {
  bool name = false;
  for (const char c : format) {
    if (c == ':') name = !name;
    if (c == 'O' && !name) return true;
  }
  return false;
}

/// The bytes of a Python object that can be written.
class WritableBytes {
 public:
  explicit WritableBytes(nb::handle object) {
    const bool given =
        PyObject_GetBuffer(object.ptr(), &buffer_, PyBUF_WRITABLE | PyBUF_C_CONTIGUOUS | PyBUF_FORMAT) == 0;
    if (given && !(buffer_.format && hasObjects(buffer_.format))) return;
    if (given)
      PyBuffer_Release(&buffer_);
    else
      forgetFault();
    refuse(
        "pack: `out` must be a contiguous array of numbers that can be written, such as numpy.empty(bytes, "
        "numpy.uint8)");
  }
  ~WritableBytes() { PyBuffer_Release(&buffer_); }
  WritableBytes(const WritableBytes&) = delete;
  WritableBytes& operator=(const WritableBytes&) = delete;
  std::span<std::byte> bytes() const {
    return {static_cast<std::byte*>(buffer_.buf), static_cast<size_t>(buffer_.len)};
  }

 private:
  Py_buffer buffer_ = {};
};

void bindLayout(nb::module_& m) {
  auto layout = nb::class_<RecordLayout>(
      m, "RecordLayout", "Describes how a row lies in memory: which values it has, and where each of them is.");
  nb::class_<RecordLayout::Value>(layout, "Value", "A value of a row. It is never changed after it is made.")
      .def(
          "__init__",
          [](RecordLayout::Value* self, Field field, uint32_t component, size_t offset, ValueType type, size_t stride) {
            new (self) RecordLayout::Value{field, component, offset, type, stride};
          },
          "field"_a.noconvert(), "component"_a = 0, "offset"_a = 0, nb::arg("type").noconvert() = ValueType::f32,
          "stride"_a = 0)
      .def_ro("field", &RecordLayout::Value::field, "What the value is.")
      .def_ro("component", &RecordLayout::Value::component, "Which component of a vector, from 0 on.")
      .def_ro("offset", &RecordLayout::Value::offset, "Bytes from the start of the row; no alignment is needed.")
      .def_ro(
          "type", &RecordLayout::Value::type,
          "The field's own type, or a type that holds all of its values: f64 holds every type, f32 holds u8 and u16, "
          "and an unsigned integer holds shorter unsigned integers.")
      .def_ro("stride", &RecordLayout::Value::stride,
              "0 if the value is part of the row. Otherwise the values of all rows form a column that begins at byte "
              "`offset` of the records, with a value every `stride` bytes; if these are more than the value's own, one "
              "of 1 "
              "or 2 bytes takes 4, in which 0 follows. Only results that stay on a device have columns.");
  layout
      .def(
          "__init__",
          [](RecordLayout* self, std::vector<RecordLayout::Value> values, size_t stride, bool compact) {
            new (self) RecordLayout{std::move(values), stride, compact};
          },
          "values"_a = nb::make_tuple(), "stride"_a = 0, "compact"_a = false)
      .def_rw("stride", &RecordLayout::stride, "Bytes from row to row; 0 if all values are in columns.")
      .def_rw("compact", &RecordLayout::compact,
              "If true, only entries with a return become rows; otherwise every entry of the scan does.")
      .def("empty", &RecordLayout::empty, "Whether it holds no value.")
      .def("bytes_for", &RecordLayout::bytesFor, "rows"_a, "Bytes of that many rows on a device: a multiple of 4.");
  readWriteTuple(layout, "values", &RecordLayout::values, "A tuple of copies, assigned whole.");
  m.def(
      "_column_names",
      [](const FieldList& list) {
        std::vector<std::string> names;
        for (const ColumnInfo& column : columnsOf(list.fields)) names.emplace_back(column.name);
        return tupleOf(names);
      },
      "fields"_a, "Returns the names of the columns that a cloud file with these fields has.");
  m.def(
      "layout_of", [](const FieldList& list) { return layoutOf(list.fields); }, "fields"_a,
      "Returns a layout with the fields one after the other without gaps, each component in the field's own type.");
  m.def(
      "pack",
      [](const SharedScan& scan, const RecordLayout& of, const nb::object& out) {
        const std::shared_ptr<Scan> shared = scan.value;
        const RecordLayout chosen = of;
        const WritableBytes memory(out);
        const ReleasedGil released;
        return pack(*shared, chosen, memory.bytes());
      },
      "scan"_a, "layout"_a, "out"_a, nb::sig("def pack(scan: Scan, layout: RecordLayout, out: typing.Any) -> int"),
      "Writes the rows of the scan to the start of `out` and returns their number. `out` is a C-contiguous array that "
      "can be written, of numbers of any type or of records of them; len(scan.ranges) * layout.stride bytes always "
      "suffice. Raises "
      "Error(invalid_argument), before anything is written, for a field that the scan does not have, a type that does "
      "not hold the field, values that overlap or reach beyond the stride, and an array that is too small (the message "
      "states the bytes needed).");
}

void bindComparison(nb::module_& m) {
  nb::class_<Comparison> comparison(
      m, "Comparison",
      "The differences between two clouds of the same beams, counted per beam, or per return if beams "
      "have several. Returns that the reference marks as ties are counted separately.");
  bindState<&Comparison::beams, &Comparison::hits, &Comparison::missed, &Comparison::falseHits, &Comparison::wrongOwner,
            &Comparison::wrongRange, &Comparison::ties, &Comparison::tieDifferences, &Comparison::tieMissed,
            &Comparison::tieFalseHits, &Comparison::tieWrongOwner, &Comparison::tieErrorMax, &Comparison::rangeErrorMax,
            &Comparison::rangeError9999, &Comparison::rangeErrorRms, &Comparison::hitErrorMax, &Comparison::wrongPoint,
            &Comparison::pointErrorMax>(comparison);
  comparison.def_ro("beams", &Comparison::beams, "Beams compared, or returns if beams have several.")
      .def_ro("hits", &Comparison::hits, "Returns of the reference.")
      .def_ro("missed", &Comparison::missed, "Returns of the reference that the other does not have, without ties.")
      .def_ro("false_hits", &Comparison::falseHits,
              "Returns of the other that the reference does not have, without ties.")
      .def_ro("wrong_owner", &Comparison::wrongOwner, "Both hit, but different triangles, without ties.")
      .def_ro("wrong_range", &Comparison::wrongRange,
              "Both hit, but the ranges differ by more than the tolerance, without ties.")
      .def_ro("ties", &Comparison::ties,
              "Returns of either cloud, or beams without any, that the reference marks as ties.")
      .def_ro("tie_differences", &Comparison::tieDifferences, "Ties in which the two differ in owner or hit.")
      .def_ro("tie_missed", &Comparison::tieMissed, "Ties in which the reference hits and the other does not.")
      .def_ro("tie_false_hits", &Comparison::tieFalseHits, "Ties in which the other hits and the reference does not.")
      .def_ro("tie_wrong_owner", &Comparison::tieWrongOwner, "Ties that both hit, but different triangles.")
      .def_ro("tie_error_max", &Comparison::tieErrorMax, "Metres, over ties that both hit, whatever the owner.")
      .def_ro("range_error_max", &Comparison::rangeErrorMax, "Metres, over beams with the same owner, without ties.")
      .def_ro("range_error9999", &Comparison::rangeError9999, "99.99th percentile of |error|, in metres.")
      .def_ro("range_error_rms", &Comparison::rangeErrorRms, "Root mean square, in metres.")
      .def_ro("hit_error_max", &Comparison::hitErrorMax,
              "Metres, over beams that both hit, whatever the owner, without ties.")
      .def_ro("wrong_point", &Comparison::wrongPoint,
              "Both hit, but their points are further apart than the tolerance, without ties.")
      .def_ro("point_error_max", &Comparison::pointErrorMax,
              "Metres between points, over beams that both hit, whatever the owner, without ties.")
      .def("same", &Comparison::same, "Whether nothing is missed, false or wrong.");
  m.def(
      "compare",
      [](const SharedScan& reference, const SharedScan& other, double tolerance) {
        const std::shared_ptr<Scan> truth = reference.value, compared = other.value;
        const ReleasedGil released;
        return compare(*truth, *compared, tolerance);
      },
      "reference"_a, "other"_a, "tolerance"_a = 1e-3,
      "Compares two clouds; `reference` is taken as the truth. `tolerance`, in metres, applies to beams for which the "
      "reference states no tolerance of its own. If both clouds have points, these may be apart by the tolerance and "
      "the rounding of coordinates: a millionth of the range, or 2^-22 of the distance from the frame's origin if that "
      "is more. Raises Error(invalid_argument) if the clouds do not have the same beams, or for a tolerance that is "
      "not "
      "a number from 0 on.");
}

}  // namespace

void bindOutput(nb::module_& m) {
  m.def(
      "parse_fields", [](const FieldList& list) { return tupleOf(list.fields); }, "fields"_a,
      "The fields of a text such as 'x,y,z,range', or of a sequence of Field or names; every `fields` of this package "
      "takes both. An empty text has none. Raises Error(invalid_argument) with the nearest names for another name, "
      "and TypeError for anything else.");
  m.def(
      "default_fields", [] { return tupleOf(defaultFields()); }, "x y z range ring beam triangle instance");
  bindLayout(m);

  auto options = nb::class_<CloudOptions>(m, "CloudOptions", "What a cloud file holds.");
  options
      .def(
          "__init__",
          [](CloudOptions* self, FieldList fields, std::optional<bool> compact, bool ascii) {
            new (self) CloudOptions{std::move(fields.fields), compact, ascii};
          },
          "fields"_a = nb::make_tuple(), "compact"_a = nb::none(), "ascii"_a = false)
      .def_rw(
          "compact", &CloudOptions::compact,
          "If true, only returns are written, one row each. If false, every entry is, with NaN (0xffffffff in indices) "
          "for one without a return, as a grid of channels x columns (x returns). None: true if beams have several "
          "returns.")
      .def_rw("ascii", &CloudOptions::ascii, "Writes PCD and PLY as text; CSV always is text.");
  readWriteFields(options, &CloudOptions::fields,
                  "If empty: default_fields(), plus return_number and return_count if beams have several returns.");
  m.def(
      "write_cloud",
      [](const SharedScan& scan, const std::filesystem::path& file, const CloudOptions& of) {
        const std::shared_ptr<Scan> shared = scan.value;
        const CloudOptions chosen = of;
        const ReleasedGil released;
        writeCloud(*shared, file, chosen);
      },
      "scan"_a, "file"_a, "options"_a = CloudOptions(),
      ("Writes " + cloudEndings("or") +
       "; the file's ending decides. No half-written file is left. Raises Error(invalid_argument) for an unknown "
       "ending or a field that the scan does not have, and Error(file) if the file cannot be written.")
          .c_str());
  m.def(
      "write_picture",
      [](const SharedScan& scan, const std::filesystem::path& file) {
        const std::shared_ptr<Scan> shared = scan.value;
        const ReleasedGil released;
        writePicture(*shared, file);
      },
      "scan"_a, "file"_a,
      "Writes a PNG: a range image over columns and channels, and below it a bird's-eye view coloured by height. "
      "Raises Error(invalid_argument) for a file that does not end in .png, and Error(file) if it cannot be written.");
  m.def(
      "read_cloud",
      [](const std::filesystem::path& file) {
        const ReleasedGil released;
        return SharedScan{std::make_shared<Scan>(readCloud(file))};
      },
      "file"_a,
      "Reads a PCD, PLY, NPY or CSV cloud that write_cloud() wrote. The scan gets the fields of the file except ring, "
      "beam, return_number and return_count, which follow from the index of an entry. With the field `beam` entries "
      "are placed by it, and by `return` if beams have several; without it the points are of one beam each, unless "
      "there is one for every entry of the grid that the file states. A compact file of several returns has no rows "
      "for beams without any, so its `cause` is left out. PCD states the sensor's pose, and PCD and "
      "PLY state Scan.skewed; other files leave the pose unknown (Scan.pose_known). Raises Error(file), Error(format), "
      "or Error(invalid_argument) for an extension that cannot be read.");
  bindComparison(m);
}

}  // namespace gnosphere::python
