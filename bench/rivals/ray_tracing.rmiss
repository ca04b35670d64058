// SPDX-License-Identifier: Apache-2.0
// Reports that a beam hit nothing.
#version 460
#extension GL_EXT_ray_tracing : require

layout(location = 0) rayPayloadInEXT uvec3 found;

void main() { found.y = 0xffffffffu; }
