// A hand that makes contact as expensive as it can be, and what a step of it costs: for the
// benchmark and the performance test of 3D contact.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "acus/base/core/cpu_time.h"
#include "acus/base/core/random.h"
#include "acus/physics/mechanics/condensation/condensation.h"
#include "acus/physics/mechanics/condensation/reachable.h"
#include "support/fem_needle_scene.h"
#include "support/fresh_contact.h"

namespace acus::testing_support {

/// A cube of cells of 4 mm with the skin on top, held at bottom and sides; some 1000 nodes around a
/// needle straight down through the middle are in reach.
struct HandlingScene {
  double side_mm;
  mesh::TetraMesh mesh;
  mechanics::Compliance compliance;

  HandlingScene(int cells, double corridor_mm, double depth_mm) : side_mm(4.0 * cells) {
    const double half_mm = 0.5 * side_mm;
    mesh = BoxMesh(Eigen::Vector3i::Constant(cells), {-half_mm, -half_mm, -side_mm},
                   {half_mm, half_mm, 0.0}, 0.15);
    Fix(mesh, [&](const Eigen::Vector3d& x) {
      return x.z() < 1e-6 - side_mm || x.head<2>().cwiseAbs().maxCoeff() > half_mm - 1e-6;
    });
    const mechanics::FreeNodes free = mechanics::FindFreeNodes(mesh);
    const std::vector<int> reachable = mechanics::CorridorNodes(
        mesh, free, {{0, 0, -corridor_mm}, {0, 0, -depth_mm}, corridor_mm});
    const mechanics::Condensation condensation(mesh, free, Elasticity(),
                                               mechanics::ElementKind::kAveragedDilatation,
                                               reachable, mechanics::kDefaultMemoryMib, {});
    compliance = condensation.Compliance(mechanics::Storage::kFloat);
  }
  static mechanics::ElasticityTable Elasticity() { return ElasticLabels({{4, {0.01, 0.45}}}); }

  tissue::FemNeedleModel Model() const {
    tissue::FemContactSettings settings;
    settings.contact_spacing_mm = 1.0;
    return {mesh, compliance, Elasticity(), SceneForces(), SceneNeedle(), settings};
  }
};

struct StepCosts {
  std::vector<double> all_us;      ///< Every step.
  std::vector<double> engaged_us;  ///< Those with nearly all points in contact.
  double mean_points = 0.0;        ///< In those.
  double worst_error_n = 0.0;      ///< To a fresh dense solve.
  double largest_force_n = 0.0;
  double work_n_mm = 0.0;  ///< Of the hand; cannot be negative, as it begins outside.
  double least_work_n_mm = 0.0;
  bool finite = true;

  /// Of another run of the same steps.
  void KeepLeast(const StepCosts& again) {
    const auto least = [](std::vector<double>& of, const std::vector<double>& than) {
      std::ranges::transform(of, than, of.begin(),
                             [](double a, double b) { return std::min(a, b); });
    };
    least(all_us, again.all_us);
    least(engaged_us, again.engaged_us);
  }
};

/// Fast in and out with reversals every few steps and tilts to 6 degrees, cutting deeper now and
/// then, drawn out altogether and put in again, in the old channel or beside it. At 1 kHz.
class AdversarialHand {
 public:
  AdversarialHand(const tissue::FemNeedleModel& model, int points)
      : model_(model), state_(model.NewState()), points_(points), random_(51, "hand") {}

