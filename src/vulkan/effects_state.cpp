// SPDX-License-Identifier: Apache-2.0
#include "vulkan/effects_state.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "effects/device_parameters.hpp"
#include "effects/noise.h"

namespace gnosphere::vulkan {
namespace {

// Of any module of the footprint.
constexpr size_t kMostSubRays = 61;

// Texels of all images, one after the other, and where each lies.
struct PackedImages {
  std::vector<std::array<uint32_t, 4>> images;  // width, height, first byte, how it wraps: u | v << 8
  std::vector<uint8_t> texels;
};

PackedImages packed(const std::vector<AlphaImage>& images) {
  PackedImages result;
  for (const AlphaImage& image : images) {
    const auto wraps = static_cast<uint32_t>(image.wrapU) | static_cast<uint32_t>(image.wrapV) << 8;
    result.images.push_back({image.width, image.height, static_cast<uint32_t>(result.texels.size()), wraps});
    result.texels.insert(result.texels.end(), image.alpha.begin(), image.alpha.end());
  }
  result.texels.resize((result.texels.size() + 3) / 4 * 4);
  return result;
}

template <typename T>
void write(Buffer& buffer, std::span<const T> data) {
  std::memcpy(buffer.mapped(), data.data(), data.size_bytes());
  buffer.flush();
}

}  // namespace

std::vector<gpu::Optics4> packedOptics(const Scene& scene, const SimulatorOptions& options) {
  std::vector<gpu::Optics4> result;
  for (const Optics& optics : opticsOf(scene, options.materials, options.effects.intensity.wavelength)) {
    const Material& material = scene.materials[result.size()];
    const bool mask = material.alphaMode == AlphaMode::mask;
    gpu::Optics4 packed = {};
    packed.reflection = {optics.reflectance, optics.gloss, optics.roughness, optics.retro};
    packed.passage = {optics.transmission, mask ? material.alphaCutoff : 0, material.baseColor[3],
                      std::bit_cast<float>(mask ? material.alphaImage : gpu::kNone)};
    result.push_back(packed);
  }
  return result;
}

std::vector<Output> outputsOf(const PlannedEffects& planned) {
  const uint32_t four = planned.returns * sizeof(gpu::vec4), two = planned.returns * 2 * sizeof(uint32_t);
  std::vector<Output> outputs = {{gpu::kBindPoints, four}, {gpu::kBindOwners, two}};
  if (planned.asks(gpu::kFieldSignal)) outputs.push_back({gpu::kBindSignals, four});
  if (planned.asks(gpu::kFieldSurface)) outputs.push_back({gpu::kBindSurfaces, four});
  if (planned.speeds()) outputs.push_back({gpu::kBindMotions, four});
  if (planned.asks(gpu::kFieldBarycentrics)) outputs.push_back({gpu::kBindBarycentrics, two});
  return outputs;
}

uint64_t bytesPerBeam(const PlannedEffects& planned) {
  uint64_t most = sizeof(uint64_t);  // a word
  for (const Output& output : outputsOf(planned)) most = std::max<uint64_t>(most, output.bytesPerBeam);
  if (planned.footprint()) most = std::max<uint64_t>(most, gpu::kMaxEchoes * sizeof(gpu::vec4));
  return most;
}

EffectsState::EffectsState(const Device& device, const EffectsSetup& setup, std::span<const gpu::Row> rows,
                           const Sensor& part, uint64_t firstBeam, bool copied)
    : device_(device),
      setup_(setup),
      parameters_(effectParameters(setup.effects, setup.sensor, setup.planned.bits)),
      subRays_(subRays(setup.effects, setup.sensor, setup.planned.bits)) {
  parameters_.sensor = setup.sensorIndex;
  parameters_.firstBeam = static_cast<uint32_t>(firstBeam);
  parameters_.returnsPerBeam = setup.planned.returns;
  const PlannedEffects& planned = setup_.planned;
  const uint64_t beams = part.beamCount();
  Uploader uploader(device);
  if (planned.motion()) {
    std::vector<gpu::vec4> origins;
    for (const gpu::Row& row : rows) {
      const Vec3& origin = part.channels[static_cast<size_t>(row.angles.w)].origin;
      origins.push_back({static_cast<float>(origin.x), static_cast<float>(origin.y), static_cast<float>(origin.z), 0});
    }
    buffers_[gpu::kBindRowOrigins] = uploader.upload<gpu::vec4>("rowOrigins", origins);
  }
  if (planned.footprint()) {
    std::vector<gpu::vec4> lines;
    for (const SubRay& ray : subRays_)
      lines.push_back({ray.u, ray.v, ray.weight, std::sqrt(1 + ray.u * ray.u + ray.v * ray.v)});
    lines.resize(kMostSubRays, {0, 0, 0, 1});  // those that a module has and the footprint has not
    buffers_[gpu::kBindSubRays] = uploader.upload<gpu::vec4>("subRays", lines);
    make(gpu::kBindHardBeams, "hardBeams", beams * sizeof(uint32_t));
    make(gpu::kBindEchoCounts, "echoCounts", beams * sizeof(uint32_t));
    make(gpu::kBindEchoes, "echoes", beams * gpu::kMaxEchoes * sizeof(gpu::vec4));
    make(gpu::kBindEchoOwners, "echoOwners", beams * gpu::kMaxEchoes * 2 * sizeof(uint32_t));
    if (planned.asks(gpu::kFieldSurface))
      make(gpu::kBindEchoSurfaces, "echoSurfaces", beams * gpu::kMaxEchoes * sizeof(gpu::vec4));
  }
  if (planned.footprint() || planned.surfaces()) {
    buffers_[gpu::kBindOptics] = uploader.upload<gpu::Optics4>("optics", setup_.optics);
  }
  if (planned.has(gpu::kCutOuts)) {
    const PackedImages images = packed(setup_.alphaImages);
    buffers_[gpu::kBindAlphaImages] = uploader.upload<std::array<uint32_t, 4>>("alphaImages", images.images);
    buffers_[gpu::kBindTexels] = uploader.upload<uint8_t>("texels", images.texels);
  }
  if (const auto dead = deadBeamBits(setup_.effects, setup_.sensor); planned.has(gpu::kDropOut) && !dead.empty())
    buffers_[gpu::kBindDeadBeams] = uploader.upload<uint32_t>("deadBeams", dead);
  for (const Output& output : outputsOf(planned))
    if (copied && output.binding >= gpu::kWorkBindingCount)
      make(output.binding, "results", beams * output.bytesPerBeam);
  // What is looked at but not asked for stays on the device.
  if (planned.surfaces() && !planned.footprint() && !planned.asks(gpu::kFieldSurface))
    make(gpu::kBindSurfaces, "surfaces", beams * planned.returns * sizeof(gpu::vec4));
}

void EffectsState::make(uint32_t binding, const char* name, uint64_t bytes) {
  buffers_[binding] = Buffer(device_, name, bytes, Memory::device);
}

float EffectsState::footprint() const {
  const PlannedEffects& planned = setup_.planned;
  if (!planned.footprint()) return 0;
  double most = 0;
  for (const SubRay& ray : subRays_) most = std::max(most, std::hypot(double{ray.u}, double{ray.v}));
  const Effects::AngleNoise& noise = setup_.effects.angleNoise;
  if (planned.has(gpu::kStrays)) most += gpu::kAngleCutOff * std::hypot(noise.azimuth, noise.elevation);
  return static_cast<float>(most * 1.0001);
}

void EffectsState::growProjected(uint64_t count) {
  if (setup_.planned.footprint()) make(gpu::kBindProjectedMaterials, "projectedMaterials", count * sizeof(uint32_t));
  if (setup_.planned.has(gpu::kCutOuts))
    make(gpu::kBindProjectedTexture, "projectedTexture", count * 2 * sizeof(gpu::vec4));
  if (setup_.planned.has(gpu::kObjectMotion))
    make(gpu::kBindProjectedMotions, "projectedMotions", count * 3 * sizeof(gpu::vec4));
}

EffectsFrame EffectsState::makeFrame() const {
  EffectsFrame frame;
  const auto make = [&](Buffer& buffer, const char* name, uint64_t bytes) {
    buffer = Buffer(device_, name, bytes, Memory::upload);
  };
  if (setup_.planned.signals()) make(frame.parameters, "parameters", sizeof(gpu::EffectParameters));
  if (setup_.planned.has(gpu::kVolumes))
    make(frame.volumes, "volumes", setup_.effects.volumes.boxes.size() * sizeof(gpu::VolumeBox));
  if (setup_.planned.motion()) {
    make(frame.columnMotions, "columnMotions", setup_.sensor.columns * sizeof(gpu::ColumnMotion));
    make(frame.motionBounds, "motionBounds", sizeof(gpu::MotionBounds));
    make(frame.instanceMotions, "instanceMotions", 0);
  }
  return frame;
}

void EffectsState::prepare(EffectsFrame& frame, const Shot& shot, const ShotMotion* motion) const {
  if (motion) {
    write<gpu::ColumnMotion>(frame.columnMotions, motion->tables.columns);
    write<gpu::MotionBounds>(frame.motionBounds, {&motion->tables.bounds, 1});
    if (frame.instanceMotions.bytes() < motion->instances.size() * sizeof(gpu::InstanceMotion))
      frame.instanceMotions =
          Buffer(device_, "instanceMotions", motion->instances.size() * sizeof(gpu::InstanceMotion), Memory::upload);
    if (!motion->instances.empty()) write<gpu::InstanceMotion>(frame.instanceMotions, motion->instances);
  }
  if (frame.parameters.handle()) {
    gpu::EffectParameters parameters = parameters_;
    parameters.frame = static_cast<uint32_t>(shot.frame);
    write<gpu::EffectParameters>(frame.parameters, {&parameters, 1});
  }
  if (frame.volumes.handle()) write<gpu::VolumeBox>(frame.volumes, volumeBoxes(setup_.effects, shot.pose));
}

void EffectsState::bind(const EffectsFrame& frame, Bindings& bindings) const {
  for (size_t i = gpu::kWorkBindingCount; i < bindings.size(); ++i)
    if (buffers_[i].handle()) bindings[i] = &buffers_[i];
  const auto put = [&](uint32_t binding, const Buffer& buffer) {
    if (buffer.handle()) bindings[binding] = &buffer;
  };
  put(gpu::kBindParameters, frame.parameters);
  put(gpu::kBindVolumes, frame.volumes);
  put(gpu::kBindInstanceMotions, frame.instanceMotions);
  put(gpu::kBindColumnMotions, frame.columnMotions);
  put(gpu::kBindMotionBounds, frame.motionBounds);
}

uint64_t EffectsState::bytes() const {
  uint64_t sum = 0;
  for (const Buffer& buffer : buffers_) sum += buffer.bytes();
  return sum;
}

void EffectsState::list(std::vector<Plan::Buffer>& to) const {
  for (const Buffer& buffer : buffers_)
    if (buffer.bytes() > 0) to.push_back({buffer.name(), buffer.bytes()});
}

}  // namespace gnosphere::vulkan
