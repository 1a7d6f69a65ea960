// The nearest point of a triangle surface.
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "acus/data/mesh/surface.h"

namespace acus::mesh {

struct NearestPoint {
  int triangle = -1;
  Eigen::Vector3d point_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d weights = Eigen::Vector3d::Zero();  ///< Barycentric: of the triangle's corners.
  double squared_mm2 = 0.0;
};

/// The point of the triangle abc nearest to x, by its barycentric weights (Ericson 2005, section
/// 5.1.5).
Eigen::Vector3d NearestWeights(const Eigen::Vector3d& x, const Eigen::Vector3d& a,
                               const Eigen::Vector3d& b, const Eigen::Vector3d& c);

/// A tree of boxes over the triangles. Looking up neither allocates nor changes anything; of
/// triangles equally near the one with the lowest number is found.
class NearestTriangle {
 public:
  /// Keeps a copy of what it needs. @throws InputError if the surface has no triangle, or names a
  /// node that does not exist.
  explicit NearestTriangle(const Surface& surface);

  NearestPoint Find(const Eigen::Vector3d& x_mm) const;

  /// Unit normal, outwards if the triangles are counter-clockwise seen from outside. Zero for a
  /// flat triangle.
  Eigen::Vector3d Normal(int triangle) const { return normals_.col(triangle); }

 private:
  struct Node {
    Eigen::AlignedBox3d box;
    int first = 0;  ///< Of order_, for a leaf; else the left child.
    int count = 0;  ///< Of a leaf; 0 for others.
    int right = 0;  ///< The right child.
  };
  int Build(int first, int count, const Eigen::Matrix3Xd& centres);

  Eigen::Matrix3Xd corners_;  ///< Three columns per triangle.
  Eigen::Matrix3Xd normals_;
  std::vector<int> order_;
  std::vector<Node> nodes_;
};

}  // namespace acus::mesh
