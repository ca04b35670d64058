// SPDX-License-Identifier: Apache-2.0
// Last pass of the stage effects. One row of workgroups per channel, one invocation per beam: turns the echoes of a
// beam into returns. A beam without a footprint that meets no pane has one echo, the nearest hit in its word.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_buffer_reference_uvec2 : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#extension GL_KHR_shader_subgroup_shuffle : require
#extension GL_KHR_shader_subgroup_vote : require
#include "common/shared.h"
#include "options.glsl"
#include "bindings.glsl"
#include "common/effects/vector.h"
#include "common/beam.h"
#include "views.glsl"
#include "beams.glsl"
#include "runs.glsl"
#include "common/effects/doppler.h"
#include "motion.glsl"
#include "beam_place.glsl"
#include "owner.glsl"
#include "strays.glsl"
#include "to_sensor.glsl"
#include "surface_of.glsl"
#include "shared_surface.glsl"

layout(local_size_x = 64) in;

// Macros, because glslang 11 fails on constants that depend on specialisation constants.
#define SIGNALS ((EFFECTS & kSignalEffects) != 0 || (FIELDS & (kFieldSignal | kFieldIntensity)) != 0)
#define SPEEDS ((EFFECTS & kRadialSpeed) != 0 || (FIELDS & kFieldMotion) != 0)
#define MOST_ECHOES ((EFFECTS & (kFootprint | kTransmission)) != 0 ? keptEchoes(RETURNS) : 1u)
#define MANY_ECHOES ((EFFECTS & kFootprint) != 0 || PASS == kPassEffectsListed)
#define POINTS ((FIELDS & kFieldPoints) != 0)
#define LOOKS_AT_MATERIALS ((EFFECTS & kIntensity) != 0 && planned.intensityModel == kModelPhysical)

// The beam being processed: its number, its index in `words`, and whether `echoes` has its echoes, and its hit if not.
uint beamIndex, wordIndex, rowIndex, columnIndex;
bool many;
vec3 beamDirection, lightDirection, pointDirection;
uvec2 hitWord;
float hitRange;  // NaN if there is no hit
uvec2 hitOwner;  // found only if it is stored
SurfaceRecord hitSurface;
vec2 hitBarycentrics;
Echo hitEcho;  // of a beam with a hit, if `echoes` does not have it
// Each invocation counts hits and causes. The array has one entry more than there are causes, as laneSums has one more
// in workgroup_sums.glsl: arrays of equal size have one type, and those of `Counters`, of 8, have a stride.
uint hits;
uint causeCounts[kCauses + 1];
EffectParameters planned;   // loaded once, because a compiler must reload memory after each store that may alias it

Echo loadEcho(uint k);
void storeReturn(uint j, Return value);
VolumeBox loadVolume(uint i) {
  VolumeBox box = volumes.at[view * planned.volumeCount + i];
  if (MOTION) {
    box.row0 = seenPlane(beamMotion, beamOrigin, box.row0);
    box.row1 = seenPlane(beamMotion, beamOrigin, box.row1);
    box.row2 = seenPlane(beamMotion, beamOrigin, box.row2);
  }
  return box;
}
bool isDead(uint beam) {
  return (deadBeams.at[beam / 32] >> (beam % 32) & 1) != 0;
}

#define OWN_RANGES NUMBERED
#include "common/effects/signal.h"

// Computes the echo of the hit of a beam that has no others. Its energy needs the material, many loads on a CPU.
Echo echoOfHit() {
  float energy = 1.0;
  if (LOOKS_AT_MATERIALS) {
    vec3 direction = lightDirection;
    if (MOTION) direction = reportedDirection(beamMotion, direction);
    float cosIncidence = min(abs(dotOf(hitSurface.normal, direction)), 1.0);
    energy = reflected(optics.at[hitSurface.material], cosIncidence);
  }
  return Echo(hitRange, energy, planned.pulseWidth, 0.0, 0);
}

Echo loadEcho(uint k) {
  if (!many) return hitEcho;
  vec4 echo = echoes.at[echoPlace(wordIndex, k)];
  return Echo(echo.x, echo.y, echo.z, echo.w, k);
}

// Returns the velocity of the point of a moving triangle that the beam meets, in the column's frame; `point` is as seen
// from the laser. Between the velocities of its corners lie those of triangles that deform, or of flat instances.
vec3 surfaceVelocityAt(uvec2 owner, vec3 point) {
  InstanceMotion moving = instanceMotions.at[owner.y];
  vec3 rigid;
  if (DEFORMED == kDeformsNothing || moving.bound.z == 0.0) {
    precise vec3 met = point + beamOrigin;  // `point` is a product, and no device may fuse it with this sum
    vec3 now = fromColumn(beamMotion, met);
    if (findVelocity(moving, instances.at[owner.y], beamMotion.velocity.w, now, rigid))
      return rotated(beamMotion.row0, beamMotion.row1, beamMotion.row2, rigid);
  }
  Surface surface = surfaceOf(owner, beamMotion, beamOrigin);
  vec2 shares = barycentricsOf(surface.corners, point);
  precise vec3 velocity = surface.velocities.a + (surface.velocities.b - surface.velocities.a) * shares.x +
                          (surface.velocities.c - surface.velocities.a) * shares.y;
  return rotated(beamMotion.row0, beamMotion.row1, beamMotion.row2, velocity);
}

