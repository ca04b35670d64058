// SPDX-License-Identifier: Apache-2.0
// A scan: the sensor and its rows, what kernels count, and the shells in which triangles are processed.
#ifndef GNOSPHERE_COMMON_FRAME_H
#define GNOSPHERE_COMMON_FRAME_H

#include "limits.h"

#ifdef __cplusplus
namespace gnosphere::gpu {
#endif

// A corner of a projected triangle in the sensor's frame, with the tag that arrays.h describes.
struct TaggedCorner {
  vec3 corner;
  uint tag;
};

// State of a beam with a footprint: the sub-rays that opaque triangles stop, and its chain.
struct Cover {
  uint farthest;           // bits of the largest range at which an opaque triangle stops a sub-ray
  uint lowRays, highRays;  // one bit for each sub-ray that is stopped: 0..31 and 32..63
  uint links;              // of the beam's chain of candidates
};

// The surface under a return.
struct SurfaceRecord {
  vec3 normal;    // unit vector, towards the sensor
  uint material;  // kNone: no surface
};

// A return has these values besides its range and its intensity.
struct SignalRecord {
  float trueRange, width;
  uint word;  // label | cause << 8 | number << 16 | count << 24
};

// The constants of a submission that are not in tables: of its sensor and views, and how much room its lists have.
struct Frame {
  uint columns;
  uint rows;
  uint beams;
  float rangeMin, rangeMax;
  float columnsPerRadian;
  float columnSlack;  // kAzimuthSlack in columns, plus the rounding of a column position
  uint projectedCapacity;
  uint tileCapacity;
  uint candidateCapacity;
  float paperFirstElevation;                // of accuracy paper: elevation of row 0 in radians
  float paperRowsPerRadian;                 // of accuracy paper
  float shiftMin, shiftMax;                 // columns by which a row's beams fire earlier (less than 0) or later than
                                            // those of their places: at least and at most
  float beside;                             // columns by which beams lie behind their places, at most
  uint momentsBefore, momentsAfter;         // entries of columnMotions before and behind those of the columns
  float stretch;                            // growth of that shift, in columns, from one beam of a row to the next
  float footprint;                          // radians: largest angle by which a beam spreads or deviates from its axis
  uint slabShift;                           // a slab has 1 << slabShift columns and is owned by one subgroup
  uint cullWorkgroups, triangleWorkgroups;  // of a shell's dispatches, if there is work for them
  uint shellClusters;                       // clusters that the first shell should hold
  float shellHint;                          // metres; a shell should end here; 0: nothing is known
  float spreadAcross;                       // like footprint, in azimuth and times the cosine of the elevation
  float spreadUp;                           // like footprint, in elevation
  uint hasBeamRanges;                       // 1 if beams have ranges of their own
  uint hidesNear;                           // 1 if a hit nearer than the least range ends its beam
  float steepest;                           // largest elevation key of a line of light, upwards or downwards
  float phase;                              // azimuth of column 0 beyond -180 degrees, in columns
  uint shellCount;                          // most shells of a scan
  uint slabFirst, slabCount;                // slabs that hold all beams; after the last slab comes slab 0
  uint beamColumnFirst, beamColumnCount;    // columns that hold all beams; after the last column comes column 0
  uint views;                               // of the submission
  uint moments;                             // entries of columnMotions per view; 0 if all views share them
  uint scanBeams;                           // beams of the sensor, by whose numbers results are stored
  uint table;                               // of a list: the table of its beams; several views have `viewTables`
  uint lookupCells;                         // of a list: entries of `rowLookup` per table
};

// One channel; rows are sorted by elevation. A row of cells has no angles.
struct Row {
  vec3 angles;  // cos and sin of the elevation, elevation key (see elevationKey())
  uint channel;
  uint azimuths;  // where its run of `columns` begins
  int first;      // place of its first beam in order of azimuth; places wrap
  float lag;      // entry of columnMotions of that beam, between two entries
  float behind;   // columns by which that beam lies behind its place
};

// Counts of list entries and of triangles by result; read back with the results.
struct Counters {
  uint projectedSmall, projectedLarge, tiles, candidates;
  uint binnedSmall, binnedTiles;  // counts of projectedSmall and tiles that earlier shells have binned
  uint hits;
  uint triangles;  // read from visible clusters
  uint nonFinite, culledByRange, culledByFace, culledBetweenBeams, culledHidden;
  uint integerSides, integerRanges;  // `exact`: tests that floating point could not decide
  uint causes[kCauses];              // beams by Cause, if effects are planned
  uint lostEchoes;                   // echoes beyond keptEchoes() of a beam
  uint ownLinks;                     // entries of `ownLinks`
  uint hardBeams;                    // lines that meet a pane
  uint edgeBeams[kEffortClasses];    // by effort: beams whose footprint does not lie on one triangle and meets no pane
  uint paneBeams[kEffortClasses];    // by effort: beams whose footprint may meet a pane
  uint boxedBeams;                   // with slabs: beams in the boxes of the triangles that are listed, summed
  uint tried;                        // triangles whose beams project has tried; they are on no list
  uint alive;                        // kAlive after project_groups: the device has done something
};

// The arguments of an indirect dispatch, as Vulkan reads them.
struct Workgroups {
  uint x, y, z;
};

// A shell is a range of distances from the sensor. A shell holds the clusters whose nearest points lie in that range.
struct Shell {
  float end;                                      // metres; the next shell begins here
  uint groups;                                    // listed for this shell
  uint visible;                                   // clusters listed
  uint visibleBehind;                             // with slabs: further ones, in the far halves of their groups
  uint nextCluster, nextSlab;                     // on a CPU: the next cluster, and the next slab or share of boxes
  uint laterRowsDown, laterRowsUp;                // content beyond the shell is in rows rows - down..up - 1
  Workgroups clusterWork, triangleWork, binWork;  // x is 0 until there is something to do
};

// All shells of a scan, zero when it starts. The last one is for moving instances, which a scan adds to a still image.
struct Shells {
  Shell of[kMostShells + 1];
  uint clusters[kShellBuckets];  // clusters in reach by the distance of their groups
};

// Push constants: a range of placed groups, and a shell.
struct Pass {
  uint placedFirst;  // first (instance, group) pair to process
  uint placedCount;
  uint shell;
  uint last;       // 1 if the shell reaches to infinity
  uint occluders;  // 1 if the farthest-range table is filled
  uint table;      // kTable...: what this dispatch writes to the farthest-range table
  // A step may be divided into dispatches of which each runs some of its workgroups (see runs.glsl): the first of them,
  // and how many the step has; 0 for kernels that cannot be divided.
  uint firstGroup, groups;
  uint clusters;  // in the placed groups
};

#ifdef __cplusplus
static_assert(sizeof(Frame) == 160 && sizeof(Row) == 32 && sizeof(Counters) == 180 && sizeof(Cover) == 16);
static_assert(sizeof(Pass) == 36 && sizeof(Shell) == 68 && sizeof(Shells) == 1412);
}  // namespace gnosphere::gpu
#endif
#endif
