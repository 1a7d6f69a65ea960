#include "acus/physics/tissue/fem_field.h"

#include <gmock/gmock.h>

#include "acus/base/core/error.h"
#include "acus/physics/mechanics/sparse/sparse_factor.h"
#include "support/condensed_box.h"

namespace acus::tissue {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;
using testing_support::CondensedBox;

/// The box, its image, and the whole solution to compare with.
class FemFieldTest : public ::testing::Test {
 protected:
  FemFieldTest() {
    mechanics::Condensation condensation = box_.Condense();
    condensation.SetVisible(box_.visible);
    const int size = 3 * static_cast<int>(box_.reachable.size());
    Eigen::MatrixXf block(3 * box_.visible.size(), size);
    condensation.ImageColumns(0, size, block.data());
    tissue_ = {condensation.Compliance(mechanics::Storage::kDouble),
               mechanics::ImageBlock::FromMatrix(box_.visible, block)};
  }

  /// Nodal displacements of the whole mesh by forces on mesh nodes, 3 x n.
  Eigen::Matrix3Xd Solved(const Eigen::Matrix3Xd& nodal_force_n) const {
    const mechanics::SparseFactor factor(mechanics::FreeStiffness(
        mechanics::AssembleStiffness(box_.mesh, box_.elasticity, mechanics::ElementKind::kLinear),
        box_.free));
    Eigen::VectorXd right(box_.free.num_dofs());
    for (std::size_t r = 0; r < box_.free.mesh_node.size(); ++r) {
      right.segment<3>(3 * r) = nodal_force_n.col(box_.free.mesh_node[r]);
    }
    const Eigen::VectorXd u = factor.Solve(right);
    Eigen::Matrix3Xd out = Eigen::Matrix3Xd::Zero(3, nodal_force_n.cols());
    for (std::size_t r = 0; r < box_.free.mesh_node.size(); ++r) {
      out.col(box_.free.mesh_node[r]) = u.segment<3>(3 * r);
    }
    return out;
  }

  /// Some loads along the corridor, and the same as nodal forces.
  TissueLoad SomeLoad(Eigen::Matrix3Xd& nodal_force_n) const {
    const mesh::PointLocation location(box_.mesh);
    nodal_force_n = Eigen::Matrix3Xd::Zero(3, box_.mesh.nodes_mm.cols());
    TissueLoad load;
    for (int p = 0; p < 7; ++p) {
      PointLoad& point = load.point[load.num_points++];
      point.rest_in_ct_mm = {16.3, 15.8, 31.0 - 2.0 * p};
      point.force_in_ct_n = {0.01 * p, -0.02, -0.05};
      const auto at = location.Find(point.rest_in_ct_mm);
      for (int c = 0; c < 4; ++c) {
        nodal_force_n.col(box_.mesh.tetrahedra(c, at->tetrahedron)) +=
            at->weights[c] * point.force_in_ct_n;
      }
    }
    return load;
  }

