// The elastica integrated on its own, with no part of the rod's code: a clamped inextensible beam
// with a dead load at its tip.
#pragma once

#include <array>
#include <cmath>

namespace acus::needle::testing_support {

struct ElasticaTip {
  double across = 0.0;  ///< Deflection, in lengths.
  double along = 1.0;   ///< Position along the clamped direction, in lengths.
  double angle_rad = 0.0;
};

/// theta'' = -k (cos theta) across - ... on s in [0, 1], theta(0) = 0, theta'(1) = 0, by shooting
/// with classical Runge-Kutta (2000 steps: error under 1e-12).
/// @param across  F_across L^2 / EI;  @param push  F_against_axis L^2 / EI (compression positive).
/// @param curvature_guess  theta'(0) to start the search from.
inline ElasticaTip Elastica(double across, double push, double curvature_guess) {
  using State = std::array<double, 4>;  // theta, theta', along, across
  const auto slope = [&](const State& y) {
    return State{y[1], -across * std::cos(y[0]) - push * std::sin(y[0]), std::cos(y[0]),
                 std::sin(y[0])};
  };
  const auto shoot = [&](double curvature) {
    constexpr int kSteps = 2000;
    constexpr double kStep = 1.0 / kSteps;
    State y{0.0, curvature, 0.0, 0.0};
    const auto moved = [](const State& a, const State& b, double f) {
      return State{a[0] + f * b[0], a[1] + f * b[1], a[2] + f * b[2], a[3] + f * b[3]};
    };
    for (int i = 0; i < kSteps; ++i) {
      const State k1 = slope(y);
      const State k2 = slope(moved(y, k1, 0.5 * kStep));
      const State k3 = slope(moved(y, k2, 0.5 * kStep));
      const State k4 = slope(moved(y, k3, kStep));
      for (int j = 0; j < 4; ++j) y[j] += kStep / 6.0 * (k1[j] + 2 * k2[j] + 2 * k3[j] + k4[j]);
    }
    return y;
  };
  double a = curvature_guess;
  double b = 1.001 * curvature_guess + 1e-6;
  double fa = shoot(a)[1];
  double fb = shoot(b)[1];
  for (int i = 0; i < 60 && std::abs(fb) > 1e-13 && fa != fb; ++i) {
    const double c = b - fb * (b - a) / (fb - fa);
    a = b;
    fa = fb;
    b = c;
    fb = shoot(b)[1];
  }
  const State tip = shoot(b);
  return {tip[3], tip[2], tip[0]};
}

}  // namespace acus::needle::testing_support
