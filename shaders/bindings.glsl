// SPDX-License-Identifier: Apache-2.0
// Every array of a scan, under the name it has on the host. A stage says above its main() what it reads and writes.

#define WORK(binding_, access_, type_, name_) \
  layout(std430, set = 0, binding = binding_) access_ buffer name_##Block { type_ name_[]; }
#define CHUNK(binding_, type_, name_) \
  layout(std430, set = 1, binding = binding_) readonly buffer name_##Block { type_ name_[]; }

layout(std430, set = 0, binding = kBindFrame) readonly buffer FrameBlock { Frame frame; };
layout(std430, set = 0, binding = kBindCounters) coherent buffer CountersBlock { Counters counters; };
WORK(kBindInstances, readonly, Instance, instances);
WORK(kBindRows, readonly, Row, rows);
WORK(kBindRowLookup, readonly, uint, rowLookup);
WORK(kBindColumns, readonly, vec2, columns);       // cos, sin of the azimuth
WORK(kBindVisible, , uvec2, visible);              // instance, cluster
WORK(kBindProjectedA, , float, projectedA);        // first corner of each projected triangle, x y z, sensor frame
WORK(kBindProjectedB, , float, projectedB);
WORK(kBindProjectedC, , float, projectedC);
WORK(kBindProjectedBoxes, , Box, projectedBoxes);
WORK(kBindProjectedIds, , uint, projectedIds);     // placed triangle; the top bit says one-sided
WORK(kBindTiles, , Tile, tiles);
WORK(kBindWords, coherent, uint, words);           // per beam: triangle, range bits (a little-endian 64-bit word)
WORK(kBindListEnds, coherent, uint, listEnds);     // counts, then starts, then ends of each beam's candidates
WORK(kBindBlockSums, , uint, blockSums);
WORK(kBindCandidates, , uint, candidates);         // indices of projected triangles
WORK(kBindPoints, writeonly, float, points);
WORK(kBindRanges, writeonly, float, ranges);
WORK(kBindTriangles, writeonly, uint, triangles);
WORK(kBindOwners, writeonly, uint, owners);        // instance of each beam's triangle
CHUNK(kBindPlaced, uvec2, placed);                 // instance, cluster
CHUNK(kBindClusters, Cluster, clusters);
CHUNK(kBindPositions, float, positions);
CHUNK(kBindCorners, uint, corners);                // three 8-bit vertex numbers
CHUNK(kBindTriangleIds, uint, triangleIds);        // index within the mesh
