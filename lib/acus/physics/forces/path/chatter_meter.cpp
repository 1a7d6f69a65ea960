#include "acus/physics/forces/path/chatter_meter.h"

#include <cmath>
#include <numbers>

namespace acus::forces {

void ChatterMeter::Add(double dt_s, const Eigen::Vector3d& force_n, bool counts) noexcept {
  if (!started_) slow_n_ = force_n;
  started_ = true;
  slow_n_ += (1.0 - std::exp(-2.0 * std::numbers::pi * kHz * dt_s)) * (force_n - slow_n_);
  if (!counts) return;
  sum_ += (force_n - slow_n_).squaredNorm();
  num_ += 1.0;
}

double ChatterMeter::RmsN() const noexcept {
  return num_ > 0.0 ? std::sqrt(sum_ / num_) : 0.0;
}

}  // namespace acus::forces
