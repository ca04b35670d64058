// SPDX-License-Identifier: Apache-2.0
// Requests drawn at random: scans that an application records on its own device, against scans on a device of our own.
#include <algorithm>
#include <memory>

#include "base/vector.hpp"
#include "engine/recorded.hpp"
#include "random/request.hpp"

namespace gnosphere::test {
namespace {

/// The records and the header of one recorded scan.
struct Results {
  Results(const VulkanApp& app, uint64_t bytes) : records(app, bytes), header(app, sizeof(RecordHeader)) {}
  VulkanApp::Buffer records, header;
};

/// A layout with the geometry of each return and with every field that the request asks for, but for the incidence with
/// deskew, which a device does not know.
RecordLayout layoutFor(const SensorRequest& request, uint32_t number) {
  std::vector<Field> fields = {Field::x,        Field::range, Field::ring,    Field::beam,
                               Field::triangle, Field::time,  Field::instance};
  for (const Field field : request.fields)
    if (field != Field::incidence || !request.effects.sensorMotion.deskew) fields.push_back(field);
  RecordLayout layout = layoutOf(fields);
  layout.compact = number % 2 == 0;
  return layout;
}

/// Requires that the records are the rows of a scan, unless a list was too small for them.
void requireComplete(const Results& results, const Scan& scan, const RecordLayout& layout) {
  const RecordHeader& header = *results.header.as<RecordHeader>();
  CHECK(results.records.guarded());
  if (header.incomplete == 0) requireRows(results.records.bytes().first(header.rows * layout.stride), scan, layout);
}

/// The steps of a request recorded with two frames in flight. If `patient`, each is waited for, and recorded again
/// until no list was too small; otherwise the next one is recorded meanwhile, and incomplete scans are not compared.
void requireRecorded(VulkanApp& app, uint32_t number) {
  Request request = anyRequest(number);
  const bool patient = number % 3 != 0;
  INFO("request " << number << (patient ? "" : ", two in flight") << ":" << request.text);
  std::vector<SensorRequest> onHost = request.sensors, recordedSensors = request.sensors;
  for (size_t i = 0; i < onHost.size(); ++i) {
    recordedSensors[i].layout = layoutFor(request.sensors[i], number);
    for (const RecordLayout::Value& value : recordedSensors[i].layout.values) onHost[i].fields.push_back(value.field);
  }
  SimulatorOptions own = request.options;
  own.device = {DeviceChoice::Kind::vulkan, app.deviceName()};
  Simulator expected(request.scene, onHost, own);
  SimulatorOptions adopted = request.options;
  adopted.device = app.choice();
  adopted.validation = false;
  Simulator recorded(request.scene, recordedSensors, adopted);
  vulkan::Recorder recorder(recorded, 2);

  std::vector<std::unique_ptr<Results>> results;
  std::vector<Scan> scans(request.steps.size());
  VulkanApp::Frame frames[] = {VulkanApp::Frame(app), VulkanApp::Frame(app)};
  const auto record = [&](size_t i) {
    VulkanApp::Frame& frame = frames[i % 2];
    const vulkan::RecordedShot shot = {request.steps[i].shot, results[i]->records.range(), results[i]->header.range()};
    recorder.record(frame.begin(), i % 2, {&shot, 1});
    frame.submit();
  };
  for (size_t i = 0; i < scans.size(); ++i) {
    const Step& step = request.steps[i];
    change(expected, step);
    change(recorded, step);
    expected.scanInto(step.shot, scans[i]);
    const RecordLayout& layout = recordedSensors[step.shot.sensor].layout;
    results.push_back(std::make_unique<Results>(app, layout.bytesFor(scans[i].ranges.size())));
    record(i);
    for (int attempt = 0; patient && attempt < 8; ++attempt) {
      frames[i % 2].wait();
      if (results[i]->header.as<RecordHeader>()->incomplete == 0) break;
      record(i);
    }
  }
  for (VulkanApp::Frame& frame : frames) frame.wait();
  for (size_t i = 0; i < scans.size(); ++i) {
    INFO("shot " << i);
    if (patient) CHECK(results[i]->header.as<RecordHeader>()->incomplete == 0);
    requireComplete(*results[i], scans[i], recordedSensors[request.steps[i].shot.sensor].layout);
  }

  // The last shot from several places, in one recording.
  std::vector<Shot> together(5, request.steps.back().shot);
  const RecordLayout& layout = recordedSensors[together[0].sensor].layout;
  std::vector<std::unique_ptr<Results>> ofTogether;
  std::vector<vulkan::RecordedShot> recordedShots;
  scans.assign(together.size(), {});
  for (size_t i = 0; i < together.size(); ++i) {
    Shot& shot = together[i];
    const Vec3 by = {0.13 * static_cast<double>(i), -0.07 * static_cast<double>(i), 0};
    shot.frame += i;
    shot.pose.position = shot.pose.position + by;
    for (SensorMotion::Stamp& stamp : shot.motion.stamps) stamp.pose.position = stamp.pose.position + by;
    expected.scanInto(shot, scans[i]);
    ofTogether.push_back(std::make_unique<Results>(app, layout.bytesFor(scans[i].ranges.size())));
    recordedShots.push_back({shot, ofTogether[i]->records.range(), ofTogether[i]->header.range()});
  }
  bool incomplete = true;
  for (int attempt = 0; incomplete && attempt < 8; ++attempt) {
    recorder.record(frames[0].begin(), 0, recordedShots);
    frames[0].submit();
    frames[0].wait();
    incomplete = std::ranges::any_of(
        ofTogether, [](const auto& of) { return of->header.template as<RecordHeader>()->incomplete != 0; });
  }
  CHECK_FALSE(incomplete);
  for (size_t i = 0; i < together.size(); ++i) {
    INFO("together, shot " << i);
    requireComplete(*ofTogether[i], scans[i], layout);
  }
}

}  // namespace

TEST_CASE("recorded scans have the bytes of scans on a device of our own for requests drawn at random",
          "[combinations]") {
  needVulkan();
  const CommonApp common;
  VulkanApp& app = common.app;
  for (const uint32_t number : numbersToTry(20)) requireRecorded(app, number);
}

}  // namespace gnosphere::test
