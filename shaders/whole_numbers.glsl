// SPDX-License-Identifier: Apache-2.0
// Conversions of whole numbers from floats to integers.

// Converts a whole number up to 2^31. Mesa's lavapipe converts the lanes one by one, with eight instructions each. So on
// CPUs the number is added, in two halves, to a float whose last bit counts ones.
int whole(float number) {
  if (!kLanesInStep) return int(number);
  float bounded = clamp(number, -2147483520.0, 2147483520.0), high = floor(bounded * (1.0 / 65536.0));
  uint low = floatBitsToUint((bounded - high * 65536.0) + 12582912.0) - 0x4b400000u;
  uint bits = (floatBitsToUint(high + 12582912.0) << 16) + low;
  return number == number ? int(bits) : 0;
}

// The same for whole numbers from 0 to 2^22.
uint smallWhole(float number) { return floatBitsToUint(number + 8388608.0) - 0x4b000000u; }
