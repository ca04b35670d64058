// SPDX-License-Identifier: Apache-2.0
#include "gnosphere/batch_stream.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "base/call.hpp"
#include "base/limits.hpp"
#include "effects/sensor_plan.hpp"
#include "gnosphere/error.hpp"
#include "pipeline/recording.hpp"
#include "pipeline/result_ring.hpp"
#include "shot_checks.hpp"

namespace gnosphere {
namespace {

[[noreturn]] void refuse(const std::string& why) {
  throw Error(ErrorCode::invalidArgument, why);
}

constexpr uint64_t kAlignment = 256;  // of the records in a buffer; that of views is 16
constexpr uint64_t kNoBatch = UINT64_MAX;

uint64_t roundedUp(uint64_t value, uint64_t to) {
  return (value + to - 1) / to * to;
}

}  // namespace

class BatchStream::Impl {
 public:
  const MakerProcess& maker() const { return calls_.maker; }
  CallState& calls() { return calls_; }

  Impl(Simulator& simulator, const BatchStreamOptions& options) : simulator_(simulator), options_(options) {
    if (options.views == 0 || options.views > limits::kMostNumber)
      refuse("a BatchStream is made for 1 to " + std::to_string(limits::kMostNumber) + " views, not for " +
             std::to_string(options.views));
    if (options.inFlight == 0 || options.inFlight > limits::kFrames.most)
      refuse("a BatchStream has 1 to " + std::to_string(limits::kFrames.most) + " batches in flight, not " +
             std::to_string(options.inFlight));
    batches_.resize(options.inFlight);
    for (size_t sensor = 0; sensor < simulator.plans().size(); ++sensor)
      if (simulator.plans()[sensor]) bytes_ = std::max(bytes_, bytesFor(sensor));
    ring_ = simulator.makeRing(options.inFlight, bytes_, options.toHost ? bytes_ : headerBytes());
  }

  uint64_t submit(std::span<const Shot> shots, size_t sensorOfNone) {
    if (shots.size() > options_.views)
      refuse("the batch has " + std::to_string(shots.size()) + " shots; the stream is made for " +
             std::to_string(options_.views));
    checkSensorOfBatch(shots);
    const size_t buffer = next_ % options_.inFlight, sensor = shots.empty() ? sensorOfNone : shots[0].sensor;
    if (bytesFor(sensor) > bytes_)
      refuse("sensor " + std::to_string(sensor) + " needs result buffers of " + std::to_string(bytesFor(sensor)) +
             " bytes; those of the stream, which was made before the sensor was added, have " + std::to_string(bytes_));
    Batch& batch = batches_[buffer];
    waitFor(buffer);
    // The lists grow when the next batch of the buffer is recorded, so a batch that finds them too small is made again
    // before anything else can change the scene.
    bool mayOverflow;
    do {
      const ResultPlaces places = placesOf(sensor);
      mayOverflow = start(shots, places, buffer);
      batch = {next_, sensor, shots.size(), places, simulator_.plans()[sensor]};
      if (mayOverflow) waitFor(buffer);
    } while (mayOverflow && !complete(batch));
    return next_++;
  }

  StreamedBatch wait(uint64_t number) {
    if (number >= next_) refuse("no batch " + std::to_string(number) + " has been submitted");
    const size_t buffer = number % options_.inFlight;
    Batch& batch = batches_[buffer];
    if (batch.number != number)  // also after a batch that failed
      refuse("the results of batch " + std::to_string(number) + " are gone, because the stream keeps those of " +
             std::to_string(options_.inFlight) + " batches");
    waitFor(buffer);
    StreamedBatch result;
    result.number = number;
    result.buffer = buffer;
    result.sensor = batch.sensor;
    result.views = batch.views;
    result.places = batch.places;
    result.layout = batch.plan->layout;
    result.headers = headersOf(batch);
    result.complete = complete(batch);
    if (ring_->hostHasAll(buffer))
      result.records = {ring_->host(buffer) + batch.places.records, batch.views * batch.places.bytesPerView};
    return result;
  }

  const RecordLayout& layout(size_t sensor) const { return planOf(sensor).layout; }

  ResultPlaces placesOf(size_t sensor) const {
    const SensorPlan& plan = planOf(sensor);
    ResultPlaces places;
    places.records = roundedUp(headerBytes(), kAlignment);
    places.returns = plan.returns;
    places.rowsPerView = plan.sensor.beamCount() * plan.returns;
    places.bytesPerView = roundedUp(std::max<uint64_t>(plan.layout.bytesFor(places.rowsPerView), 4), 16);
    places.bytes = bytes_;
    return places;
  }

