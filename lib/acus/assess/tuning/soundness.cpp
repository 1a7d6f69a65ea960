#include "acus/assess/tuning/soundness.h"

#include <algorithm>

#include "acus/base/core/error.h"
#include "acus/physics/forces/laws/force_table.h"

namespace acus::tuning {
namespace {

using simulation::StepOutput;

constexpr double kSlack = 1.0 + 1e-9;

/// Limit of the needle's force, N; 0: no force.
double LargestForceN(const scenario::Scenario& scenario, const simulation::Scene& scene) {
  if (scene.forces) return scene.forces->table().settings.largest_force_n;
  if (!scenario.tissue) return 0.0;
  return forces::ReadForceTable(scenario.tissue->table).settings.largest_force_n;
}

/// The work between the hand and the needle.
class Work {
 public:
  /// A device holds the force from one sample to the next.
  void Add(const StepOutput& before, const StepOutput& now) {
    const Eigen::AngleAxisd turned(now.ct_from_needle.linear() *
                                   before.ct_from_needle.linear().transpose());
    const Eigen::Vector3d moved_mm =
        now.ct_from_needle.translation() - before.ct_from_needle.translation();
    balance_mj_ -= before.force.force_in_ct_n.dot(moved_mm) +
                   before.force.torque_in_ct_n_mm.dot(turned.angle() * turned.axis());
    spent_mj_ = std::max(spent_mj_, balance_mj_);
    generated_mj_ = std::max(generated_mj_, -balance_mj_);
  }

  /// A held force generates a little energy; an unstable solver generates it without limit.
  bool IsSound() const { return generated_mj_ <= std::max(1.0, 0.1 * spent_mj_); }
  double generated_mj() const { return generated_mj_; }

 private:
  double balance_mj_ = 0.0;    // Work of the hand, minus the energy that it got back.
  double spent_mj_ = 0.0;      // Maximum of balance_mj_ so far.
  double generated_mj_ = 0.0;  // Maximum of -balance_mj_ so far.
};

/// The error of one step, or empty.
std::string Wrong(const StepOutput& out, double needle_limit_n, double probe_limit_n) {
  const Eigen::Vector3d& needle_n = out.force.force_in_ct_n;
  const Eigen::Vector3d& probe_n = out.probe.force_in_ct_n;
  if (!needle_n.allFinite() || !out.force.torque_in_ct_n_mm.allFinite()) {
    return "the needle's force is not finite";
  }
  if (!probe_n.allFinite()) return "the probe's force is not finite";
  if (needle_limit_n > 0.0 && needle_n.norm() > needle_limit_n * kSlack) {
    return Message("the needle's force of ", needle_n.norm(), " N is above ", needle_limit_n, " N");
  }
  if (probe_limit_n > 0.0 && probe_n.norm() > probe_limit_n * kSlack) {
    return Message("the probe's force of ", probe_n.norm(), " N is above ", probe_limit_n, " N");
  }
  return {};
}

}  // namespace

std::string WhyUnusable(const scenario::Scenario& scenario, const simulation::Scene& scene,
                        const replay::StepLog& log) {
  const double needle_limit_n = LargestForceN(scenario, scene);
  const double probe_limit_n = scene.probe_force ? scene.probe_force->LargestForceN() : 0.0;
  Work work;
  for (std::size_t i = 0; i < log.steps.size(); ++i) {
    const StepOutput& out = log.steps[i];
    if (const std::string wrong = Wrong(out, needle_limit_n, probe_limit_n); !wrong.empty()) {
      return Message(wrong, " at ",
                     1e-9 * static_cast<double>(out.time_ns - log.steps.front().time_ns), " s");
    }
    if (i > 0) work.Add(log.steps[i - 1], out);
  }
  // A patient who breathes does work on the needle.
  if (!scene.breathing && !work.IsSound()) {
    return Message("it gave the hand ", work.generated_mj(), " mJ more than it took");
  }
  return {};
}

}  // namespace acus::tuning
