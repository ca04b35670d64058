// SPDX-License-Identifier: Apache-2.0
// Radar: detections from points, and objects from detections.
#include <algorithm>
#include <complex>
#include <limits>

#include "rgl/node.hpp"
#include "rgl/scene.hpp"

namespace gnosphere::rgl {
namespace {

struct Interval {
  float min = std::numeric_limits<float>::max(), max = std::numeric_limits<float>::lowest();
  void add(float value) { min = std::min(min, value), max = std::max(max, value); }
  void add(const Interval& other) { add(other.min), add(other.max); }
  float middle() const { return (min + max) / 2; }
  /// Whether a value lies in the interval, or as near as this beside it.
  bool isNear(float value, float distance) const { return value >= min - distance && value <= max + distance; }
  bool isNear(const Interval& other, float distance) const {
    return other.max >= min - distance && other.min <= max + distance;
  }
};

/// Points that a radar cannot tell apart.
struct Cluster {
  const rgl_radar_scope_t* scope = nullptr;
  std::vector<uint32_t> points;
  Interval distance, azimuth, elevation, speed;

  void add(Cluster&& other) {
    points.insert(points.end(), other.points.begin(), other.points.end());
    distance.add(other.distance), azimuth.add(other.azimuth);
    elevation.add(other.elevation), speed.add(other.speed);
  }
  bool meets(const Cluster& other) const {
    return scope == other.scope && distance.isNear(other.distance, scope->distance_separation_threshold) &&
           azimuth.isNear(other.azimuth, scope->azimuth_separation_threshold) &&
           speed.isNear(other.speed, scope->radial_speed_separation_threshold);
  }
};

/// One detection per cluster of points: that nearest to the cluster's middle direction.
class RadarPostprocessNode : public PointsFilter {
 public:
  static constexpr const char* kName = "RadarPostprocessPointsNode";
  const char* name() const override { return kName; }
  struct Settings {
    std::vector<rgl_radar_scope_t> scopes;
    float azimuthStep, elevationStep, frequency, power, gain, noiseMean, noiseDeviation;
  };
  void set(Settings settings) { settings_ = std::move(settings); }
  Fields required() const override {
    return {RGL_FIELD_XYZ_VEC3_F32,   RGL_FIELD_DISTANCE_F32,     RGL_FIELD_AZIMUTH_F32,
            RGL_FIELD_ELEVATION_F32,  RGL_FIELD_RADIAL_SPEED_F32, RGL_FIELD_RAY_POSE_MAT3x4_F32,
            RGL_FIELD_NORMAL_VEC3_F32};
  }
  bool has(rgl_field_t field) const override {
    return (field >= RGL_FIELD_POWER_F32 && field <= RGL_FIELD_SNR_F32) || PointsFilter::has(field);
  }
  void validate() override {
    PointsFilter::validate();
    if (!input_->isDense())
      throw Failure(RGL_INVALID_PIPELINE, std::string(kName) + " requires dense input; put a compact node before it");
  }
  void run() override {
    const Cloud& from = input_->cloud();
    const std::vector<Cluster> clusters = findClusters(from);
    const float* azimuths = from.values<float>(RGL_FIELD_AZIMUTH_F32);
    const float* elevations = from.values<float>(RGL_FIELD_ELEVATION_F32);
    std::vector<uint32_t> chosen;
    for (const Cluster& cluster : clusters)
      chosen.push_back(*std::min_element(cluster.points.begin(), cluster.points.end(), [&](uint32_t a, uint32_t b) {
        const auto away = [&](uint32_t i) {
          return std::abs(azimuths[i] - cluster.azimuth.middle()) +
                 std::abs(elevations[i] - cluster.elevation.middle());
        };
        return away(a) < away(b);
      }));
    cloud_ = from.select(chosen);
    writeSignals(from, clusters);
  }

