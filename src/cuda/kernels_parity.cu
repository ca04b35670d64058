// SPDX-License-Identifier: Apache-2.0
// The kernels without fused multiply-add: the build compiles this file with -fmad=false.
#define GNO_MODE parity
#include "cuda/kernels.cuh"
