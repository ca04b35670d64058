// SPDX-License-Identifier: Apache-2.0
// Limits and sizes that kernels and host agree on.
#ifndef GNOSPHERE_COMMON_LIMITS_H
#define GNOSPHERE_COMMON_LIMITS_H

#include "types.h"

#ifdef __cplusplus
namespace gnosphere::gpu {
#endif

// Most triangles of a cluster. One subgroup projects a cluster and keeps one bit per triangle, so 32 is the limit. In
// town scenes 32 took 0.95 of the time of 64, and 16 was not faster.
GNO_CONST uint kClusterTriangles = 32;
// Most clusters of a group. One subgroup processes the clusters of a group.
GNO_CONST uint kGroupClusters = 64;
// One invocation processes a box of at most this many beams; a larger box is cut into tiles, and one subgroup
// processes a tile.
GNO_CONST uint kSmallBoxBeams = 16;
// Where there are few threads, stage project tries a triangle at once if that takes at most so many steps: beams
// between its edges, and rows (see columns_between.glsl). On two CPU cores, beside boxes of at most 16 beams that are
// all tried, 128 took 0.92 of the CPU time with an HDL-64E (geometric mean of 17 scenes) and 0.85 with Hypothetical-256
// (16 scenes); 256 took 1.06 and 1.02 of the time of 128 (5 and 4 scenes).
GNO_CONST float kTriedSteps = 128.0f;
// Most beams of a tile. A box over a whole 18000 x 350 sensor becomes 1540 tiles.
GNO_CONST uint kTileBeams = 4096;
// For a tile of at most this many beams, all rows are tried without computing first which rows can have hits.
GNO_CONST uint kFewBeams = 32;
// A box over at most this many rows of cells is searched for beams before its triangle is stored.
GNO_CONST uint kFewRows = 4;
// Cells of the table from elevation key to row.
GNO_CONST uint kRowLookupCells = 16384;
// Vertices with a larger coordinate are dropped and counted: products of three coordinates would overflow a float.
GNO_CONST float kCoordinateLimit = 1e9f;
// A map whose determinant is at most this share of the product of its columns' lengths flattens a mesh. Rounding leaves
// 1e-16 of it, or 1e-7 where a file states single precision, and its inverse would take points far away.
GNO_CONST float kFlatVolume = 1e-6f;
// Error of the elevation key (range -1..1) by which bounds are widened. The slack covers 3 rounding errors of the key
// itself (2e-7), the error of an arc's highest point from a normal with relative error 3e-7 per unit edge/height ratio,
// and the shift of a vertex by the inside test's own rounding (3e-7). Ten times their sum is still small beside the
// distance between rows, 4e-3.
GNO_CONST float kKeySlack = 1e-5f;
// The slack of an azimuth in radians, at the horizon; it grows as 1/cos(elevation).
GNO_CONST float kAzimuthSlack = 2e-6f;
// A beam index or list link that refers to nothing.
GNO_CONST uint kNone = 0xffffffffu;
// Links of a beam with a footprint that have places of their own. 4 took 1.04 of the time, 8 the same.
GNO_CONST uint kOwnLinks = 6;
// Classes of beams with footprints by their number of candidates.
GNO_CONST uint kEffortClasses = 8;
// Beams that one entry of the farthest-range table covers: columns by rows, on its fine and on its coarse level.
GNO_CONST uint kFineColumns = 8;
GNO_CONST uint kFineRows = 4;
GNO_CONST uint kCoarseColumns = 64;
GNO_CONST uint kCoarseRows = 32;
// Most table entries that are read for one box; a box over more entries counts as visible.
GNO_CONST uint kMaxLookups = 16;
// A cluster that at most so many beams may meet is compared with their hits again before it is projected.
GNO_CONST uint kBeamsAskedAgain = 128;
// At most so many beams that may meet a cluster are tried on all of its triangles; 32 took 0.9 to 1.2 of the time
// of 16.
GNO_CONST uint kBeamsTriedOnAll = 16;
// Most shells of a scan, and the buckets of distance, four per octave, in which groups are counted to choose them.
GNO_CONST uint kMostShells = 16;
GNO_CONST uint kShellGrowth = 2;  // each shell should hold so many times the clusters of the shell before it
GNO_CONST uint kShellBuckets = 64;
GNO_CONST uint kBucketShift = 21;  // of a float's bits: two of the mantissa are left
// A shell of the next scan should end at the range within which kHintPercent per cent of a sample of the returns lie.
// The sample is made of about kHintSamples entries; with fewer than kHintReturns returns it tells nothing.
GNO_CONST uint kHintSamples = 2048;
GNO_CONST uint kHintReturns = 64;
GNO_CONST uint kHintPercent = 95;
// Beams of a channel that one workgroup resolves: enough to keep the atomics on the hit counter few.
GNO_CONST uint kResolveColumns = 1024;
// A triangle that moves fast around the sensor is bounded for intervals of the scan. An interval is divided while its
// box has more than kFewIntervalBeams beams and the scan has fewer than kMostIntervals intervals of its length.
GNO_CONST uint kFewIntervalBeams = 32;
GNO_CONST uint kFewSliceBeams = 64;  // the same for cells of a list, whose beams are found by their slices
GNO_CONST uint kMostIntervals = 64;
// Slices of time into which the scan of a moving list is divided, intervals of columnMotions per slice, the columns and
// rows of cells per entry of sliceMasks, and the most entries that are read for a box.
GNO_CONST uint kTimeSlices = 32;
GNO_CONST uint kSliceIntervals = 64;
GNO_CONST uint kSliceColumns = 16;
GNO_CONST uint kSliceRows = 8;
GNO_CONST uint kMostSliceMasks = 64;
// Columns and rows of the blocks of cells whose beams are sorted by slices together. With blocks of 4 x 4 cells a scan
// of a moving list took 1.03 to 1.06 of the time, because most triangles' boxes are smaller than these blocks.
GNO_CONST uint kTimedColumns = 4;
GNO_CONST uint kTimedRows = 2;
// Number of placed triangles per entry of ownerRanges.
GNO_CONST uint kOwnerBlock = 256;
// Number of values of Cause.
GNO_CONST uint kCauses = 8;
// Value of Counters::alive after the first kernel.
GNO_CONST uint kAlive = 0x51de1e55u;
// Beams per block of the prefix sum.
GNO_CONST uint kPrefixBlock = 1024;

#ifdef __cplusplus
static_assert(kClusterTriangles <= 32 && 3 * kClusterTriangles < 1 << 7);
}  // namespace gnosphere::gpu
#endif
#endif
