// SPDX-License-Identifier: Apache-2.0
#define GNO_MODE parity
#define GNO_CALLERS_BUFFERS
#define GNO_SPREAD_RAYS 7
#define GNO_INVOCATIONS "lanes/lanes.hpp"
#include "cuda/kernels.cuh"
