// SPDX-License-Identifier: Apache-2.0
// Stands in for CUDA's header in the helpers of RGL's tests, which run on the host.
#pragma once

#define __host__
#define __device__

struct float3 {
  float x, y, z;
};
struct int3 {
  int x, y, z;
};
