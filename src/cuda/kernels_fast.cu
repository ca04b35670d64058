// SPDX-License-Identifier: Apache-2.0
// The kernels with fused multiply-add, which is the compiler's default.
#define GNO_MODE fast
#include "cuda/kernels.cuh"
