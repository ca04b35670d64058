// SPDX-License-Identifier: Apache-2.0
// Snow between the sensor and the points. docs/rgl.md has the model; RGL's own extension is closed.
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/snow.hpp"
#include "rgl/legacy.hpp"
#include "rgl/node.hpp"

namespace gnosphere::rgl {
namespace {

/// The parameters of rgl_node_points_simulate_snow(), in its units.
struct Snow {
  float least, most;  // range in metres
  float rate;         // mm/h of melted water
  float diameter;     // mean of the flakes, in metres
  float speed;        // of their fall, m/s
  float density;      // g/cm^3
  float divergence;   // full angle of a beam, in radians
  bool loss;          // whether flakes take light from what lies behind them
  float threshold;    // share of a beam that the smallest flake with a return covers
};

/// The intensity of a white surface in RGL's textures.
constexpr double kWhite = 255;

class SnowNode : public PointsFilter {
 public:
  static constexpr const char* kName = "SimulateSnowPointsNode";
  const char* name() const override { return kName; }
  Fields required() const override {
    return {RGL_FIELD_XYZ_VEC3_F32, RGL_FIELD_IS_HIT_I32, RGL_FIELD_DISTANCE_F32, RGL_FIELD_RAY_POSE_MAT3x4_F32};
  }

  void set(const Snow& snow) {
    snow_ = snow;
    // Diameters have an exponential distribution, whose mean cube is six times the cube of the mean.
    const double diameter = snow.diameter, share = snow.rate / 3.6e6 / (double{snow.density} * snow.speed);
    const double perVolume = share / (M_PI * diameter * diameter * diameter);
    extinction_ = perVolume * M_PI / 2 * diameter * diameter;
    const double growth = perVolume * M_PI / 4 * snow.divergence * snow.divergence,
                 decay = std::sqrt(double{snow.threshold}) * snow.divergence / diameter;
    const auto perMetre = [&](double range) { return growth * range * range * std::exp(-decay * range); };
    end_ = std::min(double{snow.most}, endOfFlakes(snow.least, growth, decay));
    expected_[0] = 0;
    for (int i = 0; i < kSteps; ++i)
      expected_[i + 1] =
          expected_[i] + (perMetre(rangeOf(i)) + perMetre(rangeOf(i + 1))) / 2 * (rangeOf(i + 1) - rangeOf(i));
  }

 protected:
  void run() override {
    cloud_ = input_->cloud();
    const Columns to(cloud_);
    std::exponential_distribution<double> exponential;
    for (size_t i = 0; i < cloud_.count; ++i) {
      // Both are drawn for every point, so that the others stay as they are when one becomes another.
      const double flake = rangeOfExpected(exponential(random_)), size = exponential(random_);
      if (flake < (to.hit[i] ? double{to.distance[i]} : std::numeric_limits<double>::infinity()))
        putFlake(to, i, flake, size);
      else if (to.hit[i] && snow_.loss)
        to.scaleIntensity(i, transmission(to.distance[i]));
    }
  }

 private:
  static constexpr int kSteps = 1024;

  /// The columns that a flake changes; null pointers for those that are not there.
  struct Columns {
    explicit Columns(Cloud& cloud) {
      const auto column = [&]<class T>(T*& to, rgl_field_t field) {
        if (!cloud.has(field)) return;
        const T* from = cloud.values<T>(field);
        const auto kept = cloud.columns.at(field).bytes;
        std::copy_n(from, cloud.count, to = cloud.write<T>(field));
      };
      poses = cloud.values<Mat>(RGL_FIELD_RAY_POSE_MAT3x4_F32);
      column(xyz, RGL_FIELD_XYZ_VEC3_F32);
      column(hit, RGL_FIELD_IS_HIT_I32);
      column(distance, RGL_FIELD_DISTANCE_F32);
      column(intensity, RGL_FIELD_INTENSITY_F32);
      column(intensity8, RGL_FIELD_INTENSITY_U8);
      column(entity, RGL_FIELD_ENTITY_ID_I32);
      column(retro, RGL_FIELD_LASER_RETRO_F32);
      column(incident, RGL_FIELD_INCIDENT_ANGLE_F32);
      column(radialSpeed, RGL_FIELD_RADIAL_SPEED_F32);
      column(reflectivity, RGL_FIELD_REFLECTIVITY_F32);
      column(normal, RGL_FIELD_NORMAL_VEC3_F32);
      column(velocity, RGL_FIELD_ABSOLUTE_VELOCITY_VEC3_F32);
      column(relative, RGL_FIELD_RELATIVE_VELOCITY_VEC3_F32);
    }
    void scaleIntensity(size_t i, double share) const {
      if (intensity) intensity[i] = static_cast<float>(intensity[i] * share);
      if (intensity8) intensity8[i] = static_cast<uint8_t>(std::round(intensity8[i] * share));
      if (reflectivity) reflectivity[i] = static_cast<float>(reflectivity[i] * share);
    }

