// The bendable needle in a scene, against closed forms.
#include <Eigen/Dense>
#include <cmath>
#include <complex>
#include <gtest/gtest.h>

#include "support/bending_scene.h"

namespace acus::simulation {
namespace {

using Eigen::Vector3d;
using testing_support::BendingScene;
using testing_support::NeedleAt;

/// Straight in along +z to `to_mm` in steps of 0.05 mm, then turned about the hand's tip.
struct Insertion {
  const Simulation& simulation;
  State state;
  StepOutput out;
  double time_s = 0.0;

  explicit Insertion(const Simulation& of) : simulation(of), state(of.NewState()) {}
  void To(const Vector3d& tip_mm, const Vector3d& turn_rad = Vector3d::Zero()) {
    out = simulation.Step(state, NeedleAt(time_s += 0.001, tip_mm, turn_rad));
  }
  void StraightTo(double to_mm) {
    for (double z = -2.0; z < to_mm; z += 0.05) To({0.0, 0.0, z});
    To({0.0, 0.0, to_mm});
  }
};

/// A beam, free of the tissue for z in [-outside, 0] and on an elastic foundation for z in
/// [0, depth], with springs at both ends: EI y'''' + k y = 0 (k = 0 outside). Solved for its eight
/// constants. The hub is drawn to `v` and to `x` and turned to `slope`.
class BeamInTissue {
 public:
  double ei, k, outside, depth, tip_spring, hub_spring, kappa, turn_spring, v, x, slope;

  void Solve() {
    Eigen::Matrix<double, 8, 8> a = Eigen::Matrix<double, 8, 8>::Zero();
    Eigen::Matrix<double, 8, 1> b = Eigen::Matrix<double, 8, 1>::Zero();
    a.row(0).head<4>() = ei * Free(-outside, 3) + (hub_spring + kappa) * Free(-outside, 0);
    b[0] = hub_spring * v + kappa * x;
    a.row(1).head<4>() = -ei * Free(-outside, 2) + turn_spring * Free(-outside, 1);
    b[1] = turn_spring * slope;
    for (int order = 0; order < 4; ++order) {
      a.row(2 + order) << Free(0.0, order), -Buried(0.0, order);
    }
    a.row(6).tail<4>() = Buried(depth, 2);
    a.row(7).tail<4>() = -ei * Buried(depth, 3) + tip_spring * Buried(depth, 0);
    constants_ = a.fullPivLu().solve(b);
  }
  double At(double z) const {
    return z < 0.0 ? Free(z, 0).dot(constants_.head<4>()) : Buried(z, 0).dot(constants_.tail<4>());
  }

