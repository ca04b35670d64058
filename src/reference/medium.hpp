// SPDX-License-Identifier: Apache-2.0
// Fog, rain, snow and dust, in double and in the world: what they take of light and what they throw back.
#pragma once

#include <optional>

#include "reference/draws.hpp"
#include "reference/trace.hpp"

namespace gnosphere::reference {

/// What comes back from one depth of a beam.
struct Echo {
  Bounded range;
  Bounded energy = 1;  ///< share of the beam's, times what the surface throws back
  double width = 0;
  Hit hit = {};  ///< of several the strongest; none: of the medium
};

/// Power received, relative to a Lambertian target of reflectance 1, square to the beam, at 1 m: the lidar equation for
/// a target that catches the whole beam, behind a medium of that optical depth.
Bounded received(const Bounded& energy, const Bounded& range, const Bounded& depth);

/// The least power that is detected: that of the stated target at the stated range.
double thresholdOf(const Effects& effects, const Sensor& sensor);
/// Metres of a pulse, there and back.
double pulseLength(const Effects& effects);

class Medium {
 public:
  Medium(const SensorPlan& plan, const Shot& shot);

  /// Optical depth along a line up to a range.
  Bounded depthTo(const Line& line, const Bounded& range) const;
  /// The echo of the medium that has most power of those nearer than `far`.
  std::optional<Echo> strongest(const Draws& draws, size_t beam, const Line& line, const Bounded& far,
                                bool& doubt) const;

 private:
  /// Expected number of drops or flakes up to a range that are strong enough to be detected: a table of eight ranges
  /// that lie closer where they are near, and straight lines between them.
  struct Counts {
    static constexpr size_t kSize = 8;
    double first = 0, last = 0;
    std::array<double, kSize + 1> upTo = {};

    double rangeOf(size_t entry) const;
    double rangeWith(double count) const;
  };
  struct Particles {
    double intercept = 0;    ///< 1/m^4: intercept * exp(-slope D) per m^3 and metre of diameter D
    double slope = 0;        ///< 1/m
    double reflectance = 0;  ///< of one, as a Lambertian disc of its diameter
    Counts counts, others;   ///< two tables where rounding decides where the table ends
    double countError = 0;
  };
  struct Span {
    Bounded near, far;
  };

  Bounded density(const Particles& particles, double range) const;
  void tabulate(Particles& particles) const;
  Bounded beamArea(const Bounded& range) const;
  std::optional<Echo> scatter(double extinction, double lidarRatio, const Bounded& near, const Bounded& far,
                              const std::array<uint32_t, 4>& words, const std::array<uint32_t, 4>& more,
                              bool& doubt) const;
  std::optional<Echo> particle(const Particles& particles, const Bounded& far, const std::array<uint32_t, 4>& words,
                               bool& doubt) const;
  Span within(const Effects::Volume& box, const Line& line, const Bounded& far, bool& doubt) const;

  const SensorPlan& plan_;
  double fog_ = 0, still_ = 0;  // 1/m: of fog; of fog, rain and snow together
  double threshold_, pulse_, horizontal_, vertical_;
  double travel_ = 0;  // metres that the sensor moves within the scan, at most
  Particles rain_, snow_;
};

}  // namespace gnosphere::reference
