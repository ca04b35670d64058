// SPDX-License-Identifier: Apache-2.0
// Every array that the shaders read or write, under the one name it has in shaders, on the host and in a plan. A device
// finds them by a table of addresses in the order of this list. BLOCK is a single struct, ARRAY has any number of
// elements. The first argument says how GLSL may access it.
#ifndef GNOSPHERE_ARRAYS_H
#define GNOSPHERE_ARRAYS_H

// clang-format off

// The sensor.
#define GNO_SENSOR_ARRAYS(BLOCK, ARRAY) \
  BLOCK(readonly, Frame, frame) \
  ARRAY(readonly, Row, rows) \
  ARRAY(readonly, uint, rowLookup) /* per cell of keys: first row in or above it | first above it << 16 */ \
  ARRAY(readonly, vec2, columns)   /* cos, sin of the azimuth */

// The scene: its meshes, and where they are placed.
#define GNO_SCENE_ARRAYS(BLOCK, ARRAY) \
  ARRAY(readonly, Group, groups) \
  ARRAY(readonly, Cluster, clusters) \
  ARRAY(readonly, vec3, positions) \
  ARRAY(readonly, uvec2, triangleCorners)    /* three 8-bit vertex numbers of the cluster, index in the mesh */ \
  ARRAY(readonly, vec2, textureCoordinates)  /* per vertex */ \
  ARRAY(readonly, uint, meshTriangles)       /* per mesh: its first entry in triangleSlots */ \
  ARRAY(readonly, uint, triangleSlots)       /* per triangle of a mesh: cluster * kClusterTriangles + its number there */ \
  ARRAY(readonly, Instance, instances) \
  ARRAY(readonly, uint, instanceMeshes) \
  ARRAY(readonly, uvec2, placed)             /* instance, group */ \
  ARRAY(readonly, uvec2, ownerRanges)        /* per block of placed triangles: first and last instance in it */

// What the stages leave for one another. Of a projected triangle: corner a and the placed triangle (the top bit says
// one-sided); corner b and a range that no point of it is nearer than; corner c and its first row in the low 16 bits, its
// last one in the high ones; first and last column. Small boxes come from the front, large ones from the back. A tile is
// a part of a box: its triangle, first column in it, columns, and in the list of a slab the tile before it; with slabs
// the tiles of further slabs come behind one tile per triangle.
#define GNO_WORK_ARRAYS(BLOCK, ARRAY) \
  BLOCK(coherent, Counters, counters) \
  ARRAY(, uvec2, visibleGroups)            /* instance, group */ \
  ARRAY(, uvec2, visible)                  /* instance, cluster */ \
  ARRAY(, uint, farthest)                  /* bits of the largest range met so far; fine entries, then coarse ones */ \
  ARRAY(, TaggedCorner, projectedA) \
  ARRAY(, vec4, projectedB) \
  ARRAY(, TaggedCorner, projectedC) \
  ARRAY(, vec2, projectedColumns) \
  ARRAY(, uvec4, tiles) \
  ARRAY(coherent, uvec2, words)            /* per beam, row by row: triangle, range bits (a little-endian 64-bit word) */ \
  ARRAY(, uvec2, stillWords)               /* the words as what does not move leaves them */ \
  ARRAY(coherent, uint, listEnds)          /* per beam, row by row: count, then start, then end of its candidates; */ \
                                           /* or per slab of columns: its last tile */ \
  ARRAY(, uint, blockSums) \
  ARRAY(, uint, candidates)                /* indices of projected triangles */ \
  ARRAY(, uint, projectedMaterials)        /* per projected triangle */ \
  ARRAY(, vec4, projectedMotions)          /* per projected triangle: m/s of its three corners */ \
  ARRAY(, vec4, projectedTexture)          /* per projected triangle: uv of a and b, of c */ \
  ARRAY(, uint, hardBeams)                 /* beams, row by row, that the footprint's second pass does */ \
  ARRAY(, uint, echoCounts)                /* per beam up to kMaxEchoes of what its footprint met, in order of range: */ \
  ARRAY(, vec4, echoes)                    /* range, energy, width, cosine of the incidence */ \
  ARRAY(, uvec2, echoOwners)               /* as owners */ \
  ARRAY(, SurfaceRecord, echoSurfaces)

// Results, per return of every beam, in the sensor's own order.
#define GNO_RESULT_ARRAYS(BLOCK, ARRAY) \
  ARRAY(, vec4, points)                    /* x, y, z, range */ \
  ARRAY(, uvec2, owners)                   /* triangle within its mesh, instance */ \
  ARRAY(, SurfaceRecord, surfaces) \
  ARRAY(, SignalRecord, signals) \
  ARRAY(, vec4, motions)                   /* velocity in the sensor's axes, radial speed */ \
  ARRAY(, vec2, barycentrics)

// What effects need to know.
#define GNO_EFFECT_ARRAYS(BLOCK, ARRAY) \
  BLOCK(readonly, EffectParameters, parameters) \
  BLOCK(readonly, MotionBounds, motion) \
  ARRAY(readonly, ColumnMotion, columnMotions) \
  ARRAY(readonly, InstanceMotion, instanceMotions) \
  ARRAY(readonly, vec4, rowOrigins)        /* of each row's laser in the head: forward, left, up */ \
  ARRAY(readonly, Optics4, optics)         /* per material */ \
  ARRAY(readonly, uint, deadBeams)         /* a bit per beam */ \
  ARRAY(readonly, VolumeBox, volumes) \
  ARRAY(readonly, uvec4, alphaImages)      /* width, height, first byte, wrapping of u | of v << 8 */ \
  ARRAY(readonly, uint, texels)            /* four bytes of alpha each */ \
  ARRAY(readonly, vec4, subRays)           /* tangents left and up, weight, length of (1, left, up) */

#define GNO_ARRAYS(BLOCK, ARRAY) \
  GNO_SENSOR_ARRAYS(BLOCK, ARRAY) \
  GNO_SCENE_ARRAYS(BLOCK, ARRAY) \
  GNO_WORK_ARRAYS(BLOCK, ARRAY) \
  GNO_RESULT_ARRAYS(BLOCK, ARRAY) \
  GNO_EFFECT_ARRAYS(BLOCK, ARRAY)

// clang-format on

#ifdef __cplusplus
#include <cstdint>
namespace gnosphere::gpu {

/// The arrays by number, in the order of their addresses.
enum class Array : uint32_t {
#define GNO_NUMBER(access_, type_, name_) name_,
  GNO_ARRAYS(GNO_NUMBER, GNO_NUMBER)
#undef GNO_NUMBER
};

/// Where a kernel finds each array. What a kernel does not use may be 0.
struct Addresses {
#define GNO_ADDRESS(access_, type_, name_) uint64_t name_;
  GNO_ARRAYS(GNO_ADDRESS, GNO_ADDRESS)
#undef GNO_ADDRESS
};

inline constexpr const char* kArrayNames[] = {
#define GNO_NAME(access_, type_, name_) #name_,
    GNO_ARRAYS(GNO_NAME, GNO_NAME)
#undef GNO_NAME
};
inline constexpr uint32_t kArrayCount = sizeof(Addresses) / sizeof(uint64_t);
inline const char* nameOf(Array array) {
  return kArrayNames[static_cast<uint32_t>(array)];
}

}  // namespace gnosphere::gpu
#endif

#endif
