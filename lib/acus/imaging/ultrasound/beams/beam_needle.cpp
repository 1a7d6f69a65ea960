#include "acus/imaging/ultrasound/beams/beam_needle.h"

#include <algorithm>
#include <cmath>

#include "acus/base/core/error.h"
#include "acus/imaging/acoustics/beam_width.h"
#include "acus/imaging/ultrasound/beams/beam_interface.h"
#include "acus/imaging/ultrasound/beams/beam_kernels.h"

namespace acus::ultrasound {

BeamNeedle::BeamNeedle(const acoustics::Probe& probe, const BeamOptions& options,
                       const acoustics::ScanGrid& grid)
    : probe_(probe),
      options_(options),
      grid_(grid),
      most_marks_(static_cast<std::size_t>(2 * (grid.lines() + grid.samples))) {
  for (int k = 0; k < grid.samples; ++k) {
    slice_mm_.push_back(acoustics::ElevationFwhmMm(probe, k * grid.step_mm));
  }
  marks_.reserve(most_marks_);
  first_.assign(static_cast<std::size_t>(grid.lines()) + 2, 0);
}

BeamNeedle::Beam BeamNeedle::BeamAt(const Eigen::Vector3d& place_mm) const {
  const int lines = grid_.lines();
  if (probe_.steer_rad != 0.0) {
    const acoustics::BeamPlace place =
        acoustics::PlaceInBeams(probe_, grid_, {place_mm.x(), place_mm.y()});
    return {place.line, place.sample};
  }
  if (probe_.kind == acoustics::ProbeKind::kLinear) {
    const double spacing_mm = grid_.LateralSpacingMm(0);
    return {(place_mm.x() - grid_.start_mm[0].x()) / spacing_mm, place_mm.y() / grid_.step_mm};
  }
  const double y = place_mm.y() + probe_.radius_mm;
  const double angle = std::atan2(place_mm.x(), y);
  return {(angle / probe_.field_of_view_rad + 0.5) * (lines - 1),
          (std::hypot(place_mm.x(), y) - probe_.radius_mm) / grid_.step_mm};
}

double BeamNeedle::SliceWeight(double from_plane_mm, int sample) const {
  const double apart = std::abs(from_plane_mm) / slice_mm_[Index(sample)];
  constexpr double kGone = 1.5;
  if (apart >= kGone) return 0.0;
  // A Gaussian with its foot cut off.
  const auto profile = [](double x) { return std::exp2(-4.0 * x * x); };
  const double foot = profile(kGone);
  return (profile(apart) - foot) / (1.0 - foot);
}

void BeamNeedle::AddMark(const Eigen::Vector3d& place_mm, const Eigen::Vector3d& axis,
                         double radius_mm) {
  const Beam beam = BeamAt(place_mm);
  const int line = static_cast<int>(std::lround(beam.line));
  const double front = beam.sample - radius_mm / grid_.step_mm;
  const int sample = static_cast<int>(std::lround(front));
  if (line < 0 || line >= grid_.lines() || sample < 0 || sample >= grid_.samples) return;
  if (marks_.size() >= most_marks_) return;
  if (!marks_.empty() && marks_.back().line == line && marks_.back().sample == sample) return;
  const double weight = SliceWeight(place_mm.z(), sample);
  if (weight <= 0.0) return;
  const Eigen::Vector2d direction = grid_.direction[Index(line)];
  const double along = direction.dot(axis.head<2>());
  const double cos_incidence = std::sqrt(std::max(0.0, 1.0 - along * along));
  const double lobe = options_.angle ? MirrorLobe(cos_incidence, options_.needle_lobe_deg,
                                                  options_.needle_diffuse_share)
                                     : 1.0;
  const double behind =
      options_.needle_shadow ? std::pow(10.0, options_.needle_transmission_db / 20.0) : 1.0;
  marks_.push_back({.line = line,
                    .sample = sample,
                    .beside = static_cast<float>(front - sample),
                    .echo = static_cast<float>(options_.needle_reflection * weight * lobe),
                    .transmission = static_cast<float>(1.0 - weight * (1.0 - behind))});
}

void BeamNeedle::AddTip(const Eigen::Vector3d& place_mm) {
  const Beam beam = BeamAt(place_mm);
  const int line = static_cast<int>(std::lround(beam.line));
  const int sample = static_cast<int>(std::lround(beam.sample));
  if (line < 0 || line >= grid_.lines() || sample < 0 || sample >= grid_.samples) return;
  if (marks_.size() >= most_marks_) return;
  const double weight = SliceWeight(place_mm.z(), sample);
  if (weight <= 0.0) return;
  marks_.push_back({.line = line,
                    .sample = sample,
                    .beside = static_cast<float>(beam.sample - sample),
                    .echo = static_cast<float>(options_.needle_tip_echo * weight),
                    .transmission = 1.0F});
}

void BeamNeedle::AddPiece(const Eigen::Vector3d& from_mm, const Eigen::Vector3d& to_mm,
                          double radius_mm) {
  const Eigen::Vector3d whole = to_mm - from_mm;
  const double length = whole.norm();
  const Eigen::Vector3d axis = whole / std::max(length, 1e-12);
  const Beam a = BeamAt(from_mm);
  const Beam b = BeamAt(to_mm);
  // One mark per line that it crosses; per sample, if it runs along a line.
  const bool flat = std::abs(b.line - a.line) * grid_.LateralSpacingMm(grid_.samples / 2) >=
                    0.2 * std::abs(b.sample - a.sample) * grid_.step_mm;
  const double span = flat ? std::abs(b.line - a.line) : std::abs(b.sample - a.sample);
  const int steps = static_cast<int>(std::min(4.0 * std::ceil(span) + 4.0, 65536.0));
  // Where it passes through the plane, if it does.
  const double through = std::abs(whole.z()) > 1e-9 ? -from_mm.z() / whole.z() : -1.0;
  const auto key_at = [&](int n) {
    const Beam beam = BeamAt(from_mm + whole * (static_cast<double>(n) / steps));
    return static_cast<int>(std::lround(flat ? beam.line : beam.sample));
  };
  for (int n = 0; n <= steps;) {
    const int key = key_at(n);
    int end = n;
    while (end < steps && key_at(end + 1) == key) ++end;
    // The part of the shaft on one line: seen in its middle, or where it is nearest to the plane.
    const double low = static_cast<double>(n) / steps;
    const double high = static_cast<double>(end) / steps;
    double share = 0.5 * (low + high);
    if (through >= low && through <= high) share = through;
    if (n == 0 && end == steps) share = std::clamp(through, low, high);
    AddMark(from_mm + whole * share, axis, radius_mm);
    n = end + 1;
  }
}

void BeamNeedle::Set(const std::optional<image::NeedleInImage>& needle,
                     const Eigen::Isometry3d& ct_from_probe, int lanes_per_block) {
  marks_.clear();
  std::fill(first_.begin(), first_.end(), std::size_t{0});
  if (!needle) return;
  ACUS_REQUIRE(std::isfinite(needle->radius_mm) && needle->radius_mm >= 0.0,
               "needle in the image: radius ", needle->radius_mm, " mm; it may not be negative");
  const Eigen::Isometry3d probe_from_ct = ct_from_probe.inverse();
  ring_samples_ = std::max(1.0, 2.0 * needle->radius_mm / grid_.step_mm);
  const math::Polyline& shape = needle->shape;
  if (shape.num_points >= 2) {
    for (int i = 1; i < shape.num_points; ++i) {
      ACUS_REQUIRE(shape.At(i - 1).allFinite() && shape.At(i).allFinite(),
                   "needle in the image: point ", i, " of its shape is not finite");
      AddPiece(probe_from_ct * shape.At(i - 1), probe_from_ct * shape.At(i), needle->radius_mm);
    }
  } else {
    ACUS_REQUIRE(needle->tip_in_ct_mm.allFinite() && needle->axis_in_ct.allFinite() &&
                     std::isfinite(needle->length_mm),
                 "needle in the image: has a value that is not finite");
    ACUS_REQUIRE(needle->axis_in_ct.norm() > 1e-6,
                 "needle in the image: its axis has no direction");
    ACUS_REQUIRE(needle->length_mm >= 0.0, "needle in the image: length ", needle->length_mm,
                 " mm; it may not be negative");
    const Eigen::Vector3d tip_mm = probe_from_ct * needle->tip_in_ct_mm;
    const Eigen::Vector3d axis = probe_from_ct.linear() * needle->axis_in_ct.normalized();
    AddPiece(tip_mm, tip_mm - needle->length_mm * axis, needle->radius_mm);
  }
  if (options_.needle_tip_echo > 0.0) {
    AddTip(probe_from_ct * (shape.num_points >= 2 ? shape.At(0) : needle->tip_in_ct_mm));
  }
  const auto block = [&](const NeedleMark& mark) { return mark.line / lanes_per_block; };
  std::sort(marks_.begin(), marks_.end(), [&](const NeedleMark& a, const NeedleMark& b) {
    if (block(a) != block(b)) return block(a) < block(b);
    return a.sample != b.sample ? a.sample < b.sample : a.line < b.line;
  });
  for (const NeedleMark& mark : marks_) ++first_[Index(block(mark)) + 1];
  for (std::size_t b = 1; b < first_.size(); ++b) first_[b] += first_[b - 1];
}

}  // namespace acus::ultrasound