  void Step(StepCosts& costs) {
    Plan();
    tissue::ToolSample sample;
    sample.time_s = time_s_ += 1e-3;
    sample.axis_in_ct = Eigen::Vector3d(tilt_.x(), tilt_.y(), -1.0).normalized();
    // It turns about where it entered.
    sample.tip_in_ct_mm =
        Eigen::Vector3d(entry_.x(), entry_.y(), 0.0) + depth_mm_ * sample.axis_in_ct;
    const double begin_s = ThreadCpuSeconds();
    const forces::NeedleForce force = model_.Step(state_, sample);
    const double cost_us = 1e6 * (ThreadCpuSeconds() - begin_s);
    costs.all_us.push_back(cost_us);
    const int in_contact = state_.contact.num_points();
    if (in_contact >= points_ - points_ / 12) {
      costs.engaged_us.push_back(cost_us);
      costs.mean_points +=
          (in_contact - costs.mean_points) / static_cast<double>(costs.engaged_us.size());
    }
    Check(sample, force, costs);
  }

  const tissue::FemNeedleState& state() const { return state_; }

 private:
  void Plan() {
    if (--steps_left_ <= 0) {
      steps_left_ = 2 + static_cast<int>(7.0 * random_.Uniform());
      speed_mm_ = random_.Uniform(-2.5, 2.5);
      if (++moves_ % 150 == 0) {  // Out altogether, at 5 m/s, and in again.
        speed_mm_ = -5.0;
        steps_left_ = static_cast<int>(depth_mm_ / 5.0) + 3;
        leaving_ = true;
      } else if (leaving_) {
        leaving_ = false;
        if (moves_ % 2 == 1) entry_ = {random_.Uniform(-2, 2), random_.Uniform(-2, 2)};
        speed_mm_ = 2.0;
        steps_left_ = points_ / 2 + 3;
      }
    }
    // Points lag behind the tip by what the tissue gives way.
    const double deepest_mm = model_.spacing_mm() * (points_ + points_ / 8) + 4.0;
    depth_mm_ = std::min(depth_mm_ + speed_mm_, deepest_mm);
    if (!leaving_ && depth_mm_ < deepest_mm - points_ / 5.0 - 2.0 && speed_mm_ < 0.0) {
      speed_mm_ = std::abs(speed_mm_);
    }
    for (int d = 0; d < 2; ++d) {
      tilt_[d] = std::clamp(tilt_[d] + random_.Uniform(-0.01, 0.01), -0.1, 0.1);
    }
  }

  void Check(const tissue::ToolSample& sample, const forces::NeedleForce& force, StepCosts& costs) {
    costs.finite = costs.finite && force.force_in_ct_n.allFinite();
    costs.largest_force_n = std::max(costs.largest_force_n, force.force_in_ct_n.norm());
    // Turned about the tip and moved with it.
    const Eigen::Vector3d turned = last_axis_.cross(sample.axis_in_ct);
    costs.work_n_mm -= force.force_in_ct_n.dot(sample.tip_in_ct_mm - last_tip_mm_) +
                       force.torque_in_ct_n_mm.dot(turned);
    costs.least_work_n_mm = std::min(costs.least_work_n_mm, costs.work_n_mm);
    last_axis_ = sample.axis_in_ct;
    last_tip_mm_ = sample.tip_in_ct_mm;
    if (costs.all_us.size() % 997 != 0 || state_.contact.num_points() == 0) return;
    tissue::ContactState again = state_.contact;
    model_.system().Solve(again);
    const FreshComparison fresh = CompareWithFresh(model_.system(), again);
    costs.worst_error_n = std::max({costs.worst_error_n, fresh.force_error_n, fresh.breach});
  }

  const tissue::FemNeedleModel& model_;
  tissue::FemNeedleState state_;
  int points_;
  RandomStream random_;
  double time_s_ = 0.0;
  double depth_mm_ = -5.0;
  double speed_mm_ = 1.0;
  int steps_left_ = 120;
  long moves_ = 0;
  bool leaving_ = false;
  Eigen::Vector2d tilt_ = Eigen::Vector2d::Zero();
  Eigen::Vector2d entry_{0.4, -0.6};
  Eigen::Vector3d last_tip_mm_{0.4, -0.6, 5.0};
  Eigen::Vector3d last_axis_ = -Eigen::Vector3d::UnitZ();
};

}  // namespace acus::testing_support
