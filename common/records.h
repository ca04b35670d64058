// SPDX-License-Identifier: Apache-2.0
// Results in a layout of the caller: the values that it may hold, and where they lie.
#ifndef GNOSPHERE_COMMON_RECORDS_H
#define GNOSPHERE_COMMON_RECORDS_H

#include "types.h"

#ifdef __cplusplus
namespace gnosphere::gpu {
#endif

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
#ifdef __cplusplus
static_assert((1ull << kValues) <= kFromWords, "every value has a bit of RECORDS below kFromWords and kWholeWords");
#endif

// Types of values in memory; the numbers of ValueType.
GNO_CONST uint kTypeF32 = 0;
GNO_CONST uint kTypeF64 = 1;
GNO_CONST uint kTypeU8 = 2;
GNO_CONST uint kTypeU16 = 3;
GNO_CONST uint kTypeU32 = 4;

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

// How the results of a shot that stay on the device are written.
struct RecordPlan {
  uint entries;     // returns of all beams, with those that are missing
  uint capacity;    // most records that the caller's buffer holds
  uint organised;   // 1 if every entry has a record, 0 if only returns have one
  uint streams;     // entries of recordStreams
  uint gaps;        // entries of recordGaps
  uint classes;     // entries of instanceClasses
  uint directions;  // 1 if points do not tell the directions of beams, which beamDirections then has
  uint frame;       // number of the scan
  uint continues;   // 1 if an earlier submission has projected other beams of the shot
  uint firstBeam;   // entry of the first beam in beamPlaces, beamFacts and beamDirections
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

#ifdef __cplusplus
}  // namespace gnosphere::gpu
#endif
#endif
