/* SPDX-License-Identifier: Apache-2.0
 *
 * The part of GnoSphere's C interface (see gnosphere.h) for batches whose results stay on the device of the library:
 * they are submitted and waited for apart, and handed out as file descriptors or as addresses in CUDA. docs/batches.md
 * shows how to use it, in C++ under the same names.
 */
#ifndef GNOSPHERE_STREAM_H
#define GNOSPHERE_STREAM_H

#include <gnosphere.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Batches of a simulator that was created with the option "results_on_device=true", see gno_options_set(). */
typedef struct gno_batch_stream_object* gno_batch_stream;

/* How many results a stream of batches keeps, and where. */
typedef struct gno_batch_stream_options {
  size_t struct_size;
  size_t views;     /* most shots of a batch; at least 1 */
  size_t in_flight; /* result buffers, 1 to 16; the default is 2 */
  int32_t to_host;  /* not 0: the results are also copied to the host, unless it shares the device's memory anyway */
} gno_batch_stream_options;

/* Where the results are in a result buffer, in bytes from its start. */
typedef struct gno_result_places {
  size_t struct_size;
  uint64_t headers;        /* a gno_record_header per view */
  uint64_t records;        /* of the first view */
  uint64_t bytes_per_view; /* from the records of one view to those of the next; a multiple of 16 */
  uint64_t rows_per_view;  /* entries of a view: beams * returns */
  uint32_t returns;        /* entries per beam */
  uint64_t bytes;          /* of the whole buffer */
} gno_result_places;

/* The results of a batch that has been waited for, until the batch is submitted that uses the buffer next. */
typedef struct gno_streamed_batch {
  size_t struct_size;
  uint64_t number; /* as gno_batch_stream_submit() has given it */
  size_t buffer;   /* the result buffer: number % in_flight */
  size_t sensor;   /* its index when the batch was submitted; another sensor may have it by now */
  size_t views;
  int32_t complete; /* 0 if a list was too small for some view, so that it may lack hits */
  const gno_record_header* headers;
  const void* records; /* those of the first view; null if the host does not have them */
  /* Where the results are in the buffer, and how the records of a view lie in memory, also after the sensor has been
   * removed or replaced. */
  const gno_result_places* places;
  const gno_layout* layout;
} gno_streamed_batch;

/* A file descriptor for the memory of a result buffer, which begins at byte 0 of that memory. */
typedef struct gno_exported_memory {
  size_t struct_size;
  int32_t fd;     /* the caller's to close, unless an import takes it over */
  uint64_t bytes; /* size of the memory, which imports must state */
} gno_exported_memory;

/* Makes the result buffers, for the sensors that the simulator has. A simulator can have one stream at a time, and
 * lives at least as long as it, even if its own handle is destroyed. */
GNO_API gno_status gno_batch_stream_create(gno_simulator simulator, const gno_batch_stream_options* options,
                                           gno_batch_stream* stream);
GNO_API gno_status gno_batch_stream_destroy(gno_batch_stream stream);
/* Starts the scans of shots of one sensor, and gives the number of the batch: 0, then 1, and so on. Changes of the
 * simulator before the call count, those after it do not. The call waits for the batch that has used the same result
 * buffer; and for this one, so that lists can grow, if no batch of the sensor that is known to be complete had as many
 * views, or was in motion if this one is. It does not wait for other users of the buffer, such as CUDA.
 * GNO_INVALID_ARGUMENT for shots that are not valid, in which case nothing has changed; GNO_OUT_OF_MEMORY and
 * GNO_DEVICE, after which the results that the buffer had may be gone, as gno_batch_stream_wait() tells. */
GNO_API gno_status gno_batch_stream_submit(gno_batch_stream stream, const gno_shot* shots, size_t shot_count,
                                           uint64_t* number);
/* Waits until a batch is done. GNO_INVALID_ARGUMENT if there is none of this number, or if its buffer has been used
 * again; GNO_DEVICE. */
GNO_API gno_status gno_batch_stream_wait(gno_batch_stream stream, uint64_t number, gno_streamed_batch* batch);
/* The layout of a sensor's records: gno_request::layout, or columns of ranges and of gno_request::fields if that is
 * null; that of a batch is gno_streamed_batch::layout. The values are valid until this function is called again for
 * this stream. */
GNO_API gno_status gno_batch_stream_get_layout(gno_batch_stream stream, size_t sensor, gno_layout* layout);
/* Where a sensor's results are in a result buffer; those of a batch are at gno_streamed_batch::places.
 * GNO_INVALID_ARGUMENT for an unknown sensor. */
GNO_API gno_status gno_batch_stream_get_places(gno_batch_stream stream, size_t sensor, gno_result_places* places);
/* Hands out the memory of a result buffer, to be imported by Vulkan or CUDA as an opaque file descriptor. */
GNO_API gno_status gno_batch_stream_export(gno_batch_stream stream, size_t buffer, gno_exported_memory* memory);
/* Gives the address of a result buffer in CUDA's primary context of the same card, and the card's number in CUDA
 * (`device` may be null). The memory is imported once and is valid as long as the stream. Work of CUDA on it must have
 * completed before the batch is submitted that uses the buffer again. GNO_DEVICE if CUDA cannot have it. */
GNO_API gno_status gno_batch_stream_get_cuda_address(gno_batch_stream stream, size_t buffer, uint64_t* address,
                                                     int32_t* device);

/* ---------------------------------------------------------------------------------------- default values */

GNO_INIT(gno_batch_stream_options, value.in_flight = 2;)
GNO_INIT(gno_result_places, )
GNO_INIT(gno_streamed_batch, )
GNO_INIT(gno_exported_memory, value.fd = -1;)

#ifdef __cplusplus
}
#endif

#endif
