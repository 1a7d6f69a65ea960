// Distance of points to a set of triangles.
#pragma once

#include <Eigen/Dense>
#include <array>
#include <vector>

namespace acus::mesh {

/// Squared distance of x to the nearest point of the triangle abc (Ericson 2005, section 5.1.5).
double SquaredDistanceToTriangle(const Eigen::Vector3d& x, const Eigen::Vector3d& a,
                                 const Eigen::Vector3d& b, const Eigen::Vector3d& c);

/// Triangles in a grid of cells. Looking up neither allocates nor changes anything.
class TriangleDistance {
 public:
  /// Columns of `corners`: three per triangle, any unit of length; the answers have the same.
  explicit TriangleDistance(Eigen::Matrix3Xd corners);

  /// Distance of x to the nearest triangle, or `limit` if it is farther or there is none.
  double At(const Eigen::Vector3d& x, double limit) const;

 private:
  std::size_t Index(int i, int j, int k) const {
    return (static_cast<std::size_t>(k) * size_[1] + j) * size_[0] + i;
  }

  Eigen::Matrix3Xd corners_;
  Eigen::Array3d low_ = Eigen::Array3d::Zero();
  double cell_ = 1.0;
  Eigen::Array3i size_ = Eigen::Array3i::Ones();
  std::vector<int> first_;  ///< Of each cell, into members_.
  std::vector<int> members_;
};

}  // namespace acus::mesh
