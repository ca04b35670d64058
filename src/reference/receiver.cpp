// SPDX-License-Identifier: Apache-2.0
#include "reference/receiver.hpp"

#include <limits>

namespace gnosphere::reference {

/// An echo with the number that keys its random draws. Surfaces keep their numbers whether or not the medium adds an
/// echo.
struct Receiver::Numbered {
  Echo echo;
  uint32_t number = 0;
  Bounded depth = {};

  bool isSurface() const { return echo.hit.triangle != kNobody; }
};

std::array<Bounded, 2> Receiver::angleError(size_t beam) const {
  constexpr double kCutOff = 4;  // in standard deviations
  const auto [azimuth, elevation] = draws_.normals(beam, 0, gpu::kAngleNoise);
  const auto& noise = plan_.effects.angleNoise;
  return {given(noise.azimuth) * max(-kCutOff, min(azimuth, kCutOff)),
          given(noise.elevation) * max(-kCutOff, min(elevation, kCutOff))};
}

/// Detection is a step at the threshold, or the logistic function of ln(power / threshold) / softness. A power within a
/// millionth of the threshold counts as equal to it.
/// `softness` is 0 for a drop or flake, since the table of particles has no weaker ones.
bool Receiver::detected(const Bounded& power, double softness, double chance, bool& doubt) const {
  if (!(power.value > 1e-37)) return false;
  if (!(softness > 0)) return !less(power, threshold_ * Bounded(0.999999), doubt);
  const Bounded steps = (log(power) - log(threshold_)) / given(softness);
  return less(chance, Bounded(1) / (Bounded(1) + exp(-max(steps, -80))), doubt);
}

/// Reflectance of the Lambertian target that would give this power at this range and normal incidence; or CARLA's
/// intensity.
Bounded Receiver::unitIntensity(const Echo& echo, const Bounded& depth) const {
  const Effects::Intensity& intensity = plan_.effects.intensity;
  if (intensity.model == Effects::Intensity::Model::carla) return exp(-(given(intensity.attenuation) * echo.range));
  return echo.energy * exp(Bounded(-2) * depth);
}

/// Bytes up to 100 are per cent of a diffuse target; 100..255 is a logarithmic scale for retro-reflectors, up to a gain
/// of 1000.
Bounded Receiver::scaled(const Bounded& unit, const Bounded& range) const {
  const Effects::Intensity& intensity = plan_.effects.intensity;
  switch (intensity.scale) {
    case Effects::Intensity::Scale::raw:
      return intensity.model == Effects::Intensity::Model::carla ? unit : received(unit, range, 0);
    case Effects::Intensity::Scale::unit: return min(unit, 1);
    case Effects::Intensity::Scale::byte: break;
  }
  const Bounded diffuse = Bounded(100) * unit;
  const Bounded retro = Bounded(100) + given(155 / std::log(1000.0)) * log(max(unit, 1));
  return nearestWhole(min(unit.value > 1 ? retro : diffuse, 255));
}

/// Returns the indices of the `powers` (in order of range) that the mode selects.
std::vector<size_t> Receiver::chosen(const std::vector<Bounded>& powers, bool& doubt) const {
  using Mode = Effects::Returns::Mode;
  const Mode mode = plan_.has(gpu::kReturns) ? plan_.effects.returns.mode : Mode::strongest;
  constexpr size_t kNone = static_cast<size_t>(-1);
  const size_t count = powers.size();
  const size_t first = count > 0 ? 0 : kNone, second = count > 1 ? 1 : kNone, last = count - 1;
  // The strongest except `but`; among equals the nearest.
  const auto strongest = [&](size_t but) {
    size_t best = kNone;
    for (size_t i = 0; i < count; ++i)
      if (i != but && (best == kNone || less(powers[best], powers[i], doubt))) best = i;
    return best;
  };
  const auto secondStrongest = [&] { return count > 1 ? strongest(strongest(kNone)) : kNone; };
  std::vector<size_t> result;
  switch (mode) {
    case Mode::first: result = {first}; break;
    case Mode::second: result = {second}; break;
    case Mode::last: result = {last}; break;
    case Mode::strongest: result = {strongest(kNone)}; break;
    case Mode::secondStrongest: result = {secondStrongest()}; break;
    case Mode::firstSecond: result = {first, second}; break;
    case Mode::firstLast: result = {first, last}; break;
    case Mode::firstStrongest: result = {first, strongest(kNone)}; break;
    case Mode::lastStrongest: result = {last, strongest(kNone)}; break;
    case Mode::strongestSecondStrongest: result = {strongest(kNone), secondStrongest()}; break;
    case Mode::dual: {
      const size_t most = strongest(kNone);
      result = {last, last == most ? secondStrongest() : most};
      break;
    }
    case Mode::all:
      for (size_t i = 0; i < count; ++i) result.push_back(i);
  }
  std::sort(result.begin(), result.end());
  result.erase(std::unique(result.begin(), result.end()), result.end());
  while (!result.empty() && result.back() == kNone) result.pop_back();
  if (result.size() > plan_.returns) result.resize(plan_.returns);
  return result;
}

/// Applies noise and scaling to a returned echo.
Return Receiver::measured(size_t beam, const Numbered& numbered, bool& doubt) const {
  const auto& [echo, number, depth] = numbered;
  Return result = {echo.range, echo.range.value, std::numeric_limits<double>::quiet_NaN(), echo.width, echo.hit};
  if (plan_.has(gpu::kSpeedNoise))
    result.speedError = plan_.effects.radialSpeed.sigma * draws_.normals(beam, number, gpu::kRadialSpeed)[0].value;
  if (plan_.has(gpu::kRangeNoise)) {
    const Effects::RangeNoise& noise = plan_.effects.rangeNoise;
    Bounded sigma = given(noise.sigma) + given(noise.sigmaPerMetre) * echo.range +
                    given(noise.sigmaPerSquareMetre) * echo.range * echo.range;
    if (noise.sigmaAtThreshold > 0) {
      const Bounded power = received(echo.energy, echo.range, depth);
      const Bounded weak = given(noise.sigmaAtThreshold) * threshold_ / max(power, threshold_);
      sigma = sqrt(sigma * sigma + weak * weak);
    }
    Bounded range = echo.range + given(noise.bias) + sigma * draws_.normals(beam, number, gpu::kRangeNoise)[0];
    if (noise.step > 0) range = nearestWhole(range / given(noise.step)) * given(noise.step);
    result.range = max(range, 0);
  }
  if (plan_.has(gpu::kIntensity)) {
    Bounded unit = unitIntensity(echo, depth);
    if (plan_.has(gpu::kIntensityNoise))
      unit = max(
          unit + given(plan_.effects.intensityNoise.sigma) * draws_.normals(beam, number, gpu::kIntensityNoise)[0], 0);
    const Bounded intensity = scaled(unit, echo.range);
    doubt = doubt || (plan_.effects.intensity.scale == Effects::Intensity::Scale::byte && intensity.error > 0);
    result.intensity = intensity.value;
  }
  return result;
}

Judgement Receiver::judge(size_t beam, const Line& axis, double least, std::vector<Echo> surfaces, bool& doubt) const {
  Judgement result;
  const Effects::DropOut& dropOut = plan_.effects.dropOut;
  if (plan_.has(gpu::kDropOut)) {
    const auto& dead = dropOut.deadBeams;
    if (std::find(dead.begin(), dead.end(), beam) != dead.end()) return {{}, Cause::dead};
    if (less(draws_.uniform(beam, 0, gpu::kDropOut), given(dropOut.generalRate), doubt))
      return {{}, surfaces.empty() && !plan_.has(gpu::kMediumEffects) ? Cause::noSurface : Cause::droppedOut};
  }

  std::vector<Numbered> echoes;
  for (const Echo& echo : surfaces) echoes.push_back({echo, static_cast<uint32_t>(echoes.size())});
  const bool inMedium = plan_.has(gpu::kMediumEffects);
  if (inMedium) {
    const Bounded separation = given(plan_.effects.returns.separation);
    const bool ends = !surfaces.empty() && !(surfaces.back().light.value > 0);
    const Bounded far = ends ? surfaces.back().range : given(axis.window.most);
    const std::optional<Echo> scatter = medium_.strongest(draws_, beam, axis, given(least), far, surfaces, doubt);
    // Light from the medium close to a surface merges with the surface's echo, if that one is detected by itself.
    const double softness = plan_.effects.detection.softness;
    const auto merges = [&](const Numbered& surface) {
      const auto& [echo, number, depth] = surface;
      if (less(separation, max(scatter->range - echo.range, echo.range - scatter->range), doubt)) return false;
      if (least > axis.window.least && less(echo.range, given(least), doubt)) return false;
      const double chance = softness > 0 ? draws_.uniform(beam, number, gpu::kDetection) : 0;
      return detected(received(echo.energy, echo.range, medium_.depthTo(axis, echo.range)), softness, chance, doubt);
    };
    if (scatter && std::none_of(echoes.begin(), echoes.end(), merges)) {
      size_t at = 0;
      while (at < surfaces.size() && !less(scatter->range, surfaces[at].range, doubt)) ++at;
      echoes.insert(echoes.begin() + static_cast<ptrdiff_t>(at), {*scatter, gpu::kScatterDraw});
    }
  }

  std::vector<Numbered> found;
  std::vector<Bounded> powers;
  for (Numbered& numbered : echoes) {
    const Echo& echo = numbered.echo;
    if (least > axis.window.least && less(echo.range, given(least), doubt)) {
      if (result.cause == Cause::noSurface) result.cause = Cause::tooNear;
      continue;
    }
    numbered.depth = inMedium ? medium_.depthTo(axis, echo.range) : Bounded(0);
    const Bounded power = received(echo.energy, echo.range, numbered.depth);
    if (inMedium || plan_.has(gpu::kDetection)) {
      const double softness = echo.ofParticle ? 0 : plan_.effects.detection.softness;
      const double chance = softness > 0 ? draws_.uniform(beam, numbered.number, gpu::kDetection) : 0;
      if (!detected(power, softness, chance, doubt)) {
        if (!numbered.isSurface()) continue;
        const bool inClearAir = inMedium && detected(received(echo.energy, echo.range, 0), softness, chance, doubt);
        const bool unexplained = result.cause == Cause::noSurface || result.cause == Cause::weak;
        if (inClearAir && unexplained) result.cause = Cause::attenuated;
        if (!inClearAir && result.cause == Cause::noSurface) result.cause = Cause::weak;
        continue;
      }
    }
    if (plan_.has(gpu::kDropOut) && dropOut.intensityLimit > 0 && dropOut.zeroIntensityRate > 0) {
      const Bounded share = unitIntensity(echo, numbered.depth) / given(dropOut.intensityLimit);
      const Bounded rate = given(dropOut.zeroIntensityRate) * (Bounded(1) - min(share, 1));
      if (less(draws_.uniform(beam, numbered.number + 1, gpu::kDropOut), rate, doubt)) {
        result.cause = Cause::droppedOut;
        continue;
      }
    }
    found.push_back(numbered);
    powers.push_back(power);
  }
  for (const size_t i : chosen(powers, doubt)) result.returns.push_back(measured(beam, found[i], doubt));
  if (!found.empty()) result.cause = result.returns.empty() ? Cause::notChosen : Cause::returned;
  return result;
}

}  // namespace gnosphere::reference
