// A random hand through every force model, 20 s by default: developer/stability --full takes a
// million steps through each. Finite, bounded, and no energy that the hand did not put in.
#include <gmock/gmock.h>

#include "benchmarks/force_model_cases.h"
#include "references/closed_loop.h"
#include "support/bound.h"
#include "support/stability_length.h"

namespace acus::benchmarks {
namespace {

using Eigen::Vector3d;
using testing_support::Above;
using testing_support::AtMost;
using testing_support::BoundPlot;
using testing_support::HardCase;
using testing_support::Largest;

struct Account {
  Largest force_n;
  Largest generated_mj;
  double taken_mj = 0.0;
  BoundPlot::Curve balance;  ///< mJ over seconds.
};

/// The force of a step acts until the next.
Account RandomSteps(const ForceModelCase& model, int num_steps, std::uint64_t seed) {
  forces::RandomHand motion{.across_mm = 3.0};
  motion.axis_in_ct = -Vector3d::UnitZ();
  motion.slowest_s = 1.0;
  const auto place = forces::RandomMotion(motion, 1e-3 * num_steps, seed);
  const auto step = model.begin();
  forces::PassivityObserver observer;
  Account account;
  Vector3d before_mm = place(0.0);
  Vector3d force_n = Vector3d::Zero();
  for (int i = 0; i < num_steps; ++i) {
    tissue::ToolSample sample;
    sample.time_s = 1e-3 * i;
    sample.tip_in_ct_mm = place(sample.time_s);
    sample.axis_in_ct = -Vector3d::UnitZ();
    observer.Add(force_n, sample.tip_in_ct_mm - before_mm);
    before_mm = sample.tip_in_ct_mm;
    force_n = step(sample).force_in_ct_n;
    account.force_n.Add(force_n.norm());
    if (i % (num_steps / 500) == 0) account.balance.Add(sample.time_s, observer.taken_mj());
  }
  account.generated_mj.Add(observer.generated_mj());
  account.taken_mj = observer.taken_mj();
  return account;
}

TEST(RandomHandInModels, EveryModelStaysBoundedAndGivesNoEnergy) {
  const HardCase hard("In, out and across at random with tremor, for long: what adds up shows.");
  const int num_steps = testing_support::StabilitySteps(20'000);
  BoundPlot plot{.title = "Energy that a random hand put into each model",
                 .x_label = "time [s]",
                 .y_label = "energy [mJ]"};
  for (const ForceModelCase& model : ForceModelCases({.element_mm = 6.0}, {})) {
    Account account = RandomSteps(model, num_steps, testing_support::StabilitySeed());
    hard.Expect("largest force, " + model.name, account.force_n,
                AtMost(model.largest_n * (1.0 + 1e-9)), "N");
    hard.Expect("energy generated, " + model.name, account.generated_mj, AtMost(1.0), "mJ");
    hard.Expect("energy taken, " + model.name, account.taken_mj, Above(1.0), "mJ");
    account.balance.name = model.name;
    plot.curves.push_back(std::move(account.balance));
  }
  hard.Note("random steps through each of the models", std::to_string(num_steps));
  hard.Plot(plot);
}

}  // namespace
}  // namespace acus::benchmarks
