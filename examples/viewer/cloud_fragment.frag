// SPDX-License-Identifier: Apache-2.0
#version 460

layout(location = 0) flat in vec3 colour;
layout(location = 0) out vec4 shade;

void main() { shade = vec4(colour, 1); }