 private:
  std::vector<Cluster> findClusters(const Cloud& from) const {
    const float* distances = from.values<float>(RGL_FIELD_DISTANCE_F32);
    const float* azimuths = from.values<float>(RGL_FIELD_AZIMUTH_F32);
    const float* elevations = from.values<float>(RGL_FIELD_ELEVATION_F32);
    const float* speeds = from.values<float>(RGL_FIELD_RADIAL_SPEED_F32);
    std::vector<Cluster> clusters;
    for (uint32_t i = 0; i < from.count; ++i) {
      Cluster point;
      for (const rgl_radar_scope_t& scope : settings_.scopes)
        if (!point.scope && distances[i] >= scope.begin_distance && distances[i] <= scope.end_distance)
          point.scope = &scope;
      if (!point.scope) continue;  // no scope sees it
      point.points = {i};
      point.distance.add(distances[i]), point.azimuth.add(azimuths[i]), point.elevation.add(elevations[i]);
      point.speed.add(std::isnan(speeds[i]) ? 0 : speeds[i]);
      const auto found =
          std::find_if(clusters.begin(), clusters.end(), [&](const Cluster& cluster) { return cluster.meets(point); });
      if (found == clusters.end())
        clusters.push_back(std::move(point));
      else
        found->add(std::move(point));
    }
    for (size_t i = 0; i < clusters.size(); ++i)  // clusters that have grown towards each other
      for (size_t j = i + 1; j < clusters.size(); ++j)
        if (clusters[i].meets(clusters[j])) {
          clusters[i].add(std::move(clusters[j]));
          clusters.erase(clusters.begin() + static_cast<std::ptrdiff_t>(j));
          j = i;
        }
    return clusters;
  }

  // Physical optics: each ray stands for a patch of its solid angle, and the patches of a cluster add up with their
  // phases. sigma = 4 pi / lambda^2 |sum of area * exp(-2 i k d)|^2. The power follows from the radar equation.
  void writeSignals(const Cloud& from, const std::vector<Cluster>& clusters) {
    const float* distances = from.values<float>(RGL_FIELD_DISTANCE_F32);
    const float* elevations = from.values<float>(RGL_FIELD_ELEVATION_F32);
    const double wavelength = 299792458.0 / settings_.frequency;
    auto* power = cloud_.write<float>(RGL_FIELD_POWER_F32);
    auto* rcs = cloud_.write<float>(RGL_FIELD_RCS_F32);
    auto* noise = cloud_.write<float>(RGL_FIELD_NOISE_F32);
    auto* snr = cloud_.write<float>(RGL_FIELD_SNR_F32);
    std::normal_distribution<float> normal;
    for (size_t k = 0; k < clusters.size(); ++k) {
      std::complex<double> sum = 0;
      double distance = 0;
      for (const uint32_t i : clusters[k].points) {
        const double d = distances[i];
        const double area = d * d * settings_.azimuthStep * settings_.elevationStep * std::cos(double{elevations[i]});
        sum += std::polar(area, -4 * M_PI / wavelength * d);
        distance += d / static_cast<double>(clusters[k].points.size());
      }
      const double section = 4 * M_PI / (wavelength * wavelength) * std::norm(sum);
      rcs[k] = static_cast<float>(10 * std::log10(section));
      power[k] = static_cast<float>(settings_.power + settings_.gain + 20 * std::log10(wavelength) + rcs[k] -
                                    30 * std::log10(4 * M_PI) - 40 * std::log10(distance));
      noise[k] = settings_.noiseMean + normal(random_) * std::max(settings_.noiseDeviation, 0.f);
      snr[k] = power[k] - noise[k];
    }
  }

