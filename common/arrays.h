// SPDX-License-Identifier: Apache-2.0
// All arrays that the shaders read or write. Each has one name, which shaders, host and plan share. A kernel finds the
// arrays by a table of addresses in the order of this list. A BLOCK is a single struct, an ARRAY has any number of
// elements; the first argument is the GLSL access qualifier.
#ifndef GNOSPHERE_ARRAYS_H
#define GNOSPHERE_ARRAYS_H

// clang-format off

// Arrays that describe a sensor. A list may have several tables of its beams, of one size, which follow each other in
// the arrays: tables of beams that start far apart, or that different scans fire.
#define GNO_SENSOR_ARRAYS(BLOCK, ARRAY) \
  BLOCK(readonly, Frame, frame) \
  ARRAY(readonly, Row, rows) \
  ARRAY(readonly, uvec2, viewTables)  /* of a list, per view: the table of its beams, and the number of its shot */ \
  ARRAY(readonly, uint, rowLookup) /* per cell of elevation keys: first row from it up | first row above it << 16 */ \
  ARRAY(readonly, vec2, columns)   /* cos, sin of the azimuth of each place; then those of rows that look elsewhere */ \
  ARRAY(readonly, uint, cellStarts)   /* of a list, per cell (row * columns + column) and at the end: its first beam */ \
  ARRAY(readonly, vec4, beamAngles)   /* per listed beam: cos, sin of its azimuth, cos, sin of its elevation */ \
  ARRAY(readonly, uint, beamNumbers)  /* per beam, by index: its number in a scan; kNone: none */ \
  ARRAY(readonly, vec2, beamRanges)   /* per beam, by index: least and largest range, if hasBeamRanges */ \
  ARRAY(readonly, uvec2, startWords)  /* per place of a grid with holes: its word before anything is hit */ \
  ARRAY(readonly, uint, startFarthest)  /* `farthest` before anything is hit, if parts of the grid have no beams */ \
  ARRAY(readonly, vec4, beamOrigins)  /* per listed beam, with motion: its origin as in rowOrigins, */ \
                                      /* its place in columnMotions */ \
  ARRAY(readonly, uint, sliceMasks)   /* of a list with motion, per kSliceRows x kSliceColumns cells: one bit for each */ \
                                      /* slice of time in which their beams fire */ \
  ARRAY(readonly, uvec2, timedBeams)  /* of a moving list, by blocks of kTimedRows x kTimedColumns cells, then by slices: */ \
                                      /* index of a beam, row of its cell in the block | column in it << 16 */ \
  ARRAY(readonly, uint, timedStarts)  /* per block and slice, and at the end: its first entry of timedBeams */

// The scene: its meshes and their placed instances.
#define GNO_SCENE_ARRAYS(BLOCK, ARRAY) \
  ARRAY(readonly, Group, groups) \
  ARRAY(readonly, Cluster, clusters) \
  ARRAY(, vec3, positions)                   /* kernels write those of deformable meshes and of vertexSources */ \
  ARRAY(readonly, uvec2, triangleCorners)    /* three 8-bit vertex numbers of the cluster, index in the mesh */ \
  ARRAY(readonly, vec2, textureCoordinates)  /* per vertex */ \
  ARRAY(readonly, uint, meshTriangles)       /* per mesh: its first entry in triangleSlots */ \
  ARRAY(readonly, uint, triangleSlots)       /* per triangle of a mesh: cluster * kClusterTriangles + number in it */ \
  ARRAY(readonly, Deformer, deformers)       /* per mesh */ \
  ARRAY(readonly, vec3, restPositions)       /* per vertex of a deformable mesh, as in positions */ \
  ARRAY(readonly, vec3, morphOffsets)        /* per morph target and such vertex */ \
  ARRAY(readonly, ClusterBones, clusterBones)  /* per cluster of a deformable mesh */ \
  ARRAY(readonly, uint, bones)               /* of a cluster in the order of their joints: the joint, and its least */ \
                                             /* weight at a vertex, see deform.h */ \
  ARRAY(readonly, uint, boneWeights)         /* per vertex of a cluster and influence: the bone's number among those */ \
                                             /* of the cluster, and its weight, see deform.h */ \
  ARRAY(readonly, vec4, jointRows)           /* three per joint: its map, row by row */ \
  ARRAY(readonly, float, morphWeights)       /* per morph target of a mesh */ \
  ARRAY(readonly, VertexSource, vertexSources)  /* per mesh whose vertices are taken from a buffer of the caller */ \
  ARRAY(readonly, CallerBuffer, vertexBuffers)  /* per such mesh: where its first vertex is */ \
  ARRAY(, uint, droppedTriangles)            /* two per such mesh: triangles with a corner that is not finite; others */ \
                                             /* with two corners at one place */ \
  ARRAY(readonly, uvec2, sourceGroups)       /* per group of such a mesh: its entry in vertexSources, the group */ \
  ARRAY(readonly, uint, vertexNumbers)       /* per vertex of such a mesh, as in positions: its number in the mesh */ \
  ARRAY(readonly, TransformSource, transformSources)  /* per buffer of the caller from which transforms are taken */ \
  ARRAY(readonly, CallerBuffer, transformBuffers)     /* per such buffer: where its first transform is */ \
  ARRAY(readonly, TransformedInstance, transformedInstances) \
  ARRAY(, uint, unplacedInstances)           /* how many of these have a transform that is not finite */ \
  ARRAY(readonly, Instance, instances) \
  ARRAY(readonly, uint, instanceMeshes) \
  ARRAY(readonly, uint, instanceViews)       /* per instance, if a submission has several views: its view */ \
  ARRAY(readonly, uint, instanceNumbers)     /* the same, if results stay on the device: its number in the scene */ \
  ARRAY(readonly, uvec2, placed)             /* per placed group: its instance and its group */ \
  ARRAY(readonly, uvec2, ownerRanges)        /* per block of placed triangles: first and last instance in it; if a */ \
                                             /* submission has several views, two runs of instances per view: first */ \
                                             /* one, one after the last */

