// SPDX-License-Identifier: Apache-2.0
// A property of snow that the effects and RGL's interface share.
#pragma once

namespace gnosphere {

/// Back-scatter of a snow flake relative to a Lambertian disc: a Lambertian sphere of reflectance 0.9 returns 2/3 of
/// the light of a disc with that reflectance.
inline constexpr double kFlakeReflectance = 0.6;

}  // namespace gnosphere
