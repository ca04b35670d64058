// SPDX-License-Identifier: Apache-2.0
// gno_batch_stream: batches whose results stay on the device.
#include <gnosphere_stream.h>

#include "c/handles.hpp"

namespace gnosphere::c {

namespace {

/// The places and the layout that gno_streamed_batch points to. A second wait for a batch leaves both as the first one
/// has written them, because another thread may be reading.
struct Described {
  uint64_t number = UINT64_MAX;  ///< of the batch
  gno_result_places places = gno_result_places_init();
  gno_layout layout = gno_layout_init();
  std::vector<gno_layout_value> values;
};

void give(const ResultPlaces& places, gno_result_places& to) {
  to.headers = places.headers;
  to.records = places.records;
  to.bytes_per_view = places.bytesPerView;
  to.rows_per_view = places.rowsPerView;
  to.returns = places.returns;
  to.bytes = places.bytes;
}

/// A stream, and its simulator, which lives at least as long.
struct StreamObject {
  Shared<gno_simulator> simulator;
  BatchStream stream;
  std::vector<Described> described;      ///< by result buffer
  std::vector<gno_layout_value> layout;  ///< what gno_batch_stream_get_layout() last handed out
};

}  // namespace

GNO_HELD(gno_batch_stream, StreamObject, "batch stream")

}  // namespace gnosphere::c

using namespace gnosphere;
using namespace gnosphere::c;

extern "C" {

gno_status gno_batch_stream_create(gno_simulator simulator, const gno_batch_stream_options* options,
                                   gno_batch_stream* stream) {
  return giveHandle(stream, "stream", [&] {
    const gno_batch_stream_options from = sized(options, GNO_TYPE(gno_batch_stream_options));
    Idle idle(simulator);
    return make<gno_batch_stream>({find(simulator),
                                   BatchStream(idle.simulator(), {from.views, from.in_flight, from.to_host != 0}),
                                   std::vector<Described>(from.in_flight),
                                   {}});
  });
}

gno_status gno_batch_stream_destroy(gno_batch_stream stream) {
  return guard([&] { destroy(stream); });
}

gno_status gno_batch_stream_submit(gno_batch_stream stream, const gno_shot* shots, size_t shot_count,
                                   uint64_t* number) {
  return guard([&] {
    const std::vector<Shot> wanted = shotsOf(shots, shot_count);
    WithSimulator locked(stream);
    const uint64_t submitted = locked->stream.submit(wanted);
    if (number) *number = submitted;
  });
}

gno_status gno_batch_stream_wait(gno_batch_stream stream, uint64_t number, gno_streamed_batch* batch) {
  return guard([&] {
    const Out to(batch, GNO_TYPE(gno_streamed_batch));
    Locked locked(stream);
    const StreamedBatch from = locked->stream.wait(number);
    to->number = from.number;
    to->buffer = from.buffer;
    to->sensor = from.sensor;
    to->views = from.views;
    to->complete = from.complete;
    to->headers = reinterpret_cast<const gno_record_header*>(from.headers.data());
    to->records = from.records.data();
    Described& described = locked->described[from.buffer];
    if (described.number != number) {
      described.number = UINT64_MAX;
      give(from.places, described.places);
      give(from.layout, described.values, described.layout);
      described.number = number;
    }
    to->places = &described.places;
    to->layout = &described.layout;
  });
}

gno_status gno_batch_stream_get_layout(gno_batch_stream stream, size_t sensor, gno_layout* layout) {
  return guard([&] {
    const Out to(layout, GNO_TYPE(gno_layout));
    WithSimulator locked(stream);
    give(locked->stream.layout(sensor), locked->layout, *to);
  });
}

gno_status gno_batch_stream_get_places(gno_batch_stream stream, size_t sensor, gno_result_places* places) {
  return guard([&] {
    const Out to(places, GNO_TYPE(gno_result_places));
    WithSimulator locked(stream);
    give(locked->stream.places(sensor), *to);
  });
}

gno_status gno_batch_stream_export(gno_batch_stream stream, size_t buffer, gno_exported_memory* memory) {
  return guard([&] {
    const Out to(memory, GNO_TYPE(gno_exported_memory));
    const ExportedMemory from = Locked(stream)->stream.exportMemory(buffer);
    to->fd = from.fd;
    to->bytes = from.bytes;
  });
}

gno_status gno_batch_stream_get_cuda_address(gno_batch_stream stream, size_t buffer, uint64_t* address,
                                             int32_t* device) {
  return guard([&] {
    the(address, "address");
    const CudaAddress from = Locked(stream)->stream.cudaAddress(buffer);
    *address = from.address;
    if (device) *device = from.device;
  });
}

}  // extern "C"
