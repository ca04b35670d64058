// SPDX-License-Identifier: Apache-2.0
// Structs and constants that host and device share, included by GLSL, C++ and CUDA.
#ifndef GNOSPHERE_SHARED_H
#define GNOSPHERE_SHARED_H

#include "frame.h"
#include "limits.h"
#include "movement.h"
#include "options.h"
#include "records.h"
#include "scene.h"
#endif
