// SPDX-License-Identifier: Apache-2.0
#include "variants.hpp"

#include <cmath>
#include <numbers>
#include <set>

#include "base/quaternion.hpp"

namespace gnosphere::bench {
namespace {

struct VariantRow {
  const char* name;
  const char* effect;
  std::vector<const char*> assignments;
  std::vector<Field> fields = {};
  Ranges ranges = Ranges::other;
};

// 0.00087 rad are 0.05 degrees. `auto` is used where the scene decides whether the effect applies.
const std::vector<VariantRow> kRows = {
    {"intensity", "intensity", {"intensity=on"}, {Field::intensity}, Ranges::same},
    {"detection, 10 % at 50 m", "detection", {"detection.reflectance=0.1", "detection.range=50"}, {}, Ranges::same},
    {"drop-out, 10 %", "drop-out", {"drop-out.general_rate=0.1"}, {}, Ranges::same},
    {"range noise, 2 cm", "range-noise", {"range-noise.sigma=0.02"}, {}, Ranges::same},
    {"angle noise of points, 0.05 deg",
     "angle-noise",
     {"angle-noise.azimuth=0.00087", "angle-noise.elevation=0.00087", "angle-noise.at=point"},
     {},
     Ranges::same},
    {"angle noise of beams, 0.05 deg",
     "angle-noise",
     {"angle-noise.azimuth=0.00087", "angle-noise.elevation=0.00087", "angle-noise.at=beam"}},
    {"intensity noise, 5 %", "intensity-noise", {"intensity-noise.sigma=0.05"}, {Field::intensity}, Ranges::same},
    {"1 sub-ray", "divergence", {"divergence.sub_rays=1"}, {}, Ranges::near},
    {"7 sub-rays", "divergence", {"divergence.sub_rays=7"}},
    {"19 sub-rays", "divergence", {"divergence.sub_rays=19"}},
    {"37 sub-rays", "divergence", {"divergence.sub_rays=37"}},
    {"61 sub-rays", "divergence", {"divergence.sub_rays=61"}},
    {"returns, 3", "returns", {"returns=on"}, {}, Ranges::near},
    {"transmission", "transmission", {"transmission=auto"}},
    {"cut-outs", "cut-outs", {"cut-outs=auto"}},
    {"sensor motion, 15 m/s", "sensor-motion", {"sensor-motion=on"}},
    {"object motion, 10 m/s", "object-motion", {"object-motion=on"}},
    {"fog, 200 m", "fog", {"fog.visibility=200"}, {}, Ranges::same},
    {"rain, 20 mm/h", "rain", {"rain.rate=20"}, {}, Ranges::same},
    {"snow, 2 mm/h", "snow", {"snow.rate=2"}, {}, Ranges::same},
    {"a box of dust", "volumes", {"volumes=on"}, {}, Ranges::same},
    {"radial speed", "radial-speed", {"radial-speed=on"}, {Field::radialSpeed}, Ranges::same},
};

}  // namespace

std::vector<Variant> variantsOf(const Vec3& dust) {
  Effects none = Effects::none();
  none.intensity.use = EffectUse::automatic;
  none.volumes.boxes = {{{dust.x - 5, dust.y - 5, dust.z - 5}, {dust.x + 5, dust.y + 5, dust.z + 5}, 0.1}};
  std::vector<Variant> variants;
  Variant all = {"all of them", "", none, {Field::intensity, Field::radialSpeed}, Ranges::other};
  for (const VariantRow& row : kRows) {
    Variant variant = {row.name, row.effect, none, row.fields, row.ranges};
    for (const char* assignment : row.assignments) {
      assign(variant.request, assignment);
      assign(all.request, assignment);
    }
    variants.push_back(variant);
  }
  assign(all.request, "divergence.sub_rays=19");
  variants.push_back(all);
  return variants;
}

SensorMotion drivenFrom(const Pose& pose, double seconds) {
  const double metres = 15 * seconds, half = 0.5 * 30 * std::numbers::pi / 180 * seconds;
  const Quaternion& q = pose.orientation;
  const Quaternion turn = {0, 0, std::sin(half), std::cos(half)};  // about the sensor's z axis
  return {{{0, pose}, {seconds, {pose.position + metres * (q * Vec3{1, 0, 0}), q * turn}}}};
}

std::vector<InstanceMotion> drivenVehicles(const Scene& scene, double seconds) {
  static const std::set<std::string> kVehicles = {"hatchback", "saloon", "estate", "van", "bus"};
  std::vector<InstanceMotion> vehicles, all;
  for (size_t i = 0; i < scene.instances.size(); ++i) {
    const Instance& instance = scene.instances[i];
    const Transform along = {{1, 0, 0, 10 * seconds, 0, 1, 0, 0, 0, 0, 1, 0}};
    all.push_back({i, instance.transform * along});
    if (kVehicles.count(scene.meshes[instance.mesh].name) > 0) vehicles.push_back(all.back());
  }
  return vehicles.empty() ? all : vehicles;
}

}  // namespace gnosphere::bench
