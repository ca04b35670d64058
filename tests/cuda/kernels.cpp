// SPDX-License-Identifier: Apache-2.0
#define GNO_MODE parity
#include "cuda/kernels.cuh"
