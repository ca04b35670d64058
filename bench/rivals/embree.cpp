// SPDX-License-Identifier: Apache-2.0
#include "rivals/embree.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <stdexcept>

#include "console.hpp"
#include "gnosphere/error.hpp"
#include "rivals/embree_trace.hpp"
#include "rivals/workers.hpp"

#ifdef __SSE3__
#include <pmmintrin.h>
#endif

namespace gnosphere::bench {
namespace {

/// Transform from the mesh frame to the scene's frame: relative to `origin`, including the mesh's own origin.
Transform relativeTo(const Vec3& origin, const Transform& transform, const Vec3& meshOrigin) {
  Transform from, to;
  from.rows = {1, 0, 0, meshOrigin.x, 0, 1, 0, meshOrigin.y, 0, 0, 1, meshOrigin.z};
  to.rows = {1, 0, 0, -origin.x, 0, 1, 0, -origin.y, 0, 0, 1, -origin.z};
  return to * (transform * from);
}

/// Embree reads 16 bytes at every vertex, beyond the end of the last one.
constexpr size_t kPadding = 1;

class Embree : public EmbreeRival {
 public:
  Embree(const Scene& scene, const Vec3& origin, EmbreeWay way) : scene_(scene), origin_(origin), way_(way) {
    device_ = rtcNewDevice(nullptr);
    if (!device_) throw Error(ErrorCode::device, "Embree has no device here");
    rtcSetDeviceMemoryMonitorFunction(device_, count, &bytes_);
    for (const Instance& instance : scene.instances) transforms_.push_back(instance.transform);
    const size_t sets = instanced() ? scene.meshes.size() : scene.instances.size();
    vertices_.resize(sets);
    workers_.run(sets, [&](size_t set) { fill(set); });
  }
  ~Embree() override {
    clear();
    rtcReleaseDevice(device_);
  }

  std::string name() const override {
    constexpr const char* kWays[] = {"flat", "instanced", "rebuilt", "instances rebuilt", "refitted"};
    const auto number = [&](RTCDeviceProperty property) {
      return std::to_string(rtcGetDeviceProperty(device_, property));
    };
    return "Embree " + number(RTC_DEVICE_PROPERTY_VERSION_MAJOR) + "." + number(RTC_DEVICE_PROPERTY_VERSION_MINOR) +
           "." + number(RTC_DEVICE_PROPERTY_VERSION_PATCH) + ", " + kWays[static_cast<size_t>(way_)];
  }

  double build() override {
    clear();
    const double start = cli::nowMs();
    top_ = newScene();
    if (instanced()) {
      attachInstances();
    } else {
      for (size_t i = 0; i < transforms_.size(); ++i) attach(top_, i, scene_.instances[i].mesh);
    }
    rtcCommitScene(top_);
    check();
    return cli::nowMs() - start;
  }

  double update(std::span<const Moved> moved) override {
    for (const Moved& move : moved) transforms_[move.instance] = move.transform;
    if (!instanced()) workers_.run(moved.size(), [&](size_t i) { fill(moved[i].instance); });
    if (way_ == EmbreeWay::flat || way_ == EmbreeWay::rebuilt) return build();
    const double start = cli::nowMs();
    if (instanced()) {
      workers_.run(moved.size(), [&](size_t i) { place(moved[i].instance); });
    } else {
      for (const Moved& move : moved) {
        const RTCGeometry geometry = rtcGetGeometry(top_, static_cast<unsigned>(move.instance));
        rtcUpdateGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0);
        rtcCommitGeometry(geometry);
      }
    }
    rtcCommitScene(top_);
    check();
    return cli::nowMs() - start;
  }

