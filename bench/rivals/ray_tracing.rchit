// SPDX-License-Identifier: Apache-2.0
// Reports the nearest hit of a beam.
#version 460
#extension GL_EXT_ray_tracing : require

layout(location = 0) rayPayloadInEXT uvec3 found;

void main() { found = uvec3(floatBitsToUint(gl_HitTEXT), gl_InstanceID, gl_PrimitiveID); }