// Returns the velocity of the beam's laser in the column's frame.
vec3 laserVelocity() {
  if (!ORIGINS) return beamMotion.velocity.xyz;
  precise vec3 velocity = beamMotion.velocity.xyz + crossOf(beamMotion.spin.xyz, beamOrigin);
  return velocity;
}

// Stores the velocity of the surface where the light meets it, and its radial speed as the sensor measures it. Without
// motion the velocity is 0. That of fog, drops, flakes and dust is always 0.
void storeMotion(uint at, uvec2 owner, Return value) {
  vec3 velocity = vec3(0.0);
  float radial = 0.0;
  if (MOTION) {
    if (owner.x != kNone && motion.instances != 0) velocity = surfaceVelocityAt(owner, lightDirection * value.trueRange);
    radial = radialSpeed(lightDirection, velocity, laserVelocity());
    velocity = reportedDirection(beamMotion, velocity);
  }
  if ((EFFECTS & kSpeedNoise) != 0) {
    uint number = value.label == kLabelSolid ? value.echo : kScatterDraw;
    radial = noisySpeed(planned, radial, gaussians(draw(planned, beamIndex, number, kRadialSpeed)).x);
  }
  motions.at[at] = vec4(velocity, value.label != kLabelNone ? radial : notANumber());
}

// Stores the return in a word of its beam. Point and owner are then computed from the word as for a nearest hit.
void storeWord(uint j, Return value, uvec2 owner) {
  uvec2 word = uvec2(kNone);
  if (value.label != kLabelNone) word.y = floatBitsToUint(value.range);
  if (value.label == kLabelSolid) word.x = many ? firstTriangleOf(owner.y) + owner.x : hitWord.x;
  if (j > 0)
    laterWords.at[firstWord() * (RETURNS - 1) + (j - 1) * frame.beams + wordIndex] = word;
  else if (many || word.x != hitWord.x || word.y != hitWord.y)
    words.at[beamEntry(wordIndex)] = word;
}

void storePoint(uint at, Return value, uvec2 owner) {
  vec3 position = MOTION ? reported(beamMotion, beamOrigin, pointDirection, value.range)
                         : pointDirection * value.range;
  points.at[at] = value.label != kLabelNone ? vec4(position, value.range) : vec4(notANumber());
  owners.at[at] = owner;
}

void storeReturn(uint j, Return value) {
  uint at = resultOf(beamIndex) * RETURNS + j;
  uvec2 owner = uvec2(kNone);
  SurfaceRecord surface = SurfaceRecord(vec3(0.0), kNone);
  vec2 weights = vec2(notANumber());
  if (value.label == kLabelSolid && many) {
    uint echo = echoPlace(wordIndex, value.echo);
    owner = echoOwners.at[echo];
    if ((FIELDS & kFieldSurface) != 0) surface = echoSurfaces.at[echo];
  } else if (value.label == kLabelSolid) {
    owner = hitOwner;
    surface = hitSurface;
    weights = hitBarycentrics;
  }
  if (POINTS)
    storePoint(at, value, owner);
  else
    storeWord(j, value, owner);
  if ((FIELDS & kFieldIntensity) != 0) intensities.at[at] = value.intensity;
  if ((FIELDS & kFieldSignal) != 0)
    signals.at[at] = SignalRecord(value.trueRange, value.width,
                                  value.label | value.cause << 8 | value.number << 16 | value.count << 24);
  if ((FIELDS & kFieldSurface) != 0) surfaces.at[at] = surface;
  if ((FIELDS & kFieldBarycentrics) != 0) barycentrics.at[at] = weights;
  if (SPEEDS) storeMotion(at, owner, value);
}

// Whether the beam has a hit in range.
bool isHit() { return floatBitsToUint(hitRange) <= 0x7f800000u; }

// Computes the returns of one beam.
void computeReturns() {
  uint count = isHit() ? 1 : 0, returned;
  if (many)
    count = echoCounts.at[resultOf(beamIndex)];
  else if (count > 0)
    hitEcho = echoOfHit();
  uint cause = signalsOf(planned, beamIndex, beamDirection, count, returned);
  for (uint k = 0; k < kCauses; ++k) causeCounts[k] += cause == k ? 1 : 0;
}

// Stores the hit as the only return of a beam without signals.
void storeHit() {
  Return value = noReturn();
  value.range = value.trueRange = hitRange;
  bool hit = isHit();
  if (hit) value.label = kLabelSolid;
  storeReturn(0, value);
  hits += hit ? 1 : 0;
}