  double trace(const Sensor& sensor, const Pose& pose, Hits& hits) override {
    table_.prepare(sensor, pose.orientation);
    hits.resize(sensor.beamCount());
    const double start = cli::nowMs();
    const float origin[3] = {static_cast<float>(pose.position.x - origin_.x),
                             static_cast<float>(pose.position.y - origin_.y),
                             static_cast<float>(pose.position.z - origin_.z)};
    const float near = static_cast<float>(sensor.rangeMin), far = static_cast<float>(sensor.rangeMax);
    const std::vector<Packet>& packets = table_.packets();
    constexpr size_t kShare = 32;  // packets: a share takes about 10 us
    workers_.run((packets.size() + kShare - 1) / kShare, [&](size_t share) {
#ifdef __SSE3__
      _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_ON);  // required by Embree's manual
      _MM_SET_DENORMALS_ZERO_MODE(_MM_DENORMALS_ZERO_ON);
#endif
      const size_t end = std::min(packets.size(), (share + 1) * kShare);
      for (size_t p = share * kShare; p < end; ++p) tracePacket(top_, packets[p], origin, near, far, instanced(), hits);
#ifdef __SSE3__
      _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_OFF);
      _MM_SET_DENORMALS_ZERO_MODE(_MM_DENORMALS_ZERO_OFF);
#endif
    });
    return cli::nowMs() - start;
  }

  double trace(const Lines& lines, const std::vector<bool>& paneMaterials, LineHits& hits) override {
    preparePanes(paneMaterials);
    hits.ranges.assign(lines.count * lines.layers, std::numeric_limits<float>::quiet_NaN());
    const double start = cli::nowMs();
    const auto isPane = [&](uint32_t instance, uint32_t triangle) {
      const std::vector<bool>& panes = panes_[scene_.instances[instance].mesh];
      return !panes.empty() && panes[triangle];
    };
    constexpr size_t kShare = 32;  // packets
    workers_.run((lines.packets.size() + kShare - 1) / kShare, [&](size_t share) {
#ifdef __SSE3__
      _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_ON);  // required by Embree's manual
      _MM_SET_DENORMALS_ZERO_MODE(_MM_DENORMALS_ZERO_ON);
#endif
      const size_t end = std::min(lines.packets.size(), (share + 1) * kShare);
      for (size_t p = share * kShare; p < end; ++p) traceLines(top_, lines, p, instanced(), isPane, hits);
#ifdef __SSE3__
      _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_OFF);
      _MM_SET_DENORMALS_ZERO_MODE(_MM_DENORMALS_ZERO_OFF);
#endif
    });
    return cli::nowMs() - start;
  }

  uint64_t memoryBytes() const override {
    return static_cast<uint64_t>(bytes_.load());
  }

 private:
  bool instanced() const {
    return way_ == EmbreeWay::instanced || way_ == EmbreeWay::placed;
  }

  /// Notes for each triangle whether it is a pane; nothing for meshes without any.
  void preparePanes(const std::vector<bool>& materials) {
    if (!panes_.empty()) return;
    panes_.resize(scene_.meshes.size());
    for (size_t mesh = 0; mesh < panes_.size(); ++mesh)
      for (const MeshPart& part : scene_.meshes[mesh].parts) {
        if (!materials[part.material]) continue;
        panes_[mesh].resize(scene_.meshes[mesh].triangleCount());
        std::fill_n(panes_[mesh].begin() + part.firstTriangle, part.triangleCount, true);
      }
  }

  static bool count(void* total, ssize_t bytes, bool) {
    *static_cast<std::atomic<int64_t>*>(total) += bytes;
    return true;
  }

  void check() const {
    if (const RTCError error = rtcGetDeviceError(device_); error != RTC_ERROR_NONE)
      throw Error(error == RTC_ERROR_OUT_OF_MEMORY ? ErrorCode::outOfMemory : ErrorCode::device,
                  "Embree failed with error " + std::to_string(error));
  }

  RTCBuildQuality quality() const {
    const bool traced = way_ == EmbreeWay::flat || way_ == EmbreeWay::instanced || way_ == EmbreeWay::placed;
    return traced ? RTC_BUILD_QUALITY_HIGH : RTC_BUILD_QUALITY_LOW;
  }

  RTCScene newScene() const {
    const RTCScene scene = rtcNewScene(device_);
    const bool dynamic = way_ == EmbreeWay::refitted;
    rtcSetSceneFlags(scene, static_cast<RTCSceneFlags>(RTC_SCENE_FLAG_ROBUST |
                                                       (dynamic ? RTC_SCENE_FLAG_DYNAMIC : RTC_SCENE_FLAG_NONE)));
    rtcSetSceneBuildQuality(scene, way_ == EmbreeWay::placed ? RTC_BUILD_QUALITY_LOW : quality());
    return scene;
  }

  /// Fills the vertices of a set: a mesh's own, or those of an instance in the scene's frame.
  void fill(size_t set) {
    const Mesh& mesh = scene_.meshes[instanced() ? set : scene_.instances[set].mesh];
    std::vector<float>& vertices = vertices_[set];
    vertices.resize(mesh.positions.size() + kPadding);
    if (instanced()) {
      std::copy(mesh.positions.begin(), mesh.positions.end(), vertices.begin());
      return;
    }
    const Transform m = relativeTo(origin_, transforms_[set], mesh.origin);
    for (size_t v = 0; v < mesh.positions.size(); v += 3) {
      const double x = mesh.positions[v], y = mesh.positions[v + 1], z = mesh.positions[v + 2];
      for (size_t row = 0; row < 3; ++row) {
        const double* r = &m.rows[4 * row];
        vertices[v + row] = static_cast<float>(r[0] * x + r[1] * y + r[2] * z + r[3]);
      }
    }
  }

  /// Attaches a set of vertices as geometry number `set` of `scene`, or as number 0 of a mesh's own scene.
  void attach(RTCScene scene, size_t set, size_t meshIndex) {
    const Mesh& mesh = scene_.meshes[meshIndex];
    const RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, vertices_[set].data(), 0,
                               3 * sizeof(float), mesh.vertexCount());
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, mesh.indices.data(), 0,
                               3 * sizeof(uint32_t), mesh.triangleCount());
    rtcSetGeometryBuildQuality(geometry, way_ == EmbreeWay::refitted ? RTC_BUILD_QUALITY_REFIT : quality());
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(scene, geometry, instanced() ? 0 : static_cast<unsigned>(set));
    rtcReleaseGeometry(geometry);
  }

  void attachInstances() {
    bottoms_.resize(scene_.meshes.size());
    for (size_t mesh = 0; mesh < bottoms_.size(); ++mesh) {
      bottoms_[mesh] = rtcNewScene(device_);
      rtcSetSceneFlags(bottoms_[mesh], RTC_SCENE_FLAG_ROBUST);
      rtcSetSceneBuildQuality(bottoms_[mesh], quality());
      attach(bottoms_[mesh], mesh, mesh);
      rtcCommitScene(bottoms_[mesh]);
    }
    for (size_t i = 0; i < transforms_.size(); ++i) {
      const RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_INSTANCE);
      rtcSetGeometryInstancedScene(geometry, bottoms_[scene_.instances[i].mesh]);
      rtcAttachGeometryByID(top_, geometry, static_cast<unsigned>(i));
      rtcReleaseGeometry(geometry);
      place(i);
    }
  }

  void place(size_t instance) {
    const Vec3& meshOrigin = scene_.meshes[scene_.instances[instance].mesh].origin;
    const Transform m = relativeTo(origin_, transforms_[instance], meshOrigin);
    std::array<float, 12> rows;
    std::transform(m.rows.begin(), m.rows.end(), rows.begin(), [](double v) { return static_cast<float>(v); });
    const RTCGeometry geometry = rtcGetGeometry(top_, static_cast<unsigned>(instance));
    rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_ROW_MAJOR, rows.data());
    rtcCommitGeometry(geometry);
  }

  void clear() {
    if (top_) rtcReleaseScene(top_);
    for (const RTCScene scene : bottoms_) rtcReleaseScene(scene);
    top_ = nullptr;
    bottoms_.clear();
  }

  const Scene& scene_;
  Vec3 origin_;
  EmbreeWay way_;
  Workers workers_;
  std::vector<Transform> transforms_;
  std::vector<std::vector<float>> vertices_;
  PacketTable table_;
  std::vector<std::vector<bool>> panes_;
  std::atomic<int64_t> bytes_ = 0;
  RTCDevice device_ = nullptr;
  RTCScene top_ = nullptr;
  std::vector<RTCScene> bottoms_;
};

}  // namespace

bool haveEmbree() {
  return true;
}

std::unique_ptr<EmbreeRival> makeEmbree(const Scene& scene, const Vec3& origin, EmbreeWay way) {
  return std::make_unique<Embree>(scene, origin, way);
}

}  // namespace gnosphere::bench
