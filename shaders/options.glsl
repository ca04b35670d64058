// SPDX-License-Identifier: Apache-2.0
// What a pipeline is specialised for. Constant 0 is left to the workgroup size of a kernel that needs one.
layout(constant_id = 1) const uint ACCURACY = kAccuracyStandard;
layout(constant_id = 2) const bool AZIMUTH_OFFSETS = false;  // channels have azimuth offsets of their own
layout(constant_id = 3) const uint FACES = kFacesMaterial;
layout(constant_id = 4) const uint PASS = 0;  // which pass of a shader that has several