// Adds the counts of a cause; without signals, the only cause is that of a hit. All invocations of the subgroup must call
// this.
void addCount(uint cause, uint count) {
  uint sum = subgroupAdd(count);
  if (subgroupElect() && sum > 0) {
    if (VIEWS)
      atomicAdd(viewCauses.at[view * kCauses + cause], sum);
    else if (SIGNALS)
      atomicAdd(counters.causes[cause], sum);
    else
      atomicAdd(counters.hits, sum);
  }
}

void addCounts() {
  if (SIGNALS)
    for (uint k = 0; k < kCauses; ++k) addCount(k, causeCounts[k]);
  else
    addCount(kCauseReturned, hits);
}

// Finds the hit of the beam's axis, and its surface if that is needed. All invocations of the subgroup must call this;
// one that has no beam of its own has no hit, because another invocation may be writing the word.
void loadHit(bool own) {
  hitWord = own ? words.at[beamEntry(wordIndex)] : uvec2(kNone);
  float range = uintBitsToFloat(hitWord.y);
  bool there = hitWord.y != kNone && !(NUMBERED && beamIndex == kNone), looks = (FIELDS & kSurfaceFields) != 0;
  if (SIGNALS)
    looks = looks || LOOKS_AT_MATERIALS;  // and isReturned() judges near hits
  else
    there = there && !hidesItself(wordIndex, range);
  hitRange = there ? range : notANumber();
  if (!(looks || SPEEDS || POINTS)) return;
  Surface surface;
  findHit(there ? hitWord.x : kNone, looks, hitOwner, surface);
  if (looks) surface = seenSurface(surface, beamMotion, beamOrigin);
  hitSurface = SurfaceRecord(surface.normal, surface.material);
  if ((FIELDS & kFieldBarycentrics) != 0) hitBarycentrics = barycentricsOf(surface.corners, lightDirection * hitRange);
}

// Computes the returns of a beam whose directions are known, and its hit if it needs one.
void answerBeam() {
  if (NUMBERED && SIGNALS) {
    vec2 window = rangesOf(wordIndex);
    planned.rangeMin = window.x;
    planned.rangeMax = window.y;
  }
  many = MANY_ECHOES;
  if (PANES && PASS == kPassEffectsAll) many = echoCounts.at[resultOf(beamIndex)] != kNone;
  pointDirection = beamDirection;
  if ((EFFECTS & kAngleNoise) != 0 && planned.angleNoiseAt == kAngleAtPoint)
    pointDirection = astray(beamDirection, angleError(planned, beamIndex));
  if (SIGNALS)
    computeReturns();
  else
    storeHit();
}

// Computes the returns of a beam. An invocation that has no beam of its own takes part with that of another. No invocation
// returns early, because Vulkan promises only behind an `if` or a loop that all of a subgroup run together again, and they
// share the surfaces of their next beams.
void answer(BeamRow row, bool own) {
  beamIndex = numberIn(row, wordIndex, columnIndex);
  Beam axis = beamIn(row, columnIndex);
  loadPlaceOfBeam(rowIndex, columnIndex, axis.azimuth);
  beamDirection = lightDirection = axis.direction;
  if ((EFFECTS & kStrays) != 0) lightDirection = strayed(axis, strays.at[beamEntry(wordIndex)]);
  if (!MANY_ECHOES) loadHit(own);
  if (own && !(NUMBERED && beamIndex == kNone)) answerBeam();
}

void main() {
  useOwnAddresses();
  loadMotion();
  uint groupRow = rowInView(gl_WorkGroupID.y);
  if (SIGNALS) planned = parametersOf(view);
  hits = 0;
  for (uint k = 0; k < kCauses; ++k) causeCounts[k] = 0;
  // Only the listed beams are processed if nothing but panes can change an answer. There is one loop for both cases,
  // because compilers inline answer() at every call. No invocation leaves it early, because all of a subgroup share
  // surfaces.
  bool listed = PANES && PASS == kPassEffectsListed;
  uvec2 run = listed ? runOf(counters.hardBeams) : runOfBeams();
  uint ownRow = dealt(groupRow, frame.rows);
  BeamRow row = loadRow(ownRow);
  for (uint first = run.x; first < run.y; first += gl_SubgroupSize) {
    uint i = min(first + gl_SubgroupInvocationID, run.y - 1);
    // Row and column are known except for listed beams; to divide the index by the number of columns would be slow.
    rowIndex = ownRow;
    columnIndex = beamColumn(i);
    wordIndex = indexOf(rowIndex, columnIndex);
    if (LISTED || listed) {
      if (listed) wordIndex = enterView(hardBeams.at[i]);
      rowIndex = rowOf(wordIndex);
      columnIndex = columnOf(wordIndex);
    }
    if (listed) row = loadRow(rowIndex);
    answer(row, first + gl_SubgroupInvocationID < run.y);
  }
  if (!listed) addCounts();
}
