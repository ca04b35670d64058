// SPDX-License-Identifier: Apache-2.0
// The strength of a return, relative to a Lambertian target of reflectance 1, square to the beam, at 1 m.
#ifndef GNOSPHERE_EFFECTS_INTENSITY_H
#define GNOSPHERE_EFFECTS_INTENSITY_H

#include "parameters.h"

#ifdef __cplusplus
namespace gnosphere::gpu {
#endif

// Least alpha of the GGX lobe. A narrower lobe would be missed, or hit by chance, between two beams.
GNO_CONST float kLeastGloss = 0.05f;

// The glossy lobe seen from the light source: GGX with alpha = roughness^2 (Walter et al., EGSR 2007) and Smith's
// shadowing (Heitz, JCGT 2014), where half vector, light and view coincide. Returns pi * f * cosine, a scale on which
// a Lambertian surface gives the cosine.
GNO_INLINE float glossyLobe(float cosine, float roughness) {
  GNO_PRECISE float alpha = max(roughness * roughness, kLeastGloss);
  GNO_PRECISE float square = alpha * alpha;
  GNO_PRECISE float cosineSquare = cosine * cosine;
  GNO_PRECISE float t = cosineSquare * square + (1.0f - cosineSquare);
  GNO_PRECISE float tSquare = t * t;
  GNO_PRECISE float shadowing = cosineSquare + square * (1.0f - cosineSquare);  // its square
  GNO_PRECISE float result = 0.25f * square * inverseRoot(tSquare * tSquare * shadowing);
  return result;
}

// Share of a beam's energy that a surface without gloss reflects; `cosIncidence` is 1 if the surface is square to the
// beam.
GNO_INLINE float reflectedDiffusely(Optics4 optics, float cosIncidence) {
  GNO_PRECISE float cosine = min(abs(cosIncidence), 1.0f);
  GNO_PRECISE float result = (optics.reflection.x + optics.reflection.w) * cosine;
  return result;
}

// The same for a surface with gloss.
GNO_INLINE float reflectedGlossily(Optics4 optics, float cosIncidence) {
  GNO_PRECISE float lobe = glossyLobe(min(abs(cosIncidence), 1.0f), optics.reflection.z);
  GNO_PRECISE float result = reflectedDiffusely(optics, cosIncidence) + optics.reflection.y * lobe;
  return result;
}

// The same for any surface.
GNO_INLINE float reflected(Optics4 optics, float cosIncidence) {
  return optics.reflection.y > 0.0f ? reflectedGlossily(optics, cosIncidence)
                                    : reflectedDiffusely(optics, cosIncidence);
}

// Share of the light from behind a transmitting surface that returns: the light passes the surface twice.
GNO_INLINE float transmitted(Optics4 optics) {
  GNO_PRECISE float both = optics.passage.x * optics.passage.x;
  return both;
}

// Relative received power, by the lidar equation for a target that covers the whole beam. `depth` is the optical depth
// of the medium up to the target.
GNO_INLINE float received(float energy, float range, float depth) {
  GNO_PRECISE float square = max(range * range, 1e-8f);
  GNO_PRECISE float power = quotient(energy, square) * exponential(-2.0f * depth);
  return power;
}

// Unit intensity: the reflectance at which a Lambertian target, square to the beam at that range, would return as
// much.
GNO_INLINE float unitIntensity(EffectParameters p, float energy, float range, float depth) {
  if (p.intensityModel == kModelCarla) {  // RayCastLidar.cpp of CARLA 0.9
    GNO_PRECISE float depthOfCarla = p.attenuation * range;
    return exponential(-depthOfCarla);
  }
  GNO_PRECISE float physical = energy * exponential(-2.0f * depth);
  return physical;
}

// Converts unit intensity to the requested scale. Bytes follow Velodyne's calibrated reflectivity (VLP-16 user manual,
// 63-9243): 0..100 are per cent of diffuse reflection, 101..255 are retro-reflectors. The law for these is logarithmic
// here; the manual gives none.
GNO_INLINE float scaled(EffectParameters p, float unit, float range) {
  if (p.intensityScale == kScaleRaw) return p.intensityModel == kModelCarla ? unit : received(unit, range, 0.0f);
  if (p.intensityScale == kScaleUnit) return min(unit, 1.0f);
  GNO_PRECISE float diffuse = 100.0f * unit;
  // The factor is 155 / ln 1000: a retro-reflector of unit intensity 1000 is 255, and so are stronger ones.
  GNO_PRECISE float retro = 100.0f + 22.438445f * naturalLog(max(unit, 1.0f));
  GNO_PRECISE float rounded = floor(min(unit > 1.0f ? retro : diffuse, 255.0f) + 0.5f);
  return rounded;
}

#ifdef __cplusplus
}  // namespace gnosphere::gpu
#endif
#endif
