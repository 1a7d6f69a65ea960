#include "references/stiffness_fit.h"

#include <algorithm>
#include <cmath>

#include "acus/base/core/error.h"
#include "acus/physics/needle/rod.h"

namespace acus::needle {

double TipDeflectionMm(double force_n, double length_mm, double bending_n_mm2, int num_nodes) {
  RodProperties properties;
  properties.length_mm = length_mm;
  properties.bending_n_mm2 = bending_n_mm2;
  properties.twist_n_mm2 = bending_n_mm2;  // Takes no part.
  RodOptions options;
  options.num_nodes = num_nodes;
  options.tolerance_mm = 1e-8 * length_mm;
  options.max_iterations = 200;
  const RodModel model(properties, options);
  RodState state = model.NewState();
  const RodLoad load{length_mm, Eigen::Vector3d(force_n, 0.0, 0.0)};
  RodInput input;
  input.loads = {&load, 1};
  const RodResult result = model.Solve(state, input);
  if (!result.converged()) {
    throw NoAnswerError("needle: no shape found for a tip force far beyond what bends it");
  }
  return state.point.back().position_mm.x();
}

double FitBendingStiffness(std::span<const TipDeflection> measured, double length_mm) {
  ACUS_REQUIRE(!measured.empty(), "needle: a stiffness needs at least one measured deflection");
  double softest = 0.0;
  double stiffest = 0.0;
  for (const TipDeflection& m : measured) {
    ACUS_REQUIRE(m.force_n > 0.0 && std::isfinite(m.force_n), "needle: force_n is ", m.force_n,
                 "; it must be above 0");
    ACUS_REQUIRE(m.deflection_mm > 0.0 && m.deflection_mm < 0.9 * length_mm,
                 "needle: deflection_mm is ", m.deflection_mm,
                 "; it must be above 0 and below 0.9 lengths, ", 0.9 * length_mm);
    const double linear = m.force_n * std::pow(length_mm, 3) / (3.0 * m.deflection_mm);
    softest = softest == 0.0 ? linear : std::min(softest, linear);
    stiffest = std::max(stiffest, linear);
  }
  const auto misfit = [&](double log_stiffness) {
    double sum = 0.0;
    for (const TipDeflection& m : measured) {
      const double bent_mm = TipDeflectionMm(m.force_n, length_mm, std::exp(log_stiffness));
      sum += std::pow(bent_mm / m.deflection_mm - 1.0, 2);
    }
    return sum;
  };
  // Golden section: large deflections need a softer needle than small-deflection theory says.
  constexpr double kGolden = 0.6180339887498949;
  double low = std::log(0.02 * softest);
  double high = std::log(1.1 * stiffest);
  double a = high - kGolden * (high - low);
  double b = low + kGolden * (high - low);
  double fa = misfit(a);
  double fb = misfit(b);
  while (high - low > 1e-7) {
    if (fa < fb) {
      high = b;
      b = a;
      fb = fa;
      a = high - kGolden * (high - low);
      fa = misfit(a);
    } else {
      low = a;
      a = b;
      fa = fb;
      b = low + kGolden * (high - low);
      fb = misfit(b);
    }
  }
  return std::exp(0.5 * (low + high));
}

}  // namespace acus::needle
