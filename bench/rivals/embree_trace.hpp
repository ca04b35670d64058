// SPDX-License-Identifier: Apache-2.0
// Traces one packet with Embree 3 or 4.
#pragma once

#if GNOSPHERE_EMBREE >= 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <algorithm>
#include <limits>

#include "rivals/lines.hpp"
#include "rivals/packets.hpp"
#include "rivals/rival.hpp"

namespace gnosphere::bench {

inline void intersect(RTCScene scene, const int* valid, RTCRayHit16& packet) {
#if GNOSPHERE_EMBREE >= 4
  RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
  arguments.feature_mask = static_cast<RTCFeatureFlags>(RTC_FEATURE_FLAG_TRIANGLE | RTC_FEATURE_FLAG_INSTANCE);
  rtcIntersect16(valid, scene, &packet, &arguments);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  rtcIntersect16(valid, scene, &context, &packet);
#endif
}

/// `origin` is that of the rays, in the scene's frame.
inline void tracePacket(RTCScene scene, const Packet& packet, const float (&origin)[3], float rangeMin, float rangeMax,
                        bool instanced, Hits& hits) {
  alignas(64) int valid[kPacketBeams];
  RTCRayHit16 rays;
  for (uint32_t lane = 0; lane < kPacketBeams; ++lane) {
    valid[lane] = lane < packet.count ? -1 : 0;
    rays.ray.org_x[lane] = origin[0];
    rays.ray.org_y[lane] = origin[1];
    rays.ray.org_z[lane] = origin[2];
    rays.ray.dir_x[lane] = packet.x[lane];
    rays.ray.dir_y[lane] = packet.y[lane];
    rays.ray.dir_z[lane] = packet.z[lane];
    rays.ray.tnear[lane] = rangeMin;
    rays.ray.tfar[lane] = rangeMax;
    rays.ray.time[lane] = 0;
    rays.ray.mask[lane] = 0xffffffffU;
    rays.ray.flags[lane] = 0;
    rays.hit.geomID[lane] = RTC_INVALID_GEOMETRY_ID;
    rays.hit.instID[0][lane] = RTC_INVALID_GEOMETRY_ID;
  }
  intersect(scene, valid, rays);
  for (uint32_t lane = 0; lane < packet.count; ++lane) {
    const uint32_t beam = packet.first + lane;
    const bool hit = rays.hit.geomID[lane] != RTC_INVALID_GEOMETRY_ID;
    const float range = hit ? rays.ray.tfar[lane] : std::numeric_limits<float>::quiet_NaN();
    hits.points[3 * size_t{beam}] = packet.x[lane] * range;
    hits.points[3 * size_t{beam} + 1] = packet.y[lane] * range;
    hits.points[3 * size_t{beam} + 2] = packet.z[lane] * range;
    hits.ranges[beam] = range;
    hits.triangles[beam] = hit ? rays.hit.primID[lane] : kNoTriangle;
    hits.instances[beam] = !hit ? kNoTriangle : instanced ? rays.hit.instID[0][lane] : rays.hit.geomID[lane];
  }
}

/// Follows the lines of one packet. `isPane` says of an instance and a triangle whether light passes it; the next
/// surface is looked for a millionth of the range behind it.
template <typename IsPane>
void traceLines(RTCScene scene, const Lines& lines, size_t number, bool instanced, const IsPane& isPane,
                LineHits& hits) {
  const LinePacket& packet = lines.packets[number];
  alignas(64) int valid[kPacketLines];
  RTCRayHit16 rays;
  bool any = false;
  for (uint32_t lane = 0; lane < kPacketLines; ++lane) {
    valid[lane] = packet.far[lane] >= packet.near[lane] ? -1 : 0;
    any |= valid[lane] != 0;
    rays.ray.org_x[lane] = packet.originX[lane];
    rays.ray.org_y[lane] = packet.originY[lane];
    rays.ray.org_z[lane] = packet.originZ[lane];
    rays.ray.dir_x[lane] = packet.x[lane];
    rays.ray.dir_y[lane] = packet.y[lane];
    rays.ray.dir_z[lane] = packet.z[lane];
    rays.ray.tnear[lane] = packet.near[lane];
    rays.ray.time[lane] = 0;
    rays.ray.mask[lane] = 0xffffffffU;
    rays.ray.flags[lane] = 0;
  }
  for (uint32_t layer = 0; any && layer < lines.layers; ++layer) {
    for (uint32_t lane = 0; lane < kPacketLines; ++lane) {
      rays.ray.tfar[lane] = packet.far[lane];
      rays.hit.geomID[lane] = RTC_INVALID_GEOMETRY_ID;
      rays.hit.instID[0][lane] = RTC_INVALID_GEOMETRY_ID;
    }
    intersect(scene, valid, rays);
    any = false;
    for (uint32_t lane = 0; lane < kPacketLines; ++lane) {
      if (!valid[lane]) continue;
      valid[lane] = 0;
      if (rays.hit.geomID[lane] == RTC_INVALID_GEOMETRY_ID) continue;
      const float range = rays.ray.tfar[lane];
      hits.ranges[(number * kPacketLines + lane) * lines.layers + layer] = range;
      if (!isPane(instanced ? rays.hit.instID[0][lane] : rays.hit.geomID[lane], rays.hit.primID[lane])) continue;
      rays.ray.tnear[lane] = range * (1 + 1e-6f);
      valid[lane] = -1;
      any = true;
    }
  }
}

}  // namespace gnosphere::bench