  Settings settings_;
  std::mt19937_64 random_ = randomSource();
};

/// Objects from detections, followed from run to run by their positions.
class RadarTrackNode : public PointsFilter {
 public:
  static constexpr const char* kName = "RadarTrackObjectsPointsNode";
  const char* name() const override { return kName; }
  struct Settings {
    float distance, azimuth, elevation, speed, matching, prediction, sensitivity;
  };
  void set(const Settings& settings) { settings_ = settings; }
  Fields required() const override {
    return {RGL_FIELD_XYZ_VEC3_F32,  RGL_FIELD_DISTANCE_F32,     RGL_FIELD_AZIMUTH_F32,
            RGL_FIELD_ELEVATION_F32, RGL_FIELD_RADIAL_SPEED_F32, RGL_FIELD_ENTITY_ID_I32};
  }
  bool has(rgl_field_t field) const override {
    return field == RGL_FIELD_XYZ_VEC3_F32 || field == RGL_FIELD_ENTITY_ID_I32;
  }
  void run() override {
    const double now = scene().time ? static_cast<double>(*scene().time) * 1e-6 : 0;  // ms
    const std::vector<Vec> objects = objectsIn(input_->cloud());
    // A run that fails leaves the tracks as they were.
    std::vector<Track> tracks = tracks_;
    int32_t nextId = nextId_;
    match(objects, now, tracks, nextId);
    Cloud cloud;
    cloud.count = tracks.size();
    auto* points = cloud.write<Vec>(RGL_FIELD_XYZ_VEC3_F32);
    auto* ids = cloud.write<int32_t>(RGL_FIELD_ENTITY_ID_I32);
    for (size_t i = 0; i < tracks.size(); ++i) {
      points[i] = tracks[i].at(now);
      ids[i] = tracks[i].id;
    }
    cloud_ = std::move(cloud);
    tracks_ = std::move(tracks);
    nextId_ = nextId;
  }

 private:
  struct Track {
    int32_t id;
    Vec position, velocity;  ///< when it was measured last; m per ms
    double time;
    Vec at(double now) const { return position + velocity * static_cast<float>(now - time); }
  };

  // Returns a place per object: detections that are close in every measure belong to one.
  std::vector<Vec> objectsIn(const Cloud& from) const {
    const Vec* points = from.values<Vec>(RGL_FIELD_XYZ_VEC3_F32);
    const float* measures[4] = {from.values<float>(RGL_FIELD_DISTANCE_F32), from.values<float>(RGL_FIELD_AZIMUTH_F32),
                                from.values<float>(RGL_FIELD_ELEVATION_F32),
                                from.values<float>(RGL_FIELD_RADIAL_SPEED_F32)};
    const float limits[4] = {settings_.distance, settings_.azimuth, settings_.elevation, settings_.speed};
    const auto close = [&](uint32_t a, uint32_t b) {
      for (int k = 0; k < 4; ++k)
        if (std::abs(measures[k][a] - measures[k][b]) > limits[k]) return false;
      return true;
    };
    std::vector<uint32_t> left(from.count);
    for (uint32_t i = 0; i < from.count; ++i) left[i] = i;
    std::vector<Vec> objects;
    while (!left.empty()) {
      std::vector<uint32_t> members = {left.back()};
      left.pop_back();
      for (size_t k = 0; k < members.size(); ++k)
        std::erase_if(left, [&](uint32_t other) {
          const bool joins = close(members[k], other);
          if (joins) members.push_back(other);
          return joins;
        });
      Interval x, y, z;
      for (const uint32_t i : members) x.add(points[i].x), y.add(points[i].y), z.add(points[i].z);
      objects.push_back({x.middle(), y.middle(), z.middle()});
    }
    return objects;
  }

  void match(const std::vector<Vec>& objects, double now, std::vector<Track>& tracks, int32_t& nextId) const {
    std::vector<bool> taken(tracks.size());
    const size_t former = tracks.size();
    for (const Vec& object : objects) {
      size_t best = former;
      float least = settings_.matching;
      for (size_t i = 0; i < former; ++i) {
        const float away = length(tracks[i].at(now) - object);
        if (!taken[i] && away <= least) best = i, least = away;
      }
      if (best == former) {
        tracks.push_back({nextId++, object, {}, now});
        continue;
      }
      Track& track = tracks[best];
      taken[best] = true;
      if (now > track.time) {
        track.velocity = (object - track.position) * static_cast<float>(1 / (now - track.time));
        if (length(track.velocity) * 1000 < settings_.sensitivity) track.velocity = {};  // it stands
      }
      track.position = object;
      track.time = now;
    }
    std::erase_if(tracks, [&](const Track& track) { return now - track.time > settings_.prediction; });
  }

  Settings settings_{};
  std::vector<Track> tracks_;
  int32_t nextId_ = 1;
};

}  // namespace
}  // namespace gnosphere::rgl

using namespace gnosphere::rgl;

