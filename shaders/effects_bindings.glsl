// SPDX-License-Identifier: Apache-2.0
// The arrays of stage effects, on top of those in bindings.glsl.
layout(std430, set = 0, binding = kBindParameters) readonly buffer ParametersBlock { EffectParameters parameters; };
WORK(kBindOptics, readonly, Optics4, optics);             // per material
WORK(kBindDeadBeams, readonly, uint, deadBeams);          // a bit per beam of the whole sensor
WORK(kBindVolumes, readonly, VolumeBox, volumes);
// Per return of every beam, in the sensor's own order:
WORK(kBindSurfaces, , vec4, surfaces);                    // normal towards the sensor, material (kNone: no surface)
WORK(kBindSignals, , vec4, signals);                      // intensity, true range, width, label | cause << 8 | number << 16 | count << 24
WORK(kBindMotions, writeonly, vec4, motions);             // velocity in the sensor's axes, radial speed
WORK(kBindBarycentrics, , vec2, barycentrics);
WORK(kBindInstanceMeshes, readonly, uint, instanceMeshes);
WORK(kBindInstanceMotions, readonly, InstanceMotion, instanceMotions);
WORK(kBindColumnMotions, readonly, ColumnMotion, columnMotions);
// Per beam up to kMaxEchoes of what its footprint met, in order of range:
WORK(kBindEchoCounts, , uint, echoCounts);
WORK(kBindHardBeams, , uint, hardBeams);                  // beams, row by row, that the footprint's second pass does
WORK(kBindEchoes, , vec4, echoes);                        // range, energy, width, cosine of the incidence
WORK(kBindEchoOwners, , uvec2, echoOwners);               // as owners
WORK(kBindEchoSurfaces, , vec4, echoSurfaces);            // as surfaces
layout(std430, set = 0, binding = kBindMotionBounds) readonly buffer MotionBoundsBlock { MotionBounds motion; };
WORK(kBindRowOrigins, readonly, vec4, rowOrigins);        // of each row's laser in the head: forward, left, up
WORK(kBindProjectedMotions, , vec4, projectedMotions);    // of each projected triangle: m/s of its three corners
WORK(kBindProjectedTexture, , vec4, projectedTexture);    // of each projected triangle: uv of a and b, of c
WORK(kBindAlphaImages, readonly, uvec4, alphaImages);     // width, height, first byte, wrapping of u | of v << 8
WORK(kBindTexels, readonly, uint, texels);                // four bytes of alpha each
WORK(kBindSubRays, readonly, vec4, subRays);              // tangents left and up, weight, length of (1, left, up)
WORK(kBindProjectedMaterials, , uint, projectedMaterials);  // of each projected triangle
CHUNK(kBindClusterMaterials, uint, clusterMaterials);
CHUNK(kBindTextureCoordinates, vec2, textureCoordinates);  // per vertex of the chunk
CHUNK(kBindMeshPlaces, uint, meshPlaces);                 // per mesh: its first entry in trianglePlaces; kNone: elsewhere
CHUNK(kBindTrianglePlaces, uint, trianglePlaces);         // per triangle of a mesh: cluster * kClusterTriangles + its place there
