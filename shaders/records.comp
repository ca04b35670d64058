// SPDX-License-Identifier: Apache-2.0
// Stage records: writes the results of a scan that stay on the device, in the caller's layout. The passes count the
// entries with a return per block of entries, sum the counts and write the header, list the entries in order, and write
// the records. If every entry has a record, the pass that writes the records also counts the returns, and no pass before
// it needs a barrier, for which CPU drivers pay in every workgroup. No workgroup waits for another. Each shot of a
// submission has a row of workgroups, results of its own, and buffers of the caller. If several submissions project the
// beams of a shot, these passes run once, after the last one. If the words of the beams tell their returns (see
// leavesWords()), the results come from them, and no stage stores points; each shot is then one view.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_buffer_reference_uvec2 : require
#extension GL_EXT_scalar_block_layout : require
#include "common/shared.h"
#include "options.glsl"
#include "bindings.glsl"
#include "common/effects/incidence.h"
#include "to_sensor.glsl"
#include "common/beam.h"
#include "views.glsl"
#include "beams.glsl"
#include "motion.glsl"
#include "owner.glsl"
#include "buckets.glsl"

layout(local_size_x = 64) in;

#include "workgroup_sums.glsl"

#define FROM_WORDS ((RECORDS & kFromWords) != 0)

// Four records of any size are a whole number of words, so an invocation that writes four shares no word with another.
const uint kRecordsEach = 4;
shared uint sampled[kShellBuckets + 1];  // see workgroup_sums.glsl

uint shot;
RecordPlan plan;
RecordMemory records, recordHeader;

// Sets the shot for which this workgroup works.
void beginShot() {
  shot = gl_WorkGroupID.y;
  plan = recordPlans.at[shot];
  records = recordBuffers.at[shot].records;
  recordHeader = recordBuffers.at[shot].header;
  if (FROM_WORDS) lookFrom(shot);
}

// Returns the place of an entry of the shot in arrays with the results of all shots.
uint resultAt(uint entry) { return shot * plan.entries + entry; }

uint blockCount() { return (plan.entries + kPrefixBlock - 1) / kPrefixBlock; }

// Returns the word of a beam by its number; kNone for a beam without a return. Stage effects asks whether a hit hides
// itself before it adds noise to ranges.
uvec2 wordOf(uint beam) {
  uint index = beamPlaces.at[plan.firstBeam + beam];
  if (index == kNone) return uvec2(kNone);
  uvec2 word = words.at[beamEntry(index)];
  if ((EFFECTS & kRangeNoise) == 0 && word.y != kNone && hidesItself(index, uintBitsToFloat(word.y)))
    return uvec2(kNone);
  return word;
}

float rangeOf(uint entry) {
  if (!FROM_WORDS) return points.at[resultAt(entry)].w;
  uint bits = wordOf(entry).y;
  return uintBitsToFloat(bits == kNone ? 0x7fc00000u : bits);
}

bool isNumber(float value) { return (floatBitsToUint(value) & 0x7fffffffu) <= 0x7f800000u; }
bool returned(uint entry) { return isNumber(rangeOf(entry)); }

// Returns an owner with the instance's number in the scene. With several views, an instance is an entry of a view.
uvec2 inScene(uvec2 owner) {
  return VIEWS && owner.y != kNone ? uvec2(owner.x, instanceNumbers.at[owner.y]) : owner;
}

// Returns point and range of an entry, and in `owner` the triangle within its mesh and the instance.
vec4 pointOf(uint entry, out uvec2 owner) {
  if (!FROM_WORDS) {
    owner = inScene(owners.at[resultAt(entry)]);
    return points.at[resultAt(entry)];
  }
  owner = uvec2(kNone);
  uvec2 word = wordOf(entry);
  if (word.y == kNone) return vec4(uintBitsToFloat(0x7fc00000u));
  if (word.x != kNone) owner = inScene(ownerOf(word.x));
  uint index = beamPlaces.at[plan.firstBeam + entry];
  Beam beam = beamWith(index);
  float range = uintBitsToFloat(word.y);
  vec3 point = beam.direction * range;
  if (MOTION) point = reported(columnOf(index), rowOf(index), beam.azimuth, beam.direction, range);
  return vec4(point, range);
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
    if (gl_LocalInvocationID.x == 0) recordBlocks.at[shot * blockCount() + block] = total;
  }
}

