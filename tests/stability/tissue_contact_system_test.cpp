// Stick and slip for a long time, and where it is hard. Bounds: docs/models/tissue_contact.md.
#include <gtest/gtest.h>

#include "acus/base/core/random.h"
#include "acus/physics/tissue/contact_mesh.h"
#include "acus/physics/tissue/contact_system.h"
#include "support/allocation_counter.h"
#include "support/bound.h"
#include "support/elastic_box.h"
#include "support/fresh_contact.h"

namespace acus::testing_support {

/// For the other sources of this program; only one of them may count.
long NumAllocations();
long NumAllocations() {
  return num_allocations;
}

}  // namespace acus::testing_support

namespace acus::tissue {
namespace {

using testing_support::Above;
using testing_support::AtMost;
using testing_support::Below;
using testing_support::BoundPlot;
using testing_support::BoxMesh;
using testing_support::CompareWithFresh;
using testing_support::ElasticLabels;
using testing_support::Exactly;
using testing_support::HardCase;
using testing_support::Largest;

// About what a needle of 1.2 mm has around 1.5 mm of its shaft in tissue of 10 kPa.
constexpr LocalCompliance kLocal{20.0, 30.0};

mesh::TetraMesh HeldBox(double jitter = 0.1) {
  mesh::TetraMesh box = BoxMesh({4, 4, 5}, {-20, -20, 0}, {20, 20, 50}, jitter);
  testing_support::Fix(box, [](const Eigen::Vector3d& x) { return x.z() < 0.1; });
  return box;
}

mechanics::Compliance AllOf(const mesh::TetraMesh& mesh, mechanics::Storage storage,
                            const mechanics::ElasticityTable& table) {
  return testing_support::ComplianceOf(mesh, table, storage,
                                       [](const Eigen::Vector3d&) { return true; });
}

Eigen::Matrix3d Down() {
  Eigen::Matrix3d frame;
  frame << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  return frame;
}

/// A shaft along -z that is driven up and down at random, with a tip and a few nodes under a probe.
/// Slip is followed as in a needle: a point that slips sticks where it slipped to.
class Shaft {
 public:
  Shaft(const mesh::TetraMesh& mesh, mechanics::Compliance compliance, int points,
        double node_local_mm_per_n = 0.0)
      : mesh_(mesh, compliance),
        system_(std::move(compliance), {.points = points, .slots = 4}),
        state_(system_.NewState()),
        slip_mm_(static_cast<std::size_t>(points), 0.0) {
    system_.Restart(state_, Down());
    for (int s = 1; s < 4; ++s) {
      system_.SetSlot(state_, s, mesh_.Find({-20.0 + 10.0 * s, 10.0, 50.0}).place,
                      -Eigen::Vector3d::UnitZ(), node_local_mm_per_n);
    }
  }

  /// Points every `spacing_mm` down to `depth_mm`; the tip below the last.
  void Reach(double depth_mm, double spacing_mm) {
    while (state_.num_points() > 0 && (state_.num_points() - 1) * spacing_mm > depth_mm) {
      system_.TruncatePoints(state_, state_.num_points() - 1);
    }
    while (state_.num_points() < system_.capacity().points &&
           state_.num_points() * spacing_mm <= depth_mm) {
      const int p = state_.num_points();
      const Eigen::Vector3d moved =
          system_.AppendPoint(state_, mesh_.Find({1.1, -2.3, 49.9 - p * spacing_mm}).place, kLocal);
      slip_mm_[static_cast<std::size_t>(p)] = at_mm_ - moved[2];
    }
    system_.SetSlot(state_, 0, mesh_.Find({1.1, -2.3, 49.9 - depth_mm}).place,
                    -Eigen::Vector3d::UnitZ(), 1.0);
  }

