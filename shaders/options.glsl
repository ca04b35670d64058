// SPDX-License-Identifier: Apache-2.0
// Specialisation constants of the pipelines, in the order of Options in src/pipeline/kernels.hpp.
#include "common/effects/bits.h"

layout(constant_id = 0) const uint BOUNDS = kBoundsExact;
layout(constant_id = 1) const uint CULL = kCullNearestPoint;
layout(constant_id = 2) const uint INSIDE = kInsideWatertight;
layout(constant_id = 3) const uint RANGE = kRangeEdgeWeights;
layout(constant_id = 4) const bool AZIMUTH_OFFSETS = false;  // rows look between the places of the grid, each at azimuths
                                                             // of its own
layout(constant_id = 5) const uint FACES = kFacesMaterial;
layout(constant_id = 6) const uint BINNING = kBinningNearest;
layout(constant_id = 7) const uint PASS = 0;      // selects a pass of a shader that has several
layout(constant_id = 8) const uint CULLING = 0;   // bits kCull...
layout(constant_id = 9) const uint EFFECTS = 0;   // bits of effects/bits.h
layout(constant_id = 10) const uint FIELDS = 0;   // bits kField...
layout(constant_id = 11) const uint LAYERS = 1;   // surfaces that a sub-ray may hit; all but the last let light pass
layout(constant_id = 12) const uint RETURNS = 1;  // kept per beam; before stage effects, entry 0 of a beam holds its hit
layout(constant_id = 13) const bool MOTION = false;  // the sensor or instances move within the scan; except for
                                                     // project and bin, also if lasers have origins
layout(constant_id = 14) const bool LISTED = false;  // the beams are a list, sorted into the cells of a grid
layout(constant_id = 15) const bool MAPPED = false;  // each beam lies in a place of a grid, and a table has its number
layout(constant_id = 16) const uint RAYS = 61;  // places for the sub-rays of a footprint: 1, 7, 19 or 61
layout(constant_id = 17) const uint RECORDS = 0;  // bits of records.h: values that records hold, kWholeWords, kFromWords
layout(constant_id = 18) const uint DEFORMED = kDeformsNothing;  // whether the scene has deformable meshes
layout(constant_id = 19) const bool ORIGINS = false;    // lasers stand away from the point that the scan is seen from
layout(constant_id = 20) const bool STAGGERED = false;  // the beams of a place fire at different times
layout(constant_id = 21) const bool VIEWS = false;  // the submission may have several views, see views.glsl
layout(constant_id = 22) const uint SPREAD_RAYS = 0;  // sub-rays of a beam that the lanes share, see spread_rays.glsl

// True if lasers do not see everything from one place all the time.
#define APART (MOTION || ORIGINS)

// True if a box may hold only those beams of its places that fire within some time.
#define TIMED ((LISTED || STAGGERED) && MOTION)

// True if light may pass surfaces and beams are single lines: opaque triangles are binned first, then panes.
#define PANES ((EFFECTS & (kTransmission | kFootprint)) == kTransmission)

// True on CPU devices, which execute the lanes of a subgroup together in any case. The constant follows from the device,
// not from the scan.
layout(constant_id = 24) const bool kLanesInStep = false;
