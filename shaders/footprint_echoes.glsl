// SPDX-License-Identifier: Apache-2.0
// Combines the hits of a beam's sub-rays in all layers into echoes.

// The number of layers in which the beam has hits. Most light meets one pane at most, so few beams need the remaining
// layers, which are skipped.
uint layersMet;
#define IS_MET(layer) (HELD_LAYERS == 1u || layer < layersMet)

// Returns the least range after `after` of the hits that count; kNothing if there is none.
float nextRange(float after) {
  float least = kNothing;
  [[unroll]] for (uint layer = 0; layer < HELD_LAYERS; ++layer) {
#define NEXT(s) \
  if (ranges[layer * RAYS + s] > after && energies[layer * RAYS + s] >= 0.0) least = min(least, ranges[layer * RAYS + s]);
    if (IS_MET(layer)) {
      EACH_RAY(NEXT)
    }
  }
  return leastOfBeam(least);
}

// Returns the largest range below `before` of the hits that count; 0 if there is none.
float lastBefore(float before) {
  float last = 0.0;
  [[unroll]] for (uint layer = 0; layer < HELD_LAYERS; ++layer) {
#define LAST(s) \
  last = max(last, ranges[layer * RAYS + s] < before && energies[layer * RAYS + s] >= 0.0 ? ranges[layer * RAYS + s] : 0.0);
    if (IS_MET(layer)) {
      EACH_RAY(LAST)
    }
  }
  return mostOfBeam(last);
}

// Lets a hit join an echo to which all belongs that begins before `joined`.
void join(float before, uint piece, inout float end, inout float joined) {
  float range = ranges[piece], reach = reaches[piece];
  bool joins = sumOf(range, -reach) <= before && energies[piece] >= 0.0;
  float behind = sumOf(range, reach);
  end = joins && range > end ? range : end;
  joined = joins && behind > joined ? behind : joined;
}

// Returns the farthest range of the echo that starts at `first`; `last` is that of all hits. The surface around a hit of
// the echo begins no farther than the separation behind `first`, or overlaps the surface around a nearer hit of the
// echo.
float endOfEcho(float first, float last) {
  float end = first, joined = sumOf(first, parameters.separation), before;
  if (last <= joined) return last;
  do {
    before = joined;
    [[unroll]] for (uint layer = 0; layer < HELD_LAYERS; ++layer) {
#define FOLLOW(s) join(before, layer * RAYS + s, end, joined);
      if (IS_MET(layer)) {
        EACH_RAY(FOLLOW)
      }
    }
    joined = mostOfBeam(joined);
  } while (joined > before);
  return mostOfBeam(end);
}

// The most windows from the start of an echo to its end, and how many times the energy of a valley the light beside it has.
const float kValleyWindows = 16.0, kValleyDepth = 4.0;

// Adds the energy of a hit that lies between two ranges. A hit spreads evenly along the surface around it, and over
// a window at least.
void addWithin(inout float sum, float low, float high, float halfWindow, float first, float end, float range, float reach,
               float energy) {
  bool taken = range >= first && range <= end && energy > 0.0;
  float halfLength = max(reach, halfWindow);
  precise float within = min(high, range + halfLength) - max(low, range - halfLength);
  precise float more = sum + quotient(energy * max(within, 0.0), halfLength);
  sum = taken ? more : sum;
}

// Returns twice the energy that an echo has between two ranges.
float energyWithin(float low, float high, float halfWindow, float first, float end) {
  float sum = 0.0;
  [[unroll]] for (uint layer = 0; layer < HELD_LAYERS; ++layer) {
#define WITHIN(s)                                                                                                  \
  addWithin(sum, low, high, halfWindow, first, end, ranges[layer * RAYS + s], reaches[layer * RAYS + s],           \
            energies[layer * RAYS + s]);
#define WITHIN_OF_LANES(s)                                                                                         \
  [[dont_unroll]] for (uint lane = 0; lane < lanesWithRay(s); ++lane)                                              \
    addWithin(sum, low, high, halfWindow, first, end, subgroupShuffle(ranges[layer * RAYS + s], lane),             \
              subgroupShuffle(reaches[layer * RAYS + s], lane), subgroupShuffle(energies[layer * RAYS + s], lane));
    if (IS_MET(layer)) {
      if (SPREAD_RAYS > 0) {
        EACH_RAY(WITHIN_OF_LANES)
      } else {
        EACH_RAY(WITHIN)
      }
    }
  }
  return sum;
}

// Returns the range at which an echo that is longer than twice the separation ends, because light returns again behind a
// valley: the start of the first window with more than four times the least energy since a window with less than a quarter
// of the energy of a nearer one. Returns kNothing if there is none.
float riseOf(float first, float end) {
  precise float span = end - first, halfWindow = 0.5 * max(parameters.separation, span / kValleyWindows);
  float peak = 0.0, least = kNothing, rise = kNothing;  // least is kNothing before the valley
  if (span > sumOf(parameters.separation, parameters.separation)) {
    precise float from = first - halfWindow, to = first + halfWindow;
    [[dont_unroll]] for (float k = 0.0; k <= kValleyWindows && from <= end && rise == kNothing; ++k) {
      float energy = energyWithin(from, to, halfWindow, first, end);
      if (energy > kValleyDepth * least) rise = from;
      if (least < kNothing || kValleyDepth * energy < peak) least = min(least, energy);
      peak = max(peak, energy);
      from = to;
      to = first + (2.0 * k + 3.0) * halfWindow;
    }
  }
  return rise;
}

