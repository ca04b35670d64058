// SPDX-License-Identifier: Apache-2.0
#include "town/opendrive/reference_line.hpp"

#include <algorithm>
#include <cmath>

namespace gnosphere::town::opendrive {
namespace {

constexpr double kTurn = 6.283185307179586;  ///< radians of a full turn

Vec3 direction(double radians) {
  return {cosine(radians / kTurn), sine(radians / kTurn), 0};
}

/// Integrates over [0, end] by Gauss-Legendre quadrature with five points on each of `pieces` equal parts.
template <typename Function>
auto integral(double end, int pieces, Function&& function) {
  constexpr double kNodes[] = {0, 0.5384693101056831, 0.9061798459386640};
  constexpr double kWeights[] = {0.5688888888888889, 0.4786286704993665, 0.2369268850561891};
  const double half = end / pieces / 2;
  auto sum = 0.0 * function(0.0);
  for (int i = 0; i < pieces; ++i) {
    const double middle = (2 * i + 1) * half;
    sum = sum + half * kWeights[0] * function(middle);
    for (int k = 1; k < 3; ++k)
      sum = sum + half * kWeights[k] * (function(middle - half * kNodes[k]) + function(middle + half * kNodes[k]));
  }
  return sum;
}

/// Number of parts of a curve that turns by `turned` radians for which integral() is accurate to a micrometre.
int piecesFor(double turned) {
  return 1 + static_cast<int>(std::min(2.0 * std::abs(turned), 1e4));
}

double polynomial(const std::array<double, 4>& k, double x) {
  return k[0] + x * (k[1] + x * (k[2] + x * k[3]));
}
double derivative(const std::array<double, 4>& k, double x) {
  return k[1] + x * (2 * k[2] + x * 3 * k[3]);
}

CurvePoint onArc(const Geometry& arc, double ds) {
  const double turned = arc.curvature * ds;
  // The chord is ds sin(turned / 2) / (turned / 2) long and points along the heading at half the arc.
  const double chord = std::abs(turned) < 1e-6 ? ds : ds * sine(turned / 2 / kTurn) / (turned / 2);
  return {arc.start + chord * direction(arc.heading + turned / 2), direction(arc.heading + turned)};
}

CurvePoint onSpiral(const Geometry& spiral, double ds) {
  // The curvature is linear in the distance: heading = heading0 + k0 ds + k' ds^2 / 2.
  const double rate = (spiral.curvatureAtEnd - spiral.curvature) / spiral.length;
  const auto along = [&](double s) { return direction(spiral.heading + s * (spiral.curvature + s * rate / 2)); };
  const double turned = ds * std::max(std::abs(spiral.curvature), std::abs(spiral.curvatureAtEnd));
  return {spiral.start + integral(ds, piecesFor(turned), along), along(ds)};
}

/// Returns the u of a poly3 where the curve is `ds` metres long (Newton's method).
double abscissa(const Geometry& poly, double ds) {
  const auto speed = [&](double u) { return std::sqrt(1 + derivative(poly.v, u) * derivative(poly.v, u)); };
  double u = ds / speed(0);
  for (int i = 0; i < 20; ++i) {
    const double step = (integral(u, 8, speed) - ds) / speed(u);
    u -= step;
    if (std::abs(step) < 1e-10) break;
  }
  return u;
}

CurvePoint onPolynomials(const Geometry& poly, double ds) {
  double u, v, du, dv;
  if (poly.shape == Shape::poly3) {
    u = abscissa(poly, ds);
    du = 1;
    v = polynomial(poly.v, u);
    dv = derivative(poly.v, u);
  } else {
    const double p = ds / poly.length * poly.parameterRange;
    u = polynomial(poly.u, p);
    v = polynomial(poly.v, p);
    du = derivative(poly.u, p);
    dv = derivative(poly.v, p);
  }
  const Vec3 forward = direction(poly.heading), left = {-forward.y, forward.x, 0};
  const Vec3 along = du * forward + dv * left;
  // Where all derivatives are 0, the curve has the direction of its start.
  return {poly.start + u * forward + v * left, dot(along, along) > 0 ? normalized(along) : forward};
}

/// Returns the cubic that applies at `s`; all zero before the first.
Cubic cubicAt(const Profile& profile, double s) {
  const auto next = std::upper_bound(profile.begin(), profile.end(), s,
                                     [](double value, const Cubic& cubic) { return value < cubic.start; });
  return next == profile.begin() ? Cubic{} : next[-1];
}

}  // namespace

double valueAt(const Profile& profile, double s) {
  const Cubic k = cubicAt(profile, s);
  const double ds = s - k.start;
  return k.a + ds * (k.b + ds * (k.c + ds * k.d));
}

double slopeAt(const Profile& profile, double s) {
  const Cubic k = cubicAt(profile, s);
  const double ds = s - k.start;
  return k.b + ds * (2 * k.c + ds * 3 * k.d);
}

CurvePoint Geometry::at(double ds) const {
  switch (shape) {
    case Shape::line: return {start + ds * direction(heading), direction(heading)};
    case Shape::arc: return onArc(*this, ds);
    case Shape::spiral: return onSpiral(*this, ds);
    default: return onPolynomials(*this, ds);
  }
}

}  // namespace gnosphere::town::opendrive
