// SPDX-License-Identifier: Apache-2.0
// Compiles tinyobjloader again, so that the sanitizers and the fuzzer instrument it.
#define TINYOBJLOADER_IMPLEMENTATION
#define TINYOBJLOADER_USE_DOUBLE
#include <tiny_obj_loader.h>
