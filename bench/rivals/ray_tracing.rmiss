// SPDX-License-Identifier: Apache-2.0
// One invocation is a beam that has met nothing.
#version 460
#extension GL_EXT_ray_tracing : require

layout(location = 0) rayPayloadInEXT uvec3 found;

void main() { found.y = 0xffffffffu; }
