// SPDX-License-Identifier: Apache-2.0
// Stage records: writes the results of a scan that stay on the device, in the caller's layout. The passes count the
// entries with a return per block of entries, sum the counts and write the header, list the entries in order, and write
// the records. No workgroup waits for another.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
#include "shared.h"
#include "options.glsl"
#include "bindings.glsl"
#include "effects/incidence.h"
#include "buckets.glsl"

layout(local_size_x = 64) in;

const uint kLanes = gl_WorkGroupSize.x;
const uint kPerLane = kPrefixBlock / kLanes;
const uint kRangeSamples = 2048;
// Four records of any size are a whole number of words, so an invocation that writes four shares no word with another.
const uint kRecordsEach = 4;
shared uint laneSums[kLanes];
shared uint sampled[kShellBuckets];

RecordPlan plan = recordPlanAt.at[0];

uint blockCount() { return (plan.entries + kPrefixBlock - 1) / kPrefixBlock; }

bool isNumber(float value) { return (floatBitsToUint(value) & 0x7fffffffu) <= 0x7f800000u; }
bool returned(uint entry) { return isNumber(points.at[entry].w); }

// Returns the sum over the lanes before this one. All lanes of the workgroup must call this.
uint sumBefore(uint value, out uint total) {
  uint lane = gl_LocalInvocationID.x;
  laneSums[lane] = value;
  barrier();
  uint before = 0;
  total = 0;
  for (uint k = 0; k < kLanes; ++k) {
    if (k < lane) before += laneSums[k];
    total += laneSums[k];
  }
  barrier();
  return before;
}

uint returnsOfLane(uint block) {
  uint sum = 0;
  for (uint k = 0; k < kPerLane; ++k) {
    uint entry = block * kPrefixBlock + gl_LocalInvocationID.x * kPerLane + k;
    if (entry < plan.entries && returned(entry)) ++sum;
  }
  return sum;
}

void countReturns() {
  for (uint block = gl_WorkGroupID.x; block < blockCount(); block += gl_NumWorkGroups.x) {
    uint total;
    sumBefore(returnsOfLane(block), total);
    if (gl_LocalInvocationID.x == 0) recordBlocks.at[block] = total;
  }
}

// Counts the ranges of a sample of the entries by distance, from which the host chooses the shells of later scans.
void sampleRanges() {
  uint lane = gl_LocalInvocationID.x;
  for (uint bucket = lane; bucket < kShellBuckets; bucket += kLanes) sampled[bucket] = 0;
  barrier();
  uint stride = plan.entries / kRangeSamples | 1;  // an odd stride meets all columns of a grid
  for (uint entry = lane * stride; entry < plan.entries; entry += kLanes * stride)
    if (returned(entry)) atomicAdd(sampled[bucketOf(points.at[entry].w)], 1);
  barrier();
  for (uint bucket = lane; bucket < kShellBuckets; bucket += kLanes) rangeCounts.at[bucket] = sampled[bucket];
}

bool listsTooSmall() {
  return counters.projectedSmall + counters.projectedLarge > frame.projectedCapacity ||
         counters.tiles > frame.tileCapacity || counters.candidates > frame.candidateCapacity;
}

// Runs in one workgroup; each lane processes a range of consecutive blocks.
void sumBlocks() {
  uint run = (blockCount() + kLanes - 1) / kLanes;
  uint first = gl_LocalInvocationID.x * run, end = min(first + run, blockCount());
  uint sum = 0;
  for (uint k = first; k < end; ++k) sum += recordBlocks.at[k];
  uint total;
  uint start = sumBefore(sum, total);
  for (uint k = first; k < end; ++k) {
    uint count = recordBlocks.at[k];
    recordBlocks.at[k] = start;
    start += count;
  }
  sampleRanges();
  if (gl_LocalInvocationID.x > 0) return;
  uint wanted = plan.organised != 0 ? plan.entries : total;
  recordHeader.at[0] = min(wanted, plan.capacity);
  recordHeader.at[1] = 1;
  recordHeader.at[2] = 0;
  recordHeader.at[3] = 0;
  recordHeader.at[4] = wanted;
  recordHeader.at[5] = total;
  recordHeader.at[6] = listsTooSmall() ? 1 : 0;
  recordHeader.at[7] = plan.frame;
}

void listEntries() {
  for (uint block = gl_WorkGroupID.x; block < blockCount(); block += gl_NumWorkGroups.x) {
    uint total;
    uint at = recordBlocks.at[block] + sumBefore(returnsOfLane(block), total);
    for (uint k = 0; k < kPerLane; ++k) {
      uint entry = block * kPrefixBlock + gl_LocalInvocationID.x * kPerLane + k;
      if (entry < plan.entries && returned(entry)) recordEntries.at[at++] = entry;
    }
  }
}

// --- Values -------------------------------------------------------------------------------------------------------

float notANumberIf(bool condition, float value) { return condition ? uintBitsToFloat(0x7fc00000u) : value; }

float incidenceAt(uint entry) {
  vec4 point = points.at[entry];
  vec3 normal = surfaces.at[entry].normal;
  if (plan.directions != 0) return incidenceOf(normal, beamDirections.at[entry / RETURNS].xyz, 1.0);
  return incidenceOf(normal, point.xyz, point.w);
}

