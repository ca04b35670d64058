// SPDX-License-Identifier: Apache-2.0
// Compiled as the compiler sees fit: products and sums may become one.
#define GNO_MODE fast
#include "cuda/kernels.cuh"
