// SPDX-License-Identifier: Apache-2.0
// The implementation macro of volk, and nothing else.
#define VOLK_IMPLEMENTATION
#include <volk.h>
