// The inverse of a displacement field, point by point.
#pragma once

#include <Eigen/Core>
#include <algorithm>

namespace acus::math {

struct InverseSettings {
  int max_iterations = 20;
  double tolerance_mm = 1e-3;  ///< Of |X + u(X) - x|.
};

struct InversePoint {
  Eigen::Vector3d rest_mm = Eigen::Vector3d::Zero();
  double residual_mm = 0.0;  ///< |X + u(X) - x| of what is returned.
  int iterations = 0;
};

/// Solves X + u(X) = x for X by the fixed point X <- x - u(X), which converges where the strain is
/// below 1 (Chen et al. 2008; Fortmeier-2016 after eq. 2). Where a step does not lower the
/// residual, the next one is half as long. Where the field folds or jumps there may be no answer:
/// then the best point met is returned with its residual; nothing diverges, and the cost is
/// bounded.
///
/// @param u      Displacement in mm at a rest point in mm; must be finite.
/// @param start  A guess, such as the answer of a neighbour.
template <class Field>
InversePoint InvertDisplacement(const Field& u, const Eigen::Vector3d& x_mm,
                                const Eigen::Vector3d& start_mm,
                                const InverseSettings& settings = {}) {
  InversePoint best;
  best.rest_mm = start_mm;
  Eigen::Vector3d error = start_mm + u(start_mm) - x_mm;
  best.residual_mm = error.norm();
  double step = 1.0;
  while (best.residual_mm > settings.tolerance_mm && best.iterations < settings.max_iterations) {
    ++best.iterations;
    const Eigen::Vector3d next = best.rest_mm - step * error;
    const Eigen::Vector3d next_error = next + u(next) - x_mm;
    const double residual_mm = next_error.norm();
    if (residual_mm < best.residual_mm) {
      best.rest_mm = next;
      best.residual_mm = residual_mm;
      error = next_error;
      step = std::min(1.0, 2.0 * step);
    } else {
      step *= 0.5;
    }
  }
  return best;
}

}  // namespace acus::math
