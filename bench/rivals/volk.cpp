// SPDX-License-Identifier: Apache-2.0
// The shared library keeps its pointers to Vulkan's functions to itself, so the rivals have their own.
#define VOLK_IMPLEMENTATION
#include <volk.h>