// Counts the ranges of a sample of the entries by distance, from which the host chooses the shells of later scans.
void sampleRanges() {
  uint lane = gl_LocalInvocationID.x;
  for (uint bucket = lane; bucket < kShellBuckets; bucket += kLanes) sampled[bucket] = 0;
  barrier();
  uint stride = plan.entries / kHintSamples | 1;  // an odd stride meets all columns of a grid
  for (uint entry = lane * stride; entry < plan.entries; entry += kLanes * stride)
    if (returned(entry)) atomicAdd(sampled[bucketOf(rangeOf(entry))], 1);
  barrier();
  for (uint bucket = lane; bucket < kShellBuckets; bucket += kLanes) rangeCounts.at[bucket] = sampled[bucket];
}

bool listsTooSmall() {
  return counters.projectedSmall + counters.projectedLarge > frame.projectedCapacity ||
         counters.tiles > frame.tileCapacity || counters.candidates > frame.candidateCapacity;
}

// Notes in the header whether a list was too small for this submission or an earlier one of the shot.
void noteLists() {
  uint before = plan.continues != 0 ? recordHeader.at[6] : 0;
  recordHeader.at[6] = listsTooSmall() ? 1 : before;
}

// Lists the entries with a return of a block, behind those `before` it, and returns their number.
uint listBlock(uint block, uint before) {
  uint total;
  uint at = before + sumBefore(returnsOfLane(block), total);
  for (uint k = 0; k < kPerLane; ++k) {
    uint entry = block * kPrefixBlock + gl_LocalInvocationID.x * kPerLane + k;
    if (entry < plan.entries && returned(entry)) recordEntries.at[resultAt(at++)] = entry;
  }
  return total;
}

void writeHeader(uint wanted, uint hits) {
  recordHeader.at[0] = min(wanted, plan.capacity);
  recordHeader.at[1] = 1;
  recordHeader.at[2] = 0;
  recordHeader.at[3] = 0;
  recordHeader.at[4] = wanted;
  recordHeader.at[5] = hits;
  noteLists();
  recordHeader.at[7] = plan.frame;
}

// Runs in one workgroup; each lane processes a range of consecutive blocks, and returns the sum of all.
uint sumBlocks() {
  uint run = (blockCount() + kLanes - 1) / kLanes, block = shot * blockCount();
  uint first = gl_LocalInvocationID.x * run, end = min(first + run, blockCount());
  uint sum = 0;
  for (uint k = first; k < end; ++k) sum += recordBlocks.at[block + k];
  uint total;
  uint start = sumBefore(sum, total);
  for (uint k = first; k < end; ++k) {
    uint count = recordBlocks.at[block + k];
    recordBlocks.at[block + k] = start;
    start += count;
  }
  return total;
}

// The only block of a shot was not counted before; its entries are listed at once.
void writeHeaderOfReturns() {
  uint total = blockCount() == 1 ? listBlock(0, 0) : sumBlocks();
  if (shot == 0) sampleRanges();
  if (gl_LocalInvocationID.x == 0) writeHeader(total, total);
}

void listEntries() {
  for (uint block = gl_WorkGroupID.x; block < blockCount(); block += gl_NumWorkGroups.x)
    listBlock(block, recordBlocks.at[shot * blockCount() + block]);
}

// --- Values -------------------------------------------------------------------------------------------------------

// True if the records hold the value; false at compile time for all others.
#define HOLDS(value_) ((RECORDS & 1u << (value_)) != 0)
#define HOLDS_ANY(bits_) ((RECORDS & (bits_)) != 0)
#define BITS(first_, last_) ((2u << (last_)) - (1u << (first_)))

float notANumberIf(bool condition, float value) { return condition ? uintBitsToFloat(0x7fc00000u) : value; }

float incidenceAt(uint entry, vec4 point) {
  vec3 normal = surfaces.at[resultAt(entry)].normal;
  if (plan.directions != 0) return incidenceOf(normal, beamDirections.at[plan.firstBeam + entry / RETURNS].xyz, 1.0);
  return incidenceOf(normal, point.xyz, point.w);
}

uint returnCountOf(uint first) {
  uint count = 0;
  for (uint k = 0; k < RETURNS; ++k) count += returned(first + k) ? 1 : 0;
  return count;
}

