// SPDX-License-Identifier: Apache-2.0
// Beams that deviate from their axes because of angle noise. `strays` has the tangents of each deviation, to the left
// and up.

// Returns the length of the vector (1, left, up).
float lengthOf(float left, float up) {
  precise float square = 1.0 + left * left + up * up;
  return squareRoot(square);
}

// Returns the unit vector of the deviating beam.
vec3 strayed(Beam axis, vec2 stray) {
  precise vec3 up = vec3(-axis.sinElevation * axis.azimuth.x, -axis.sinElevation * axis.azimuth.y, axis.cosElevation);
  precise vec3 aim = axis.direction + vec3(-axis.azimuth.y, axis.azimuth.x, 0.0) * stray.x + up * stray.y;
  precise vec3 unit = aim * quotient(1.0, lengthOf(stray.x, stray.y));
  return unit;
}
