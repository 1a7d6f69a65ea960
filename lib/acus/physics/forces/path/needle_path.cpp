#include "acus/physics/forces/path/needle_path.h"

namespace acus::forces {

double NeedlePath::DepthMm(const Eigen::Vector3d& point_in_ct_mm) const noexcept {
  return (point_in_ct_mm - entry_in_ct_mm).dot(direction_in_ct);
}

Eigen::Vector3d NeedlePath::DeviationMm(const Eigen::Vector3d& point_in_ct_mm) const noexcept {
  const Eigen::Vector3d along = point_in_ct_mm - entry_in_ct_mm;
  return along - along.dot(direction_in_ct) * direction_in_ct;
}

double NeedlePath::EndMm() const noexcept {
  return num_segments > 0 ? segment[num_segments - 1].end_mm : 0.0;
}

volume::Label NeedlePath::LastTissue() const noexcept {
  return num_segments > 0 ? segment[num_segments - 1].tissue : volume::Label{0};
}

volume::Label NeedlePath::TissueAt(double depth_mm) const noexcept {
  for (int i = 0; i < num_segments; ++i) {
    if (depth_mm < segment[i].end_mm) return segment[i].tissue;
  }
  return LastTissue();
}

void NeedlePath::ExtendTo(double end_mm) noexcept {
  if (num_segments > 0) segment[num_segments - 1].end_mm = std::max(EndMm(), end_mm);
}

void NeedlePath::Append(volume::Label tissue, double friction_n_per_mm,
                        double withdrawal_n_per_mm) noexcept {
  if (num_segments == kMaxSegments) {
    Segment& first = segment[0];
    Segment& second = segment[1];
    if (second.end_mm > 0.0) {
      for (double Segment::*per_mm : {&Segment::friction_n_per_mm, &Segment::withdrawal_n_per_mm}) {
        second.*per_mm =
            (first.*per_mm * first.end_mm + second.*per_mm * (second.end_mm - first.end_mm)) /
            second.end_mm;
      }
    }
    std::move(segment.begin() + 1, segment.end(), segment.begin());
    --num_segments;
  }
  const double begin_mm = EndMm();
  segment[num_segments++] = {begin_mm, tissue, friction_n_per_mm, withdrawal_n_per_mm};
}

void NeedlePath::CutOffAt(double end_mm) noexcept {
  while (num_segments > 1 && segment[num_segments - 2].end_mm >= end_mm) --num_segments;
  if (num_segments > 0) {
    segment[num_segments - 1].end_mm = std::clamp(end_mm, 0.0, EndMm());
  }
}

double NeedlePath::FrictionN(double depth_mm) const noexcept {
  return SumN(depth_mm, [](const Segment& s) { return s.friction_n_per_mm; });
}

double NeedlePath::WithdrawalFrictionN(double depth_mm) const noexcept {
  return SumN(depth_mm, [](const Segment& s) { return s.withdrawal_n_per_mm; });
}

}  // namespace acus::forces
