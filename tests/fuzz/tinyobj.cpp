// SPDX-License-Identifier: Apache-2.0
// tinyobjloader once more, from its header, so that the sanitizers and the fuzzer see into it.
#define TINYOBJLOADER_IMPLEMENTATION
#define TINYOBJLOADER_USE_DOUBLE
#include <tiny_obj_loader.h>
