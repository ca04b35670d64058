// SPDX-License-Identifier: Apache-2.0
// Everything that follows from one sensor's request in one scene. The plan is computed once and read by every backend.
#pragma once

#include <array>
#include <memory>

#include "common/effects/bits.h"
#include "effects/formula_inputs.hpp"
#include "gnosphere/plan.hpp"
#include "gnosphere/simulator.hpp"
#include "sensor/beams.hpp"
#include "sensor/row_grid.hpp"

namespace gnosphere {

/// The alpha images of a scene in the layout that devices read.
struct TextureArrays {
  std::vector<std::array<uint32_t, 4>> images;  ///< width, height, first texel, wrapping of u | of v << 8
  std::vector<uint8_t> texels;                  ///< alpha of all images, padded to four bytes
};

/// Largest angles between light and the axis of its beam, in radians.
struct AngularSpread {
  float angle = 0;           ///< in any direction
  float across = 0, up = 0;  ///< in azimuth, times the cosine of the elevation; in elevation
};

/// Returns the largest tangent of the elevation of a beam, upwards or downwards. The tangent of a beam to a pole counts
/// as finite, so that 0 times the result is 0 and not NaN.
double steepestTangent(const Sensor& sensor);

struct SensorPlan {
  Sensor sensor;
  Effects effects;  ///< as requested
  std::vector<Plan::Decision> decisions;
  uint32_t bits = 0;              ///< bits of effects/bits.h: planned effects, kStrays, kFootprint and kSpeedNoise
  uint32_t fields = 0;            ///< gpu::kField... bits of the requested fields
  uint32_t returns = 1;           ///< per beam
  RecordLayout layout;            ///< of results that stay on the device; empty if the host reads them
  bool listed = false;            ///< the beams are a list, in places or cells of a grid
  std::optional<RowGrid> rows;    ///< of a grid whose beams need places of their own; then they are no list
  bool origins = false;           ///< some lasers have an origin other than zero
  std::vector<uint8_t> ignored;   ///< by instance: 1 if scans leave it out; may be shorter than the instances
  bool looksAtMaterials = false;  ///< the intensity depends on the surface that is hit

  // Inputs of the device's formulas. The reference computes its own.
  gpu::EffectParameters parameters = {};          ///< for frame 0
  std::vector<SubRay> subRays;                    ///< shared by all footprints; a single one without divergence
  std::vector<uint32_t> deadBeams;                ///< one bit per beam; empty if no beam is dead
  AngularSpread spread;                           ///< how far light is from its beam's axis
  std::vector<gpu::Optics4> optics;               ///< per material of the scene, at the wavelength of the sensor
  std::shared_ptr<const TextureArrays> textures;  ///< shared by the sensors of a scene; null without cut-outs

  bool has(uint32_t anyOf) const { return (bits & anyOf) != 0; }
  bool asks(uint32_t anyOf) const { return (fields & anyOf) != 0; }
  /// Whether the hits of beams are found from their footprints; see kFootprint.
  bool footprint() const { return has(gpu::kFootprint); }
  /// Whether beams may start away from the sensor's origin, or sensor or instances may move during a scan.
  bool motion() const { return moves() || origins; }
  /// Whether the sensor or instances may move during a scan.
  bool moves() const { return has(gpu::kSensorMotion | gpu::kObjectMotion) || speeds(); }
  /// Whether the stages compute the surface of each hit.
  bool surfaces() const { return looksAtMaterials || asks(gpu::kSurfaceFields); }
  bool holes() const { return has(gpu::kCutOuts); }
  /// Whether every point without deskew lies on the axis of its beam, seen from the sensor's origin, and away from it;
  /// range noise may move a point to the origin.
  bool pointsTellDirections() const { return !origins && !has(gpu::kAngleNoise | gpu::kRangeNoise); }
  /// Whether light may pass surfaces and beams are single lines: opaque triangles are binned first, then panes.
  bool panes() const { return has(gpu::kTransmission) && !footprint(); }
  /// Whether the stages read the optics of materials.
  bool looksAtOptics() const { return surfaces() || has(gpu::kFootprintEffects); }
  /// Whether the stages compute the signal of each return, because an effect or a field needs it.
  bool signals() const { return has(gpu::kSignalEffects) || asks(gpu::kFieldSignal | gpu::kFieldIntensity); }
  bool speeds() const { return has(gpu::kRadialSpeed) || asks(gpu::kFieldMotion); }
  /// Largest number of surfaces that a sub-ray hits.
  uint32_t layers() const { return has(gpu::kTransmission) ? gpu::kMaxLayers : 1; }
  /// Whether only geometry is planned.
  bool bare() const { return !footprint() && !motion() && !surfaces() && !signals() && !speeds(); }
  /// Whether the only return of a beam that meets no pane is the nearest hit of its line, and no field asks for more:
  /// geometry, in which surfaces may have holes and let light pass, beams may deviate, and sensor and instances may
  /// move.
  bool onlyLines() const;
  /// Whether points lie on the axes of their beams, as seen from the lasers: with words, ranges are then enough.
  bool pointsOnAxes() const { return !has(gpu::kAngleNoise) || has(gpu::kStrays); }
  /// Whether stage effects computes the results of all beams.
  bool computesReturns() const { return !onlyLines() && (signals() || speeds() || surfaces()); }
};

/// Makes the plans of sensors. When the scene changes, plan() is called again with the changed scene.
class SensorPlanner {
 public:
  explicit SensorPlanner(const SimulatorOptions& options) : options_(options) {}

  /// Makes the plan of a sensor. `scene` needs no vertices and no triangles. `index` is the index of the sensor, part
  /// of the key of the random numbers. Throws Error(invalidArgument) as decide() and leaveOutUnsupported() do.
  /// `changed` tells that the scene has changed since the sensor was added: an effect that is on then stays planned
  /// even if the scene can no longer show it.
  std::shared_ptr<const SensorPlan> plan(const Scene& scene, const SensorRequest& request, size_t index, bool changed);
  /// Drops the textures that plans share; to be called after the images of the scene have changed.
  void forgetTextures() { textures_.reset(); }

 private:
  const SimulatorOptions& options_;
  std::shared_ptr<const TextureArrays> textures_;
};

/// Returns whether the plan `after` ignores the same instances as the plan `before`, and can use the arrays and kernels
/// made for it, but for the optics.
bool sameButOptics(const SensorPlan& before, const SensorPlan& after);
/// The same with the optics.
bool sameArrays(const SensorPlan& before, const SensorPlan& after);

/// Returns the effects for one shot: those of the plan, with the shot's weather if it has any.
Effects effectsOf(const SensorPlan& plan, const Shot& shot);
/// Returns whether a scan simulates that instances move. Instances stand still if all beams fire at the start of the
/// scan, because a motion would take no time.
bool instancesMove(const SensorPlan& plan, const Shot& shot);
/// Throws Error(invalidArgument), whose message begins with `which`, if the weather is not planned or a value is out of
/// range.
void checkWeather(const SensorPlan& plan, const Weather& weather, const std::string& which);

/// Resizes the planned arrays of a scan and empties the others. If `cleared`, every entry is set to a miss. The
/// reference makes the arrays of ties and tolerances itself.
void resizeArrays(const SensorPlan& plan, Scan& scan, bool cleared = false);

}  // namespace gnosphere