RGL_API rgl_status_t rgl_node_points_radar_postprocess(rgl_node_t* node, const rgl_radar_scope_t* radar_scopes,
                                                       int32_t radar_scopes_count, float ray_azimuth_step,
                                                       float ray_elevation_step, float frequency,
                                                       float power_transmitted, float cumulative_device_gain,
                                                       float received_noise_mean, float received_noise_st_dev) {
  return call(__func__,
              taped(out(node), arrayOf(radar_scopes, radar_scopes_count), radar_scopes_count, ray_azimuth_step,
                    ray_elevation_step, frequency, power_transmitted, cumulative_device_gain, received_noise_mean,
                    received_noise_st_dev),
              [&] {
                RGL_CHECK(node != nullptr);
                RGL_CHECK(radar_scopes != nullptr);
                RGL_CHECK(radar_scopes_count > 0);
                RGL_CHECK(ray_azimuth_step > 0);
                RGL_CHECK(ray_elevation_step > 0);
                RGL_CHECK(frequency > 0);
                RGL_CHECK(received_noise_st_dev >= 0);
                for (int32_t i = 0; i < radar_scopes_count; ++i) {
                  RGL_CHECK(radar_scopes[i].begin_distance >= 0);
                  RGL_CHECK(radar_scopes[i].end_distance >= radar_scopes[i].begin_distance);
                  RGL_CHECK(radar_scopes[i].distance_separation_threshold >= 0);
                  RGL_CHECK(radar_scopes[i].radial_speed_separation_threshold >= 0);
                  RGL_CHECK(radar_scopes[i].azimuth_separation_threshold >= 0);
                }
                createOrUpdate<RadarPostprocessNode>(node, Affects::graph, [&](auto& made) {
                  made.set({{radar_scopes, radar_scopes + radar_scopes_count},
                            ray_azimuth_step,
                            ray_elevation_step,
                            frequency,
                            power_transmitted,
                            cumulative_device_gain,
                            received_noise_mean,
                            received_noise_st_dev});
                });
              });
}

RGL_API rgl_status_t rgl_node_points_radar_track_objects(rgl_node_t* node, float object_distance_threshold,
                                                         float object_azimuth_threshold,
                                                         float object_elevation_threshold,
                                                         float object_radial_speed_threshold,
                                                         float max_matching_distance, float max_prediction_time_frame,
                                                         float movement_sensitivity) {
  return call(
      __func__,
      taped(out(node), object_distance_threshold, object_azimuth_threshold, object_elevation_threshold,
            object_radial_speed_threshold, max_matching_distance, max_prediction_time_frame, movement_sensitivity),
      [&] {
        RGL_CHECK(node != nullptr);
        RGL_CHECK(object_distance_threshold > 0.0f);
        RGL_CHECK(object_azimuth_threshold > 0.0f);
        RGL_CHECK(object_elevation_threshold > 0.0f);
        RGL_CHECK(object_radial_speed_threshold > 0.0f);
        RGL_CHECK(max_matching_distance > 0.0f);
        RGL_CHECK(max_prediction_time_frame > 0.0f);
        RGL_CHECK(movement_sensitivity >= 0.0f);
        createOrUpdate<RadarTrackNode>(node, Affects::graph, [&](auto& made) {
          made.set({object_distance_threshold, object_azimuth_threshold, object_elevation_threshold,
                    object_radial_speed_threshold, max_matching_distance, max_prediction_time_frame,
                    movement_sensitivity});
        });
      });
}

RGL_API rgl_status_t rgl_node_points_radar_set_classes(rgl_node_t node, const int32_t* entity_ids,
                                                       const rgl_radar_object_class_t* object_classes, int32_t count) {
  return call(__func__, taped(node, arrayOf(entity_ids, count), arrayOf(object_classes, count), count), [&] {
    RGL_CHECK(node != nullptr);
    RGL_CHECK(entity_ids != nullptr);
    RGL_CHECK(object_classes != nullptr);
    RGL_CHECK(count >= 0);
    for (int32_t i = 0; i < count; ++i) RGL_CHECK(object_classes[i] >= 0 && object_classes[i] < RGL_RADAR_CLASS_COUNT);
    nodeAs<RadarTrackNode>(node);  // no field of the results has the classes of objects
  });
}
