// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "gnosphere/layout.hpp"
#include "gnosphere/simulator.hpp"

namespace gnosphere {

/// How many results a stream of batches keeps, and where.
struct BatchStreamOptions {
  size_t views = 0;     ///< most shots of a batch; at least 1
  size_t inFlight = 2;  ///< result buffers, 1 to 16: so many batches may run, or wait to be read, at a time
  /// If true, the results are also copied to the host. A device that shares the host's memory needs no copy: there the
  /// host has the results in any case.
  bool toHost = false;
};

/// Where the results are in a result buffer.
struct ResultPlaces {
  uint64_t headers = 0;       ///< bytes from the start of the buffer to the headers, one RecordHeader per view
  uint64_t records = 0;       ///< bytes from the start of the buffer to the records of the first view
  uint64_t bytesPerView = 0;  ///< from the records of one view to those of the next; a multiple of 16
  uint64_t rowsPerView = 0;   ///< entries of a view: beams * returns
  uint32_t returns = 1;       ///< entries per beam
  uint64_t bytes = 0;         ///< of the whole buffer
};

/// The results of a batch that has been waited for, until the stream needs the buffer again: for the batch that is
/// submitted BatchStreamOptions::inFlight later.
struct StreamedBatch {
  uint64_t number = 0;  ///< as submit() has returned it
  size_t buffer = 0;    ///< the result buffer: number % BatchStreamOptions::inFlight
  size_t sensor = 0;    ///< its index when the batch was submitted; another sensor may have it by now
  size_t views = 0;
  /// False if a list was too small for some view, so that it may lack hits; see RecordHeader::incomplete. The list has
  /// grown when the next batch in the same buffer begins.
  bool complete = true;
  std::span<const RecordHeader> headers;  ///< one per view
  /// The records of all views, ResultPlaces::bytesPerView bytes for each; empty if the host does not have them.
  std::span<const std::byte> records;
  ResultPlaces places;  ///< where the results are in the buffer, also after the sensor has been removed or replaced
  RecordLayout layout;  ///< how the records of a view lie in memory
};

/// A file descriptor for the memory of a result buffer, which begins at byte 0 of that memory.
struct ExportedMemory {
  int fd = -1;         ///< the caller's to close, unless an import takes it over
  uint64_t bytes = 0;  ///< size of the memory, which imports must state
};

/// A result buffer in CUDA.
struct CudaAddress {
  uint64_t address = 0;  ///< of the first byte, a CUdeviceptr in the primary context, which PyTorch uses as well
  int device = 0;        ///< the number by which CUDA knows the card
};

/// Batches of a simulator whose results stay on its device (SimulatorOptions::resultsOnDevice). Batches are submitted
/// and waited for apart, so that the device works on one while the program works on the results of another. Other users
/// of the device, in this process or in another, read the result buffers where they are: by a file descriptor, or in
/// CUDA. The records of a view lie in the layout of the sensor, SensorRequest::layout.
class GNOSPHERE_API BatchStream {
 public:
  /// Makes the result buffers, for the sensors that the simulator has. The simulator must outlive the stream, must not
  /// be moved meanwhile, and can have one at a time. Throws Error(invalidArgument) if its results do not stay on its
  /// device, and Error(outOfMemory).
  BatchStream(Simulator& simulator, const BatchStreamOptions& options);
  ~BatchStream();
  BatchStream(BatchStream&&) noexcept;
  BatchStream& operator=(BatchStream&&) noexcept;

  /// Starts the scans of shots of one sensor, and returns the number of the batch: 0, then 1, and so on. Changes of the
  /// simulator before the call count, those after it do not. Waits for the batch that has used the same result buffer;
  /// and for this one, so that lists can grow, if no batch of the sensor that is known to be complete had as many
  /// views, or was in motion if this one is. Other users of the buffer must have finished with it: neither their
  /// commands nor CUDA's are waited for. Throws Error(invalidArgument) as Simulator::scanBatch() does, in which case
  /// nothing has changed, Error(outOfMemory) and Error(device), after which the results that the buffer had may be
  /// gone, as wait() tells. Without shots the batch is one of `sensorOfNone`, which counts in this case alone.
  uint64_t submit(std::span<const Shot> shots, size_t sensorOfNone = 0);
  /// Waits until a batch is done. Throws Error(invalidArgument) if there is none of this number, or if its buffer has
  /// been used again, and Error(device).
  StreamedBatch wait(uint64_t number);

  /// The layout of a sensor's records; that of a batch is StreamedBatch::layout. Throws Error(invalidArgument) for an
  /// unknown sensor.
  const RecordLayout& layout(size_t sensor = 0) const;
  /// Where a sensor's results are in a result buffer; those of a batch are at StreamedBatch::places. Throws
  /// Error(invalidArgument) for an unknown sensor.
  ResultPlaces places(size_t sensor = 0) const;
  /// Hands out the memory of a result buffer, to be imported by Vulkan or CUDA as an opaque file descriptor. Its
  /// content is a batch's as soon as wait() has returned for the batch. Throws Error(device) if the device exports
  /// none.
  ExportedMemory exportMemory(size_t buffer) const;
  /// Imports a result buffer in CUDA at the first call; the address is valid as long as the stream. Work of CUDA on the
  /// buffer must have completed, as cuStreamSynchronize() tells, before the submit() that uses the buffer again. Throws
  /// Error(device) that gives the reason if CUDA cannot have the buffer.
  CudaAddress cudaAddress(size_t buffer);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace gnosphere
