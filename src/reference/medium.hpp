// SPDX-License-Identifier: Apache-2.0
// Fog, rain, snow and dust, in double and in world coordinates: how they attenuate light, and their own echoes.
#pragma once

#include <array>
#include <optional>

#include "reference/draws.hpp"
#include "reference/trace.hpp"

namespace gnosphere::reference {

/// Light that returns from one depth along a beam.
struct Echo {
  Bounded range;
  Bounded energy = 1;  ///< share of the beam's energy that arrives, times the share that the surface reflects
  double width = 0;
  Hit hit = {};             ///< the strongest hit if there are several; none: the echo is the medium's
  Bounded light = 0;        ///< share of the beam's light that goes on behind it
  bool ofParticle = false;  ///< the medium's, of a single drop or flake
};

/// Received power relative to a Lambertian target of reflectance 1 at 1 m and normal incidence: the lidar equation for
/// a target that fills the beam, behind a medium of the given optical depth.
Bounded received(const Bounded& energy, const Bounded& range, const Bounded& depth);

/// Returns the least detectable power: that of the stated target at the stated range.
double thresholdOf(const Effects& effects, const Sensor& sensor);
/// Full angles of the beam in radians, horizontal and vertical: those of the request, or else the sensor's.
std::array<double, 2> fullAnglesOf(const SensorPlan& plan);
/// Half the length of a pulse in metres, because light travels there and back.
double pulseLength(const Effects& effects);

class Medium {
 public:
  Medium(const SensorPlan& plan, const Shot& shot);

  /// Returns the optical depth along a line up to a range.
  Bounded depthTo(const Line& line, const Bounded& range) const;
  /// Returns the medium's strongest echo between `nearest` and `far`; `surfaces` has the beam's other echoes.
  std::optional<Echo> strongest(const Draws& draws, size_t beam, const Line& line, const Bounded& nearest,
                                const Bounded& far, const std::vector<Echo>& surfaces, bool& doubt) const;

 private:
  /// A table of the expected number of detectable drops or flakes up to eight ranges, which are denser near the sensor.
  /// Between two ranges the number is the increasing rational function with both numbers and both densities (Gregory
  /// and Delbourgo 1982).
  struct Counts {
    static constexpr size_t kSize = 8;
    struct Part {
      double before, between;  ///< particles before its start, and between its start and end
      double atStart, atEnd;   ///< densities as multiples of its mean density
    };
    double first = 0, last = 0;
    std::array<double, kSize + 1> upTo = {};
    std::array<double, kSize + 1> density = {};  ///< 1/m

    double rangeOf(size_t entry) const;
    double rangeWith(double count) const;
    double countUpTo(double range) const;
    Part partOf(size_t entry) const;  ///< between entry - 1 and entry
  };
  struct Particles {
    double intercept = 0;    ///< 1/m^4: intercept * exp(-slope D) per m^3 and metre of diameter D
    double slope = 0;        ///< 1/m
    double reflectance = 0;  ///< of one particle, as a Lambertian disc of its diameter
    Counts counts, others;   ///< two tables if rounding decides at which range the table ends
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
  Bounded lightBehind(const std::vector<Echo>& surfaces, const Bounded& range, bool& doubt) const;
  /// Returns the echo of the particle up to which, from `nearest` on, `beyond` particles are expected; none if it is
  /// beyond the table or `far`.
  std::optional<Echo> particle(const Particles& particles, Bounded beyond, const Bounded& nearest, const Bounded& far,
                               uint32_t size, bool& doubt) const;
  Span within(const Effects::Volume& box, const Line& line, const Bounded& far, bool& doubt) const;

  const SensorPlan& plan_;
  double fog_ = 0, still_ = 0;  // 1/m: of fog; of fog, rain and snow together
  double threshold_, pulse_, horizontal_, vertical_;
  double travel_ = 0;  // longest distance in metres that the sensor moves within the scan
  Particles rain_, snow_;
};

}  // namespace gnosphere::reference
