// The mean of a force over the last milliseconds, whatever the rate of the samples.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>

namespace acus::forces {

/// The mean over the last m (or n) steps in Vidal-2008 eq. 3 and 8, as a mean over time, so that it
/// does not depend on the rate of the steps. Before the first sample the value was 0. A plain
/// value.
class WindowAverage {
 public:
  /// Takes in a value that held for the last dt_s and returns the mean over the last window_s.
  Eigen::Vector3d Add(const Eigen::Vector3d& value, double dt_s, double window_s) noexcept {
    if (!(window_s > dt_s)) {
      Clear();
      return value;
    }
    // A slot holds at least a share of the window, so that they never run out.
    if (num_ > 0 && At(num_ - 1).length_s < window_s / (kSlots - 2)) {
      Slot& last = At(num_ - 1);
      last.integral += value * dt_s;
      last.length_s += dt_s;
    } else {
      if (num_ == kSlots) DropFirst();
      At(num_++) = {value * dt_s, dt_s};
    }
    double length_s = 0.0;
    for (int i = 0; i < num_; ++i) length_s += At(i).length_s;
    while (num_ > 1 && length_s - At(0).length_s >= window_s) {
      length_s -= At(0).length_s;
      DropFirst();
    }
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (int i = 0; i < num_; ++i) sum += At(i).integral;
    const double over_s = length_s - window_s;  // Of the oldest slot, that is out already.
    if (over_s > 0.0) sum -= At(0).integral * (over_s / At(0).length_s);
    return sum / window_s;
  }

  /// As printed: the sum of the steps from t - m to t, which are m + 1 terms, over m.
  Eigen::Vector3d AddAsPrinted(const Eigen::Vector3d& value, double dt_s,
                               double window_s) noexcept {
    if (window_s < dt_s) return value;
    return Add(value, dt_s, window_s + dt_s) * ((window_s + dt_s) / window_s);
  }

  void Clear() noexcept { num_ = first_ = 0; }

 private:
  static constexpr int kSlots = 34;
  struct Slot {
    Eigen::Vector3d integral = Eigen::Vector3d::Zero();
    double length_s = 0.0;
  };
  Slot& At(int i) noexcept { return slot_[(first_ + i) % kSlots]; }
  void DropFirst() noexcept {
    first_ = (first_ + 1) % kSlots;
    --num_;
  }

  std::array<Slot, kSlots> slot_{};
  int first_ = 0;
  int num_ = 0;
};

}  // namespace acus::forces
