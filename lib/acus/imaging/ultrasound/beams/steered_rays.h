// Straight rays from the elements of a phased array to every place of its sector.
#pragma once

#include <cstddef>
#include <vector>

#include "acus/imaging/acoustics/probe.h"

namespace acus::ultrasound {

/// All elements serve each steered line. A ray that leaves the element at u under the angle phi is,
/// at the range rho from the middle of the face, on the line of the angle
///   theta = phi + asin(u cos(phi) / rho),
/// and the place (rho, theta) is reached from u under tan(phi) = (rho sin(theta) - u) /
/// (rho cos(theta)). Rays are numbered by phi, lines apart as the image's, and continue beside the
/// outermost lines.
class SteeredRays {
 public:
  /// @param grid  Rows at which rays are required; keeps nothing of it.
  /// @param directions  Odd: places u across the aperture.
  /// @pre the probe is phased, and grid has two lines or more.
  SteeredRays(const acoustics::Probe& probe, const acoustics::ScanGrid& grid, int directions);

  int directions() const { return static_cast<int>(u_mm_.size()); }
  int rays() const { return rays_; }
  /// Line of ray 0, not positive.
  int first() const { return -beside_; }
  /// Whether rays of this direction have reached the row: before, they are nearer than u.
  bool Reached(int direction, int row) const;
  /// Share of the aperture's amplitude, cosine apodisation; the sum over directions is 1.
  float Weight(int direction, int row) const {
    return weight_[static_cast<std::size_t>(direction) * static_cast<std::size_t>(rows_) +
                   static_cast<std::size_t>(row)];
  }
  /// By ray: the line that it is on, within the image's lines.
  const float* LineOfRay(int direction, int row) const;
  /// By line: the ray that reaches it, within [0, rays() - 1].
  const float* RayOfLine(int direction, int row) const;
  /// Two-way amplitude of an element towards a line, relative to the middle one.
  float Directivity(int line) const { return directivity_[static_cast<std::size_t>(line)]; }

 private:
  int lines_;
  int rows_;
  int beside_ = 0;
  int rays_ = 0;
  double step_mm_;
  std::vector<double> u_mm_;
  std::vector<float> weight_;
  std::vector<float> line_of_ray_;
  std::vector<float> ray_of_line_;
  std::vector<float> directivity_;
};

}  // namespace acus::ultrasound