// Arrays that the stages pass on to each other. A projected triangle is spread over four of them. projectedA holds
// corner a and the number of the placed triangle (top bit: one-sided). projectedB holds corner b and a lower bound of
// the range to any point of the triangle (sign bit: the triangle moves). projectedC holds corner c, with the first row
// of the box in the low and the last row in the high 16 bits. projectedColumns holds the first and last column. Small
// boxes are stored from the front, large ones from the back. A tile is a part of a box: its triangle, its first column
// in the box, its number of columns and, in a slab's list, the previous tile. With slabs, every triangle has one tile
// at its own index; tiles for further slabs follow behind.
#define GNO_WORK_ARRAYS(BLOCK, ARRAY) \
  BLOCK(coherent, Counters, counters) \
  BLOCK(coherent, Shells, shells) \
  ARRAY(, uint, viewCauses)                /* per view, if there are several: its beams by Cause; without signals its hits */ \
  ARRAY(, uvec4, shellGroups)              /* instance, group, bits of its nearest distance, its first row | row */ \
                                           /* after its last << 16; one half for even shells, one for odd ones */ \
  ARRAY(, uvec2, visible)                  /* instance, cluster */ \
  ARRAY(, uint, farthest)                  /* bits of the largest range found so far; fine, then coarse entries */ \
  ARRAY(coherent, uint, staleEntries)      /* per coarse entry of `farthest`: 1 if project has found hits there */ \
  ARRAY(, TaggedCorner, projectedA) \
  ARRAY(, vec4, projectedB) \
  ARRAY(, TaggedCorner, projectedC) \
  ARRAY(, vec2, projectedColumns) \
  ARRAY(, uint, projectedViews)            /* per projected triangle, if there are several views: its view */ \
  ARRAY(, uvec2, projectedTimes)           /* per projected triangle, if TIMED: Box::times */ \
  ARRAY(, uvec4, tiles) \
  ARRAY(coherent, uvec2, words)            /* per beam, by rows: triangle, range bits (little-endian 64-bit word) */ \
                                           /* of its nearest hit; without kFieldPoints, at last of its return */ \
  ARRAY(, uvec2, laterWords)               /* like words, of the second returns of all beams, then of the third ones; */ \
                                           /* if words tell the returns, and panes or stage effects may give several */ \
  ARRAY(coherent, Cover, covers)           /* per beam, by index, with footprints */ \
  ARRAY(, uvec2, ownLinks)                 /* with footprints, kOwnLinks per beam: the first links of its chain */ \
  ARRAY(, uvec2, stillWords)               /* the words after the objects that do not move have been binned */ \
  ARRAY(coherent, uint, listEnds)          /* per beam, row by row: count, then start, then end of its candidates; */ \
                                           /* or the last link of its chain of panes */ \
  ARRAY(coherent, uint, slabEnds)          /* per slab of columns, view by view: its last tile; then of panes */ \
  ARRAY(, uint, blockSums) \
  ARRAY(, uint, candidates)                /* indices of projected triangles; with panes three per link, see bin.comp */ \
  ARRAY(, uint, projectedMaterials)        /* per projected triangle */ \
  ARRAY(, vec4, projectedMotions)          /* per projected triangle that moves: m/s of its three corners */ \
  ARRAY(, vec4, projectedTexture)          /* per projected triangle: uv of a and b, of c */ \
  ARRAY(, BeamFrame, beamFrames)           /* per beam, by index, if BEAM_FRAMES */ \
  ARRAY(, vec2, strays)                    /* per beam, by rows: tangents of its angle error, to the left and up */ \
  ARRAY(, uint, hardBeams)                 /* beams, by index, for effects_panes; for the later passes of footprints see */ \
                                           /* left_beams.glsl */ \
  ARRAY(, uint, echoCounts)                /* per beam: its echoes, in order of range: keptEchoes() at most, or */ \
                                           /* kMaxLayers with panes; kNone: the beam meets no pane */ \
  ARRAY(, vec4, echoes)                    /* echo by echo, per beam: range, energy, width, cosine of the */ \
                                           /* incidence */ \
  ARRAY(, uvec2, echoOwners)               /* in the order of echoes, laid out like owners */ \
  ARRAY(, SurfaceRecord, echoSurfaces)