// Returns the class of a triangle: the one that its material states, else that of its instance.
uint classOf(uvec2 owner) {
  if (owner.y >= plan.classes) return 0;
  InstanceClass instance = instanceClasses.at[owner.y];
  if (instance.runs == 0) return instance.classId;
  uint first = instance.firstRun, end = first + instance.runs;
  while (end - first > 1) {
    uint middle = (first + end) / 2;
    if (classRuns.at[middle].firstTriangle <= owner.x)
      first = middle;
    else
      end = middle;
  }
  uint stated = classRuns.at[first].classId;
  return stated != 0 ? stated : instance.classId;
}

// Calls USE(number of the value, its bits) for every value of an entry. A float has its own bits.
#define EACH_VALUE(entry_, USE) \
  { \
    uint beam_ = (entry_) / RETURNS; \
    uvec2 owner_ = uvec2(kNone); \
    vec4 point_ = vec4(0.0); \
    if (HOLDS_ANY(BITS(kValueX, kValueRange) | BITS(kValueNormalX, kValueBarycentricV) | \
                  BITS(kValueTriangle, kValueInstance) | BITS(kValueMaterial, kValueClass))) \
      point_ = pointOf(entry_, owner_); \
    bool hit_ = owner_.x != kNone; \
    USE(kValueX, floatBitsToUint(point_.x)); \
    USE(kValueY, floatBitsToUint(point_.y)); \
    USE(kValueZ, floatBitsToUint(point_.z)); \
    USE(kValueRange, floatBitsToUint(point_.w)); \
    if (HOLDS(kValueIntensity)) USE(kValueIntensity, floatBitsToUint(intensities.at[resultAt(entry_)])); \
    if (HOLDS_ANY(BITS(kValueTrueRange, kValueWidth) | 1u << kValueLabel)) { \
      SignalRecord signal_ = signals.at[resultAt(entry_)]; \
      USE(kValueTrueRange, floatBitsToUint(signal_.trueRange)); \
      USE(kValueWidth, floatBitsToUint(signal_.width)); \
      USE(kValueLabel, signal_.word & 0xff); \
    } \
    if (HOLDS_ANY(BITS(kValueNormalX, kValueNormalZ) | 1u << kValueMaterial)) { \
      SurfaceRecord surface_ = surfaces.at[resultAt(entry_)]; \
      USE(kValueNormalX, floatBitsToUint(notANumberIf(!hit_, surface_.normal.x))); \
      USE(kValueNormalY, floatBitsToUint(notANumberIf(!hit_, surface_.normal.y))); \
      USE(kValueNormalZ, floatBitsToUint(notANumberIf(!hit_, surface_.normal.z))); \
      USE(kValueMaterial, hit_ ? surface_.material : kNone); \
    } \
    if (HOLDS(kValueIncidence)) USE(kValueIncidence, floatBitsToUint(notANumberIf(!hit_, incidenceAt(entry_, point_)))); \
    if (HOLDS_ANY(BITS(kValueBarycentricU, kValueBarycentricV))) { \
      vec2 weights_ = barycentrics.at[resultAt(entry_)]; \
      USE(kValueBarycentricU, floatBitsToUint(notANumberIf(!hit_, weights_.x))); \
      USE(kValueBarycentricV, floatBitsToUint(notANumberIf(!hit_, weights_.y))); \
    } \
    if (HOLDS_ANY(BITS(kValueVelocityX, kValueRadialSpeed))) { \
      vec4 motion_ = motions.at[resultAt(entry_)]; \
      USE(kValueVelocityX, floatBitsToUint(motion_.x)); \
      USE(kValueVelocityY, floatBitsToUint(motion_.y)); \
      USE(kValueVelocityZ, floatBitsToUint(motion_.z)); \
      USE(kValueRadialSpeed, floatBitsToUint(motion_.w)); \
    } \
    if (HOLDS_ANY(BITS(kValueTime, kValueRing))) { \
      uvec4 facts_ = beamFacts.at[plan.firstBeam + beam_]; \
      USE(kValueTime, facts_.x); \
      USE(kValueAzimuth, facts_.y); \
      USE(kValueElevation, facts_.z); \
      USE(kValueRing, facts_.w); \
    } \
    USE(kValueBeam, beam_); \
    USE(kValueTriangle, owner_.x); \
    USE(kValueInstance, owner_.y); \
    /* The cause of a beam is stored in its first return. */ \
    if (HOLDS(kValueCause)) USE(kValueCause, signals.at[resultAt(beam_ * RETURNS)].word >> 8 & 0xff); \
    if (HOLDS(kValueReturnNumber)) USE(kValueReturnNumber, returned(entry_) ? (entry_) % RETURNS + 1 : 0); \
    if (HOLDS(kValueReturnCount)) USE(kValueReturnCount, returnCountOf(beam_ * RETURNS)); \
    if (HOLDS(kValueClass)) USE(kValueClass, classOf(owner_)); \
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

// Returns the bits of a value in memory, low word first. `bits` are those of its own type.
uvec2 converted(uint value, uint type, uint bits) {
  bool real = value < kFirstIntegerValue;
  if (type == kTypeF64) return real ? doubleOf(uintBitsToFloat(bits)) : doubleOf(bits);
  return uvec2(type == kTypeF32 && !real ? floatBitsToUint(float(bits)) : bits, 0);
}

// --- Writing ------------------------------------------------------------------------------------------------------

uint place;    // of the next byte
uint pending;  // bytes of the word of `place` that come before it

// Moves on to the place `next`. The bytes between are 0 if `filling`; otherwise words without a value are left alone.
void moveTo(uint next, bool filling) {
  if (next / 4 != place / 4) {
    if (filling || place % 4 != 0) records.at[place / 4] = pending;
    if (filling)
      for (uint word = place / 4 + 1; word < next / 4; ++word) records.at[word] = 0;
    pending = 0;
  }
  place = next;
}

uint entryOf(uint record) { return plan.organised != 0 ? record : recordEntries.at[resultAt(record)]; }

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
    uint bits[kValues];
    uint entry = entryOf(record);
#define KEEP(value_, bits_) bits[value_] = bits_
    EACH_VALUE(entry, KEEP)
    for (uint k = 0; k < stream.values; ++k) {
      RecordValue value = recordValues.at[stream.firstValue + k];
      moveTo(stream.start + record * stream.stride + value.offset, filling);
      uvec2 memory = converted(value.value, value.type, bits[value.value]);
      put(memory.x, sizeOf(value.type));
      if (value.type == kTypeF64) put(memory.y, 4);
    }
    if (filling) moveTo(stream.start + (record + 1) * stream.stride, filling);
  }
  if (place % 4 != 0) records.at[place / 4] = pending;
}

