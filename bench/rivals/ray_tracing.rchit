// SPDX-License-Identifier: Apache-2.0
// One invocation is a beam that has met its nearest triangle.
#version 460
#extension GL_EXT_ray_tracing : require

layout(location = 0) rayPayloadInEXT uvec3 found;

void main() { found = uvec3(floatBitsToUint(gl_HitTEXT), gl_InstanceID, gl_PrimitiveID); }
