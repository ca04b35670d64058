// SPDX-License-Identifier: Apache-2.0
// What weather does to light: published figures, made the parameters of the device's formulas.
#pragma once

#include "effects/parameters.h"

namespace gnosphere {

/// 1/m of fog with a meteorological optical range in metres: contrast falls to 5 % there (Koschmieder 1924, WMO-No. 8).
double fogExtinction(double visibility);
/// 1/m of rain in mm/h: ITU-R P.1814 (2007), after Carbonneau and Wisely (1998): 1.076 R^0.67 dB/km.
double rainExtinction(double rate);
/// 1/m of dry snow in mm/h of water at a wavelength in nm: ITU-R P.1814: (0.0000542 nm + 5.4958776) S^1.38 dB/km.
double snowExtinction(double rate, double wavelength);

/// Relative power that one pulse length (metres) of a medium throws back at 1 m: pi * back-scatter * length, where
/// back-scatter = extinction / lidar ratio (sr).
double scatterOf(double extinction, double lidarRatio, double pulseWidth);
/// sr, of water droplets at 905 nm: O'Connor et al., J. Atmos. Oceanic Technol. 21 (2004).
inline constexpr double kFogLidarRatio = 18.8;
/// sr, of mineral dust: Mueller et al., J. Geophys. Res. 112 (2007), at 532 nm.
inline constexpr double kDustLidarRatio = 55;

/// How drops or flakes are spread over diameters D: intercept * exp(-slope D) per m^3 and metre of diameter.
struct DropSizes {
  double intercept = 0;    ///< 1/m^4
  double slope = 0;        ///< 1/m
  double reflectance = 0;  ///< of one, as a Lambertian disc of its diameter
};
/// Marshall and Palmer (1948), mm/h.
DropSizes rainDrops(double rate);
/// Sekhon and Srivastava (1970), mm/h of water.
DropSizes snowFlakes(double rate);

/// Expected number of particles per metre of the beam at `range` that are strong enough to be detected. What the beam
/// is like and what is detected is read from `p`.
double particleDensity(const gpu::EffectParameters& p, const DropSizes& sizes, double range);
/// The table of the above, summed up along the range window of `p`.
gpu::Particles particlesOf(const gpu::EffectParameters& p, const DropSizes& sizes);

}  // namespace gnosphere