// Results for every return of every beam, in the sensor's own order.
#define GNO_RESULT_ARRAYS(BLOCK, ARRAY) \
  ARRAY(, vec4, points)                    /* x, y, z, range */ \
  ARRAY(, uvec2, owners)                   /* triangle within its mesh, instance */ \
  ARRAY(, SurfaceRecord, surfaces) \
  ARRAY(, float, intensities) \
  ARRAY(, SignalRecord, signals) \
  ARRAY(, vec4, motions)                   /* velocity in the sensor's axes, radial speed */ \
  ARRAY(, vec2, barycentrics)

// Arrays of inputs of the effects.
#define GNO_EFFECT_ARRAYS(BLOCK, ARRAY) \
  BLOCK(readonly, EffectParameters, parameters) \
  BLOCK(readonly, MotionBounds, motion) \
  ARRAY(readonly, ColumnMotion, columnMotions) \
  ARRAY(readonly, InstanceMotion, instanceMotions) \
  ARRAY(readonly, vec4, endJointRows)      /* like jointRows and morphWeights, at the end of the motion; */ \
  ARRAY(readonly, float, endMorphWeights)  /* only for meshes that are deformed meanwhile */ \
  ARRAY(readonly, vec4, rowOrigins)        /* each row's laser as seen from the middle of all: forward, left, up */ \
  ARRAY(readonly, Optics4, optics)         /* per material */ \
  ARRAY(readonly, uint, deadBeams)         /* one bit per beam */ \
  ARRAY(readonly, VolumeBox, volumes)      /* per view: as many as EffectParameters::volumeCount says */ \
  ARRAY(readonly, uvec4, alphaImages)      /* width, height, first byte, wrapping of u | wrapping of v << 8 */ \
  ARRAY(readonly, uint, texels)            /* four bytes of alpha each */ \
  ARRAY(readonly, vec4, subRays)           /* tangents to the left and up, weight, length of (1, left, up) */

// Results that stay on the device, in the layout of the caller.
#define GNO_RECORD_ARRAYS(BLOCK, ARRAY) \
  ARRAY(readonly, RecordPlan, recordPlans)        /* per shot */ \
  ARRAY(readonly, RecordBuffers, recordBuffers)   /* per shot: the caller's buffers */ \
  ARRAY(readonly, RecordStream, recordStreams) \
  ARRAY(readonly, RecordValue, recordValues) \
  ARRAY(readonly, RecordPlace, recordPlaces)  /* per value, if all are whole words */ \
  ARRAY(readonly, RecordPlace, recordGaps)    /* words of a record without a value */ \
  ARRAY(readonly, uint, beamPlaces)        /* per pattern and beam, by number: its index; kNone: it never fires */ \
  ARRAY(readonly, uvec4, beamFacts)        /* per pattern and beam: bits of time, azimuth and elevation, its ring */ \
  ARRAY(readonly, vec4, beamDirections)    /* per pattern and beam: unit vector in the sensor's frame, 0 */ \
  ARRAY(readonly, InstanceClass, instanceClasses) \
  ARRAY(readonly, ClassRun, classRuns)     /* mesh by mesh, in the order of the triangles */ \
  ARRAY(, uint, recordBlocks)              /* per shot and block of its entries: returns in it, then returns before it */ \
  ARRAY(, uint, recordEntries)             /* per shot: its entries with a return */ \
  ARRAY(, uint, rangeCounts)               /* per bucket of distance: returns of a sample of the first shot's entries */

#define GNO_ARRAYS(BLOCK, ARRAY) \
  GNO_SENSOR_ARRAYS(BLOCK, ARRAY) \
  GNO_SCENE_ARRAYS(BLOCK, ARRAY) \
  GNO_WORK_ARRAYS(BLOCK, ARRAY) \
  GNO_RESULT_ARRAYS(BLOCK, ARRAY) \
  GNO_EFFECT_ARRAYS(BLOCK, ARRAY) \
  GNO_RECORD_ARRAYS(BLOCK, ARRAY)

// clang-format on

#ifdef __cplusplus
#include <cstdint>
namespace gnosphere::gpu {

/// The number of each array, in the order of the addresses.
enum class Array : uint32_t {
#define GNO_NUMBER(access_, type_, name_) name_,
  GNO_ARRAYS(GNO_NUMBER, GNO_NUMBER)
#undef GNO_NUMBER
};

/// The device address of each array. An array that a kernel does not use may have address 0.
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
