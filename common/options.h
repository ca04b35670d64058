// SPDX-License-Identifier: Apache-2.0
// Values of the specialisation constants of shaders/options.glsl.
#ifndef GNOSPHERE_COMMON_OPTIONS_H
#define GNOSPHERE_COMMON_OPTIONS_H

#include "types.h"

#ifdef __cplusplus
namespace gnosphere::gpu {
#endif

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

// Values of PASS, which are named by their shader: project_groups, bin (with lists, then with words), prefix_sum,
// resolve, effects_footprint, effects, records.
GNO_CONST uint kPassGroupsList = 0;
GNO_CONST uint kPassGroupsShells = 1;

GNO_CONST uint kPassBinCount = 0;
GNO_CONST uint kPassBinFill = 1;

GNO_CONST uint kPassBinNearest = 0;
GNO_CONST uint kPassBinPanes = 1;  // lists the panes before the beams' words
GNO_CONST uint kPassBinTable = 2;  // no hits, the farthest-range table instead

GNO_CONST uint kPassSumReduce = 0;
GNO_CONST uint kPassSumBlocks = 1;
GNO_CONST uint kPassSumApply = 2;

GNO_CONST uint kPassResolveResults = 0;
GNO_CONST uint kPassResolveWords = 1;  // only the words, which lists do not have

GNO_CONST uint kPassFootprintWithinOne = 0;  // beams whose footprint lies on one triangle
GNO_CONST uint kPassFootprintOthers = 1;     // the others whose light meets no pane
GNO_CONST uint kPassFootprintPanesToo = 2;   // those whose light may meet panes

GNO_CONST uint kPassEffectsAll = 0;
GNO_CONST uint kPassEffectsListed = 1;  // only the beams of hardBeams

GNO_CONST uint kPassRecordsCount = 0;
GNO_CONST uint kPassRecordsHeader = 1;
GNO_CONST uint kPassRecordsEntries = 2;  // lists the entries with a return
GNO_CONST uint kPassRecordsWrite = 3;
GNO_CONST uint kPassRecordsNoteLists =
    4;  // only notes whether a list was too small for a group of beams before the last
GNO_CONST uint kPassRecordsHeaderOfAll = 5;  // of results in which every entry has a record, which count the returns
GNO_CONST uint kPassRecordsSample = 6;       // ranges, for the shells of later scans

// Values of the specialization constant DEFORMED.
GNO_CONST uint kDeformsNothing = 0;
GNO_CONST uint kDeforms = 1;
GNO_CONST uint kDeformsAndStores = 2;  // project stores the vertices, because later kernels read them

#ifdef __cplusplus
}  // namespace gnosphere::gpu
#endif
#endif
