// SPDX-License-Identifier: Apache-2.0
// Compiled with -fmad=false.
#define GNO_MODE parity
#include "cuda/kernels.cuh"
