// SPDX-License-Identifier: Apache-2.0
// Stage effects, in place of effects_footprint where beams are single lines. One invocation per beam that meets a pane
// before anything opaque: follows its light through the panes and combines their hits and the opaque one into echoes.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_buffer_reference_uvec2 : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_KHR_shader_subgroup_basic : require
#include "common/shared.h"
#include "options.glsl"
#include "bindings.glsl"
#include "common/effects/vector.h"
#include "common/effects/intensity.h"
#include "common/effects/returns.h"
#include "views.glsl"
#include "motion.glsl"
#include "beam_place.glsl"
#include "to_sensor.glsl"
#include "inside.glsl"
#include "seen.glsl"
#include "owner.glsl"
#include "surface_of.glsl"
#include "panes.glsl"
#include "runs.glsl"
#include "echoes.glsl"

layout(local_size_x = 64) in;

// The light of a beam: its index in row order, its row, its axis and its true direction, in the frame that surfaces are
// in.
uint beamIndex, beamRow;
Beam axis;
vec3 direction;

// The hits of the beam stand in order of range, each with the light that comes to it. Behind the last one stands the
// light that no surface ends.
const uint kLights = kMaxLayers + 1;
uint hitCount;
float ranges[kMaxLayers], energies[kMaxLayers], lights[kLights];
uint ids[kMaxLayers];

float farthestOf(uint index) { return frame.rangeMax; }

bool looksAtMaterials() { return (EFFECTS & kIntensity) != 0 && parameters.intensityModel == kModelPhysical; }

// The list of a beam is a run of candidates with kBinningLists, otherwise a chain of hits; see bin.comp.
uint listFirst() {
  if (BINNING != kBinningLists) return listEnds.at[beamEntry(beamIndex)];
  uint entry = beamEntry(beamIndex);
  return entry == 0 ? 0 : min(listEnds.at[max(entry, 1) - 1], frame.candidateCapacity);
}

uint listEnd() {
  if (BINNING != kBinningLists) return kNone;
  return min(listEnds.at[beamEntry(beamIndex)], frame.candidateCapacity);
}

uint nextOf(uint k) {
  if (BINNING != kBinningLists) return candidates.at[3 * k + 2];
  return k + 1;
}

// Returns a pane as the beam sees it.
Triangle paneAt(uint projected) {
  Triangle triangle = loadProjected(projected);
  if (MOTION && !atRest(triangle.moves)) triangle = seenAt(triangle, projected, beamMotion);
  if (MOTION) triangle = seenFrom(triangle, beamRow, axis.azimuth);
  return triangle;
}

// True if the beam meets a pane. The corners do not come from paneAt(): it has applied the sensor's pose, which
// turnedFrom() applies itself where each beam has a frame.
bool meetsPane(uint projected, out float range) {
  Triangle pane = loadProjected(projected);
  if (MOTION) pane = seenFrom(pane, projected, columnOf(beamIndex), beamRow, axis.azimuth);
  Turned turned = turnedFrom(pane, beamRow, beamIndex, axis.azimuth);
  return meet(pane, prepare(pane), turned, axis, beamIndex, projected, range);
}

// Returns the projected triangle of an entry of the list if it is a pane that the beam meets, otherwise kNone.
uint paneOf(uint k, out float range) {
  if (BINNING != kBinningLists) {
    range = uintBitsToFloat(candidates.at[3 * k + 1]);
    return candidates.at[3 * k];
  }
  uint projected = candidates.at[k];
  return isPane(projected) && meetsPane(projected, range) ? projected : kNone;
}

// Finds the nearest pane that is clearly behind the range `before`, and before the opaque hit. Panes closer to each
// other, relative to their range, count as one: light through a shared edge hits both of its triangles, but they are
// not two panes. Returns its projected triangle, or kNone.
uint nextPane(float before, uvec2 opaque, out float range, out uint id) {
  precise float behind = before * (1.0 + 9.5367431640625e-7);
  uvec2 best = opaque;
  uint pane = kNone;
  for (uint k = listFirst(), end = listEnd(); k != end; k = nextOf(k)) {
    float met;
    uint projected = paneOf(k, met);
    if (projected == kNone || !(met > behind) || floatBitsToUint(met) > best.y) continue;
    uint number = projectedA.at[projected].tag & 0x7fffffffu;
    if (!comesBefore(met, number, best)) continue;
    best = uvec2(number, floatBitsToUint(met));
    pane = projected;
  }
  range = uintBitsToFloat(best.y);
  id = best.x;
  return pane;
}