  CondensedBox box_;
  mechanics::CondensedTissue tissue_;
};

TEST_F(FemFieldTest, IsTheFullSolutionAtStoredNodes) {
  Eigen::Matrix3Xd force_n;
  const TissueLoad load = SomeLoad(force_n);
  const Eigen::Matrix3Xd exact = Solved(force_n);
  const double largest_mm = exact.colwise().norm().maxCoeff();
  ASSERT_GT(largest_mm, 1.0);
  const FemImage image(box_.mesh, tissue_);
  FemField field(image);
  field.Update(load);
  EXPECT_EQ(field.num_dropped_loads(), 0);
  for (const int node : box_.visible) {
    const Eigen::Vector3d u = field.DisplacementMm(box_.mesh.nodes_mm.col(node));
    EXPECT_LT((u - exact.col(node)).norm(), 1e-6 * largest_mm);
  }
}

TEST_F(FemFieldTest, IsLinearBetweenStoredNodesAndFallsToZeroInOneElement) {
  Eigen::Matrix3Xd force_n;
  const TissueLoad load = SomeLoad(force_n);
  Eigen::Matrix3Xd nodal = Solved(force_n);
  const double largest_mm = nodal.colwise().norm().maxCoeff();
  std::vector<char> is_stored(nodal.cols(), 0);
  for (const int node : box_.visible) is_stored[node] = 1;
  for (int i = 0; i < nodal.cols(); ++i) {
    if (!is_stored[i]) nodal.col(i).setZero();
  }
  const FemImage image(box_.mesh, tissue_);
  FemField field(image);
  field.Update(load);
  const Eigen::Vector4d weights(0.1, 0.25, 0.3, 0.35);
  for (int t = 0; t < box_.mesh.tetrahedra.cols(); ++t) {
    Eigen::Vector3d x = Eigen::Vector3d::Zero(), u = Eigen::Vector3d::Zero();
    for (int c = 0; c < 4; ++c) {
      x += weights[c] * box_.mesh.nodes_mm.col(box_.mesh.tetrahedra(c, t));
      u += weights[c] * nodal.col(box_.mesh.tetrahedra(c, t));
    }
    ASSERT_LT((field.DisplacementMm(x) - u).norm(), 1e-6 * largest_mm) << t;
  }
}

TEST_F(FemFieldTest, IsContinuousAcrossFaces) {
  Eigen::Matrix3Xd force_n;
  const FemImage image(box_.mesh, tissue_);
  FemField field(image);
  field.Update(SomeLoad(force_n));
  // Along a line through the whole box, a step of a micrometre never moves the tissue by more
  // than a steep element would.
  double largest_mm = 0.0;
  for (int line = 0; line < 20; ++line) {
    const Eigen::Vector3d from(1.3 * line + 2.0, 0.0, 31.9 - line);
    const Eigen::Vector3d along = Eigen::Vector3d(0.2, 1.0, -0.1).normalized();
    Eigen::Vector3d before = field.DisplacementMm(from);
    for (int k = 1; k < 3300; ++k) {
      const Eigen::Vector3d here = field.DisplacementMm(from + 0.01 * k * along);
      const Eigen::Vector3d near = field.DisplacementMm(from + (0.01 * k - 1e-6) * along);
      ASSERT_LT((here - near).norm(), 1e-5);
      largest_mm = std::max(largest_mm, (here - before).norm());
      before = here;
    }
  }
  EXPECT_GT(largest_mm, 1e-3);  // It does vary.
  EXPECT_LT(largest_mm, 0.05);
}

TEST_F(FemFieldTest, IsExactlyZeroWithoutForces) {
  Eigen::Matrix3Xd force_n;
  const FemImage image(box_.mesh, tissue_);
  FemField field(image);
  const Eigen::Vector3d place(16, 16, 25);
  EXPECT_EQ(field.DisplacementMm(place), Eigen::Vector3d::Zero());
  field.Update(SomeLoad(force_n));
  EXPECT_NE(field.DisplacementMm(place), Eigen::Vector3d::Zero());
  field.Update(TissueLoad{});
  EXPECT_EQ(field.DisplacementMm(place), Eigen::Vector3d::Zero());
  TissueLoad nothing = SomeLoad(force_n);
  for (PointLoad& point : nothing.point) point.force_in_ct_n.setZero();
  field.Update(nothing);
  EXPECT_EQ(field.DisplacementMm(place), Eigen::Vector3d::Zero());
  EXPECT_EQ(field.num_dropped_loads(), 0);
}

TEST_F(FemFieldTest, DependsOnTheLastLoadOnly) {
  Eigen::Matrix3Xd force_n;
  const TissueLoad load = SomeLoad(force_n);
  TissueLoad other = load;
  other.num_points = 3;
  const FemImage image(box_.mesh, tissue_);
  FemField used(image), fresh(image);
  used.Update(other);
  used.Update(load);
  fresh.Update(load);
  for (int i = 0; i < box_.mesh.nodes_mm.cols(); ++i) {
    const Eigen::Vector3d x = box_.mesh.nodes_mm.col(i);
    EXPECT_EQ(used.DisplacementMm(x), fresh.DisplacementMm(x));
  }
}

TEST_F(FemFieldTest, ALoadAtASkinNodeNeedsNoOtherNodeInReach) {
  const FemImage image(box_.mesh, tissue_);
  FemField field(image);
  TissueLoad load;
  load.num_points = 1;
  // The outermost reachable node of the top: most elements around it go out of reach.
  int node = box_.reachable.front();
  for (const int i : box_.reachable) {
    const auto rank = [&](int n) {
      return box_.mesh.nodes_mm(2, n) + 0.01 * box_.mesh.nodes_mm(0, n);
    };
    if (rank(i) > rank(node)) node = i;
  }
  load.point[0] = {box_.mesh.nodes_mm.col(node), {0, 0, -0.1}};
  field.Update(load);
  EXPECT_EQ(field.num_dropped_loads(), 0);
  EXPECT_LT(field.DisplacementMm(box_.mesh.nodes_mm.col(node)).z(), -0.5);
}

TEST_F(FemFieldTest, DropsAndCountsLoadsOutOfReach) {
  const FemImage image(box_.mesh, tissue_);
  FemField field(image);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  TissueLoad load;
  load.num_points = 5;
  load.point[0] = {{16, 16, 60}, {0, 0, 1}};  // Outside.
  load.point[1] = {{1, 1, 5}, {0, 0, 1}};     // Not stored.
  load.point[2] = {{16, 24, 25}, {0, 0, 1}};  // Stored, but not reachable.
  load.point[3] = {{nan, 16, 25}, {0, 0, 1}};
  load.point[4] = {{16, 16, 25}, {0, 0, nan}};
  field.Update(load);
  EXPECT_EQ(field.num_dropped_loads(), 5);
  EXPECT_EQ(field.DisplacementMm({16, 16, 25}), Eigen::Vector3d::Zero());
  EXPECT_EQ(field.DisplacementMm({nan, 16, 25}), Eigen::Vector3d::Zero());
}

TEST_F(FemFieldTest, NeedsAnImageBlock) {
  tissue_.image = {};
  EXPECT_THAT([&] { FemImage(box_.mesh, tissue_); },
              ThrowsMessage<InputError>(HasSubstr("image_radius_mm")));
}

}  // namespace
}  // namespace acus::tissue
