// SPDX-License-Identifier: Apache-2.0
// Compiles the implementation of volk.
#define VOLK_IMPLEMENTATION
#include <volk.h>
