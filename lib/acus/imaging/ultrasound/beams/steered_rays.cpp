#include "acus/imaging/ultrasound/beams/steered_rays.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "acus/imaging/acoustics/beam_width.h"
#include "acus/imaging/ultrasound/beams/side_lobes.h"

namespace acus::ultrasound {

SteeredRays::SteeredRays(const acoustics::Probe& probe, const acoustics::ScanGrid& grid,
                         int directions)
    : lines_(grid.lines()), rows_(grid.samples), step_mm_(grid.step_mm) {
  const double line_rad = probe.field_of_view_rad / (lines_ - 1);
  const double middle = 0.5 * (lines_ - 1);
  const int half = directions / 2;
  double steepest_rad = 0.0;
  for (int k = 1; k < rows_; ++k) {
    const double half_mm = 0.5 * acoustics::ReceiveApertureMm(probe, k * step_mm_);
    if (half_mm < k * step_mm_) {
      steepest_rad = std::max(steepest_rad, std::asin(half_mm / (k * step_mm_)));
    }
  }
  beside_ = static_cast<int>(std::min(0.7, steepest_rad) / line_rad) + 2;
  rays_ = lines_ + 2 * beside_;
  const double farthest_mm = 0.5 * acoustics::ReceiveApertureMm(probe, (rows_ - 1) * step_mm_);
  for (int d = -half; d <= half; ++d) {
    u_mm_.push_back(half > 0 ? farthest_mm * d / (half + 0.5) : 0.0);
  }
  const auto rows = static_cast<std::size_t>(rows_);
  weight_.assign(u_mm_.size() * rows, 0.0F);
  line_of_ray_.assign(weight_.size() * static_cast<std::size_t>(rays_), 0.0F);
  ray_of_line_.assign(weight_.size() * static_cast<std::size_t>(lines_), 0.0F);
  for (int k = 0; k < rows_; ++k) {
    const double range_mm = k * step_mm_;
    const double half_mm = 0.5 * acoustics::ReceiveApertureMm(probe, range_mm);
    double sum = 0.0;
    for (std::size_t d = 0; d < u_mm_.size(); ++d) {
      const double share = std::abs(u_mm_[d]) / half_mm;
      const bool serves = u_mm_[d] == 0.0 || (share < 1.0 && std::abs(u_mm_[d]) < range_mm);
      const double weight = serves ? std::cos(0.5 * std::numbers::pi * std::min(share, 1.0)) : 0.0;
      weight_[d * rows + static_cast<std::size_t>(k)] = static_cast<float>(weight);
      sum += weight;
      const std::size_t at = d * rows + static_cast<std::size_t>(k);
      float* line = line_of_ray_.data() + at * static_cast<std::size_t>(rays_);
      float* ray = ray_of_line_.data() + at * static_cast<std::size_t>(lines_);
      const double beside = range_mm > 0.0 ? std::clamp(u_mm_[d] / range_mm, -1.0, 1.0) : 0.0;
      for (int r = 0; r < rays_; ++r) {
        const double phi = (r - beside_ - middle) * line_rad;
        const double theta = phi + std::asin(beside * std::cos(phi));
        line[r] = static_cast<float>(std::clamp(theta / line_rad + middle, 0.0, lines_ - 1.0));
      }
      for (int l = 0; l < lines_; ++l) {
        const double theta = (l - middle) * line_rad;
        const double phi = std::atan2(std::sin(theta) - beside, std::cos(theta));
        ray[l] =
            static_cast<float>(std::clamp(phi / line_rad + middle + beside_, 0.0, rays_ - 1.0));
      }
    }
    for (std::size_t d = 0; d < u_mm_.size(); ++d) {
      weight_[d * rows + static_cast<std::size_t>(k)] /= static_cast<float>(sum);
    }
  }
  const double pitch_mm =
      probe.pitch_mm > 0.0 ? probe.pitch_mm : probe.ArrayLengthMm() / probe.elements;
  const double width = SideLobes::kElementShare * pitch_mm / acoustics::WavelengthMm(probe);
  for (int l = 0; l < lines_; ++l) {
    const double one_way = ElementDirectivity(width, std::sin((l - middle) * line_rad));
    directivity_.push_back(static_cast<float>(one_way * one_way));
  }
}

bool SteeredRays::Reached(int direction, int row) const {
  return std::abs(u_mm_[static_cast<std::size_t>(direction)]) < row * step_mm_ || row == 0;
}

const float* SteeredRays::LineOfRay(int direction, int row) const {
  const auto at = static_cast<std::size_t>(direction) * static_cast<std::size_t>(rows_) +
                  static_cast<std::size_t>(row);
  return line_of_ray_.data() + at * static_cast<std::size_t>(rays_);
}

const float* SteeredRays::RayOfLine(int direction, int row) const {
  const auto at = static_cast<std::size_t>(direction) * static_cast<std::size_t>(rows_) +
                  static_cast<std::size_t>(row);
  return ray_of_line_.data() + at * static_cast<std::size_t>(lines_);
}

}  // namespace acus::ultrasound