    const Mat* poses;
    Vec *xyz = nullptr, *normal = nullptr, *velocity = nullptr, *relative = nullptr;
    int32_t *hit = nullptr, *entity = nullptr;
    float *distance = nullptr, *intensity = nullptr, *retro = nullptr, *incident = nullptr, *radialSpeed = nullptr,
          *reflectivity = nullptr;
    uint8_t* intensity8 = nullptr;
  };

  /// The range beyond which no beam meets its first flake, where a beam meets growth * r^2 * exp(-decay * r) per metre.
  static double endOfFlakes(double least, double growth, double decay) {
    // As long as decay * r < 1, a beam meets more than growth / e / 3 * (r^3 - least^3) flakes. No number that is drawn
    // is greater than 40: its probability is exp(-40).
    const double certain = std::cbrt(least * least * least + 3 * M_E * 40 / growth);
    if (decay * certain < 1) return certain;
    return least + 60 / decay;  // what is left there is exp(-60) of the flakes
  }
  /// Steps grow with the range, so that they are small wherever between the two ranges the first flakes are.
  double rangeOf(int step) const {
    const double share = static_cast<double>(step) / kSteps;
    return snow_.least + (end_ - snow_.least) * share * share * share;
  }
  /// Returns the range up to which a beam meets `number` flakes on average; infinity if it never meets so many.
  double rangeOfExpected(double number) const {
    const double* next = std::upper_bound(expected_, expected_ + kSteps + 1, number);
    if (next == expected_ + kSteps + 1) return std::numeric_limits<double>::infinity();
    const int step = static_cast<int>(next - expected_) - 1;
    return rangeOf(step) + (number - next[-1]) / (next[0] - next[-1]) * (rangeOf(step + 1) - rangeOf(step));
  }
  double transmission(double range) const { return std::exp(-2 * extinction_ * std::max(0.0, range - snow_.least)); }

  void putFlake(const Columns& to, size_t i, double range, double size) const {
    const Mat& pose = to.poses[i];
    const auto metres = static_cast<float>(range);
    to.xyz[i] = pose.translation() + unit({pose.m[0][2], pose.m[1][2], pose.m[2][2]}) * metres;
    to.hit[i] = 1;
    to.distance[i] = metres;
    // A flake is as wide as the threshold says, and more, by an exponential distribution.
    const double share =
        std::min(1.0, std::sqrt(double{snow_.threshold}) + size * snow_.diameter / (snow_.divergence * range));
    const double intensity = kWhite * kFlakeReflectance * share * share * (snow_.loss ? transmission(range) : 1);
    if (to.intensity) to.intensity[i] = static_cast<float>(intensity);
    if (to.intensity8) to.intensity8[i] = static_cast<uint8_t>(std::round(intensity));
    const float none = std::numeric_limits<float>::quiet_NaN();
    for (Vec* vectors : {to.normal, to.velocity, to.relative})
      if (vectors) vectors[i] = {none, none, none};
    if (to.incident) to.incident[i] = none;
    if (to.entity) to.entity[i] = RGL_DEFAULT_ENTITY_ID;  // 0 would say that the ray hits nothing
    for (float* values : {to.retro, to.radialSpeed, to.reflectivity})
      if (values) values[i] = 0;
  }

  Snow snow_{};
  double extinction_ = 0, end_ = 0;
  double expected_[kSteps + 1] = {};  // flakes that a beam meets up to the end of each step
  std::mt19937_64 random_ = randomSource();
};

}  // namespace
}  // namespace gnosphere::rgl

using namespace gnosphere::rgl;

RGL_API rgl_status_t rgl_node_points_simulate_snow(rgl_node_t* node, float min_range, float max_range, float rain_rate,
                                                   float mean_snowflake_diameter, float terminal_velocity,
                                                   float density, int32_t num_channels, float beam_divergence,
                                                   bool do_simulate_energy_loss, float snowflake_occupancy_threshold) {
  if (level() < 18) {  // callers of these levels pass eight arguments after the node
    do_simulate_energy_loss = true;
    snowflake_occupancy_threshold = 0.2f;
  }
  return call(__func__,
              taped(out(node), min_range, max_range, rain_rate, mean_snowflake_diameter, terminal_velocity, density,
                    num_channels, beam_divergence, do_simulate_energy_loss, snowflake_occupancy_threshold),
              [&] {
                RGL_CHECK(node != nullptr);
                RGL_CHECK(min_range >= 0);
                RGL_CHECK(max_range > min_range && std::isfinite(max_range));
                RGL_CHECK(rain_rate >= 0 && std::isfinite(rain_rate));
                RGL_CHECK(mean_snowflake_diameter > 0);
                RGL_CHECK(terminal_velocity > 0);
                RGL_CHECK(density > 0);
                RGL_CHECK(num_channels > 0);
                RGL_CHECK(beam_divergence >= 0);
                RGL_CHECK(snowflake_occupancy_threshold >= 0 && snowflake_occupancy_threshold <= 1);
                createOrUpdate<SnowNode>(node, Affects::node, [&](auto& made) {
                  made.set({min_range, max_range, rain_rate, mean_snowflake_diameter, terminal_velocity, density,
                            beam_divergence, do_simulate_energy_loss, snowflake_occupancy_threshold});
                });
              });
}
