// SPDX-License-Identifier: Apache-2.0
// Every array of a scan, under the name it has on the host. A stage says above its main() what it reads and writes.

#define WORK(binding_, access_, type_, name_) \
  layout(std430, set = 0, binding = binding_) access_ buffer name_##Block { type_ name_[]; }
#define CHUNK(binding_, type_, name_) \
  layout(std430, set = 1, binding = binding_) readonly buffer name_##Block { type_ name_[]; }

#ifdef RESULTS_ARE_READ
#define RESULTS
#else
#define RESULTS writeonly
#endif

layout(std430, set = 0, binding = kBindFrame) readonly buffer FrameBlock { Frame frame; };
layout(std430, set = 0, binding = kBindCounters) coherent buffer CountersBlock { Counters counters; };
WORK(kBindInstances, readonly, Instance, instances);
WORK(kBindRows, readonly, Row, rows);
WORK(kBindRowLookup, readonly, uint, rowLookup);   // per cell of keys: first row in or above it | first above it << 16
WORK(kBindColumns, readonly, vec2, columns);       // cos, sin of the azimuth
WORK(kBindVisibleGroups, , uvec2, visibleGroups);  // instance, group
WORK(kBindVisible, , uvec2, visible);              // instance, cluster
WORK(kBindFarthest, , uint, farthest);             // bits of the largest range met so far; fine entries, then coarse ones
// Each projected triangle: its corners in the sensor's frame, in w: placed triangle (the top bit says one-sided); no
// point is nearer; first row in the low 16 bits, last row in the high ones. Small boxes from the front, large ones from
// the back.
WORK(kBindProjectedA, , vec4, projectedA);
WORK(kBindProjectedB, , vec4, projectedB);
WORK(kBindProjectedC, , vec4, projectedC);
WORK(kBindProjectedColumns, , vec2, projectedColumns);  // first and last column of the box
// Part of a box: its triangle, first column in it, columns; in the list of a slab, the tile before it. With slabs those of
// further slabs come behind one tile per triangle.
WORK(kBindTiles, , uvec4, tiles);
// Per beam, row by row (a channel's beams lie elsewhere in the results, which are in the sensor's own order):
WORK(kBindWords, coherent, uvec2, words);          // triangle, range bits (a little-endian 64-bit word)
WORK(kBindListEnds, coherent, uint, listEnds);     // counts, then starts, then ends of the beam's candidates
                                                   // or, per slab of columns: its last tile
WORK(kBindBlockSums, , uint, blockSums);
WORK(kBindCandidates, , uint, candidates);         // indices of projected triangles
WORK(kBindPoints, RESULTS, vec4, points);        // x, y, z, range
WORK(kBindOwners, RESULTS, uvec2, owners);       // triangle within its mesh, instance
WORK(kBindPlaced, readonly, uvec2, placed);        // instance, group; chunk by chunk
WORK(kBindOwnerRanges, readonly, uvec2, ownerRanges);  // per block of placed triangles: first and last instance in it
CHUNK(kBindGroups, Group, groups);
CHUNK(kBindClusters, Cluster, clusters);
layout(scalar, set = 1, binding = kBindPositions) readonly buffer positionsBlock { vec3 positions[]; };
CHUNK(kBindTriangleCorners, uvec2, triangleCorners);  // three 8-bit vertex numbers of the cluster, index in the mesh
