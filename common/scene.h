// SPDX-License-Identifier: Apache-2.0
// The scene as kernels read it: instances, meshes in clusters and groups, and buffers of the caller.
#ifndef GNOSPHERE_COMMON_SCENE_H
#define GNOSPHERE_COMMON_SCENE_H

#include "types.h"

#ifdef __cplusplus
namespace gnosphere::gpu {
#endif

// Coordinates in buffers of the caller.
GNO_CONST uint kVertexF32 = 0;      // single precision, taken as they are
GNO_CONST uint kVertexU16 = 1;      // unsigned integers of 16 bits
GNO_CONST uint kVertexS16 = 2;      // signed ones
GNO_CONST uint kVertexSnorm16 = 3;  // signed ones, of which -32768 means the same as -32767

// The values of AlphaImage::Wrap in `alphaImages`: how texture coordinates outside 0..1 are read.
GNO_CONST uint kWrapRepeat = 0;
GNO_CONST uint kWrapMirror = 1;
GNO_CONST uint kWrapClamp = 2;

// Sensor frame = rows * (mesh position - pivot) + offset. The pivot is the sensor's position in the mesh frame,
// rounded to float. Subtracting it first keeps the error relative to the distance from the sensor: near the sensor the
// subtraction is exact.
struct Instance {
  vec4 row0;  // xyz: linear part, w: pivot
  vec4 row1;
  vec4 row2;
  vec3 offset;
  uint firstTriangle;  // number of its first placed triangle; the top bit says that the transform mirrors
};

// At most kClusterTriangles triangles of one material, in the mesh frame.
struct Cluster {
  vec3 low;  // lower corner of its box
  uint vertexFirst;
  vec3 high;  // upper corner
  uint triangleFirst;
  vec3 coneAxis;  // see cone.hpp
  uint cone;      // sine in the low 16 bits, thinness in the high 16 bits, both half floats
  uint vertexCount, triangleCount;
  uint doubleSided;  // 0 or 1
  uint material;     // index into the scene's materials
};

// At most kGroupClusters neighbouring clusters of one mesh.
struct Group {
  vec3 low;  // lower corner of its box
  uint clusterFirst;
  vec3 high;  // upper corner
  uint clusterCount;
};

// How the vertices of a mesh follow joints and morph targets. A mesh that is not deformable has neither.
struct Deformer {
  uint joints, targets;  // joints and morph targets
  uint deformed;         // 0: the vertices are where restPositions has them
  uint vertices;
  uint vertexFirst;   // the mesh's first entry in positions,
  uint restFirst;     // in restPositions,
  uint offsetFirst;   // in morphOffsets,
  uint weightFirst;   // in morphWeights,
  uint rowFirst;      // in jointRows,
  uint clusterFirst;  // in clusters,
  uint bonesFirst;    // and in clusterBones
  uint padding;
  vec3 morphLow;   // by how much the morph targets move a vertex: at least
  vec3 morphHigh;  // and at most
};

// The bones of a cluster, which are the joints that its vertices follow.
struct ClusterBones {
  uint first, count;  // the run of `bones`
  uint weightFirst;   // the first entry in boneWeights
  uint influences;    // entries in boneWeights per vertex
};

// A mesh whose vertices lie in a buffer of the caller, and the runs of arrays to which they are taken. A position is
// value * scale + offset, except that floats are the position.
struct VertexSource {
  vec3 scale;
  uint stride;  // bytes from one position to the next
  vec3 offset;
  uint format;       // kVertex...
  uint numberFirst;  // first entry in vertexNumbers
  uint vertexFirst;  // and in positions
};

// A buffer of the caller with transforms, and the sensor as seen from the point in the world to which they are
// relative. Each number is the sum of two floats: what the first leaves of it by rounding is in `...Low`.
struct TransformSource {
  vec3 row0, row1, row2;  // rotation from the world to the sensor's frame
  vec3 row0Low, row1Low, row2Low;
  vec3 shift, shiftLow;  // that point minus the sensor, in the world's axes
  uint stride;           // bytes from one transform to the next
  uint byColumns;        // 1: 4 x 4 numbers, column by column; 0: 3 x 4 numbers, row by row
};

// An instance whose transform lies in such a buffer.
struct TransformedInstance {
  vec3 origin, originLow;  // of its mesh, as a sum of two floats
  uint instance;
  uint source;  // entry in transformSources
  uint number;  // of its transform in the buffer
};

#ifdef __cplusplus
static_assert(sizeof(Instance) == 64 && sizeof(Cluster) == 64 && sizeof(Group) == 32);
static_assert(sizeof(VertexSource) == 40 && sizeof(TransformSource) == 104 && sizeof(TransformedInstance) == 36);
}  // namespace gnosphere::gpu
#endif
#endif
