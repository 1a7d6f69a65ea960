// How much a force buzzes.
#pragma once

#include <Eigen/Core>

namespace acus::forces {

/// Root mean square of a force above 30 Hz (first-order high-pass): what a hand feels as buzzing.
class ChatterMeter {
 public:
  static constexpr double kHz = 30.0;

  /// @param dt_s  Since the sample before, s, > 0.
  /// @param counts  Whether the sample is part of the mean; the filter sees all.
  void Add(double dt_s, const Eigen::Vector3d& force_n, bool counts) noexcept;

  /// What remains of the force below 30 Hz.
  const Eigen::Vector3d& slow_n() const noexcept { return slow_n_; }
  double RmsN() const noexcept;  ///< 0 before the first sample that counts.

 private:
  bool started_ = false;
  Eigen::Vector3d slow_n_ = Eigen::Vector3d::Zero();
  double sum_ = 0.0;
  double num_ = 0.0;
};

}  // namespace acus::forces
