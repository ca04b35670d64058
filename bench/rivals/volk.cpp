// SPDX-License-Identifier: Apache-2.0
// The shared library does not export its pointers to Vulkan's functions, so the rivals load their own.
#define VOLK_IMPLEMENTATION
#include <volk.h>
