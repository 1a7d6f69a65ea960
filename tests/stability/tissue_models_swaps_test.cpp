// A million changes between stick and slip on the explicit inverse of the 2D model: how far the
// forces drift from a fresh solve, and that the monitor keeps them.
#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <gtest/gtest.h>
#include <vector>

#include "acus/base/core/random.h"
#include "acus/physics/mechanics/elements/plane_strain.h"
#include "acus/physics/mechanics/sparse/swept_matrix.h"
#include "support/bound.h"

namespace acus::tissue {
namespace {

using testing_support::AtMost;
using testing_support::Below;
using testing_support::BoundPlot;
using testing_support::HardCase;
using testing_support::Largest;
using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// 30 nodes below one another in soft tissue with a stiff layer, thickness 30 mm.
RowMajor NeedleCompliance() {
  const mechanics::PlaneGrid grid{25, 33, 2.0};
  std::vector<mechanics::ElasticTissue> tissue(grid.num_triangles(), {0.01, 0.49});
  for (int t = 600; t < 700; ++t) tissue[t] = {0.5, 0.49};
  std::vector<char> fixed(grid.num_nodes(), 0);
  for (int n = 0; n < grid.num_nodes(); ++n) {
    if (n % 25 == 0 || n % 25 == 24 || n / 25 == 32) fixed[n] = 1;
  }
  const auto inverse = mechanics::InvertPlane(grid, tissue, fixed, mechanics::Dilatation::kCell);
  std::vector<int> dofs;
  for (int row = 0; row < 30; ++row) {
    const int dof = inverse.dof_of_node[grid.Node(12, row)];
    dofs.insert(dofs.end(), {dof, dof + 1});
  }
  return inverse.matrix(dofs, dofs) / 30.0;
}

/// Largest error of a force in x against a new factorisation, N.
double ErrorOfFreshSolve(const RowMajor& c, const mechanics::SweptMatrix& swept,
                         const Eigen::VectorXd& y, const Eigen::VectorXd& x) {
  std::vector<int> d;
  std::vector<int> s;
  for (int i = 0; i < swept.size(); ++i) (swept.IsDisplacement(i) ? d : s).push_back(i);
  if (d.empty()) return 0.0;
  Eigen::VectorXd right = y(d);
  if (!s.empty()) right -= c(d, s) * y(s);
  const Eigen::MatrixXd c_dd = c(d, d);
  const Eigen::VectorXd force = c_dd.llt().solve(right);
  return (force - x(d)).cwiseAbs().maxCoeff();
}

struct Outcome {
  Largest worst_n;
  Largest largest_force_n;
  int num_rebuilds = 0;
  BoundPlot::Curve error;
};

/// Nodes stick with up to 5 mm and slip with up to 0.3 N, and so on, a million times.
Outcome MillionSwaps(bool monitored) {
  const RowMajor c = NeedleCompliance();
  const int size = static_cast<int>(c.rows());
  mechanics::SweptMatrix swept = mechanics::SweptMatrix::Of(c);
  Eigen::VectorXd y = Eigen::VectorXd::Zero(size);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(size);
  RandomStream random(1, "swaps");
  Outcome out;
  for (int n = 1; n <= 1'000'000; ++n) {
    const int k = static_cast<int>(random.Uniform(0, size));
    if (!swept.Swap(k)) ADD_FAILURE() << n;
    y[k] = swept.IsDisplacement(k) ? random.Uniform(-5, 5) : random.Uniform(-0.3, 0.3);
    const bool look = n % 1000 == 0;
    if (monitored || look) swept.Solve(y.data(), x.data());
    if (monitored && swept.ForceError(c.data(), size, y.data(), x.data()) > 1e-10) {
      EXPECT_TRUE(swept.Rebuild(c.data(), size));
      swept.Solve(y.data(), x.data());
      ++out.num_rebuilds;
    }
    if (!look) continue;
    const double error_n = ErrorOfFreshSolve(c, swept, y, x);
    out.worst_n.Add(error_n);
    out.error.Add(n, error_n);
    for (int i = 0; i < size; ++i) {
      if (!swept.IsDisplacement(i)) continue;
      out.largest_force_n.Add(std::abs(x[i]));
    }
  }
  return out;
}

TEST(TissueModelsSwaps, AMillionSwapsDriftButNotWithTheMonitor) {
  const HardCase hard(
      "An inverse that is updated a million times drifts away; a monitor has to see it in time.");
  Outcome drifted = MillionSwaps(false);
  Outcome kept = MillionSwaps(true);
  hard.Expect("force error without monitor", drifted.worst_n, Below(1e-3), "N");
  hard.Expect("force error with the monitor", kept.worst_n, AtMost(1e-9), "N");
  hard.Expect("largest force", kept.largest_force_n, Below(1e3), "N");
  hard.Note("new inverses in a million changes", std::to_string(kept.num_rebuilds));
  drifted.error.name = "without monitor";
  kept.error.name = "with monitor";
  hard.Plot({.title = "Drift of an updated inverse from a fresh solve",
             .x_label = "changes between stick and slip",
             .y_label = "largest error of a force [N]",
             .log_y = true,
             .curves = {drifted.error, kept.error}});
}

}  // namespace
}  // namespace acus::tissue
