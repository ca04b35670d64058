// SPDX-License-Identifier: Apache-2.0
#include "contender.hpp"

#include "console.hpp"

namespace gnosphere::bench {
namespace {

class Ours : public Contender {
 public:
  Ours(const Scene& scene, const SensorRequest& request, const SimulatorOptions& options, const std::string& name)
      : name_(name), accuracy_(options.accuracy), start_(cli::nowMs()), simulator_(scene, request, options) {
    buildMs_ = cli::nowMs() - start_;
  }

  std::string name() const override { return name_; }
  double build() override { return buildMs_; }
  Sample run(const Task& task) override {
    Sample sample;
    const double start = cli::nowMs();
    for (const Moved& move : task.moved) simulator_.setTransform(move.instance, move.transform);
    const double moved = cli::nowMs();
    simulator_.scanInto(task.shot, scan_);
    sample.renewMs = task.moved.empty() ? 0 : moved - start;
    sample.scanMs = cli::nowMs() - moved;
    sample.deviceMs = scan_.timings.gpuMs;
    sample.stages = scan_.timings.stages;
    return sample;
  }
  const Scan& answer() const override { return scan_; }
  uint64_t memoryBytes() const override {
    const MemoryUse use = simulator_.memory();
    return use.scene + use.sensor + use.work;
  }
  bool judged() const override { return accuracy_ == Accuracy::standard || accuracy_ == Accuracy::exact; }
  const Simulator& simulator() const { return simulator_; }

 private:
  std::string name_;
  Accuracy accuracy_;
  double start_, buildMs_ = 0;
  Simulator simulator_;
  Scan scan_;
};

class Guest : public Contender {
 public:
  Guest(std::unique_ptr<Rival> rival, const Sensor& sensor, bool anew)
      : rival_(std::move(rival)), sensor_(sensor), anew_(anew) {
    scan_.sensor = sensor.name;
    scan_.columns = sensor.width();
    scan_.channels = sensor.height();
  }

  std::string name() const override { return rival_->name() + (anew_ ? ", built anew" : ""); }
  double build() override { return rival_->build(); }
  Sample run(const Task& task) override {
    Sample sample;
    if (!task.moved.empty()) {
      sample.renewMs = rival_->update(task.moved);
      if (anew_) sample.renewMs = rival_->build();  // moves were applied above, which is not counted
      sample.deviceMs = rival_->deviceMs();
      sample.stages.push_back({"renew", sample.renewMs});
    }
    sample.scanMs = rival_->trace(sensor_, task.shot.pose, hits_);
    const double traceMs = rival_->deviceMs();
    sample.deviceMs = traceMs > 0 ? sample.deviceMs + traceMs : 0;
    sample.stages.push_back({"trace", sample.scanMs});
    scan_.pose = task.shot.pose;
    return sample;
  }
  const Scan& answer() const override {
    scan_.ranges = hits_.ranges;
    scan_.triangles = hits_.triangles;
    scan_.instances = hits_.instances;
    return scan_;
  }
  uint64_t memoryBytes() const override { return rival_->memoryBytes(); }

 private:
  std::unique_ptr<Rival> rival_;
  Sensor sensor_;
  bool anew_;
  Hits hits_;
  mutable Scan scan_;
};

}  // namespace

std::unique_ptr<Contender> makeOurs(const Scene& scene, const SensorRequest& request, const SimulatorOptions& options,
                                    const std::string& name) {
  return std::make_unique<Ours>(scene, request, options, name.empty() ? nameOf(options.accuracy) : name);
}

const Simulator& simulatorOf(const Contender& ours) {
  return dynamic_cast<const Ours&>(ours).simulator();
}

std::unique_ptr<Contender> makeGuest(std::unique_ptr<Rival> rival, const Sensor& sensor, bool anew) {
  return std::make_unique<Guest>(std::move(rival), sensor, anew);
}

}  // namespace gnosphere::bench