  void MoveTo(double at_mm, double tilt, double press_mm, double friction_n) {
    at_mm_ = at_mm;
    for (int p = 0; p < state_.num_points(); ++p) {
      state_.SetLateral(p, tilt * (p - 10), 0.3 * tilt);
      state_.SetPointAxial(p, at_mm_ - slip_mm_[static_cast<std::size_t>(p)], -friction_n,
                           friction_n);
    }
    state_.SetSlotDemand(0, 0.5 * at_mm_, 0.0, 1.0);
    for (int s = 1; s < 4; ++s) {
      state_.SetSlotDemand(s, press_mm - 0.1 * s, 0.0, std::numeric_limits<double>::infinity());
    }
    solved_ = system_.Solve(state_) && solved_;
    for (int p = 0; p < state_.num_points(); ++p) {
      slip_mm_[static_cast<std::size_t>(p)] -= state_.PointExcessMm(p);
    }
  }

  const ContactSystem& system() const { return system_; }
  ContactState& state() { return state_; }
  bool solved() const { return solved_; }

 private:
  ContactMesh mesh_;
  ContactSystem system_;
  ContactState state_;
  std::vector<double> slip_mm_;
  double at_mm_ = 0.0;
  bool solved_ = true;
};

/// Largest differences of the forces of points and of slots.
struct Difference {
  double points_n = 0.0;
  double slots_n = 0.0;
};

/// The forces of `state` against a fresh start on another compliance, for the same demands.
Difference DifferenceOn(const ContactSystem& other, const ContactState& state) {
  ContactState fresh = other.NewState();
  other.Restart(fresh, state.frame());
  for (int s = 0; s < state.num_slots(); ++s) {
    if (!state.slot_in_use(s)) continue;
    other.SetSlot(fresh, s, state.slot_place(s), state.slot_direction(s),
                  state.slot_local_mm_per_n(s));
    fresh.SetSlotDemand(s, state.DemandMm(s), state.LowN(s), state.HighN(s));
  }
  for (int p = 0; p < state.num_points(); ++p) {
    other.AppendPoint(fresh, state.point_place(p), state.point_local(p));
    const int column = state.num_slots() + p;
    fresh.SetLateral(p, state.LateralMm(2 * p), state.LateralMm(2 * p + 1));
    fresh.SetPointAxial(p, state.DemandMm(column), state.LowN(column), state.HighN(column));
  }
  other.Solve(fresh);
  Difference out;
  for (int p = 0; p < state.num_points(); ++p) {
    const Eigen::Vector3d difference = fresh.PointForceN(p) - state.PointForceN(p);
    out.points_n = std::max(out.points_n, difference.cwiseAbs().maxCoeff());
  }
  for (int s = 0; s < state.num_slots(); ++s) {
    out.slots_n = std::max(out.slots_n, std::abs(fresh.SlotForceN(s) - state.SlotForceN(s)));
  }
  return out;
}

void AMillionSwaps(const HardCase& hard, mechanics::Storage storage, double bound_to_double_n,
                   double slot_bound_n) {
  const mesh::TetraMesh box = HeldBox();
  const mechanics::ElasticityTable table = ElasticLabels({{4, {0.01, 0.45}}});
  Shaft shaft(box, AllOf(box, storage, table), 24);
  const ContactSystem in_double(AllOf(box, mechanics::Storage::kDouble, table),
                                shaft.system().capacity());
  RandomStream random(21, "swaps");
  double at_mm = 0.0;
  double depth_mm = 30.0;
  Largest breach;
  Largest worst_n;
  Largest points_n;
  Largest slots_n;
  Largest largest_n;
  BoundPlot plot{.title = "Force against a fresh dense solve",
                 .x_label = "changes between stick and slip",
                 .y_label = "largest difference [N]",
                 .log_y = true,
                 .curves = {{.name = "needle, probe and tip"}, {.name = "and in double"}}};
  long steps = 0;
  shaft.Reach(depth_mm, 1.5);
  for (; shaft.state().counts().num_swaps < 1'000'000; ++steps) {
    // Small moves swap a few points, large ones all at once; reversed every few steps.
    at_mm += random.Uniform() < 0.2 ? random.Uniform(-8, 8) : random.Uniform(-0.6, 0.6);
    at_mm *= 0.98;
    if (steps % 7 == 0) {
      depth_mm = std::clamp(depth_mm + random.Uniform(-4, 4), 6.0, 38.0);
      shaft.Reach(depth_mm, 1.5);
    }
    shaft.MoveTo(at_mm, random.Uniform(-0.05, 0.05), random.Uniform(-1, 2), 0.03);
    if (steps % 997 != 0) continue;
    const auto fresh = CompareWithFresh(shaft.system(), shaft.state());
    breach.Add(fresh.breach);
    worst_n.Add(fresh.force_error_n);
    largest_n.Add(fresh.largest_force_n);
    const Difference difference = DifferenceOn(in_double, shaft.state());
    points_n.Add(difference.points_n);
    slots_n.Add(difference.slots_n);
    const auto swaps = static_cast<double>(shaft.state().counts().num_swaps);
    plot.curves[0].Add(swaps, fresh.force_error_n);
    plot.curves[1].Add(swaps, std::max(difference.points_n, difference.slots_n));
  }
  EXPECT_TRUE(shaft.solved());
  hard.Expect("breach of a stick or slip condition", breach, Below(1e-9));
  hard.Expect("force against a fresh dense solve", worst_n, AtMost(1e-9), "N");
  hard.Expect("force along the needle against one in double", points_n, AtMost(bound_to_double_n),
              "N");
  hard.Expect("force of tip and probe against one in double", slots_n, AtMost(slot_bound_n), "N");
  hard.Expect("largest force", largest_n, Below(5.0), "N");
  hard.Expect("largest force, at least", largest_n, Above(0.03), "N");
  hard.Expect("new factorisations in a million changes",
              static_cast<double>(shaft.state().num_refactors()), Exactly(0));
  hard.Note("steps", std::to_string(steps));
  hard.Note("most rounds of a step", std::to_string(shaft.state().counts().most_rounds));
  hard.Plot(plot);
}

TEST(ContactSystemStability, AMillionSwapsInDouble) {
  const HardCase hard("Each change between stick and slip updates a factorisation: errors add up.");
  AMillionSwaps(hard, mechanics::Storage::kDouble, 1e-9, 1e-9);
}

TEST(ContactSystemStability, AMillionSwapsInFloat) {
  // Rounding the matrix changes the tissue: forces by as many digits, which is 6e-8 of the 0.3 N on
  // a node under the probe. The solve itself, on the matrix as stored, is as exact as in double.
  const HardCase hard(
      "The same with the tissue's matrix in single precision, to halve its memory.");
  AMillionSwaps(hard, mechanics::Storage::kFloat, 1e-8, 5e-8);
}

TEST(ContactSystemStability, NothingIsAllocatedInSteps) {
  const HardCase hard("Memory taken in a step of 1 ms can make it late.");
  const mesh::TetraMesh box = HeldBox();
  Shaft shaft(box, AllOf(box, mechanics::Storage::kDouble, ElasticLabels({{4, {0.01, 0.45}}})), 24);
  RandomStream random(22, "moves");
  const long before = testing_support::num_allocations;
  for (int step = 0; step < 2000; ++step) {
    shaft.Reach(random.Uniform(0.0, 36.0), 1.5);
    shaft.MoveTo(random.Uniform(-5, 5), random.Uniform(-0.1, 0.1), random.Uniform(-1, 2), 0.03);
  }
  hard.Expect("allocations in 2000 steps",
              static_cast<double>(testing_support::num_allocations - before), Exactly(0));
}

TEST(ContactSystemStability, AllPointsSlipOrStickInOneStep) {
  const HardCase hard(
      "All 24 points change between stick and slip at once: many rounds, or a cycle.");
  const mesh::TetraMesh box = HeldBox();
  Shaft shaft(box, AllOf(box, mechanics::Storage::kDouble, ElasticLabels({{4, {0.01, 0.45}}})), 24);
  shaft.Reach(36.0, 1.5);
  const auto count = [&](ContactStatus status) {
    int n = 0;
    for (int p = 0; p < 24; ++p) n += shaft.state().PointStatus(p) == status ? 1 : 0;
    return n;
  };
  shaft.MoveTo(50.0, 0.0, 0.0, 0.03);
  EXPECT_EQ(count(ContactStatus::kAtHigh), 24);
  shaft.MoveTo(50.0, 0.0, 0.0, 0.04);  // More friction: nothing slips any more.
  EXPECT_EQ(count(ContactStatus::kStick), 24);
  shaft.MoveTo(-50.0, 0.0, 0.0, 0.03);
  EXPECT_EQ(count(ContactStatus::kAtLow), 24);
  shaft.MoveTo(50.0, 0.0, 0.0, 0.03);
  EXPECT_EQ(count(ContactStatus::kAtHigh), 24);
  EXPECT_TRUE(shaft.solved());
  hard.Expect("force against a fresh dense solve",
              CompareWithFresh(shaft.system(), shaft.state()).force_error_n, Below(1e-12), "N");
}

TEST(ContactSystemStability, MoreConstraintsThanUnknowns) {
  const HardCase hard("72 constraints on 9 displacements: all but 9 say the same.");
  Largest breach;
  Largest error_n;
  // Three free nodes, nine displacements; 24 points, 72 constraints.
  mesh::TetraMesh box = BoxMesh({1, 1, 5}, {-20, -20, 0}, {20, 20, 50});
  testing_support::Fix(
      box, [](const Eigen::Vector3d& x) { return x.z() < 45.0 || (x.x() < 0 && x.y() < 0); });
  Shaft shaft(box, AllOf(box, mechanics::Storage::kDouble, ElasticLabels({{4, {0.01, 0.45}}})), 24,
              1.0);
  RandomStream random(23, "moves");
  for (int step = 0; step < 500; ++step) {
    shaft.Reach(30.0, 1.3);
    shaft.MoveTo(random.Uniform(-5, 5), random.Uniform(-0.05, 0.05), 0.5, 0.03);
    const auto fresh = CompareWithFresh(shaft.system(), shaft.state());
    breach.Add(fresh.breach);
    error_n.Add(fresh.force_error_n);
  }
  hard.Expect("breach of a stick or slip condition", breach, Below(1e-10));
  hard.Expect("force against a fresh dense solve", error_n, Below(1e-11), "N");
  EXPECT_TRUE(shaft.solved());
  EXPECT_EQ(shaft.state().counts().num_weak_pivots, 0);
}

TEST(ContactSystemStability, AThousandToOneAndSlivers) {
  const HardCase hard("Layers of 1 kPa and 1 MPa, one of tetrahedra 100 times wider than high.");
  Largest breach;
  Largest error_n;
  mesh::TetraMesh box = HeldBox(0.0);
  // Layers of 1 kPa and 1 MPa, one of them 0.1 mm thick: its tetrahedra are 100 times wider.
  for (Eigen::Index t = 0; t < box.tetrahedra.cols(); ++t) {
    double z = 0.0;
    for (int c = 0; c < 4; ++c) z += 0.25 * box.nodes_mm(2, box.tetrahedra(c, t));
    if (static_cast<int>(z / 10.0) % 2 == 1) box.tissue[static_cast<std::size_t>(t)] = 5;
  }
  for (Eigen::Index i = 0; i < box.nodes_mm.cols(); ++i) {
    double& z = box.nodes_mm(2, i);
    if (z > 24.0 && z < 34.0) z = 39.9;
  }
  Shaft shaft(box,
              AllOf(box, mechanics::Storage::kDouble,
                    ElasticLabels({{4, {0.001, 0.45}}, {5, {1.0, 0.45}}})),
              24);
  RandomStream random(24, "moves");
  for (int step = 0; step < 500; ++step) {
    shaft.Reach(random.Uniform(10.0, 36.0), 1.5);
    shaft.MoveTo(random.Uniform(-5, 5), random.Uniform(-0.05, 0.05), 0.5, 0.03);
    const auto fresh = CompareWithFresh(shaft.system(), shaft.state());
    breach.Add(fresh.breach);
    error_n.Add(fresh.force_error_n);
  }
  hard.Expect("breach of a stick or slip condition", breach, Below(1e-9));
  hard.Expect("force against a fresh dense solve", error_n, Below(1e-9), "N");
  EXPECT_TRUE(shaft.solved());
}

}  // namespace
}  // namespace acus::tissue
