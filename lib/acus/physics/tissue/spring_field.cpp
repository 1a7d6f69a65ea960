// The displacement field of SpringModel.
#include <algorithm>
#include <cmath>

#include "acus/physics/tissue/displacement_functions.h"
#include "acus/physics/tissue/spring_model.h"

namespace acus::tissue {
namespace {

constexpr double kLargestShare = 0.6;  // Of the radius of influence; beyond 0.66 the field folds.
constexpr double kSteepest = 0.8;      // Decrease of the axial displacement per mm; 1 folds.

}  // namespace

void SpringField::Update(const TissueLoad& load) noexcept {
  const NeedleLoad& needle = load.needle;
  num_nodes_ = needle.in_contact ? std::min(load.num_points, SpringState::kMaxNodes) : 0;
  if (num_nodes_ == 0) return;
  const int last = num_nodes_ - 1;
  const double limit_mm = kLargestShare * model_->settings().influence_radius_mm;
  begin_mm_ = load.point[0].rest_in_ct_mm;
  const Eigen::Vector3d chord_mm = load.point[last].rest_in_ct_mm - begin_mm_;
  along_ = chord_mm.norm() > 1e-6 ? chord_mm.normalized() : needle.axis_in_ct;
  for (int i = 0; i <= last; ++i) {
    const Eigen::Vector3d& rest_mm = load.point[i].rest_in_ct_mm;
    const double at_mm = (rest_mm - begin_mm_).dot(along_);
    at_mm_[i] = i == 0 ? at_mm : std::max(at_mm, at_mm_[i - 1]);
    Eigen::Vector3d moved_mm = Eigen::Vector3d::Zero();
    if (i == last) {
      moved_mm = needle.tip_in_ct_mm - rest_mm;  // What is at the tip goes with it.
    } else if (i > 0) {
      const PathNode springs = model_->NodeAt(rest_mm);
      const double weight =
          (rest_mm - load.point[i - 1].rest_in_ct_mm).norm() / model_->settings().node_spacing_mm;
      const Eigen::Vector3d& force_n = load.point[i].force_in_ct_n;
      const Eigen::Vector3d axial_n = force_n.dot(needle.axis_in_ct) * needle.axis_in_ct;
      if (weight > 0.0 && springs.axial_n_per_mm > 0.0) {
        moved_mm = axial_n / (weight * springs.axial_n_per_mm) +
                   (force_n - axial_n) / (weight * springs.lateral_n_per_mm);
      }
    }
    const double size_mm = moved_mm.norm();
    moved_mm_[i] = size_mm > limit_mm ? Eigen::Vector3d(moved_mm * (limit_mm / size_mm)) : moved_mm;
  }
  if (num_nodes_ > 1) moved_mm_[0] = moved_mm_[1];  // The skin goes with the first of the tissue.
  // Tissue must not be pushed through what is ahead of it; the tip's own displacement is kept.
  for (int i = last - 1; i >= 0; --i) {
    const double most_mm = moved_mm_[i + 1].dot(along_) + kSteepest * (at_mm_[i + 1] - at_mm_[i]);
    const double excess_mm = moved_mm_[i].dot(along_) - most_mm;
    if (excess_mm > 0.0) moved_mm_[i] -= excess_mm * along_;
  }
}

Eigen::Vector3d SpringField::DisplacementMm(const Eigen::Vector3d& rest_in_ct_mm) const noexcept {
  if (num_nodes_ == 0) return Eigen::Vector3d::Zero();
  const double radius_mm = model_->settings().influence_radius_mm;
  const int last = num_nodes_ - 1;
  const Eigen::Vector3d from_begin = rest_in_ct_mm - begin_mm_;
  const double z_mm = from_begin.dot(along_);
  const double aside_mm = (from_begin - z_mm * along_).norm();
  const double outside_mm = z_mm < 0.0 ? -z_mm : std::max(0.0, z_mm - at_mm_[last]);
  const double r_mm = std::hypot(aside_mm, outside_mm);
  if (!(r_mm < radius_mm)) return Eigen::Vector3d::Zero();
  const double fade = Fade(r_mm / radius_mm);
  if (z_mm <= 0.0 || last == 0) return fade * moved_mm_[0];
  if (z_mm >= at_mm_[last]) return fade * moved_mm_[last];
  const auto begin = at_mm_.begin();
  const int i = static_cast<int>(std::upper_bound(begin, begin + num_nodes_, z_mm) - begin);
  const double part = (z_mm - at_mm_[i - 1]) / (at_mm_[i] - at_mm_[i - 1]);
  return fade * ((1.0 - part) * moved_mm_[i - 1] + part * moved_mm_[i]);
}

}  // namespace acus::tissue
