// SPDX-License-Identifier: Apache-2.0
// Structs and constants that host and device share, included by GLSL, C++ and CUDA. GLSL uses the scalar layout rules
// for the structs, so all three agree.
#ifndef GNOSPHERE_SHARED_H
#define GNOSPHERE_SHARED_H

#ifdef __cplusplus
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
namespace gnosphere::gpu {
using uint = uint32_t;
using glm::vec2;
using glm::vec3;
struct alignas(16) vec4 {
  float x, y, z, w;
};
/// Memory of the caller by its address. Only Vulkan's bindings have it in GLSL.
struct CallerBuffer {
  uint64_t memory;
};
#define GNO_CONST inline constexpr
#else
#define GNO_CONST const
#endif

// --- Limits -------------------------------------------------------------------------------------------------------

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
// Error of the elevation key (range -1..1) by which bounds are widened. The slack covers 3 rounding errors of the key
// itself (2e-7), the error of an arc's highest point from a normal with relative error 3e-7 per unit edge/height ratio,
// and the shift of a vertex by the inside test's own rounding (3e-7). Ten times their sum is still small beside the
// distance between rows, 4e-3.
GNO_CONST float kKeySlack = 1e-5f;
// The same for azimuth, in radians at the horizon; it grows as 1/cos(elevation).
GNO_CONST float kAzimuthSlack = 2e-6f;
// A beam index or list link that refers to nothing.
GNO_CONST uint kNone = 0xffffffffu;
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
GNO_CONST uint kMostShells = 8;
GNO_CONST uint kShellBuckets = 64;
GNO_CONST uint kBucketShift = 21;  // of a float's bits: two of the mantissa are left
// Beams of a channel that one workgroup resolves: enough to keep the atomics on the hit counter few.
GNO_CONST uint kResolveColumns = 1024;
// A triangle that moves fast around the sensor is bounded for intervals of the scan. An interval is divided if its box
// has more beams than this, and the scan fewer intervals of this length than the other number.
GNO_CONST uint kFewIntervalBeams = 32;
GNO_CONST uint kMostIntervals = 64;
// Slices of time into which the scan of a moving list is divided, intervals of columnMotions per slice, the columns and
// rows of cells per entry of sliceMasks, and the most entries that are read for a box.
GNO_CONST uint kTimeSlices = 32;
GNO_CONST uint kSliceIntervals = 64;
GNO_CONST uint kSliceColumns = 16;
GNO_CONST uint kSliceRows = 8;
GNO_CONST uint kMostSliceMasks = 64;
// Number of placed triangles per entry of ownerRanges.
GNO_CONST uint kOwnerBlock = 256;
// Number of values of Cause.
GNO_CONST uint kCauses = 6;
// Value of Counters::alive after the first kernel.
GNO_CONST uint kAlive = 0x51de1e55u;
// Beams per block of the prefix sum.
GNO_CONST uint kPrefixBlock = 1024;

// --- Specialisation constants --------------------------------------------------------------------------------------

GNO_CONST uint kBoundsPaper = 0;    // the floor of the corners' angles
GNO_CONST uint kBoundsCorners = 1;  // the corners' angles, ignoring bulging edges and poles
GNO_CONST uint kBoundsExact = 2;

GNO_CONST uint kCullFirstCorner = 0;
GNO_CONST uint kCullNearestPoint = 1;

GNO_CONST uint kInsidePlain = 0;
GNO_CONST uint kInsideWatertight = 1;
GNO_CONST uint kInsideExact = 2;

GNO_CONST uint kRangePlane = 0;
GNO_CONST uint kRangeEdgeWeights = 1;
GNO_CONST uint kRangeExact = 2;

GNO_CONST uint kFacesMaterial = 0;
GNO_CONST uint kFacesFront = 1;
GNO_CONST uint kFacesBoth = 2;

// Objects that are skipped before any of their triangles is read; bits of CULLING.
GNO_CONST uint kCullRange = 1;     // out of range
GNO_CONST uint kCullRows = 2;      // between two rows of beams, above or below the field of view
GNO_CONST uint kCullColumns = 4;   // between two columns of beams
GNO_CONST uint kCullOccluded = 8;  // behind the hits that all beams have already
GNO_CONST uint kCullCones = 16;    // clusters whose triangles are all back-facing

// How hits are assigned to beams.
GNO_CONST uint kBinningNearest = 0;  // one pass: 64-bit atomic minimum of (range, triangle)
GNO_CONST uint kBinningLists = 1;    // count and fill a list of candidates per beam
GNO_CONST uint kBinningSlabs = 2;    // minimum of (range, triangle) without atomics: each word has one owner

// Parts of the farthest-range table that a dispatch writes.
GNO_CONST uint kTableNone = 0;
GNO_CONST uint kTableLater = 1;  // only rows with content in later shells
GNO_CONST uint kTableAll = 2;

// Values of PASS, shader by shader: project_groups, bin with lists, bin with words, prefix_sum, resolve,
// effects_footprint, effects, records.
GNO_CONST uint kPassList = 0;
GNO_CONST uint kPassShells = 1;
GNO_CONST uint kPassCount = 0;
GNO_CONST uint kPassFill = 1;
GNO_CONST uint kPassNearest = 0;
GNO_CONST uint kPassPanes = 1;  // lists the panes before the beams' words
GNO_CONST uint kPassTable = 2;  // no hits, the farthest-range table instead
GNO_CONST uint kPassReduce = 0;
GNO_CONST uint kPassBlocks = 1;
GNO_CONST uint kPassApply = 2;
GNO_CONST uint kPassResults = 0;
GNO_CONST uint kPassWords = 1;      // only the words, which lists do not have
GNO_CONST uint kPassWithinOne = 0;  // beams whose footprint lies on one triangle
GNO_CONST uint kPassOthers = 1;     // the others whose light meets no pane
GNO_CONST uint kPassPanesToo = 2;   // those whose light may meet panes
GNO_CONST uint kPassAll = 0;
GNO_CONST uint kPassListed = 1;  // only the beams of hardBeams
GNO_CONST uint kPassCountReturns = 0;
GNO_CONST uint kPassHeader = 1;
GNO_CONST uint kPassEntries = 2;  // lists the entries with a return
GNO_CONST uint kPassRecords = 3;
GNO_CONST uint kPassLists = 4;  // only notes whether a list was too small for a group of beams that is not the last

// The values that records may hold: floats first, then integers.
GNO_CONST uint kValueX = 0;
GNO_CONST uint kValueY = 1;
GNO_CONST uint kValueZ = 2;
GNO_CONST uint kValueRange = 3;
GNO_CONST uint kValueIntensity = 4;
GNO_CONST uint kValueTrueRange = 5;
GNO_CONST uint kValueWidth = 6;
GNO_CONST uint kValueNormalX = 7;
GNO_CONST uint kValueNormalY = 8;
GNO_CONST uint kValueNormalZ = 9;
GNO_CONST uint kValueIncidence = 10;
GNO_CONST uint kValueBarycentricU = 11;
GNO_CONST uint kValueBarycentricV = 12;
GNO_CONST uint kValueVelocityX = 13;
GNO_CONST uint kValueVelocityY = 14;
GNO_CONST uint kValueVelocityZ = 15;
GNO_CONST uint kValueRadialSpeed = 16;
GNO_CONST uint kValueTime = 17;
GNO_CONST uint kValueAzimuth = 18;
GNO_CONST uint kValueElevation = 19;
GNO_CONST uint kFirstIntegerValue = 20;
GNO_CONST uint kValueRing = 20;
GNO_CONST uint kValueBeam = 21;
GNO_CONST uint kValueTriangle = 22;
GNO_CONST uint kValueInstance = 23;
GNO_CONST uint kValueLabel = 24;
GNO_CONST uint kValueCause = 25;
GNO_CONST uint kValueReturnNumber = 26;
GNO_CONST uint kValueReturnCount = 27;
GNO_CONST uint kValueMaterial = 28;
GNO_CONST uint kValueClass = 29;
GNO_CONST uint kValues = 30;
// In RECORDS beside the bits of the values: every value is a whole word of its own.
GNO_CONST uint kWholeWords = 0x80000000u;
// In RECORDS, too: the values come from the words of the beams.
GNO_CONST uint kFromWords = 0x40000000u;

// Values of the specialization constant DEFORMED.
GNO_CONST uint kDeformsNothing = 0;
GNO_CONST uint kDeforms = 1;
GNO_CONST uint kDeformsAndStores = 2;  // project stores the vertices, because later kernels read them

// Coordinates in buffers of the caller.
GNO_CONST uint kVertexF32 = 0;      // single precision, taken as they are
GNO_CONST uint kVertexU16 = 1;      // unsigned integers of 16 bits
GNO_CONST uint kVertexS16 = 2;      // signed ones
GNO_CONST uint kVertexSnorm16 = 3;  // signed ones, of which -32768 means the same as -32767

// Types of values in memory; the numbers of ValueType.
GNO_CONST uint kTypeF32 = 0;
GNO_CONST uint kTypeF64 = 1;
GNO_CONST uint kTypeU8 = 2;
GNO_CONST uint kTypeU16 = 3;
GNO_CONST uint kTypeU32 = 4;

// --- Structs ---------------------------------------------------------------------------------------------------------

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

// A corner of a projected triangle in the sensor's frame, with the tag that arrays.h describes.
struct TaggedCorner {
  vec3 corner;
  uint tag;
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

// All constants of a sensor that are not in tables.
struct Frame {
  uint columns;
  uint rows;
  uint beams;
  uint instanceCount;
  float rangeMin, rangeMax;
  float columnsPerRadian;
  float columnSlack;  // kAzimuthSlack in columns, plus the rounding of a column position
  uint projectedCapacity;
  uint tileCapacity;
  uint candidateCapacity;
  float paperFirstElevation;  // paper: elevation of row 0 in radians, and rows per radian
  float paperRowsPerRadian;
  float shiftMin, shiftMax;                 // columns by which a row's beams fire earlier (less than 0) or later than
                                            // those of their places: at least and at most
  float beside;                             // columns by which beams lie behind their places, at most
  uint momentsBefore, momentsAfter;         // entries of columnMotions before and behind those of the columns
  float stretch;                            // by so many more each beam of a row than that before, in order of azimuth
  float footprint;                          // radians: largest angle by which a beam spreads or deviates from its axis
  uint slabShift;                           // a slab has 1 << slabShift columns and is owned by one subgroup
  uint cullWorkgroups, triangleWorkgroups;  // of a shell's dispatches, if there is work for them
  uint shellClusters;                       // clusters that the first shell should hold
  float shellHint;                          // metres; a shell should end here; 0: nothing is known
  float spreadAcross;                       // like footprint, in azimuth and times the cosine of the elevation
  float spreadUp;                           // like footprint, in elevation
  uint ownRanges;                           // 1 if beams have ranges of their own
  uint hidesNear;                           // 1 if a hit nearer than the least range ends its beam
  float phase;                              // azimuth of column 0 beyond -180 degrees, in columns
  uint shellCount, shellGrowth;             // most shells of a scan; each has so many times the clusters of the last
  uint slabFirst, slabCount;                // slabs that hold all beams; after the last slab comes slab 0
  uint views;                               // of the submission
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
  uint causes[6];                    // beams by Cause, if effects are planned
  uint lostEchoes;                   // echoes beyond kMaxEchoes of a beam
  uint hardBeams;                    // beams whose footprint does not lie on one triangle; lines that meet a pane
  uint paneBeams;                    // beams whose footprint may meet a pane; not among hardBeams
  uint tried;                        // triangles whose beams project has tried; they are on no list
  uint alive;                        // kAlive after project_groups: the device has done something
};

// Where a value of every record lies, in words of 32 bits.
struct RecordPlace {
  uint first, stride;
};

// An instance has a semantic class, and its mesh has entries of classRuns from `firstRun` on.
struct InstanceClass {
  uint classId;
  uint firstRun, runs;  // runs: 0 if no material of the mesh states a class
};

// A run covers triangles of a mesh, up to the next run, whose materials state the same class; 0 if they state none.
struct ClassRun {
  uint firstTriangle, classId;
};

// How the results that stay on the device are written.
struct RecordPlan {
  uint entries;     // returns of all beams, with those that are missing
  uint capacity;    // most records that the caller's buffer holds
  uint organised;   // 1 if every entry has a record, 0 if only returns have one
  uint streams;     // entries of recordStreams
  uint gaps;        // entries of recordGaps
  uint classes;     // entries of instanceClasses
  uint directions;  // 1 if points do not lie on their beams, which then have an entry in beamDirections
  uint frame;       // number of the scan
  uint group;       // number of the group of beams
};

// Values that lie side by side in memory: all of a record, or a column. All places are in bytes.
struct RecordStream {
  uint start, stride;       // of the first record; from one record to the next
  uint firstValue, values;  // a run of recordValues, in the order of their offsets
  uint column;              // 1 if the bytes between values belong to somebody else
};

struct RecordValue {
  uint value;   // kValue...
  uint type;    // kType...
  uint offset;  // in the record
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
  uint nextCluster, nextSlab;                     // with slabs: the next one that no subgroup has taken
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

// The velocity of an instance's points, m/s in the sensor's axes: rows * (point, 1).
struct InstanceMotion {
  vec4 row0, row1, row2;
  // x: largest distance in metres that any of its points moves during the scan; y: largest change of a vector between
  // two of its points, as a share of the vector's length. If its mesh is deformed meanwhile, z is 1 and w is one over
  // the time that this takes, in 1/s; otherwise both are 0.
  vec4 bound;
};

// The sensor when a column fires: the column's frame = rows * (point, 1), where points are in the sensor's frame at
// the middle of the scan.
struct ColumnMotion {
  vec4 row0, row1, row2;
  vec4 report0, report1, report2;  // the frame that points are reported in = report * (point of the column's frame, 1)
  vec4 velocity;                   // of the sensor, m/s in the column's frame; w: seconds since the scan's start
};

// Bounds of the motion during the scan, relative to the sensor's frame at the middle of the scan.
struct MotionBounds {
  float shift, turn;                    // most metres and radians that the sensor moves, laser origins included
  float shiftPerColumn, turnPerColumn;  // at most, between neighbouring columns
  float origins;                        // metres: largest distance of a laser from the sensor's origin
  float forward, left, up;              // metres: largest parts of it, along the beam's azimuth, across and upwards
  float secondsPerColumn, seconds;      // per column, and for the whole scan
  uint instances, sensor;               // 1 if instances move, if the sensor moves; else its columns' frames are one
  float middle, columnsToMiddle;        // from the start of the scan to its middle: seconds, and columns
  vec3 drift;                           // metres by which the sensor moves from column to column, on average
  float wander, wanderPerColumn;        // most metres that it is elsewhere than with this average, and per column
};

#ifdef __cplusplus
static_assert(sizeof(MotionBounds) == 76 && sizeof(VertexSource) == 40);
static_assert(sizeof(TransformSource) == 104 && sizeof(TransformedInstance) == 36);
static_assert(sizeof(InstanceMotion) == 64 && sizeof(ColumnMotion) == 112);
static_assert(kClusterTriangles <= 32 && 3 * kClusterTriangles < 1 << 7);
static_assert(sizeof(Instance) == 64 && sizeof(Cluster) == 64 && sizeof(Group) == 32 && sizeof(Frame) == 140 &&
              sizeof(Row) == 32);
static_assert(sizeof(Counters) == 104 && sizeof(Pass) == 36 && sizeof(Shell) == 68);
}  // namespace gnosphere::gpu
#endif
#endif