 private:
  /// Derivatives of 1, z, z^2, z^3.
  static Eigen::RowVector4d Free(double z, int order) {
    Eigen::RowVector4d row = Eigen::RowVector4d::Zero();
    for (int power = order; power < 4; ++power) {
      double factor = 1.0;
      for (int i = 0; i < order; ++i) factor *= power - i;
      row[power] = factor * std::pow(z, power - order);
    }
    return row;
  }
  /// Derivatives of the real and imaginary parts of exp(r z), r = beta (+-1 + i).
  Eigen::RowVector4d Buried(double z, int order) const {
    const double beta = std::pow(k / (4.0 * ei), 0.25);
    Eigen::RowVector4d row;
    for (int i = 0; i < 2; ++i) {
      const std::complex<double> r(i == 0 ? beta : -beta, beta);
      const std::complex<double> value = std::pow(r, order) * std::exp(r * z);
      row[2 * i] = value.real();
      row[2 * i + 1] = value.imag();
    }
    return row;
  }
  Eigen::Matrix<double, 8, 1> constants_;
};

// The hand leans by 0.02 rad about its tip, 50 mm deep: small enough for the linear beam.
TEST(BendableScene, IsTheBeamOnAnElasticFoundation) {
  for (const int nodes : {25, 50}) {
    BendingScene bending;
    bending.effect.nodes = nodes;
    const Scene scene = bending.Make();
    const Simulation simulation(scene);
    Insertion needle(simulation);
    needle.StraightTo(50.0);
    EXPECT_LT(needle.out.shape.tip_deflection_mm, 1e-6);
    const double lean_rad = 0.02;
    for (int i = 1; i <= 200; ++i) needle.To({0, 0, 50.0}, {0.0, lean_rad * i / 200.0, 0.0});
    const auto& path = needle.state.shape.needle.path;
    const double length_mm = scene.needle->length_mm;
    BeamInTissue beam;
    beam.ei = scene.needle->beam.BendingStiffnessNMm2();
    beam.k = scene.shape->StiffnessNPerMm2(volume::LabelOf("muscle"));
    beam.depth = path.LengthMm();
    beam.outside = length_mm - beam.depth;
    beam.tip_spring = 0.5;
    beam.hub_spring = beam.kappa = 0.5;
    beam.turn_spring = 500.0;
    beam.v = -beam.outside * lean_rad;
    beam.x = -length_mm * lean_rad;
    beam.slope = lean_rad;
    beam.Solve();

    math::Polyline line;
    ASSERT_TRUE(simulation.ShapeOf(needle.state, line));
    ASSERT_EQ(line.num_points, nodes);
    const double largest_mm = std::abs(beam.At(-beam.outside));
    EXPECT_GT(largest_mm, 0.5);
    const double skin_mm = path.entry().position_mm.z();
    for (int i = 0; i < line.num_points; ++i) {
      EXPECT_NEAR(line.At(i).x(), beam.At(line.At(i).z() - skin_mm), 0.01 * largest_mm) << i;
      EXPECT_NEAR(line.At(i).y(), 0.0, 1e-6);
    }
    const double felt_n = beam.kappa * (beam.At(-beam.outside) - beam.x);
    EXPECT_NEAR(needle.out.force.force_in_ct_n.x(), felt_n, 0.01 * std::abs(felt_n));
    EXPECT_NEAR(needle.out.force.lateral_n, std::abs(felt_n), 0.01 * std::abs(felt_n));
  }
}

// Webster et al. 2006 without the offset of the wheels: a circle.
TEST(BendableScene, ABevelCutsACircle) {
  for (const double roll_rad : {0.0, 0.7, -2.0}) {
    BendingScene bending;
    bending.bevel_curvature_per_mm = 0.0045;
    bending.bevel_roll_rad = roll_rad;
    const Scene scene = bending.Make();
    const Simulation simulation(scene);
    Insertion needle(simulation);
    needle.StraightTo(60.0);
    const auto& path = needle.state.shape.needle.path;
    const Vector3d from_skin_mm = path.tip().position_mm - path.entry().position_mm;
    const double radius_mm = 1.0 / 0.0045;
    const double turn_rad = path.LengthMm() / radius_mm;
    const double aside_mm = radius_mm * (1.0 - std::cos(turn_rad));
    const Vector3d truth_mm(aside_mm * std::cos(roll_rad), aside_mm * std::sin(roll_rad),
                            radius_mm * std::sin(turn_rad));
    EXPECT_NEAR((from_skin_mm - truth_mm).norm(), 0.0, 0.2) << roll_rad;
    EXPECT_NEAR(path.LengthMm(), 60.0, 0.1);
    EXPECT_GT(aside_mm, 7.0);
    // The needle is where its path is, but for what the tissue gives way to its stiffness.
    EXPECT_NEAR((needle.out.shape.tip_in_ct_mm - path.tip().position_mm).norm(), 0.0, 1.0);

    // Switched off, the same needle goes straight.
    bending.effect.bevel = false;
    const Scene straight = bending.Make();
    const Simulation plain(straight);
    Insertion other(plain);
    other.StraightTo(60.0);
    EXPECT_LT(other.out.shape.tip_deflection_mm, 1e-6);
  }
}

// Lean at 15 mm and go on to 60 mm: how finely the rod is cut does not matter.
TEST(BendableScene, TheNumberOfNodesDoesNotMatter) {
  Vector3d tip_mm[4];
  Vector3d force_n[4];
  double deflection_mm[4];
  int count = 0;
  for (const int nodes : {100, 50, 25, 15}) {
    BendingScene bending;
    bending.effect.nodes = nodes;
    const Scene scene = bending.Make();
    const Simulation simulation(scene);
    Insertion needle(simulation);
    needle.StraightTo(15.0);
    for (int i = 1; i <= 200; ++i)
      needle.To({0, 0, 15.0}, {0.1 * i / 200.0, 0.12 * i / 200.0, 0.0});
    for (int i = 1; i <= 900; ++i) needle.To({0, 0, 15.0 + 0.05 * i}, {0.1, 0.12, 0.0});
    tip_mm[count] = needle.out.shape.tip_in_ct_mm;
    force_n[count] = needle.out.force.force_in_ct_n;
    deflection_mm[count++] = needle.out.shape.tip_deflection_mm;
  }
  EXPECT_GT(deflection_mm[0], 0.5);
  EXPECT_GT(force_n[0].norm(), 1.0);
  for (int i = 1; i < 4; ++i) {
    EXPECT_NEAR((tip_mm[i] - tip_mm[0]).norm(), 0.0, 0.03) << i;
    EXPECT_NEAR(deflection_mm[i], deflection_mm[0], 0.03) << i;
    EXPECT_NEAR((force_n[i] - force_n[0]).norm(), 0.0, 0.001 * force_n[0].norm()) << i;
  }
}

}  // namespace
}  // namespace acus::simulation
