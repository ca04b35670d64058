// SPDX-License-Identifier: Apache-2.0
// Holes that a texture cuts into a surface: glTF's alpha mode MASK. The alpha value is that of the texel that contains
// the point.

float wrapped(float value, uint wrap) {
  if (wrap == kWrapClamp) return clamp(value, 0.0, 1.0);
  precise float once = value - floor(value);
  if (wrap == kWrapRepeat) return once;
  precise float back = 1.0 - once;
  return (int(floor(value)) & 1) == 0 ? once : back;
}

bool isFinite(float value) { return (floatBitsToUint(value) & 0x7f800000u) != 0x7f800000u; }

// Coordinates that are not finite lie in no texel. There the surface is as opaque as without a texture.
float alphaAt(uint image, vec2 uv) {
  bool isKnown = isFinite(uv.x) && isFinite(uv.y);
  if (!isKnown) uv = vec2(0.0);
  uvec4 at = alphaImages.at[image];
  precise vec2 place = vec2(wrapped(uv.x, at.w & 0xff), wrapped(uv.y, at.w >> 8)) * vec2(at.xy);
  uvec2 texel = min(uvec2(place), at.xy - 1);
  uint number = at.z + texel.y * at.x + texel.x;
  float alpha = float(texels.at[number / 4] >> (8 * (number % 4)) & 0xff) * (1.0 / 255.0);
  return isKnown ? alpha : 1.0;
}

// The coordinates of a triangle's corners in its texture.
struct TextureCorners {
  vec2 a, b, c;
};

// Whether the point is in a hole, of a surface whose alpha cut-off is above 0. `weights` are the weights of the corners,
// not yet divided by their sum.
bool isHole(Optics4 surface, TextureCorners corners, vec3 weights) {
  float alpha = surface.passage.z;
  uint image = surface.alphaImage;
  if (image != kNone) {
    precise float sum = weights.x + weights.y + weights.z;
    precise vec3 w = weights * quotient(1.0, sum);
    precise vec2 uv = w.x * corners.a + w.y * corners.b + w.z * corners.c;
    precise float product_ = alpha * alphaAt(image, uv);
    alpha = product_;
  }
  return alpha < surface.passage.y;
}

// Returns the texture corners of a projected triangle.
TextureCorners textureCornersOf(uint projected) {
  vec4 ab = projectedTexture.at[2 * projected];
  return TextureCorners(ab.xy, ab.zw, projectedTexture.at[2 * projected + 1].xy);
}