  ExportedMemory exportMemory(size_t buffer) const {
    checkBuffer(buffer);
    const auto [fd, bytes] = ring_->fd(buffer);
    return {fd, bytes};
  }

  CudaAddress cudaAddress(size_t buffer) {
    checkBuffer(buffer);
    const auto [address, device] = ring_->cudaAddress(buffer);
    return {address, device};
  }

 private:
  struct Batch {
    uint64_t number = kNoBatch;
    size_t sensor = 0;
    size_t views = 0;
    ResultPlaces places = {};
    std::shared_ptr<const SensorPlan> plan = {};  // of the sensor, which may have been removed meanwhile
  };

  const SensorPlan& planOf(size_t sensor) const {
    const auto& plans = simulator_.plans();
    if (sensor >= plans.size() || !plans[sensor]) refuse("there is no sensor " + std::to_string(sensor));
    return *plans[sensor];
  }
  void checkBuffer(size_t buffer) const {
    if (buffer >= options_.inFlight)
      refuse("there is no result buffer " + std::to_string(buffer) + "; the stream has " +
             std::to_string(options_.inFlight));
  }
  uint64_t headerBytes() const { return options_.views * sizeof(RecordHeader); }
  uint64_t bytesFor(size_t sensor) const {
    const ResultPlaces places = placesOf(sensor);
    const uint64_t most = (UINT64_MAX >> 1) / places.bytesPerView;  // more is refused as too large all the same
    return places.records + std::min<uint64_t>(options_.views, most) * places.bytesPerView;
  }

  // Waits for the batch of a buffer, which has no results if the device fails.
  void waitFor(size_t buffer) {
    try {
      ring_->wait(buffer);
    } catch (...) {
      batches_[buffer].number = kNoBatch;
      throw;
    }
  }

  // Starts the scans of a batch, and returns Recording::mayOverflow.
  bool start(std::span<const Shot> shots, const ResultPlaces& places, size_t buffer) {
    const uint64_t address = ring_->address(buffer);
    Recording recording;
    ring_->begin(buffer);
    recording.ring = ring_.get();
    recording.frame = buffer;
    for (size_t view = 0; view < shots.size(); ++view)
      recording.scans.push_back({&shots[view],
                                 {address + places.records + view * places.bytesPerView, places.bytesPerView},
                                 {address + places.headers + view * sizeof(RecordHeader), sizeof(RecordHeader)}});
    simulator_.record(recording);
    try {
      ring_->submit(buffer, places.records + shots.size() * places.bytesPerView);
    } catch (...) {
      batches_[buffer].number = kNoBatch;  // a part may have been submitted, and have written to the buffer
      simulator_.abandon(buffer);
      throw;
    }
    return recording.mayOverflow;
  }

  std::span<const RecordHeader> headersOf(const Batch& batch) const {
    return {reinterpret_cast<const RecordHeader*>(ring_->host(batch.number % options_.inFlight) + batch.places.headers),
            batch.views};
  }
  bool complete(const Batch& batch) const {
    return std::ranges::all_of(headersOf(batch), [](const RecordHeader& header) { return header.incomplete == 0; });
  }

  Simulator& simulator_;
  BatchStreamOptions options_;
  CallState calls_;
  uint64_t bytes_ = 0;  // of a result buffer
  uint64_t next_ = 0;   // number of the next batch
  std::vector<Batch> batches_;
  std::shared_ptr<ResultRing> ring_;
};

BatchStream::BatchStream(Simulator& simulator, const BatchStreamOptions& options)
    : impl_(std::make_unique<Impl>(simulator, options)) {}
BatchStream::~BatchStream() {
  leaveToParent(impl_);
}
BatchStream::BatchStream(BatchStream&&) noexcept = default;
BatchStream& BatchStream::operator=(BatchStream&& other) noexcept {
  if (this == &other) return *this;
  const BatchStream before(std::move(*this));
  impl_ = std::move(other.impl_);
  return *this;
}

uint64_t BatchStream::submit(std::span<const Shot> shots, size_t sensorOfNone) {
  return Call(impl_)->submit(shots, sensorOfNone);
}
StreamedBatch BatchStream::wait(uint64_t number) {
  return Call(impl_)->wait(number);
}
const RecordLayout& BatchStream::layout(size_t sensor) const {
  return forReading(impl_).layout(sensor);
}
ResultPlaces BatchStream::places(size_t sensor) const {
  return forReading(impl_).placesOf(sensor);
}
ExportedMemory BatchStream::exportMemory(size_t buffer) const {
  return forReading(impl_).exportMemory(buffer);
}
CudaAddress BatchStream::cudaAddress(size_t buffer) {
  return Call(impl_)->cudaAddress(buffer);
}

}  // namespace gnosphere
