// A hand and a tracker that do everything that they should not.
#pragma once

#include <cmath>
#include <cstring>

#include "acus/base/core/random.h"
#include "acus/physics/forces/path/needle_sample.h"

namespace acus::testing_support {

using forces::NeedleForce;
using forces::NeedleInput;

/// A wild hand: tremor, pushes, pulls, turns, jumps, lost poses and broken numbers.
class WildHand {
 public:
  explicit WildHand(std::uint64_t seed) : random_(seed, "wild hand") {}

  NeedleInput Next() {
    const double kind = random_.Uniform();
    time_s_ += kind < 0.9 ? 0.001 : random_.Uniform(-0.01, 0.5);
    if (random_.Uniform() < 0.002) speed_mm_per_s_ = random_.Uniform(-60.0, 80.0);
    tip_mm_ += speed_mm_per_s_ * 0.001 * axis_ + 0.02 * Noise();
    if (random_.Uniform() < 0.001) tip_mm_ += 25.0 * Noise();  // About 50 mm.
    if (random_.Uniform() < 0.003) axis_ = (axis_ + 0.2 * Noise()).normalized();
    if (tip_mm_.norm() > 250.0) tip_mm_ = 50.0 * Noise();
    NeedleInput input{time_s_, tip_mm_, axis_, Label(), random_.Uniform() > 0.01};
    if (random_.Uniform() < 0.001) Break(input);
    return input;
  }

 private:
  Eigen::Vector3d Noise() { return {random_.Normal(), random_.Normal(), random_.Normal()}; }

  volume::Label Label() {
    if (random_.Uniform() < 0.02) return static_cast<volume::Label>(random_.Next());  // Any of 256.
    if (tip_mm_.z() < 0.0) return 0;
    return static_cast<volume::Label>(1 + static_cast<int>(tip_mm_.z() / 7.0) % 25);
  }

  void Break(NeedleInput& input) {
    const double bad[] = {NAN, INFINITY, -INFINITY, 1e300, -1e308, 1e-320};
    const double value = bad[random_.Next() % 6];
    switch (random_.Next() % 4) {
      case 0:
        input.tip_in_ct_mm[static_cast<int>(random_.Next() % 3)] = value;
        break;
      case 1:
        input.axis_in_ct[static_cast<int>(random_.Next() % 3)] = value;
        break;
      case 2:
        input.axis_in_ct.setZero();
        break;
      default:
        input.time_s = std::isfinite(value) ? NAN : value;
        break;
    }
  }

  RandomStream random_;
  double time_s_ = 0.0;
  double speed_mm_per_s_ = 10.0;
  Eigen::Vector3d tip_mm_{0.0, 0.0, -5.0};
  Eigen::Vector3d axis_ = Eigen::Vector3d::UnitZ();
};

inline bool SameBits(const NeedleForce& a, const NeedleForce& b) {
  const auto same = [](double x, double y) { return std::memcmp(&x, &y, sizeof x) == 0; };
  return same(a.puncture_n, b.puncture_n) && same(a.cutting_n, b.cutting_n) &&
         same(a.friction_n, b.friction_n) && same(a.bone_n, b.bone_n) &&
         same(a.lateral_n, b.lateral_n) && same(a.force_in_ct_n.x(), b.force_in_ct_n.x()) &&
         same(a.force_in_ct_n.y(), b.force_in_ct_n.y()) &&
         same(a.force_in_ct_n.z(), b.force_in_ct_n.z()) &&
         same(a.torque_in_ct_n_mm.x(), b.torque_in_ct_n_mm.x()) &&
         same(a.torque_in_ct_n_mm.y(), b.torque_in_ct_n_mm.y()) && same(a.depth_mm, b.depth_mm) &&
         a.event == b.event;
}

}  // namespace acus::testing_support
