// SPDX-License-Identifier: Apache-2.0
// Effects of weather on light: published formulas that give the parameters of the device's formulas.
#pragma once

#include "common/effects/parameters.h"
#include "sensor/beams.hpp"

namespace gnosphere {

/// Returns the extinction in 1/m of fog for a wavelength in nm. At 550 nm contrast falls to 5 % at the meteorological
/// optical range `visibility`, in metres (Koschmieder 1924, WMO-No. 8). At other wavelengths the extinction is
/// (wavelength / 550)^-q times as large, with q by Kim, McArthur and Korevaar (2001, SPIE 4214).
double fogExtinction(double visibility, double wavelength);
/// Extinction in 1/m of rain in mm/h by ITU-R P.1814 (2007), after Carbonneau and Wisely (1998): 1.076 R^0.67 dB/km.
double rainExtinction(double rate);
/// Extinction in 1/m of dry snow in mm/h of water at a wavelength in nm by ITU-R P.1814: (0.0000542 nm + 5.4958776)
/// S^1.38 dB/km.
double snowExtinction(double rate, double wavelength);

/// Relative power that one pulse length of a medium scatters back at 1 m: pi * back-scatter * `pulseWidth` (metres),
/// where back-scatter = extinction (1/m) / lidar ratio (sr).
double scatterOf(double extinction, double lidarRatio, double pulseWidth);
/// Lidar ratio in sr of water droplets at 905 nm: O'Connor et al., J. Atmos. Oceanic Technol. 21 (2004).
inline constexpr double kFogLidarRatio = 18.8;
/// Lidar ratio in sr of mineral dust at 532 nm: Mueller et al., J. Geophys. Res. 112 (2007).
inline constexpr double kDustLidarRatio = 55;

/// Size distribution of drops or flakes by diameter D: intercept * exp(-slope D) per m^3 and metre of diameter.
struct DropSizes {
  double intercept = 0;    ///< 1/m^4
  double slope = 0;        ///< 1/m
  double reflectance = 0;  ///< of one particle, relative to a Lambertian disc of its diameter
};
/// Size distribution of rain in mm/h by Marshall and Palmer (1948).
DropSizes rainDrops(double rate);
/// Size distribution of snow in mm/h of water by Sekhon and Srivastava (1970).
DropSizes snowFlakes(double rate);

/// Expected number of detectable particles per metre of the beam at `range` (metres). `p` gives the beam's spread and
/// the detection threshold.
double particleDensity(const gpu::EffectParameters& p, const DropSizes& sizes, double range);
/// Returns the table of particleDensity() and of its integral over a range window, which is that of all beams.
gpu::Particles particlesOf(const gpu::EffectParameters& p, const DropSizes& sizes, const RangeWindow& window);

}  // namespace gnosphere