void storeEcho(uint slot, vec3 echo, float light, uint projected) {
  echoes.at[slot] = vec4(echo, light);
  echoOwners.at[slot] = ownerOf(idOf(projected));
  if ((FIELDS & kFieldSurface) != 0) {
    Triangle triangle = triangleAt(projected);
    vec3 normal = normalOf(triangle.a, triangle.b, triangle.c);
    if (MOTION) normal = reportedDirection(beamMotion, normal);
    echoSurfaces.at[slot] = SurfaceRecord(normal, projectedMaterials.at[projected]);
  }
}

// Keeps an echo behind those that the beam has. If the kept echoes take all places, the weakest one behind the nearest
// is lost.
void keepEcho(uint index, uint count, vec3 echo, float light, uint projected) {
  uint place = count;
  if (count >= keptEchoes(RETURNS)) {
    atomicAdd(counters.lostEchoes, 1);
    float least = kNothing;
    [[dont_unroll]] for (uint k = 1; k < keptEchoes(RETURNS); ++k) {
      vec4 kept = echoes.at[echoPlace(index, k)];
      float power = received(kept.y, kept.x, 0.0);
      place = power <= least ? k : place;
      least = min(power, least);
    }
    [[dont_unroll]] for (; place + 1 < keptEchoes(RETURNS); ++place) {
      uint to = echoPlace(index, place), from = echoPlace(index, place + 1);
      echoes.at[to] = echoes.at[from];
      echoOwners.at[to] = echoOwners.at[from];
      if ((FIELDS & kFieldSurface) != 0) echoSurfaces.at[to] = echoSurfaces.at[from];
    }
  }
  storeEcho(echoPlace(index, place), echo, light, projected);
}

// The owner of an echo is its strongest hit, and the first one of equally strong hits.
void addTo(inout vec3 sums, inout float most, inout uint strongest, float first, float inverseFirst, float end, float range,
           float energy, uint candidate) {
  bool from = range >= first, to = range <= end, counts = energy >= 0.0;
  bool taken = from && to && counts;
  vec3 more = sums;
  addPiece(more, energy, sumOf(range, -first), inverseFirst);
  sums = taken ? more : sums;
  bool stronger = taken && energy > most;
  most = stronger ? energy : most;
  strongest = stronger ? candidate : strongest;
}

// Adds the hits of a layer in the order of the sub-rays, because sums depend on the order.
void addLayer(inout vec3 sums, inout float most, inout uint strongest, float first, float inverseFirst, float end,
              uint layer) {
#define ADD(s)                                                                                                  \
  addTo(sums, most, strongest, first, inverseFirst, end, ranges[layer * RAYS + s], energies[layer * RAYS + s],  \
        metCandidates[layer * RAYS + s]);
#define ADD_OF_LANES(s)                                                                                     \
  [[dont_unroll]] for (uint lane = 0; lane < lanesWithRay(s); ++lane)                                       \
    addTo(sums, most, strongest, first, inverseFirst, end, subgroupShuffle(ranges[layer * RAYS + s], lane), \
          subgroupShuffle(energies[layer * RAYS + s], lane), subgroupShuffle(metCandidates[layer * RAYS + s], lane));
  if (SPREAD_RAYS > 0) {
    EACH_RAY(ADD_OF_LANES)
  } else {
    EACH_RAY(ADD)
  }
}

// Returns the light of a sub-ray that nearer surfaces than `first` leave, if it comes to this layer and no earlier one.
float lightBehind(float first, uint layer, uint s) {
  bool comes = ranges[layer * RAYS + s] >= first;
  if (layer > 0) comes = comes && ranges[(layer - 1) * RAYS + s] < first;
  return comes ? lights[layer * RAYS + s] : 0.0;
}

// Returns the share of the beam's light that nearer surfaces than `first` leave, added in the order of the sub-rays; all
// surfaces if it is kNothing.
float lightTo(float first) {
  float light = 0.0;
  [[unroll]] for (uint layer = 0; layer < HELD_LAYERS; ++layer) {
#define ADD_LIGHT(s) light = sumOf(light, lightBehind(first, layer, s));
#define ADD_LIGHT_OF_LANES(s)                                       \
  [[dont_unroll]] for (uint lane = 0; lane < lanesWithRay(s); ++lane) \
    light = sumOf(light, subgroupShuffle(lightBehind(first, layer, s), lane));
    if (IS_MET(layer)) {
      if (SPREAD_RAYS > 0) {
        EACH_RAY(ADD_LIGHT_OF_LANES)
      } else {
        EACH_RAY(ADD_LIGHT)
      }
    }
  }
  return light;
}

void gatherEchoes(uint index, uint beam) {
  uint count = 0;
  float first = nextRange(0.0), last = lastBefore(kNothing);
  while (first < kNothing) {
    float end = endOfEcho(first, last), rise = riseOf(first, end), most = -1.0, inverseFirst = inverseOfFirst(first);
    if (rise < kNothing) end = lastBefore(rise);
    uint strongest = 0;
    vec3 sums = vec3(0.0);
    [[unroll]] for (uint layer = 0; layer < HELD_LAYERS; ++layer) {
      if (IS_MET(layer)) addLayer(sums, most, strongest, first, inverseFirst, end, layer);
    }
    float next = end < last ? nextRange(end) : kNothing;
    float light = KEEPS_LIGHT ? lightTo(next) : 0.0;  // up to the next echo, or beyond all surfaces
    if (speaksForBeam()) keepEcho(index, count, echoOf(first, inverseFirst, sums), light, strongest);
    ++count;
    first = next;
  }
  if (speaksForBeam()) echoCounts.at[resultOf(beam)] = min(count, keptEchoes(RETURNS));
}
