// SPDX-License-Identifier: Apache-2.0
// Records the calls of a program to PATH.yaml and PATH.bin, and makes them again.
#pragma once

#include <rgl/api/core.h>

RGL_API rgl_status_t rgl_tape_record_begin(const char* path);
RGL_API rgl_status_t rgl_tape_record_end(void);
RGL_API rgl_status_t rgl_tape_record_is_active(bool* is_active);
RGL_API rgl_status_t rgl_tape_play(const char* path);
