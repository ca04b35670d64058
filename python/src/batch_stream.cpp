// SPDX-License-Identifier: Apache-2.0
// Binds the declarations of gnosphere/batch_stream.hpp.
#include <algorithm>

#include "fields.hpp"
#include "simulator.hpp"

namespace gnosphere::python {
namespace {

/// A stream, with the Python object of its simulator, which it keeps alive.
struct Stream {
  Stream(nb::object owner, const BatchStreamOptions& options)
      : keeper(std::move(owner)),
        simulator(nb::cast<SimulatorWithFunctions&>(keeper)),
        stream(simulator.use([&](Simulator& simulator) { return BatchStream(simulator, options); })),
        inFlight(options.inFlight) {}
  nb::object keeper;
  SimulatorWithFunctions& simulator;
  BatchStream stream;
  size_t inFlight;
  uint64_t submitted = 0;  // the number of batches
};

/// A batch, with the Python object of its stream, which keeps the memory.
struct Streamed {
  StreamedBatch batch;
  std::vector<uint32_t> hits;
  nb::object stream;
};

/// A circle of references that leads through a stream or a batch of it leads on through the simulator, which drops its
/// functions. So these two drop nothing.
constexpr auto kDropsNothing = [](auto&) {};
using CollectedStream =
    Collected<Stream, [](const Stream& of) { return std::vector<nb::handle>{of.keeper}; }, kDropsNothing>;
using CollectedBatch =
    Collected<Streamed, [](const Streamed& of) { return std::vector<nb::handle>{of.stream}; }, kDropsNothing>;

Streamed wait(nb::handle self, const Whole& batch) {
  auto& of = nb::cast<Stream&>(self);
  const auto number = batch.of<uint64_t>("wait: number");
  Streamed result;
  result.stream = nb::borrow(self);
  of.simulator.use([&](Simulator&) {
    result.batch = of.stream.wait(number);
    for (const RecordHeader& header : result.batch.headers) result.hits.push_back(header.hits);
  });
  return result;
}

/// The memory that has an array.
enum class Where { host, cuda };

void requireCurrent(const Streamed& self) {
  const auto& of = nb::cast<Stream&>(self.stream);
  if (of.submitted > self.batch.number + of.inFlight)
    refuse("the results of batch " + std::to_string(self.batch.number) +
           " are gone, because the stream keeps those of " + std::to_string(of.inFlight) + " batches");
}

const RecordLayout::Value& valueOf(const Streamed& self, Field field) {
  const std::vector<RecordLayout::Value>& values = self.batch.layout.values;
  const auto found = std::ranges::find(values, field, &RecordLayout::Value::field);
  if (found == values.end())
    refuse(std::string("the batch does not have the field '") + fieldInfo(field).name +
           "'; add it to the fields of the sensor");
  return *found;
}

/// An array of shape (views, beams[, returns][, components]) of values that begin with `first`.
template <typename T>
nb::object arrayOf(const Streamed& self, const RecordLayout::Value& first, size_t components, Where where) {
  requireCurrent(self);
  const ResultPlaces& places = self.batch.places;
  std::vector<size_t> shape = {self.batch.views, places.rowsPerView / places.returns};
  const auto stride = static_cast<int64_t>(first.stride / sizeof(T));
  std::vector<int64_t> strides = {static_cast<int64_t>(places.bytesPerView / sizeof(T)),
                                  stride * static_cast<int64_t>(places.returns)};
  if (places.returns > 1) shape.push_back(places.returns), strides.push_back(stride);
  if (components > 1) shape.push_back(components), strides.push_back(1);
  if (where == Where::cuda) {
    auto& of = nb::cast<Stream&>(self.stream);
    const CudaAddress start = of.simulator.use([&](Simulator&) { return of.stream.cudaAddress(self.batch.buffer); });
    auto* const data = reinterpret_cast<T*>(start.address + places.records + first.offset);
    return nb::cast(nb::ndarray<nb::array_api, T>(data, shape.size(), shape.data(), self.stream, strides.data(),
                                                  nb::dtype<T>(), nb::device::cuda::value, start.device));
  }
  if (self.batch.records.empty() && self.batch.views > 0)
    refuse("the results are on the device only; read them in CUDA, or make the stream with to_host=True");
  auto* const data = const_cast<std::byte*>(self.batch.records.data()) + first.offset;
  return nb::cast(
      nb::ndarray<nb::numpy, T>(reinterpret_cast<T*>(data), shape.size(), shape.data(), self.stream, strides.data()));
}

nb::object column(const Streamed& self, Field field, Where where) {
  const FieldInfo info = fieldInfo(field);
  const RecordLayout::Value& first = valueOf(self, field);
  return arrayOfType(info.type, [&]<typename T>() { return arrayOf<T>(self, first, info.components, where); });
}

bool streamedHasField(const Streamed& self, Field field) {
  return std::ranges::count(self.batch.layout.values, field, &RecordLayout::Value::field) > 0;
}

nb::object columnOfStreamed(const Streamed& self, Field field) {
  return column(self, field, Where::host);
}

void bindStreamed(nb::module_& m) {
  nb::class_<Streamed> batch(
      m, "StreamedBatch", nb::type_slots(CollectedBatch::slots),
      "The results of a batch that has been waited for. Arrays have the shape (views, beams), or (views, beams, "
      "returns) if a beam may have several, and vectors have their components as a last dimension. They are views of "
      "the stream's result buffer, which they keep alive: the values change when the stream uses the buffer again, for "
      "the batch that is submitted `in_flight` later. From then on this object hands out no arrays. Copy what you keep "
      "longer.");
  batch.def_prop_ro(
      "number", [](const Streamed& self) { return self.batch.number; }, "As BatchStream.submit() has returned it.");
  batch.def_prop_ro(
      "buffer", [](const Streamed& self) { return self.batch.buffer; }, "The result buffer that holds it.");
  batch.def_prop_ro(
      "sensor", [](const Streamed& self) { return self.batch.sensor; },
      "Index of the sensor when the batch was submitted. Another sensor may have it by now.");
  batch.def_prop_ro(
      "views", [](const Streamed& self) { return self.batch.views; }, "The number of shots.");
  batch.def_prop_ro(
      "beams", [](const Streamed& self) { return self.batch.places.rowsPerView / self.batch.places.returns; },
      "Beams of each view.");
  batch.def_prop_ro(
      "returns", [](const Streamed& self) { return self.batch.places.returns; }, "Entries per beam.");
  batch.def_prop_ro(
      "places", [](const Streamed& self) { return self.batch.places; },
      "Where the results are in the buffer, also after the sensor has been removed or replaced.");
  batch.def_prop_ro(
      "layout", [](const Streamed& self) { return self.batch.layout; },
      "How the records of a view lie in memory: a column per value.");
  batch.def_prop_ro(
      "complete", [](const Streamed& self) { return self.batch.complete; },
      "False if a list was too small for some view, so that it may lack hits. The list has grown when the next batch "
      "in the same buffer begins.");
  batch.def_prop_ro(
      "hits", [](const Streamed& self) { return nb::cast(ownedColumn(self.hits)); },
      nb::for_getter(nb::sig("def hits(self, /) -> numpy.typing.NDArray[numpy.uint32]")),
      "uint32, shape (views,): the returns of each view; a copy.");
  batch.def_prop_ro(
      "ranges", [](const Streamed& self) { return column(self, Field::range, Where::host); },
      nb::for_getter(nb::sig("def ranges(self, /) -> numpy.typing.NDArray[numpy.float32]")),
      "float32: metres along the beam; NaN in an entry without a return.");
  batch.def_prop_ro(
      "points", [](const Streamed& self) { return arrayOf<float>(self, valueOf(self, Field::x), 3, Where::host); },
      nb::for_getter(nb::sig("def points(self, /) -> numpy.typing.NDArray[numpy.float32]")),
      "float32, three components: x, y, z in metres in the frame of each view's sensor; if x, y or z is a field.");
  batch
      .def(
          "column", [](const Streamed& self, const FieldLike& given) { return columnOfStreamed(self, given.field); },
          "field"_a, nb::sig("def column(self, field: Field | str) -> numpy.typing.NDArray[typing.Any]"),
          "Returns the values of a field as a NumPy array. Raises Error(invalid_argument) if the batch does not have "
          "the field, or if the results are on the device only.")
      .def(
          "cuda_column",
          [](const Streamed& self, const FieldLike& given) { return column(self, given.field, Where::cuda); },
          "field"_a, nb::sig("def cuda_column(self, field: Field | str) -> typing.Any"),
          "Returns the values of a field as an object that torch.from_dlpack() and its like take without a copy, on "
          "the CUDA device. Work on them in CUDA must have ended (torch.cuda.synchronize()) before the batch is "
          "submitted that uses the same result buffer. Raises Error(device) that gives the reason if CUDA cannot have "
          "them.")
      .def(
          "has", [](const Streamed& self, const FieldLike& given) { return streamedHasField(self, given.field); },
          "field"_a, "Whether column() has the field.");
  bindNames<&streamedHasField, &columnOfStreamed>(batch, "the batch", "SensorRequest.fields asks for more");
}

}  // namespace

void bindBatchStream(nb::module_& m) {
  bindStreamed(m);
  nb::class_<ResultPlaces>(m, "ResultPlaces", "Where the results of a sensor are in a result buffer.")
      .def_ro(
          "headers", &ResultPlaces::headers,
          "Bytes from the start of the buffer to the headers, of 8 numbers of 32 bits for each view: rows, 1, 0, 0, "
          "rows, returns of all beams, not 0 if hits may be missing, frame number.")
      .def_ro("records", &ResultPlaces::records, "Bytes from the start of the buffer to the records of the first view.")
      .def_ro("bytes_per_view", &ResultPlaces::bytesPerView, "From the records of one view to those of the next.")
      .def_ro("rows_per_view", &ResultPlaces::rowsPerView, "Entries of a view: beams * returns.")
      .def_ro("returns", &ResultPlaces::returns, "Entries per beam.")
      .def_ro("bytes", &ResultPlaces::bytes, "Of the whole buffer.");
  nb::class_<ExportedMemory>(m, "ExportedMemory",
                             "A file descriptor for the memory of a result buffer, which begins at byte 0 of that "
                             "memory.")
      .def_ro("fd", &ExportedMemory::fd, "The caller's to close, unless an import takes it over.")
      .def_ro("bytes", &ExportedMemory::bytes, "Size of the memory, which imports must state.");
  nb::class_<CudaAddress>(m, "CudaAddress", "A result buffer in CUDA.")
      .def_ro("address", &CudaAddress::address,
              "Of the first byte, in the primary context, which PyTorch uses as well.")
      .def_ro("device", &CudaAddress::device, "The number by which CUDA knows the card.");
  nb::class_<Stream>(
      m, "BatchStream", nb::type_slots(CollectedStream::slots), nb::is_weak_referenceable(),
      "Batches of a simulator whose results stay on its device (SimulatorOptions.results_on_device). Batches are "
      "submitted and waited for apart, so that the device works on one while the program works on the results of "
      "another. Others on the same card read the results where they are. A batch holds ranges and "
      "SensorRequest.fields.")
      .def(
          "__init__",
          [](Stream* self, nb::handle_t<SimulatorWithFunctions> simulator, const Whole& views, const Whole& inFlight,
             bool toHost) {
            new (self) Stream(nb::borrow(simulator), {views.of<size_t>("BatchStream: views"),
                                                      inFlight.of<size_t>("BatchStream: in_flight"), toHost});
          },
          "simulator"_a, "views"_a, "in_flight"_a = 2, "to_host"_a = false,
          "Makes the result buffers: `in_flight` of them, each with room for batches of `views` shots of any sensor "
          "that the simulator has. With `to_host` the results are also copied to the host; a device that shares the "
          "host's memory needs no copy. A simulator can have one stream at a time. Raises Error(invalid_argument) and "
          "Error(out_of_memory).")
      .def(
          "submit",
          [](Stream& self, const ShotsLike& given, const Whole& sensor, const NumbersLike& worlds, const Whole& frame,
             const IndexListsLike& ignored) {
            const std::vector<Shot> shots = shotsOf(given, {sensor, worlds, frame, ignored}, "submit");
            const auto ofNone = sensor.of<size_t>("submit: sensor");
            const uint64_t number = self.simulator.use([&](Simulator&) { return self.stream.submit(shots, ofNone); });
            self.submitted = number + 1;
            return number;
          },
          "shots"_a, "sensor"_a = 0, "worlds"_a = 0, "frame"_a = 0,
          "ignored_instances"_a = IndexListsLike{nb::make_tuple()},
          "Starts the scans of shots of one sensor, given as for Simulator.scan_batch() with its frame numbers, and "
          "returns the number of the batch. Changes of the simulator before the call count, those after it do not. The "
          "call waits for the batch that has used the same result buffer; and for this one, so that lists can grow, if "
          "the sensor's batches so far had fewer views, or none was in motion. Raises Error(invalid_argument) that "
          "names the first shot which is not valid, before anything runs, Error(out_of_memory) and Error(device).")
      .def("wait", &wait, "number"_a, nb::sig("def wait(self, number: int) -> StreamedBatch"),
           "Waits until a batch is done, and returns its results. Raises Error(invalid_argument) if there is none of "
           "this number, or if its buffer has been used again.")
      .def(
          "layout",
          [](Stream& self, const Whole& sensor) {
            const auto number = sensor.of<size_t>("layout: sensor");
            return self.simulator.use([&](Simulator&) { return RecordLayout(self.stream.layout(number)); });
          },
          "sensor"_a = 0,
          "How the records of a view of a sensor lie in memory: a column per value; StreamedBatch.layout is that of a "
          "batch. Raises Error(invalid_argument) for an unknown sensor.")
      .def(
          "places",
          [](Stream& self, const Whole& sensor) {
            const auto number = sensor.of<size_t>("places: sensor");
            return self.simulator.use([&](Simulator&) { return self.stream.places(number); });
          },
          "sensor"_a = 0,
          "Where the results of a sensor are in a result buffer; StreamedBatch.places is for those of a batch. Raises "
          "Error(invalid_argument) for an unknown sensor.")
      .def(
          "export_memory",
          [](Stream& self, const Whole& buffer) {
            const auto number = buffer.of<size_t>("export_memory: buffer");
            return self.simulator.use([&](Simulator&) { return self.stream.exportMemory(number); });
          },
          "buffer"_a,
          "Hands out the memory of a result buffer, for whoever imports it with Vulkan or CUDA as an opaque file "
          "descriptor. Its content is a batch's as soon as wait() has returned for the batch. Raises Error(device) if "
          "the device exports none.")
      .def(
          "cuda_address",
          [](Stream& self, const Whole& buffer) {
            const auto number = buffer.of<size_t>("cuda_address: buffer");
            return self.simulator.use([&](Simulator&) { return self.stream.cudaAddress(number); });
          },
          "buffer"_a,
          "Imports a result buffer in CUDA, once; it is valid as long as the stream. Raises Error(device) that gives "
          "the reason if CUDA cannot have it.");
}

}  // namespace gnosphere::python
