// SPDX-License-Identifier: Apache-2.0
// Turns a beam's echoes into returns, in double: medium, detection, drop-out, choice of returns, noise.
#pragma once

#include "gnosphere/scan.hpp"
#include "reference/medium.hpp"

namespace gnosphere::reference {

struct Return {
  Bounded range;
  double trueRange = 0, intensity = 0, width = 0;
  Hit hit;                ///< none: the echo is the medium's
  double speedError = 0;  ///< m/s, of the radial speed
};

struct Judgement {
  std::vector<Return> returns;
  Cause cause = Cause::noSurface;
};

class Receiver {
 public:
  Receiver(const SensorPlan& plan, const Shot& shot)
      : plan_(plan),
        threshold_(given(thresholdOf(plan.effects, plan.sensor))),
        draws_(plan, shot),
        medium_(plan, shot) {}

  /// `surfaces` are the beam's echoes from surfaces, in order of range.
  /// `least` is the least range of a return.
  Judgement judge(size_t beam, const Line& axis, double least, std::vector<Echo> surfaces, bool& doubt) const;
  /// Returns the angular error of the beam: azimuth and elevation in radians.
  std::array<Bounded, 2> angleError(size_t beam) const;

 private:
  struct Numbered;

  bool detected(const Bounded& power, double softness, double chance, bool& doubt) const;
  Bounded unitIntensity(const Echo& echo, const Bounded& depth) const;
  Bounded scaled(const Bounded& unit, const Bounded& range) const;
  std::vector<size_t> chosen(const std::vector<Bounded>& powers, bool& doubt) const;
  Return measured(size_t beam, const Numbered& echo, bool& doubt) const;

  const SensorPlan& plan_;
  const Bounded threshold_;  ///< least detectable power
  Draws draws_;
  Medium medium_;
};

}  // namespace gnosphere::reference