void writeWords(uint record) {
  uint entry = entryOf(record);
#define STORE(value_, bits_) \
  if (HOLDS(value_)) records.at[recordPlaces.at[value_].first + record * recordPlaces.at[value_].stride] = bits_
  EACH_VALUE(entry, STORE)
  for (uint k = 0; k < plan.gaps; ++k) records.at[recordGaps.at[k].first + record * recordGaps.at[k].stride] = 0;
}

// Adds to the header the returns among the entries for which an invocation writes the records, and among those for which
// the caller's buffer has no room.
void countHits() {
  uint hits = 0;
  for (uint entry = gl_GlobalInvocationID.x; entry < plan.entries; entry += kLanes * gl_NumWorkGroups.x)
    if (returned(entry)) ++hits;
  if (hits > 0) atomicAdd(recordHeader.at[5], hits);
}

void writeRecords() {
  uint count = recordHeader.at[0];
  if (plan.organised != 0) countHits();
  if ((RECORDS & kWholeWords) != 0) {
    for (uint record = gl_GlobalInvocationID.x; record < count; record += kLanes * gl_NumWorkGroups.x)
      writeWords(record);
    return;
  }
  for (uint first = kRecordsEach * gl_GlobalInvocationID.x; first < count;
       first += kRecordsEach * kLanes * gl_NumWorkGroups.x)
    for (uint k = 0; k < plan.streams; ++k)
      writeStream(recordStreams.at[k], first, min(first + kRecordsEach, count));
}

void main() {
  useOwnAddresses();
  loadMotion();
  beginShot();
  if (PASS == kPassRecordsNoteLists && gl_LocalInvocationID.x == 0) noteLists();
  if (PASS == kPassRecordsCount) countReturns();
  if (PASS == kPassRecordsHeader) writeHeaderOfReturns();
  if (PASS == kPassRecordsHeaderOfAll && gl_LocalInvocationID.x == 0) writeHeader(plan.entries, 0);
  if (PASS == kPassRecordsSample) sampleRanges();
  if (PASS == kPassRecordsEntries) listEntries();
  if (PASS == kPassRecordsWrite) writeRecords();
}