float floatOf(uint field, uint component, uint entry) {
  bool hit = owners.at[entry].x != kNone;
  switch (field) {
    case kValueX: return points.at[entry].x;
    case kValueY: return points.at[entry].y;
    case kValueZ: return points.at[entry].z;
    case kValueRange: return points.at[entry].w;
    case kValueIntensity: return signals.at[entry].intensity;
    case kValueTrueRange: return signals.at[entry].trueRange;
    case kValueWidth: return signals.at[entry].width;
    case kValueNormal: return notANumberIf(!hit, surfaces.at[entry].normal[component]);
    case kValueIncidence: return notANumberIf(!hit, incidenceAt(entry));
    case kValueBarycentrics: return notANumberIf(!hit, barycentrics.at[entry][component]);
    case kValueVelocity: return motions.at[entry][component];
    case kValueRadialSpeed: return motions.at[entry].w;
    case kValueTime: return beamFacts.at[entry / RETURNS].x;
    case kValueAzimuth: return beamFacts.at[entry / RETURNS].y;
    case kValueElevation: return beamFacts.at[entry / RETURNS].z;
  }
  return 0.0;
}

uint returnCountOf(uint first) {
  uint count = 0;
  for (uint k = 0; k < RETURNS; ++k) count += returned(first + k) ? 1 : 0;
  return count;
}

uint integerOf(uint field, uint entry) {
  uint beam = entry / RETURNS;
  switch (field) {
    case kValueRing: return floatBitsToUint(beamFacts.at[beam].w);
    case kValueBeam: return beam;
    case kValueTriangle: return owners.at[entry].x;
    case kValueInstance: return owners.at[entry].y;
    case kValueLabel: return signals.at[entry].word & 0xff;
    case kValueCause: return signals.at[beam * RETURNS].word >> 8 & 0xff;  // stored in the first return of the beam
    case kValueReturnNumber: return returned(entry) ? entry % RETURNS + 1 : 0;
    case kValueReturnCount: return returnCountOf(beam * RETURNS);
    case kValueMaterial: return owners.at[entry].x != kNone ? surfaces.at[entry].material : kNone;
    case kValueClass: return owners.at[entry].y < plan.classes ? instanceClasses.at[owners.at[entry].y] : 0;
  }
  return 0;
}

// Returns the bits of a float as a double, low word first; denormals become zero.
uvec2 doubleOf(float value) {
  uint bits = floatBitsToUint(value), sign = bits & 0x80000000u;
  uint exponent = bits >> 23 & 0xff, fraction = bits & 0x7fffffu;
  if (exponent == 0) return uvec2(0, sign);
  uint wide = exponent == 255 ? 2047 : exponent + 896;
  return uvec2(fraction << 29, sign | wide << 20 | fraction >> 3);
}

uvec2 doubleOf(uint value) {
  if (value == 0) return uvec2(0);
  uint top = uint(findMSB(value)), fraction = value ^ 1u << top;
  uint high = 1023 + top << 20;
  if (top <= 20) return uvec2(0, high | fraction << 20 - top);
  return uvec2(fraction << 52 - top, high | fraction >> top - 20);
}

// Returns the bits of a value in memory, low word first.
uvec2 bitsOf(RecordValue value, uint entry) {
  if (value.field < kFirstIntegerValue) {
    float number = floatOf(value.field, value.component, entry);
    return value.type == kTypeF64 ? doubleOf(number) : uvec2(floatBitsToUint(number), 0);
  }
  uint number = integerOf(value.field, entry);
  if (value.type == kTypeF64) return doubleOf(number);
  return uvec2(value.type == kTypeF32 ? floatBitsToUint(float(number)) : number, 0);
}

// --- Writing ------------------------------------------------------------------------------------------------------

uint place;    // of the next byte
uint pending;  // bytes of the word of `place` that come before it

// Moves on to `next`. The bytes between are 0 if `filling`; otherwise words without a value are left alone.
void moveTo(uint next, bool filling) {
  if (next / 4 != place / 4) {
    if (filling || place % 4 != 0) records.at[place / 4] = pending;
    if (filling)
      for (uint word = place / 4 + 1; word < next / 4; ++word) records.at[word] = 0;
    pending = 0;
  }
  place = next;
}

void put(uint bits, uint bytes) {
  uint shift = 8 * (place % 4);
  pending |= bits << shift;
  if (place % 4 + bytes >= 4) {
    records.at[place / 4] = pending;
    pending = shift == 0 ? 0 : bits >> 32 - shift;
  }
  place += bytes;
}

uint sizeOf(uint type) { return type == kTypeU8 ? 1 : type == kTypeU16 ? 2 : 4; }

void writeStream(RecordStream stream, uint first, uint end) {
  bool filling = stream.column == 0;
  place = stream.start + first * stream.stride;
  pending = 0;
  for (uint record = first; record < end; ++record) {
    uint entry = plan.organised != 0 ? record : recordEntries.at[record];
    for (uint k = 0; k < stream.values; ++k) {
      RecordValue value = recordValues.at[stream.firstValue + k];
      moveTo(stream.start + record * stream.stride + value.offset, filling);
      uvec2 bits = bitsOf(value, entry);
      put(bits.x, sizeOf(value.type));
      if (value.type == kTypeF64) put(bits.y, 4);
    }
    if (filling) moveTo(stream.start + (record + 1) * stream.stride, filling);
  }
  if (place % 4 != 0) records.at[place / 4] = pending;
}

void writeRecords() {
  uint count = recordHeader.at[0];
  for (uint first = kRecordsEach * gl_GlobalInvocationID.x; first < count;
       first += kRecordsEach * kLanes * gl_NumWorkGroups.x)
    for (uint k = 0; k < plan.streams; ++k)
      writeStream(recordStreams.at[k], first, min(first + kRecordsEach, count));
}

void main() {
  if (PASS == kPassCountReturns) countReturns();
  if (PASS == kPassHeader) sumBlocks();
  if (PASS == kPassEntries) listEntries();
  if (PASS == kPassRecords) writeRecords();
}
