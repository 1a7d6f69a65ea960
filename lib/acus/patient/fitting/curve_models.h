// The laws of the phases of a recording, as models of its samples, and where their fits start.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "acus/patient/fitting/least_squares.h"

namespace acus::fitting {

/// Samples chosen for one fit, with their index in the recording.
struct Samples {
  std::vector<double> x;
  std::vector<double> y;
  std::vector<std::size_t> index;

  void Add(std::size_t i, double at, double value);
  /// Largest minus smallest x; 0 if empty.
  double Span() const;
};

/// a - b, of independent estimates.
Estimate Difference(const Estimate& a, const Estimate& b);

/// factor a / b of independent estimates that are above 0 by nature: the difference of logarithms,
/// each end from the ends of both (Zou & Donner 2008), so that no end is below 0.
/// @pre b.low > 0, a.low >= 0.
Estimate PositiveRatio(const Estimate& a, const Estimate& b, double factor = 1.0);

/// With another uncertainty: anything within +- half, equally likely.
Estimate Widened(Estimate estimate, double half);

/// A line. Parameters: value at `middle`, slope.
SampleModel Line(double middle);
ModelFit FitLine(const Samples& samples, double middle);  ///< Robust.

/// The rise on a line of known slope: baseline + slope (d - from) + a1 x + a2 x^2, x = d - contact.
/// Parameters: contact depth, baseline, then a1 and a2 unless they are held at 0.
struct RiseLaw {
  double from_mm = 0.0;
  double slope_n_per_mm = 0.0;
  bool has_a1 = true;
  bool has_a2 = true;

  double operator()(std::span<const double> p, double depth_mm, std::span<double> gradient) const;
  double A1(std::span<const double> p) const { return has_a1 ? p[2] : 0.0; }
  double A2(std::span<const double> p) const { return has_a2 ? p[has_a1 ? 3 : 2] : 0.0; }
};

/// The best contact depth on a grid, with the other parameters from linear least squares: the
/// start from which the fit finds the global minimum. Empty if no rise fits with a1, a2 >= 0.
std::vector<double> StartOfRise(const Samples& samples, const RiseLaw& law, double to_mm);

/// A hold that began at `start_s`: F + A exp(-(t - start) / tau).
/// Parameters: F, A, logarithm of tau.
SampleModel Relaxation(double start_s);

}  // namespace acus::fitting