Surface surfaceOfHit(uint pane, uint id) {
  if (pane == kNone) return surfaceOf(ownerOf(id), beamMotion, beamOrigin);
  Triangle triangle = paneAt(pane);
  vec3 laser = MOTION && SHIFTS_TURNED ? beamOrigin : vec3(0.0);
  Surface surface;
  surface.corners = Corners(triangle.a - laser, triangle.b - laser, triangle.c - laser);
  surface.normal = normalOf(surface.corners);
  if (MOTION) surface.normal = reportedDirection(beamMotion, surface.normal);
  surface.material = projectedMaterials.at[pane];
  return surface;
}

// Follows the light through the panes. An opaque hit ends it, however close to a pane.
void follow() {
  uvec2 opaque = words.at[beamEntry(beamIndex)];
  float carried = 1.0, before = 0.0;
  hitCount = 0;
  while (hitCount < LAYERS && carried > 0.0) {
    float range;
    uint id, pane = nextPane(before, opaque, range, id);
    if (pane == kNone && opaque.y == kNone) {
      lights[hitCount] = carried;
      return;
    }
    float energy = carried, passed = 0.0;
    if (looksAtMaterials()) {
      Surface surface = surfaceOfHit(pane, id);
      float cosIncidence = min(abs(dotOf(surface.normal, direction)), 1.0);
      energy = product(energy, reflected(optics.at[surface.material], cosIncidence));
    }
    if (pane != kNone) passed = product(carried, transmitted(optics.at[projectedMaterials.at[pane]]));
    ranges[hitCount] = before = range;
    energies[hitCount] = energy == 0.0 && passed > 0.0 ? kUnseen : energy;
    lights[hitCount] = carried;
    ids[hitCount] = id;
    ++hitCount;
    carried = passed;
  }
  lights[hitCount] = 0.0;
  if (carried > 0.0) atomicAdd(counters.lostEchoes, 1);
}

void storeEcho(uint slot, vec3 echo, float light, uint id) {
  uvec2 owner = ownerOf(id);
  echoes.at[slot] = vec4(echo, light);
  echoOwners.at[slot] = owner;
  if ((FIELDS & kFieldSurface) != 0) {
    Surface surface = surfaceOf(owner, beamMotion, beamOrigin);
    echoSurfaces.at[slot] = SurfaceRecord(surface.normal, surface.material);
  }
}

// The owner of an echo is its strongest hit, and the first one of equally strong hits.
void gatherEchoes(uint beam) {
  uint count = 0;
  for (uint k = 0; k < hitCount;) {
    float first = ranges[k], inverseFirst = 0.0, most = -1.0;
    uint strongest = ids[k];
    vec3 sums = vec3(0.0);
    bool any = false;
    for (; k < hitCount; ++k) {
      if (energies[k] < 0.0) continue;
      if (!any) {
        first = ranges[k];
        inverseFirst = inverseOfFirst(first);
      }
      if (ranges[k] > sumOf(first, parameters.separation)) break;
      any = true;
      addPiece(sums, energies[k], sumOf(ranges[k], -first), inverseFirst);
      if (energies[k] <= most) continue;
      most = energies[k];
      strongest = ids[k];
    }
    if (!any) break;
    storeEcho(echoPlace(beamIndex, count), echoOf(first, inverseFirst, sums), lights[k], strongest);
    ++count;
  }
  echoCounts.at[resultOf(beam)] = count;
}

void main() {
  useOwnAddresses();
  loadMotion();
  uvec2 run = runOf(counters.hardBeams);
  for (uint i = run.x + gl_SubgroupInvocationID; i < run.y; i += gl_SubgroupSize) {
    beamIndex = enterView(hardBeams.at[i]);
    beamRow = rowOf(beamIndex);
    axis = beamWith(beamIndex);
    direction = axis.direction;
    if ((EFFECTS & kStrays) != 0) direction = strayed(axis, strays.at[beamEntry(beamIndex)]);
    loadPlaceOfBeam(beamRow, columnOf(beamIndex), axis.azimuth);
    if (MOTION) direction = reportedDirection(beamMotion, direction);
    follow();
    gatherEchoes(numberOf(beamIndex));
  }
}
